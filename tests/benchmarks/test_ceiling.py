"""What a mesh determines of the umbilics of its surface."""

from __future__ import annotations

import numpy as np
import pytest
from surfaces import icosphere, superquadric

from benchmarks.cases import Case
from benchmarks.ceiling import determined


@pytest.mark.slow
def test_noise_hides_the_flat_sides_of_a_box_before_its_corners():
    surface = superquadric((1.1, 0.9, 0.95))
    truth = surface.umbilics()
    points, triangles = icosphere(5)
    vertices = surface.on_rays(points)
    clean = Case(surface.name, "regular", 0.0, vertices, triangles, truth, euler=2)
    assert determined(clean, surface).all()
    some = determined(clean.with_noise(0.02, 1), surface)
    corner = truth.index < 0.0
    assert some[corner].all() and not some[~corner].all()


@pytest.mark.slow
def test_slopes_are_those_of_the_exact_deviator():
    surface = superquadric((1.1, 0.9, 0.95))
    truth = surface.umbilics().position
    slope = surface.slopes(truth)
    # |D| rises by the slope at least on a small circle, and by no more somewhere.
    e1, e2 = surface._frames(truth)
    step = 1e-4
    rise = np.stack(
        [
            np.abs(
                surface._deviator(
                    surface.projected(truth + step * (np.cos(a) * e1 + np.sin(a) * e2)), e1, e2
                )
            )
            for a in np.linspace(0.0, 2.0 * np.pi, 721)
        ]
    )
    np.testing.assert_allclose(rise.min(axis=0) / step, slope, rtol=0.05)
