"""A closer look where the field turns: fits of higher degree around its umbilics.

A cubic over the rings that serve the whole mesh leaves an error in the deviator that matters
only where the deviator is small. There degree four or five over some hundred samples, or five on
clean meshes, leaves a half to a fifth of it. What it finds elsewhere than the cubic is looked at in
turn, until every umbilic of the field stands on the better fit.

Where the errors of the points are independent each place has a window of its own, chosen by
their variances. Where neighbours share them, as on marching cubes, or samples are not rings, the
variance is not known well enough for that, and one scale serves all places.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from ...base.progress import Progress
from ...fields.winding import Winding
from ...mesh.rings import ring_around
from ...mesh.surface import Surface
from ..field import CurvatureField
from ..fits.jets import fit_jets
from ..scale import Scale, SmoothedNormals, grow_while_it_falls
from .blend import Blend
from .windows import best_fits

# Degree and, on clean meshes, rings.
CLEAN = (5, 3)
# Degree elsewhere; 13 rings of an even mesh hold 547 samples.
NOISY, MOST_RINGS = 4, 13
# Vertices whose fits choose the scale.
SAMPLED = 100
# Vertices around an umbilic's triangle that are fitted anew, in rings.
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
        Their degree; where it differs from place to place, that of `degrees`.
    rings, degrees:
        (n,) int64 rings and degree of the fit at each vertex, 0 where the cubic stayed; None where
        all are those of `scale`.
    winding:
        Of the field.
    """

    field: CurvatureField
    radius: np.ndarray
    scale: Scale | None
    degree: int
    winding: Winding
    rings: np.ndarray | None = None
    degrees: np.ndarray | None = None


def look_closer(
    surface: Surface,
    field: CurvatureField,
    radius: np.ndarray,
    scale: Scale,
    progress: Progress,
    exact: np.ndarray | None = None,
    start: np.ndarray | None = None,
) -> Closer:
    """Fit anew around the umbilics of the field; the fit with the smaller error stays.

    Parameters
    ----------
    field, radius:
        What cubic jets at `scale` give at the n vertices; `field.noise` its standard errors.
    exact:
        (n,) bool, vertices that nothing is fitted at, or None.
    start:
        (n, 3) unit normals that the cubic jets started from; those of the field if None.
    """
    if scale.neighbourhood.focused or scale.neighbourhood.stretch > 1 or scale.shared:
        return _at_one_scale(surface, field, radius, scale, progress, exact, start)
    blend = Blend.over(field, radius)
    # A fit that a border cuts in half sees too little of what its higher terms mean.
    seen = surface.near_border(scale.neighbourhood.rings).copy()
    if exact is not None:
        seen |= exact
    most = max(MOST_ANYWAY // 4, round(MOST_FITS * len(radius)))
    fits, now, normals = 0, field, field.normal if start is None else start
    winding = Winding.of(surface, now.d1, now.d2, progress.quiet())
    for _ in range(ROUNDS):
        triangles = np.flatnonzero(winding.index)
        triangles = triangles[~seen[surface.triangles[triangles]].any(axis=1)]
        triangles = triangles[(blend.share[surface.triangles[triangles]] < 1.0).any(axis=1)]
        fits += len(triangles)
        if len(triangles) == 0 or fits > most:
            break
        seen[surface.triangles[triangles].ravel()] = True
        fitted = best_fits(surface, normals, scale, triangles, progress.quiet())
        blend.add(surface, fitted, exact)
        now = blend.field()
        winding = winding.after(surface, np.flatnonzero(blend.weight), now.d1, now.d2)
    if not blend.rings.any():
        return Closer(field, radius, None, 0, winding)
    return Closer(now, blend.radius, scale, NOISY, winding, blend.rings, blend.degrees)


def _at_one_scale(
    surface: Surface,
    field: CurvatureField,
    radius: np.ndarray,
    scale: Scale,
    progress: Progress,
    exact: np.ndarray | None,
    start: np.ndarray | None,
) -> Closer:
    degree = CLEAN[0] if scale.neighbourhood.focused else NOISY
    seen, fits = np.zeros(len(radius), bool) if exact is None else exact.copy(), 0
    most = max(MOST_ANYWAY, round(MOST_SHARE * len(radius)))
    closer: Scale | None = None
    ask = progress.quiet()
    field = CurvatureField(**{name: value.copy() for name, value in vars(field).items()})
    radius = radius.copy()
    winding = Winding.of(surface, field.d1, field.d2, ask)
    for _ in range(ROUNDS):
        vertices = _around_umbilics(surface, winding, seen)
        if closer is None:
            if len(vertices) == 0:
                break
            normals = field.normal if start is None else start
            closer, normals = _closer_scale(normals, scale, vertices, ask, start is None)
            # A fit that a border cuts in half sees too little of what its higher terms mean.
            seen |= surface.near_border(closer.neighbourhood.rings // 2 + 1)
            vertices = vertices[~seen[vertices]]
        fits += len(vertices)
        if len(vertices) == 0 or fits > most:
            break
        seen[vertices] = True
        jets = fit_jets(surface, normals, closer.neighbourhood, ask, vertices, degree)
        noise = closer.factor * jets.noise
        better = jets.determined & ~(noise >= field.noise[vertices])
        rows = vertices[better]
        for name in ("k1", "k2", "d1", "d2", "normal"):
            getattr(field, name)[rows] = getattr(jets, name)[better]
        field.noise[rows] = noise[better]
        radius[rows] = jets.radius[better]
        winding = winding.after(surface, rows, field.d1, field.d2)
    return Closer(field, radius, closer, degree if closer else 0, winding)


def _closer_scale(
    normals: np.ndarray,
    scale: Scale,
    vertices: np.ndarray,
    progress: Progress,
    fitted: bool,
) -> tuple[Scale, np.ndarray]:
    """The scale of the fits around vertices, and the normals (n, 3) that these start from: the
    given ones where they are `fitted`, else smoothed as far as the fits reach."""
    around = scale.neighbourhood
    if around.focused:
        return Scale(dataclasses.replace(around, rings=CLEAN[1])), normals
    some = vertices[:: max(len(vertices) // SAMPLED, 1)]
    passes = around.rings
    around = dataclasses.replace(around, rings=max(passes, 3))
    smoothing = SmoothedNormals(normals, around, some, progress, passes)
    further = None if fitted else smoothing
    grown = grow_while_it_falls(normals, around, some, progress, NOISY, MOST_RINGS, further)
    return grown, smoothing.normals


def _around_umbilics(surface: Surface, winding: Winding, seen: np.ndarray) -> np.ndarray:
    """Vertices around the umbilics of a field that were not looked at."""
    corners = surface.triangles[np.flatnonzero(winding.index)].ravel()
    near = ring_around(surface, corners, AROUND)
    return near[~seen[near]]
