"""What holds the vertices of a quad mesh on its surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....base.unit import unit
from ..conformity import side_ends
from .projection import ClosestPoints

# Cosine to the surface down to which a quad's own plane is taken for the surface's under it: on
# coarse and sharp surfaces it is the better one, folded quads have none.
OWN_PLANE = 0.5
# Points times segments that are looked at together.
BLOCK = 1 << 18
# A vertex on a curve goes this part of the way to the next at most, along the curve.
NEAREST = 0.4
# Places on a line are exact to this part of the size of the surface.
ROUNDING = 1e-9


@dataclass(frozen=True)
class Guides:
    """What holds and turns the vertices of a quad mesh.

    Attributes
    ----------
    surface:
        Where vertices are kept.
    direction:
        (m, 3) float64 unit directions to turn to in its triangles.
    size:
        (m,) float64 what edges shall measure there against one another.
    fixed:
        (n,) bool vertices that do not move.
    curve:
        (n,) int64 polyline that a vertex slides along, -1 for none.
    beside:
        (n, 2) int64 vertices before and after it there, -1 for none.
    curves:
        The polylines' starts and ends, (s, 3) each.
    thin:
        Whether sheets and rods may be thinner than quads: those at hand then count more than the
        surface that is nearest, which may be that of another side.
    weight:
        (m,) float64 how much the directions count in its triangles, 1 as a mean; None for all
        alike.
    """

    surface: ClosestPoints
    direction: np.ndarray
    size: np.ndarray
    fixed: np.ndarray
    curve: np.ndarray
    beside: np.ndarray
    curves: dict[int, tuple[np.ndarray, np.ndarray]]
    thin: bool = False
    weight: np.ndarray | None = None


def on_curve(points: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Closest points (p, 3) of a polyline with the given segments."""
    within = np.broadcast_to([0.0, np.inf], (len(points), 2))
    return _nearest(points, start, end, within)[0]


