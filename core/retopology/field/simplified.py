"""The principal directions without the umbilics that were dropped.

Pairs that noise made, or that the user left out, still swirl in the directions at the vertices.
Here they leave: the field's certified singularities are then the kept umbilics and the regions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from ...base.progress import Progress
from ...curvature.field import CurvatureField
from ...curvature.noise import field_noise
from ...fields.winding import Winding
from ...mesh.input_map import places_on_surface
from ...mesh.surface import Surface
from ...umbilics.result import Umbilics
from ..crosses.smoothing import NOISE_RATIO, WEAK_GAP
from .agreement import with_index
from .filled import filled_in

# Resistance to turning, in that of an edge, of directions that are sure and of those around a kept
# umbilic. They are not held altogether: two umbilics near each other would let nothing through.
STIFF = 10.0
# Each pair leaves within about two rings around an edge. Where these would cover the surface, more
# than one triangle in so many to change, nothing is between them to go by: the field is smoothed
# first. Between ellipsoids of heavy noise (one in 7 to 10), on which directions then err half as
# much, and Suzanne (one in 13), whose plan is met exactly without. Confirmed: a quartic and a
# random ellipsoid under noise, one in 6 to 9, err by .4 to .8 of what they do without; a quartic,
# one in 34, errs more if smoothed (in 17 less), and a dragon, one in 21, keeps 49 places for 41.
ZONE = 12


@dataclass(frozen=True)
class SimplifiedField:
    """The field that lines, crosses and poles follow.

    Attributes
    ----------
    curvature:
        The shape operators at the vertices of the surface, with other directions where umbilics
        left.
    index:
        (m,) float64 its certified index in each triangle.
    stayed:
        (s,) int64 triangles with an umbilic that was to leave and cannot: nothing is left that
        it could cancel with.
    """

    curvature: CurvatureField
    index: np.ndarray
    stayed: np.ndarray


def simplify_field(
    surface: Surface,
    field: CurvatureField,
    umbilics: Umbilics,
    candidates: Umbilics,
    regions: Sequence[np.ndarray],
    undirected: np.ndarray,
    progress: Progress,
) -> SimplifiedField:
    """Take the dropped umbilics out of a field; elsewhere it stays as it is.

    Parameters
    ----------
    field:
        Shape operators at the vertices of the surface, in its coordinates.
    umbilics, candidates:
        The kept ones and all, in input rows and coordinates.
    regions:
        For each region the rows of its triangles.
    undirected:
        (m,) bool triangles of those without directions, where every index stays; of the others the
        sum does.
    """
    winding = Winding.of(surface, field.d1, field.d2, progress.part("Counting", 0.0, 0.1))
    index = winding.index
    # Methods that pair nothing find other points than these.
    if len(candidates) and np.isnan(candidates.persistence).all():
        return SimplifiedField(field, index, np.zeros(0, np.int64))
    inside = np.zeros(len(index), bool)
    for rows in regions:
        inside[rows] = True
    single = np.flatnonzero((index != 0.0) & ~inside)
    candidate = _candidates_at(surface, single, index[single], candidates)
    kept = (candidate >= 0) & np.isin(candidate, _nearest(umbilics, candidates))
    wanted = np.zeros(len(index))
    wanted[single[kept]] = index[single[kept]]
    for rows in regions:
        undecided = bool(undirected[rows].any())
        wanted[rows] = index[rows] if undecided else _least(index[rows])
    priority = np.zeros(len(index))
    known = candidate >= 0
    priority[single[known]] = np.nan_to_num(candidates.persistence[candidate[known]])
    certainty = _certainty(field)
    changing = np.flatnonzero(index != wanted)
    lines, stiffness = field.lines, STIFF * certainty
    if ZONE * len(changing) > len(index):
        held = np.zeros(len(certainty), bool)
        held[surface.triangles[undirected | ((wanted != 0.0) & (wanted == index))]] = True
        part = progress.part("Simplifying the field", 0.1, 0.6)
        lines, winding = filled_in(surface, lines, winding, changing, held, certainty, part)
        # What is left then turns as readily as an edge.
        stiffness = certainty.copy()
    stiffness[surface.triangles[single[kept]]] = STIFF
    part = progress.part("Simplifying the field", 0.6, 1.0)
    found = with_index(surface, lines, wanted, priority, stiffness, part, winding=winding)
    changed = replace(field, d1=found.field.direction, d2=found.field.across)
    return SimplifiedField(changed, found.index, found.stayed)


def in_doubt(
    surface: Surface, measured: CurvatureField, simplified: CurvatureField
) -> CurvatureField:
    """The measured directions with the errors that simplifying them tells of.

    A direction that had to turn by an angle for dropped umbilics to leave was wrong by that at
    least. What is smoothed afterwards goes by the measured ones, each weighed by its error: the
    turned ones, packed into a few rings, would be as wild as what left.
    """
    noise = measured.noise
    if not np.isfinite(noise).any():
        noise, _ = field_noise(surface, measured.k1, measured.k2, measured.d1, measured.normal)
    # Of the deviator: the chord between it before and after.
    cosine = np.einsum("nc,nc->n", measured.d1, simplified.d1)
    sine = np.sqrt(np.maximum(1.0 - cosine**2, 0.0))
    return replace(measured, noise=np.hypot(noise, 2.0 * measured.gap * sine))


def _least(index: np.ndarray) -> np.ndarray:
    """(r,) as few of the indices (r,) of a region as make up their sum."""
    left = np.zeros(len(index))
    total = float(index.sum())
    same = np.flatnonzero(index * total > 0.0)
    size = np.abs(index[same])
    left[same] = np.sign(total) * np.clip(abs(total) - (np.cumsum(size) - size), 0.0, size)
    return left


def _certainty(field: CurvatureField) -> np.ndarray:
    """(n,) float64 how sure the directions are, 0 to 1: by their noise, or where that is not known
    by the usual gap."""
    gap = np.nan_to_num(field.gap)
    doubt = NOISE_RATIO * field.noise
    doubt = np.where(np.isfinite(doubt), doubt, WEAK_GAP * float(np.median(gap)))
    return np.asarray(gap**2 / np.maximum(gap**2 + doubt**2, np.finfo(float).tiny))


def _candidates_at(
    surface: Surface, triangle: np.ndarray, index: np.ndarray, candidates: Umbilics
) -> np.ndarray:
    """(s,) the candidate found in each singular triangle, -1 for none."""
    if np.array_equal(index, candidates.index):
        # Found in these very triangles, in their order.
        return np.arange(len(index))
    # Directions that were stored and read again may turn otherwise at a few places, and a compound
    # is several: of each half that a candidate is made of one triangle, of what is left the nearest
    # pairs first. Components, one of which may lie within another, are apart along a fourth axis.
    component = surface.component[surface.triangles[:, 0]]
    inner, _ = places_on_surface(surface, candidates.triangle, candidates.barycentric)
    apart = 4.0 * float(np.ptp(surface.vertices, axis=0).max())
    middle = surface.vertices[surface.triangles[triangle]].mean(axis=1)
    place = np.column_stack([middle, apart * component[triangle]])
    position = (candidates.position - surface.origin) / surface.unit
    there = np.column_stack([position, np.where(inner >= 0, apart * component[inner], 0.0)])
    halves, parts = (
        np.rint(2.0 * np.abs(some)).astype(np.int64) for some in (candidates.index, index)
    )
    found = np.full(len(index), -1)
    for sign in (1.0, -1.0):
        mine = np.flatnonzero(sign * index > 0.0)
        mine = np.repeat(mine, parts[mine])
        theirs = np.flatnonzero(sign * candidates.index > 0.0)
        theirs = np.repeat(theirs, halves[theirs])
        while len(mine) and len(theirs):
            distance, near = cKDTree(place[mine]).query(there[theirs])
            order = np.lexsort((distance, near))
            _, first = np.unique(near[order], return_index=True)
            taken = order[first]
            found[mine[near[taken]]] = theirs[taken]
            mine, theirs = np.delete(mine, near[taken]), np.delete(theirs, taken)
    return found


def _nearest(umbilics: Umbilics, candidates: Umbilics) -> np.ndarray:
    """(k,) the candidate that each of the umbilics is: of its index, in its triangle and at its
    place, which components may share."""
    if not len(umbilics) or not len(candidates):
        return np.zeros(0, np.int64)
    extent = float(np.ptp(candidates.position, axis=0).max()) + 1.0
    one, two = (
        np.column_stack([some.position, 2.0 * extent * some.index, extent * some.triangle])
        for some in (candidates, umbilics)
    )
    return cKDTree(one).query(two)[1]
