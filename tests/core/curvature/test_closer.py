"""The closer look around umbilics: windows chosen place by place, laid over the cubic fits."""

import numpy as np
import pytest
import surfaces
from exact_fields import surface_of

import core
from core.base.progress import Progress
from core.base.unit import angles_between
from core.curvature.close_up.closer import _closer_scale, look_closer
from core.curvature.close_up.windows import best_fits, ladder
from core.curvature.field import CurvatureField
from core.curvature.fits.jets import fit_jets
from core.curvature.scale import choose, starting_normals
from core.fields.transport import doubled_angle, tangents
from core.fields.winding import certified_index
from core.mesh.neighbourhoods import Neighbourhood
from core.mesh.normals import vertex_normals
from core.mesh.rings import adjacency


def waves(length: float, noise: float):
    """A bowl with waves of that length along x, its vertices moved by a share of the edges."""
    points, triangles = surfaces.grid_points(70, 70, (-1.0, -1.0), (1.0, 1.0))
    x, y = points.T
    height = 0.6 * x * x + 0.3 * y * y + 0.02 * length**2 * np.cos(2 * np.pi * x / length)
    shift = np.random.default_rng(1).normal(size=(len(points), 3)) * noise * 2.0 / 70
    return np.column_stack([points, height]) + shift, triangles


def scale_of(vertices, triangles):
    surface, _ = core.mesh.mending.repair.clean(vertices, triangles)
    around = Neighbourhood(surface, adjacency(surface))
    return surface, choose(surface, vertex_normals(surface), around, Progress())


def inner(surface) -> np.ndarray:
    """Some triangles away from the border."""
    corners = surface.vertices[surface.triangles].mean(axis=1)
    middle = surface.vertices.mean(axis=0)
    return np.argsort(np.linalg.norm(corners - middle, axis=1))[:200:10]


def test_windows_are_wide_under_noise_and_narrow_on_detail():
    plain, scale = scale_of(*waves(100.0, 0.05))
    wide = best_fits(plain, vertex_normals(plain), scale, inner(plain), Progress())
    wavy, scale = scale_of(*waves(0.5, 0.01))
    narrow = best_fits(wavy, vertex_normals(wavy), scale, inner(wavy), Progress())
    assert np.median(wide.rings) >= 2 * np.median(narrow.rings)
    # What is chosen knows its error: the deviator at the middle of the bowl is 2 * (0.6 - 0.3).
    assert np.median(wide.error) * plain.unit**-1 < 0.05


def test_ladders_rise_to_a_bound():
    for rings in (2, 3, 5, 8, 24):
        steps = ladder(rings)
        assert steps == sorted(set(steps)) and steps[0] >= 3 and steps[-1] <= 20


@pytest.mark.once
@pytest.mark.parametrize("noise", [0.02, 0.1])
def test_the_field_is_better_around_umbilics_and_untouched_elsewhere(noise):
    exact = surfaces.quartic(5)
    noisy = surfaces.noisy(exact, noise, seed=3)
    surface = surface_of(noisy)
    around = Neighbourhood(surface, adjacency(surface))
    normals = vertex_normals(surface)
    scale = choose(surface, normals, around, Progress())
    assert not scale.neighbourhood.focused and scale.tilted
    start = starting_normals(surface, normals, scale.neighbourhood, Progress())
    jets = fit_jets(surface, start, scale.neighbourhood, Progress())
    noise_of = scale.factor * jets.noise
    field = CurvatureField(jets.k1, jets.k2, jets.d1, jets.d2, jets.normal, noise_of)
    closer = look_closer(surface, field, jets.radius, scale, Progress())
    rows = surface.source_vertex
    e1, e2 = tangents(exact.normal[rows])
    truth = doubled_angle(exact.d1[rows], e1, e2, (exact.k1 - exact.k2)[rows] * surface.unit)

    def error(field: CurvatureField, where: np.ndarray) -> float:
        value = doubled_angle(field.d1, e1, e2, field.gap)
        return float(np.sqrt((np.abs(value - truth)[where] ** 2).mean()))

    changed = closer.rings > 0
    assert changed.any()
    assert error(closer.field, changed) < 0.8 * error(field, changed)
    assert (closer.field.noise[changed] <= field.noise[changed]).all()
    for name in ("k1", "k2", "d1", "d2", "normal", "noise"):
        assert (getattr(closer.field, name)[~changed] == getattr(field, name)[~changed]).all()
    index = certified_index(surface, closer.field.d1, closer.field.d2, Progress())
    assert index.sum() == 2.0
    # What one round has left or moved the next ones have looked at.
    assert changed[surface.triangles[index != 0.0]].all()
    # Directions stay unit, tangent and at right angles where fits fade into the field.
    d1, d2, normal = closer.field.d1, closer.field.d2, closer.field.normal
    assert np.allclose(np.linalg.norm(d1, axis=1), 1.0)
    assert np.allclose(np.cross(d1, d2), normal, atol=1e-9)


def test_what_errs_less_than_the_closer_look_stays():
    surface = surface_of(surfaces.ellipsoid((1.3, 1.15, 1.0), 4))
    normals = vertex_normals(surface)
    scale = choose(surface, normals, Neighbourhood(surface, adjacency(surface)), Progress())
    assert scale.neighbourhood.focused
    jets = fit_jets(surface, normals, scale.neighbourhood, Progress())
    field = CurvatureField(jets.k1, jets.k2, jets.d1, jets.d2, jets.normal, jets.noise)
    usual = look_closer(surface, field, jets.radius, scale, Progress()).field
    better = usual.noise < field.noise
    assert better.sum() > 50
    # Every other one of these is told to err by nothing.
    exact = np.flatnonzero(better)[::2]
    field.noise[exact] = 0.0
    found = look_closer(surface, field, jets.radius, scale, Progress()).field
    assert (found.k1[exact] == field.k1[exact]).all() and (found.noise[exact] == 0.0).all()
    others = np.flatnonzero(better)[1::2]
    assert (found.k1[others] == usual.k1[others]).all()


@pytest.mark.once
def test_a_pair_within_the_errors_of_its_places_is_not_resolved():
    surface = surfaces.superquadric()
    vertices, triangles = surfaces.marching_tetrahedra(surface, 30)
    found = core.detect(vertices, triangles).candidates
    paired = np.flatnonzero(found.partner >= 0)
    other = found.partner[paired]
    apart = np.linalg.norm(found.position[paired] - found.position[other], axis=1)
    reach = np.hypot(found.uncertainty[paired], found.uncertainty[other])
    within = apart < 2.0 * reach
    assert within.any() and not found.resolved[paired[within]].any()


@pytest.mark.parametrize("fitted", [False, True])
def test_normals_that_no_fit_has_made_are_smoothed_as_the_rings_grow(fitted):
    exact = surfaces.quartic(5)
    surface = surface_of(surfaces.noisy(exact, 0.1, seed=3))
    normals = vertex_normals(surface)
    scale = choose(surface, normals, Neighbourhood(surface, adjacency(surface)), Progress())
    vertices = np.arange(0, len(normals), 20)
    grown, found = _closer_scale(normals, scale, vertices, Progress(), fitted)
    assert grown.neighbourhood.rings > scale.neighbourhood.rings
    true = exact.normal[surface.source_vertex]
    if fitted:
        assert (found == normals).all()
    else:
        assert angles_between(found, true).mean() < 0.7 * angles_between(normals, true).mean()
