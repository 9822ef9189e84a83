"""A closer look where the field turns: fits of higher degree around its umbilics.

A cubic over the rings that serve the whole mesh leaves an error in the deviator that matters
only where the deviator is small. There degree four over some hundred samples, or five on clean
meshes, leaves a half to a fifth of it. What it finds elsewhere than the cubic is looked at in
turn, until every umbilic of the field stands on the better fit.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from ..base.progress import Progress
from ..fields.winding import certified_index
from ..mesh.surface import Surface
from .field import CurvatureField
from .jets import fit_jets
from .scale import Scale, grow_while_it_falls

# Degree and, on clean meshes, rings.
CLEAN = (5, 3)
NOISY = 4
# 13 rings of an even mesh hold 547 samples.
MOST_RINGS = 13
# Vertices around an umbilic's triangle that are fitted anew, in rings.
AROUND = 2
# Rounds of looking at what the last one has left.
ROUNDS = 4
# Vertices whose fits choose the scale.
SAMPLED = 100
# Vertices that are fitted anew at most, as a share of the mesh and in any case: where noise makes
# umbilics everywhere a closer look costs much and does not help.
MOST_SHARE = 0.2
MOST_ANYWAY = 2000


@dataclasses.dataclass(frozen=True)
class Closer:
    """A field with the better of two fits at each vertex.

    Attributes
    ----------
    field, radius:
        As in `Estimate`.
    scale:
        Of the fits of higher degree; None where none was made.
    degree:
        Their degree.
    """

    field: CurvatureField
    radius: np.ndarray
    scale: Scale | None
    degree: int


def look_closer(
    surface: Surface,
    field: CurvatureField,
    radius: np.ndarray,
    scale: Scale,
    progress: Progress,
    exact: np.ndarray | None = None,
) -> Closer:
    """Fit anew around the umbilics of the field; the fit with the smaller error stays.

    Parameters
    ----------
    field, radius:
        What cubic jets at `scale` give at the n vertices; `field.noise` its standard errors.
    exact:
        (n,) bool, vertices that nothing is fitted at, or None.
    """
    degree = CLEAN[0] if scale.neighbourhood.focused else NOISY
    seen, fits = np.zeros(len(radius), bool) if exact is None else exact.copy(), 0
    most = max(MOST_ANYWAY, round(MOST_SHARE * len(radius)))
    closer: Scale | None = None
    for _ in range(ROUNDS):
        vertices = _around_umbilics(surface, field, seen, progress.quiet())
        if closer is None:
            if len(vertices) == 0:
                break
            closer = _closer_scale(surface, scale, vertices, progress.quiet())
            # A fit that a border cuts in half sees too little of what its higher terms mean.
            seen |= surface.near_border(closer.neighbourhood.rings // 2 + 1)
            vertices = vertices[~seen[vertices]]
        fits += len(vertices)
        if len(vertices) == 0 or fits > most:
            break
        seen[vertices] = True
        jets = fit_jets(surface, closer.normals, closer.neighbourhood, progress, vertices, degree)
        noise = closer.factor * jets.noise
        better = jets.determined & ~(noise >= field.noise[vertices])
        rows = vertices[better]
        values = {name: value.copy() for name, value in vars(field).items()}
        for name in ("k1", "k2", "d1", "d2", "normal"):
            values[name][rows] = getattr(jets, name)[better]
        values["noise"][rows] = noise[better]
        field = CurvatureField(**values)
        radius = radius.copy()
        radius[rows] = jets.radius[better]
    return Closer(field, radius, closer, degree)


def _around_umbilics(
    surface: Surface, field: CurvatureField, seen: np.ndarray, progress: Progress
) -> np.ndarray:
    """Vertices around the umbilics of the field that were not looked at."""
    index = certified_index(surface, field.d1, field.d2, progress)
    near = np.zeros(len(seen), bool)
    near[surface.triangles[np.flatnonzero(index)]] = True
    for _ in range(AROUND):
        inside = np.flatnonzero(near[surface.triangles].any(axis=1))
        near[surface.triangles[inside]] = True
    return np.flatnonzero(near & ~seen)


def _closer_scale(
    surface: Surface, scale: Scale, vertices: np.ndarray, progress: Progress
) -> Scale:
    some = vertices[:: max(len(vertices) // SAMPLED, 1)]
    if scale.neighbourhood.focused:
        around = dataclasses.replace(scale.neighbourhood, rings=CLEAN[1])
        return Scale(around, scale.normals, 1.0)
    around = dataclasses.replace(scale.neighbourhood, rings=max(scale.neighbourhood.rings, 3))
    return grow_while_it_falls(surface, scale.normals, around, some, progress, NOISY, MOST_RINGS)
