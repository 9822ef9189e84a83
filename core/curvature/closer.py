"""A closer look where the field turns: fits of higher degree around its umbilics.

A cubic over the rings that serve the whole mesh leaves an error in the deviator that matters
only where the deviator is small. There degree four over some hundred samples, or five on clean
meshes, leaves a half to a fifth of it. What it finds elsewhere than the cubic is looked at in
turn, until every umbilic of the field stands on the better fit.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from ..base.progress import Progress
from ..fields.winding import certified_index
from ..mesh.surface import Surface
from .blend import Blend
from .field import CurvatureField
from .jets import fit_jets
from .scale import Scale
from .windows import DEGREE, best_fits

# Degree and, on clean meshes, rings.
CLEAN = (5, 3)
# Vertices around an umbilic's triangle that are fitted anew on clean meshes, in rings.
AROUND = 2
# Rounds of looking at what the last one has left.
ROUNDS = 4
# Vertices that are fitted anew at most, as a share of the mesh and in any case: where noise makes
# umbilics everywhere a closer look costs much and does not help.
MOST_SHARE = 0.2
MOST_ANYWAY = 2000
# Fits around umbilics at most, likewise.
MOST_FITS = 0.02


@dataclass(frozen=True)
class Closer:
    """A field with the better fits around its umbilics.

    Attributes
    ----------
    field, radius:
        As in `Estimate`.
    scale:
        Of the fits of higher degree; None where none was made.
    degree:
        Their degree.
    rings:
        (n,) int64 rings of the fit at each vertex, 0 where the cubic stayed; None where all are
        those of `scale`.
    """

    field: CurvatureField
    radius: np.ndarray
    scale: Scale | None
    degree: int
    rings: np.ndarray | None = None


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
    if scale.neighbourhood.focused:
        return _closer_on_clean(surface, field, radius, scale, progress, exact)
    blend = Blend.over(field, radius)
    # A fit that a border cuts in half sees too little of what its higher terms mean.
    seen = surface.near_border(scale.neighbourhood.rings).copy()
    if exact is not None:
        seen |= exact
    most = max(MOST_ANYWAY // 4, round(MOST_FITS * len(radius)))
    fits, now = 0, field
    for _ in range(ROUNDS):
        index = certified_index(surface, now.d1, now.d2, progress.quiet())
        triangles = np.flatnonzero(index)
        triangles = triangles[~seen[surface.triangles[triangles]].any(axis=1)]
        triangles = triangles[(blend.share[surface.triangles[triangles]] < 1.0).any(axis=1)]
        fits += len(triangles)
        if len(triangles) == 0 or fits > most:
            break
        seen[surface.triangles[triangles].ravel()] = True
        blend.add(surface, best_fits(surface, scale, triangles, progress.quiet()), exact)
        now = blend.field()
    if not fits or not blend.rings.any():
        return Closer(field, radius, None, 0)
    return Closer(now, blend.radius, scale, DEGREE, blend.rings)


def _closer_on_clean(
    surface: Surface,
    field: CurvatureField,
    radius: np.ndarray,
    scale: Scale,
    progress: Progress,
    exact: np.ndarray | None,
) -> Closer:
    degree, rings = CLEAN
    seen, fits = np.zeros(len(radius), bool) if exact is None else exact.copy(), 0
    most = max(MOST_ANYWAY, round(MOST_SHARE * len(radius)))
    closer = Scale(dataclasses.replace(scale.neighbourhood, rings=rings), scale.normals, 1.0)
    looked = False
    for _ in range(ROUNDS):
        vertices = _around_umbilics(surface, field, seen, progress.quiet())
        if not looked and len(vertices):
            seen |= surface.near_border(rings // 2 + 1)
            vertices = vertices[~seen[vertices]]
        fits += len(vertices)
        if len(vertices) == 0 or fits > most:
            break
        looked = True
        seen[vertices] = True
        jets = fit_jets(surface, closer.normals, closer.neighbourhood, progress, vertices, degree)
        better = jets.determined & ~(jets.noise >= field.noise[vertices])
        rows = vertices[better]
        values = {name: value.copy() for name, value in vars(field).items()}
        for name in ("k1", "k2", "d1", "d2", "normal", "noise"):
            values[name][rows] = getattr(jets, name)[better]
        field = CurvatureField(**values)
        radius = radius.copy()
        radius[rows] = jets.radius[better]
    return Closer(field, radius, closer if looked else None, degree if looked else 0)


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
