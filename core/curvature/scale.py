"""The scale at which a surface is looked at: how far the jets reach, chosen from the noise.

A fit over few rings follows the noise, one over many smooths the surface away. Lepski's rule
(1991) takes the largest neighbourhood that still agrees with the smaller ones within their
noise: up to there only noise was averaged out, beyond it the surface's own shape is lost.

One scale serves the whole mesh. The same rule at every vertex was measured: it places umbilics
better where the noise differs over the mesh, but finds fewer and adds false ones (docs/scale.md).
"""

from __future__ import annotations

import dataclasses

import numpy as np

from ..base.progress import Progress
from ..fields.frames import frame
from ..mesh.neighbourhoods import Neighbourhood
from ..mesh.normals import smooth_normals
from ..mesh.surface import Surface
from .field import CurvatureField
from .jets import SAMPLES_PER_BLOCK, Jets, fit_jets

# Vertices that are fitted at every scale to choose one; medians over them are steady.
SAMPLED = 2000
# Median disagreement of two neighbouring scales, in standard errors of the smaller one, that
# noise alone explains: it measures 0.6 to 0.9 where there is nothing else, 1 and more where the
# shape is lost. On noisy ellipsoids, patches and tori this picks a scale whose true error is at
# most 1.4 times the least.
AGREEMENT = 0.95
# Disagreement of two and three rings from which the shape shows so clearly above the noise that
# weights in favour of near samples pay.
CLEAN = 1.5
# Eight rings hold about 200 vertices; heavier noise than they average out hides the surface.
MOST_RINGS = 8
# Length over width of the rings around the median vertex above which the nearest samples stand
# for the rings. On noisy ellipsoids of stretched triangles this places umbilics to 0.2 to 0.6
# edges instead of 1 to 2.3, and x^4 + y^4 + z^4 = 1 shows its stars at all.
STRETCHED = 1.5
# Rings that a fit must reach further to show whether the mesh resolves the shape, and the share
# of the change that counts as error. With these the test patch keeps its weak pair in ten of ten
# meshings; with the whole change it loses it in several.
FURTHER = 2
CHANGE_SHARE = 0.5
# Residuals below this share of the radius are round-off: there is no noise to average out.
ROUND_OFF = 1e-10


def choose(
    surface: Surface, normals: np.ndarray, neighbourhood: Neighbourhood, progress: Progress
) -> tuple[Neighbourhood, np.ndarray]:
    """The given neighbourhood with as many rings as the noise of the surface asks for, and the
    `starting_normals` that go with it.

    Parameters
    ----------
    normals:
        (n, 3) float64 unit vertex normals, not smoothed.
    """
    interior = np.flatnonzero(~surface.border)
    if not len(interior):
        return neighbourhood, normals
    centres = interior[:: max(len(interior) // SAMPLED, 1)]

    def fitted(candidate: Neighbourhood, start: np.ndarray) -> Jets:
        return fit_jets(surface, start, candidate, progress, centres)

    neighbourhood = dataclasses.replace(neighbourhood, rings=2, focused=False)
    smaller = fitted(neighbourhood, normals)
    if np.median(smaller.residual) <= ROUND_OFF * np.median(smaller.radius):
        return dataclasses.replace(neighbourhood, focused=True), normals
    # On a clean mesh this settles it, before any normal is smoothed.
    three = fitted(dataclasses.replace(neighbourhood, rings=3), normals)
    if _disagreement(smaller, three, normals[centres]) > CLEAN:
        return dataclasses.replace(neighbourhood, focused=True), normals
    stretch = _stretch(neighbourhood, centres)
    if stretch < STRETCHED:
        stretch = 1.0
    start = smoothed = normals
    for rings in range(3, MOST_RINGS + 1):
        candidate = dataclasses.replace(neighbourhood, rings=rings, stretch=stretch)
        # What `starting_normals` gives, from where the candidate before has come to.
        smoothed = smooth_normals(surface, smoothed, 1 if rings > 3 else 3)
        larger = fitted(candidate, smoothed)
        if _disagreement(smaller, larger, normals[centres]) > AGREEMENT:
            break
        smaller, neighbourhood, start = larger, candidate, smoothed
    return neighbourhood, start


def starting_normals(
    surface: Surface, normals: np.ndarray, neighbourhood: Neighbourhood, progress: Progress
) -> np.ndarray:
    """(n, 3) normals to start the fits from: noise that asks for more than two rings also tilts
    the normals of small triangles, so they are smoothed as far as the rings reach."""
    if neighbourhood.rings == 2:
        return normals
    return smooth_normals(surface, normals, neighbourhood.rings, progress)


def change_of_scale(
    surface: Surface,
    field: CurvatureField,
    neighbourhood: Neighbourhood,
    vertices: np.ndarray,
    progress: Progress,
) -> np.ndarray:
    """(c,) error of the deviator at some vertices by how it changes when the fit reaches further.

    Where the mesh resolves the shape it hardly changes; where detail is as small as the edges it
    changes as much as the deviator itself, though the residuals of the fit may be small.

    Parameters
    ----------
    field:
        Shape operators at the vertices of the surface, fitted to `neighbourhood`.
    vertices:
        (c,) vertices of the surface.
    """
    wider = dataclasses.replace(
        neighbourhood, rings=neighbourhood.rings + FURTHER, reach=None, focused=False
    )
    unique, place = np.unique(vertices, return_inverse=True)
    jets = fit_jets(surface, field.normal, wider, progress.quiet(), unique)
    e1, e2 = frame(field.normal[unique].T)
    here = CurvatureField(**{name: value[unique] for name, value in vars(field).items()})
    change = np.abs(_deviator(here, e1, e2) - _deviator(jets, e1, e2))
    return CHANGE_SHARE * change[place]


def _stretch(neighbourhood: Neighbourhood, centres: np.ndarray) -> float:
    """Median length over width of the rings around some vertices."""
    points = neighbourhood.surface.vertices
    stretch = np.ones(len(centres))
    for rows, members in neighbourhood.blocks(centres, SAMPLES_PER_BLOCK):
        offset = points[members] - points[members].mean(axis=0)
        _, width, length = np.linalg.eigvalsh(np.einsum("sbi,sbj->bij", offset, offset)).T
        stretch[rows] = np.sqrt(length / np.maximum(width, np.finfo(float).tiny))
    return float(np.median(stretch))


def _disagreement(smaller: Jets, larger: Jets, normals: np.ndarray) -> float:
    """Median change from one scale to the next, in standard errors of the smaller one."""
    both = smaller.determined & larger.determined
    error = float(np.median(smaller.noise[both])) if both.any() else 0.0
    if error == 0.0:
        return np.inf
    e1, e2 = frame(normals.T)
    bent = np.abs(_deviator(smaller, e1, e2) - _deviator(larger, e1, e2))
    # The mean curvature too: on a sphere the deviator stays zero however far the fit reaches.
    curved = np.abs(smaller.k1 + smaller.k2 - larger.k1 - larger.k2)
    return max(float(np.median(bent[both])), float(np.median(curved[both]))) / error


def _deviator(jets: Jets | CurvatureField, e1: np.ndarray, e2: np.ndarray) -> np.ndarray:
    direction = np.einsum("nc,cn->n", jets.d1, e1) + 1j * np.einsum("nc,cn->n", jets.d1, e2)
    return (jets.k1 - jets.k2) * direction**2