def _nearest(
    points: np.ndarray, start: np.ndarray, end: np.ndarray, within: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The closest places (p, 3) to points (p, 3) on a polyline, each `within` (p, 2) lengths along
    it, and how far along it (p,) they are."""
    along = end - start
    square = np.maximum((along**2).sum(axis=1), np.finfo(float).tiny)
    length = np.sqrt(square)
    before = np.cumsum(length) - length
    place, passed = np.empty_like(points), np.empty(len(points))
    size = max(BLOCK // len(start), 1)
    for first in range(0, len(points), size):
        some, reach = points[first : first + size], within[first : first + size]
        least, most = (np.clip((reach[:, [k]] - before) / length, 0.0, 1.0) for k in (0, 1))
        share = ((some[:, None] - start) * along).sum(axis=2) / square
        share = np.minimum(np.maximum(share, least), most)
        found = start + share[:, :, None] * along
        away = ((found - some[:, None]) ** 2).sum(axis=2)
        # Beyond the reach nothing is near.
        away[(before > reach[:, [1]]) | (before + length < reach[:, [0]])] = np.inf
        row, nearest = np.arange(len(some)), away.argmin(axis=1)
        place[first : first + size] = found[row, nearest]
        passed[first : first + size] = before[nearest] + (share * length)[row, nearest]
    return place, passed


def _slid(
    at: np.ndarray, step: np.ndarray, ends: np.ndarray, start: np.ndarray, end: np.ndarray
) -> np.ndarray:
    """Where points (p, 3) of a polyline, with those before and after them there, `ends` (p, 2, 3),
    come by a step (p, 3): to the closest place within a part of what is between, measured along
    the line. Where that is jagged the closest of all may lie beyond the next one.
    """
    points = np.concatenate([at, ends[:, 0], ends[:, 1]])
    points, row = np.unique(points, axis=0, return_inverse=True)
    whole = np.broadcast_to([0.0, np.inf], (len(points), 2))
    place, passed = _nearest(points, start, end, whole)
    here, before, after = passed[row.ravel()].reshape(3, -1)
    between = np.stack([here - before, after - here], axis=1)
    if (start[0] == end[-1]).all():
        # A ring goes on where it began.
        around = np.linalg.norm(end - start, axis=1).sum()
        between, here = between % around, here + around
        start, end = np.tile(start, (3, 1)), np.tile(end, (3, 1))
    # Where a feature fades in the open its end may leave the line.
    off = (np.abs(place - points) > ROUNDING)[row.ravel()][len(at) :].any(axis=1).reshape(2, -1).T
    straight = np.linalg.norm(ends - at[:, None], axis=2)
    between = np.where(off | (between < 0.0), straight, between)
    within = here[:, None] + NEAREST * between * [-1.0, 1.0]
    return _nearest(at + step, start, end, within)[0]


def vertex_normals(position: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """(n, 3) normals of the quads around each vertex, weighted by area."""
    at = position[quads]
    normal = np.cross(at[:, 2] - at[:, 0], at[:, 3] - at[:, 1])
    flat = quads.ravel()
    total = [
        np.bincount(flat, np.repeat(normal[:, axis], 4), minlength=len(position))
        for axis in range(3)
    ]
    return np.stack(total, axis=1)


def beside(position: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """(q, 3) sum of the unit normals of the quads across the sides of each."""
    at = position[quads]
    normal = unit(np.cross(at[:, 2] - at[:, 0], at[:, 3] - at[:, 1]))
    tail, head = side_ends(quads)
    key, back = tail * len(position) + head, head * len(position) + tail
    order = np.argsort(key)
    place = np.minimum(np.searchsorted(key, back, sorter=order), len(key) - 1)
    other = order[place]
    shared = key[other] == back
    return np.where(shared[:, None], normal[other // 4], 0.0).reshape(-1, 4, 3).sum(axis=1)


def filled_corner(position: np.ndarray, quads: np.ndarray, beside: np.ndarray) -> np.ndarray:
    """(q,) int64 vertex at the worst corner of each quad where both its sides there run along
    features, by the (n, 2) vertices `beside` each along them; -1 for others."""
    at = position[quads]
    out, back = np.roll(at, -1, axis=1) - at, np.roll(at, 1, axis=1) - at
    normal = np.cross(at[:, 2] - at[:, 0], at[:, 3] - at[:, 1])
    sine = np.einsum("qkc,qc->qk", np.cross(out, back), normal)
    length = np.linalg.norm(out, axis=2) * np.linalg.norm(back, axis=2)
    sine /= np.maximum(length, np.finfo(float).tiny)
    row, worst = np.arange(len(quads)), sine.argmin(axis=1)
    corner = quads[row, worst]
    found = np.ones(len(quads), bool)
    for step in (1, 3):
        other = quads[row, (worst + step) % 4]
        along = (beside[corner] == other[:, None]).any(axis=1)
        found &= along | (beside[other] == corner[:, None]).any(axis=1)
    return np.where(found, corner, -1)


def surface_axes(at: np.ndarray, normals: np.ndarray, guides: Guides) -> np.ndarray:
    """(q, 3) unit normals of the planes in which quads (q, 4, 3), with normals (q, 4, 3) at their
    corners, are seen."""
    normal = np.cross(at[:, 2] - at[:, 0], at[:, 3] - at[:, 1])
    around = normals.sum(axis=1)
    triangle, _ = guides.surface(at.mean(axis=1), around)
    return own_planes(normal, around, triangle, guides)


def own_planes(
    normal: np.ndarray, around: np.ndarray, triangle: np.ndarray, guides: Guides
) -> np.ndarray:
    """(q, 3) unit normals of quads, or of the triangles (q,) below where they are too far from
    these, and from the quads around too where those count."""
    own, below = unit(normal), guides.surface.normal[triangle]
    near = np.einsum("qc,qc->q", own, below) > OWN_PLANE
    if guides.thin:
        near |= np.einsum("qc,qc->q", own, unit(around)) > OWN_PLANE
    return np.where(near[:, None], own, below)


def moved_along(
    start: np.ndarray,
    step: np.ndarray,
    rows: np.ndarray,
    position: np.ndarray,
    quads: np.ndarray,
    guides: Guides,
) -> np.ndarray:
    """Where the vertices `rows` (r,) at `start` (r, 3) come by a step (r, 3): on the surface, and
    on its curve who slides along one, without coming too near to the next."""
    held = guides.curve[rows] >= 0
    moved = start + step
    for curve in np.unique(guides.curve[rows[held]]):
        mine = np.flatnonzero(guides.curve[rows] == curve)
        ends = position[guides.beside[rows[mine]]]
        moved[mine] = _slid(start[mine], step[mine], ends, *guides.curves[int(curve)])
    normals = vertex_normals(position, quads)[rows[~held]]
    moved[~held] = guides.surface(moved[~held], normals)[1]
    return moved
