"""Evening out a quad mesh on its surface and turning it to the curvature.

Each step asks every quad for the rectangle nearest to it in the plane that touches the surface
there, turned to the directions of the surface where it nearly follows them; each vertex goes to
the mean of what its quads want and back to the surface (after Bouaziz et al. 2012,
10.1111/j.1467-8659.2012.03171.x). A folded quad wants an unfolded one, so folds open.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...base.progress import Progress
from .conformity import scaled_jacobian
from .crosses import QUARTER
from .projection import ClosestPoints

# A vertex goes this far towards what is wanted in a step.
RATE = 0.7
# Quads turn to the directions where they are off by less than the first angle, and not at all
# beyond the second, in degrees.
TURNED, LEFT = 25.0, 40.0
# How far sides are evened to the median, and the least part of it that a side may want.
EVEN, LEAST_SIDE = 0.1, 0.175
# Steps between two projections of all vertices.
BETWEEN = 3
# A quad is well enough above this least sine at its corners; rounds of mending those below.
SOUND, MENDING = 0.15, 40


@dataclass(frozen=True)
class Guides:
    """What holds and turns the vertices of a quad mesh.

    Attributes
    ----------
    surface:
        Where vertices are kept.
    direction:
        (m, 3) float64 unit directions to turn to in its triangles.
    trust:
        (m,) float64 0 to 1, how much to turn to them.
    fixed:
        (n,) bool vertices that do not move.
    curve:
        (n,) int64 polyline that a vertex slides along, -1 for none.
    curves:
        The polylines' starts and ends, (s, 3) each.
    size:
        (n,) float64 length that edges shall have around each vertex, or None for the median.
    """

    surface: ClosestPoints
    direction: np.ndarray
    trust: np.ndarray
    fixed: np.ndarray
    curve: np.ndarray
    curves: dict[int, tuple[np.ndarray, np.ndarray]]


def relaxed(
    position: np.ndarray, quads: np.ndarray, guides: Guides, steps: int, progress: Progress
) -> tuple[np.ndarray, np.ndarray]:
    """Positions (n, 3) after so many steps, and the triangles (n,) of the surface they lie on.

    Folded quads are mended after, whatever the number of steps.
    """
    position = position.copy()
    n = len(position)
    count = np.bincount(quads.ravel(), minlength=n)
    inner = np.ones(len(quads), bool)
    irregular = count != 4
    irregular &= guides.curve < 0
    inner[irregular[quads].any(axis=1)] = False
    neighbours = _along_curves(quads, guides, n)
    free = ~guides.fixed & (guides.curve < 0)
    plane = None
    for step in range(steps):
        progress.step(step / max(steps, 1))
        if step % BETWEEN == 0:
            plane = _planes(position, quads, guides)
        wanted = _wanted(position, quads, plane, inner)
        target = _mean(wanted, quads, count)
        _move(position, target, free, neighbours, guides)
        if step % BETWEEN == BETWEEN - 1 or step == steps - 1:
            _back(position, quads, free, guides)
    _mend(position, quads, free, guides, neighbours, count, progress)
    return position, guides.surface(position, _vertex_normals(position, quads))[0]


def _planes(position: np.ndarray, quads: np.ndarray, guides: Guides) -> tuple[np.ndarray, ...]:
    """(q, 3) two axes along the directions of the surface under each quad, and (q,) the trust."""
    at = position[quads]
    normal = np.cross(at[:, 2] - at[:, 0], at[:, 3] - at[:, 1])
    triangle, _ = guides.surface(at.mean(axis=1), normal)
    up = guides.surface.normal[triangle]
    x = guides.direction[triangle]
    x = x - up * np.einsum("qc,qc->q", x, up)[:, None]
    x /= np.maximum(np.linalg.norm(x, axis=1), np.finfo(float).tiny)[:, None]
    return x, np.cross(up, x), guides.trust[triangle]


def _wanted(
    position: np.ndarray, quads: np.ndarray, plane: tuple[np.ndarray, ...], inner: np.ndarray
) -> np.ndarray:
    """(q, 4, 3) corners of the rectangle that each quad wants."""
    x, y, trust = plane
    at = position[quads]
    centre = at.mean(axis=1, keepdims=True)
    off = at - centre
    z = np.einsum("qkc,qc->qk", off, x) + 1j * np.einsum("qkc,qc->qk", off, y)
    first = 0.5 * (z[:, 1] - z[:, 0] + z[:, 2] - z[:, 3])
    second = 0.5 * (z[:, 3] - z[:, 0] + z[:, 2] - z[:, 1])
    # The angle of the nearest rectangle, then towards the nearest axis.
    axis = first - 1j * second
    axis = axis / np.maximum(np.abs(axis), np.finfo(float).tiny)
    angle = np.angle(axis)
    off_axis = angle - QUARTER * np.rint(angle / QUARTER)
    share = (np.radians(LEFT) - np.abs(off_axis)) / np.radians(LEFT - TURNED)
    share = np.where(inner, trust, 0.0) * np.clip(share, 0.0, 1.0)
    axis = axis * np.exp(-1j * off_axis * share)
    width = np.maximum((first * axis.conj()).real, 0.0)
    height = np.maximum((second * (1j * axis).conj()).real, 0.0)
    typical = np.median(np.concatenate([width, height]))
    width, height = (
        np.maximum(side + EVEN * (typical - side), LEAST_SIDE * typical)
        for side in (width, height)
    )
    a, b = 0.5 * axis * width, 0.5j * axis * height
    corner = np.stack([-a - b, a - b, a + b, b - a], axis=1)
    return (
        centre
        + corner.real[:, :, None] * x[:, None]
        + corner.imag[:, :, None] * y[:, None]
    )


def _mean(wanted: np.ndarray, quads: np.ndarray, count: np.ndarray) -> np.ndarray:
    """(n, 3) mean of what the quads at each vertex want."""
    flat = quads.ravel()
    total = [
        np.bincount(flat, wanted[:, :, axis].ravel(), minlength=len(count)) for axis in range(3)
    ]
    return np.stack(total, axis=1) / np.maximum(count, 1)[:, None]


def _along_curves(quads: np.ndarray, guides: Guides, n: int) -> np.ndarray:
    """(n, 2) the vertices before and after each one that slides along a curve, else -1."""
    tail, head = quads.ravel(), np.roll(quads, -1, axis=1).ravel()
    tail, head = np.concatenate([tail, head]), np.concatenate([head, tail])
    held = guides.curve >= 0
    along = held[tail] & (guides.fixed | held)[head]
    along &= (guides.curve[head] == guides.curve[tail]) | guides.fixed[head]
    pairs = np.unique(np.column_stack([tail[along], head[along]]), axis=0)
    number = np.bincount(pairs[:, 0], minlength=n)
    result = np.full((n, 2), -1)
    two = np.flatnonzero(number == 2)
    keep = np.isin(pairs[:, 0], two)
    result[two] = pairs[keep, 1].reshape(-1, 2)
    return result


def _move(
    position: np.ndarray,
    target: np.ndarray,
    free: np.ndarray,
    neighbours: np.ndarray,
    guides: Guides,
) -> None:
    """One step of all vertices, in place; those on curves stay on them."""
    sliding = np.flatnonzero((guides.curve >= 0) & ~guides.fixed & (neighbours[:, 0] >= 0))
    between = position[neighbours[sliding]].mean(axis=1)
    wanted = 0.5 * target[sliding] + 0.5 * between
    position[free] += RATE * (target[free] - position[free])
    for curve in np.unique(guides.curve[sliding]):
        mine = guides.curve[sliding] == curve
        rows = sliding[mine]
        position[rows] = _on_curve(
            position[rows] + RATE * (wanted[mine] - position[rows]), *guides.curves[int(curve)]
        )


def _on_curve(points: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Closest points (p, 3) of a polyline with the given segments."""
    along = end - start
    square = np.maximum((along**2).sum(axis=1), np.finfo(float).tiny)
    share = np.clip(((points[:, None] - start) * along).sum(axis=2) / square, 0.0, 1.0)
    place = start + share[:, :, None] * along
    nearest = ((place - points[:, None]) ** 2).sum(axis=2).argmin(axis=1)
    return place[np.arange(len(points)), nearest]


