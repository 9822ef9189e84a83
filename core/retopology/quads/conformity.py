"""Whether quads make a manifold, what they sum to, and how well they are shaped."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ...base.unit import unit
from ...mesh.half_edges import edge_keys

# A quad without area is neither turned nor not by its scaled Jacobian. What is turned is below 0 by
# more than the sines of double precision are off (1e-16), and by less than any bound of these.
BELOW = 1e-6


@dataclass(frozen=True)
class Conformity:
    """The topology of quads (q, 4) on n vertices.

    Attributes
    ----------
    manifold:
        Every edge has one or two quads that run along it in opposite senses, every vertex one
        fan of quads, and no quad a corner twice.
    border:
        (n,) bool vertices on edges with one quad.
    valence:
        (n,) int64 edges at each vertex, 0 at vertices of no quad.
    characteristic:
        Euler characteristic of all together.
    """

    manifold: bool
    border: np.ndarray
    valence: np.ndarray
    characteristic: int

    @property
    def irregular(self) -> np.ndarray:
        """(k,) int64 ascending inner vertices that are not where four quads meet: poles."""
        return np.flatnonzero((self.valence != 4) & ~self.border)


def conformity(quads: np.ndarray, count: int) -> Conformity:
    """The topology of quads on `count` vertices."""
    tail, head = side_ends(quads)
    edge, uses = np.unique(edge_keys(tail, head, count), return_counts=True)
    directed = np.unique(tail * count + head)
    ends = np.concatenate([edge // count, edge % count])
    valence = np.bincount(ends, minlength=count)
    border = np.zeros(count, bool)
    single = edge[uses == 1]
    border[single // count] = border[single % count] = True
    corners = np.bincount(tail, minlength=count)
    open_ends = np.bincount(np.concatenate([single // count, single % count]), minlength=count)
    ordered = np.sort(quads, axis=1)
    manifold = (
        not (np.diff(ordered, axis=1) == 0).any()
        and len(directed) == len(tail)
        and not (uses > 2).any()
        and np.array_equal(valence, corners + border)
        and not (open_ends > 2).any()
        and _one_fan(quads, count)
    )
    used = int(np.count_nonzero(corners))
    return Conformity(manifold, border, valence, used - len(edge) + len(quads))


def side_ends(quads: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(4 q,) int64 vertices that the sides of quads come from and go to."""
    quads = quads.astype(np.int64, copy=False)
    return quads.ravel(), np.roll(quads, -1, axis=1).ravel()


def torn(quads: np.ndarray, count: int) -> np.ndarray:
    """(count,) bool vertices at which quads (q, 4) make no manifold: corners of a quad that has one
    twice, ends of edges that are used more than once in one sense, and those of several fans."""
    tail, head = side_ends(quads)
    found = np.zeros(count, bool)
    ordered = np.sort(quads, axis=1)
    found[quads[(np.diff(ordered, axis=1) == 0).any(axis=1)]] = True
    directed, uses = np.unique(tail * count + head, return_counts=True)
    again = directed[uses > 1]
    found[again // count] = found[again % count] = True
    fan = _fans(quads, count)
    corner = np.unique(tail * (int(fan.max(initial=0)) + 1) + fan) // (int(fan.max(initial=0)) + 1)
    return found | (np.bincount(corner, minlength=count) > 1)


def _one_fan(quads: np.ndarray, count: int) -> bool:
    """Whether the quads at each vertex are joined across edges at it."""
    fans = int(_fans(quads, count).max(initial=-1)) + 1
    return fans == np.count_nonzero(np.bincount(quads.ravel(), minlength=count))


def _fans(quads: np.ndarray, count: int) -> np.ndarray:
    """(4 q,) number of the fan of quads joined across edges at a vertex that each corner is in."""
    m = quads.size
    tail, head = side_ends(quads)
    key, back = tail * count + head, head * count + tail
    order = np.argsort(key)
    place = np.minimum(np.searchsorted(key[order], back), m - 1)
    twin = np.where(key[order][place] == back, order[place], -1)
    half = np.flatnonzero(twin >= 0)
    following = half - half % 4 + (half + 1) % 4
    graph = sparse.coo_array((np.ones(len(half)), (following, twin[half])), shape=(m, m))
    _, label = csgraph.connected_components(graph, directed=False)
    return np.asarray(label, np.int64)


def scaled_jacobian(vertices: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """(q,) float64 the least sine at a corner of each quad, signed by its own normal: 1 for
    rectangles, 0 or less where a quad is degenerate or folded."""
    at = vertices[quads]
    out = np.roll(at, -1, axis=1) - at
    back = np.roll(at, 1, axis=1) - at
    normal = unit(np.cross(at[:, 2] - at[:, 0], at[:, 3] - at[:, 1]))
    area = np.einsum("qkc,qc->qk", np.cross(out, back), normal)
    size = np.linalg.norm(out, axis=2) * np.linalg.norm(back, axis=2)
    return (area / np.maximum(size, np.finfo(float).tiny)).min(axis=1)


def signed(quality: np.ndarray, turned: np.ndarray) -> np.ndarray:
    """(q,) scaled Jacobians, negative where a quad is `turned` (q,) bool: below 0 by `BELOW` where
    it has no area, too."""
    return np.where(turned, -np.abs(quality) - BELOW, quality)