def _vertex_normals(position: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """(n, 3) normals of the quads around each vertex, weighted by area."""
    at = position[quads]
    normal = np.cross(at[:, 2] - at[:, 0], at[:, 3] - at[:, 1])
    flat = quads.ravel()
    total = [
        np.bincount(flat, np.repeat(normal[:, axis], 4), minlength=len(position))
        for axis in range(3)
    ]
    return np.stack(total, axis=1)


def _back(position: np.ndarray, quads: np.ndarray, free: np.ndarray, guides: Guides) -> None:
    """Put the free vertices on the surface, in place."""
    normals = _vertex_normals(position, quads)[free]
    position[free] = guides.surface(position[free], normals)[1]


def _mend(
    position: np.ndarray,
    quads: np.ndarray,
    free: np.ndarray,
    guides: Guides,
    neighbours: np.ndarray,
    count: np.ndarray,
    progress: Progress,
) -> None:
    """Steps around quads that are folded or nearly so until there are none, in place."""
    for _ in range(MENDING):
        progress.step(1.0)
        bad = scaled_jacobian(position, quads) < SOUND
        if not bad.any():
            return
        near = np.zeros(len(position), bool)
        near[quads[bad]] = True
        for _ring in range(2):
            near[quads[near[quads].any(axis=1)]] = True
        plane = _planes(position, quads, guides)
        wanted = _wanted(position, quads, plane, np.zeros(len(quads), bool))
        target = np.where(near[:, None], _mean(wanted, quads, count), position)
        _move(position, target, free & near, neighbours, guides)
        _back(position, quads, free & near, guides)
