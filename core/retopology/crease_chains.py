"""Bent edges joined into chains; those stay that are no accident of the triangulation.

On a rounded or rough surface single edges bend as far as creases do, here and there. Taken as
features they pin the cross field to the triangulation. A crease goes on, and straight: joined,
the two tell apart (hysteresis as in Canny 1986, along edges as in Hubeli & Gross 2001).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ..base.subsets import spans
from ..base.unit import unit
from ..mesh.creases import edge_bends, is_convex
from ..mesh.half_edges import ends_of, inner_edges
from ..mesh.surface import Surface
from ..mesh.tessellated import flat_edges
from .ridges.paths import ordered_paths

# Chains are followed along edges that bend this share of the angle that they must reach.
WEAK_SHARE = 0.5
# One edge goes on in another where they turn by less than this, in degrees: more is a corner.
MOST_TURN = 75.0
# So many edges in a row may bend less than the angle within a chain.
GAP = 2
# A chain of fewer edges says nothing, unless it comes back to itself, or joins two junctions on a
# mesh of which this share of all bent edges is in chains: on rough meshes junctions are many, too.
FEWEST, IN_CHAINS = 4, 0.8
# Nor does, on other meshes, a chain that chance would make: where many edges bend, by noise or for
# want of finer ones, so many chains of its length are to be expected at most (a contrario,
# Desolneux, Moisan & Morel 2000, 10.1023/A:1026593302236). From its end an edge can go on in so
# many others within `MOST_TURN`.
BY_CHANCE, WAYS = 0.1, 3.0
# Degrees by which a chain may swerve from edge to edge. One that swerves more follows the
# triangles rather than a crease and tells the direction worse than the curvature does: the fields
# of real meshes lie 6 to 10 degrees from it. Chosen on rocker-arm (12 to 20), fandisk (0), hand
# and spot; confirmed on a plate with holes, a beetle, a bunny and a skull.
MOST_SWERVE = 10.0
# A chain bends so many times farther than the median of the edges that bend less than the angle,
# in units of what noise of the points makes of bends: the flatter a triangle beside it, the more.
# By noise or on a coarse mesh single edges do so by chance; beside a crease it is small. Chosen on
# ellipsoids of random points under noise of 5 and 10 % (up to 5, few to 11) and the rocker arm,
# whose pieces of chains (5 to 7) spoil its field; chains of a bunny, spot, a fandisk, a wing nut
# and a plate with holes stand out by 12 to thousands.
STANDS_OUT = 8.0


@dataclass(frozen=True)
class CreaseChains:
    """Creases as l chains of e edges.

    Attributes
    ----------
    start:
        (l + 1,) int64: the edges of chain i are rows start[i]:start[i + 1], one after the other.
    half_edge:
        (e,) int64 one half-edge of each edge.
    forward:
        (e,) bool, True where the chain runs along it.
    """

    start: np.ndarray
    half_edge: np.ndarray
    forward: np.ndarray


def crease_chains(surface: Surface, angle: float) -> CreaseChains:
    """The chains of edges across which the normal turns further than `angle` in degrees."""
    half_edge, bend = edge_bends(surface)
    precision = _precision(surface, half_edge)
    strong = bend >= angle
    smaller = ~strong
    usual = float(np.median((bend * precision)[smaller])) if smaller.any() else 0.0
    weak = bend >= WEAK_SHARE * angle
    half_edge, bend, precision = half_edge[weak], bend[weak], precision[weak]
    normal, _ = surface.face_normal_area
    middle = normal[half_edge // 3] + normal[surface.twin[half_edge] // 3]
    vertex = np.stack(ends_of(surface.triangles, half_edge))
    along = unit(surface.vertices[vertex[1]] - surface.vertices[vertex[0]])
    signed = np.where(is_convex(surface, half_edge), bend, -bend)

    paths = ordered_paths(_nodes(vertex, along, signed))
    path = np.repeat(np.arange(len(paths)), np.diff(paths.start))
    place = _bridged(bend[paths.segment] >= angle, path)
    edge, forward = paths.segment[place], paths.forward[place]
    first = np.ones(len(place), bool)
    first[1:] = (np.diff(path[place]) != 0) | (np.diff(place) > 1)
    piece = np.cumsum(first) - 1
    count = np.bincount(piece, minlength=int(first.sum()))

    direction = np.where(forward[:, None], along[edge], -along[edge])
    mean, apart = (
        np.bincount(piece, weights=values[edge], minlength=len(count)) / np.maximum(count, 1)
        for values in (bend, bend * precision)
    )
    swerve = _swerve(direction, middle[edge], piece, count)
    exact = np.bincount(piece[_beside_planes(surface, half_edge[edge])], minlength=len(count))
    sure = (apart >= STANDS_OUT * usual) | (exact == count)
    straight = (swerve <= MOST_SWERVE) & (mean >= angle) & sure
    # The vertices at both ends of each piece.
    start = np.flatnonzero(first)
    last = start + count - 1
    begin = np.where(forward[start], vertex[0, edge[start]], vertex[1, edge[start]])
    end = np.where(forward[last], vertex[1, edge[last]], vertex[0, edge[last]])
    meeting = np.bincount(vertex[:, edge].ravel(), minlength=len(surface.border))
    junction = (meeting >= 3) | surface.border
    long = straight & ((count >= FEWEST) | (begin == end))
    bent = int(np.count_nonzero(strong))
    kept = long & _meaningful(len(strong), bent, count)
    # What lies in chains that mean something is no chance: fewer are then left to make others.
    kept = long & _meaningful(len(strong), bent - int(count[kept].sum()), count)
    with_short = long | (straight & junction[begin] & junction[end])
    if count[with_short].sum() >= IN_CHAINS * bent:
        kept = with_short
    rows = kept[piece]
    return CreaseChains(
        start=np.concatenate([[0], np.cumsum(count[kept])]).astype(np.int64),
        half_edge=half_edge[edge[rows]],
        forward=forward[rows],
    )


def _beside_planes(surface: Surface, half_edge: np.ndarray) -> np.ndarray:
    """(e,) bool edges with a plane face of more than two triangles on a side: noise would have bent
    it, and a facet of a round face is no more than two."""
    inner = inner_edges(surface.twin)
    flat = inner[flat_edges(surface, inner)]
    one, two = flat // 3, surface.twin[flat] // 3
    m = len(surface.triangles)
    graph = sparse.coo_array((np.ones(len(flat), np.int8), (one, two)), shape=(m, m))
    face = csgraph.connected_components(graph, directed=False)[1]
    plane = (np.bincount(face) > 2)[face]
    return plane[half_edge // 3] | plane[surface.twin[half_edge] // 3]


def _meaningful(edges: int, bent: int, count: np.ndarray) -> np.ndarray:
    """(l,) whether chains of `count` (l,) edges would be few if the `bent` ones lay anywhere."""
    each = WAYS * max(bent, 1) / max(edges, 1)
    with np.errstate(under="ignore"):
        return np.asarray(edges / WAYS * each**count <= BY_CHANCE)


def _precision(surface: Surface, half_edge: np.ndarray) -> np.ndarray:
    """(e,) how precisely an edge's bend is known, as one over its error by a unit of noise in the
    corners across: 1 / hypot(1 / h, 1 / h') of their heights over the edge."""
    _, area = surface.face_normal_area
    side = np.sqrt(surface.side_squares[half_edge % 3, half_edge // 3])
    tiny = np.finfo(float).tiny
    one, two = (
        2.0 * area[half // 3] / np.maximum(side, tiny)
        for half in (half_edge, surface.twin[half_edge])
    )
    return one * two / np.maximum(np.hypot(one, two), tiny)


def _nodes(vertex: np.ndarray, along: np.ndarray, bend: np.ndarray) -> np.ndarray:
    """(e, 2) nodes that edges are joined at: where two ends at a vertex are each other's best
    continuation they share one, other ends have their own.

    Parameters
    ----------
    vertex, along:
        (2, e) the ends of edges and their (e, 3) directions.
    bend:
        (e,) degrees, negative in hollows: edges that bend alike go on in each other.
    """
    count = len(bend)
    at, outward = vertex.ravel(), np.concatenate([along, -along])
    turned = np.concatenate([bend, bend])
    one, two = _pairs(at)
    cosine = -np.einsum("pc,pc->p", outward[one], outward[two])
    turn = np.degrees(np.arccos(cosine.clip(-1.0, 1.0)))
    cost = turn + np.abs(turned[one] - turned[two])
    open_ = turn < MOST_TURN
    one, two, cost = one[open_], two[open_], cost[open_]
    order = np.lexsort((two, cost, one))
    one, two = one[order], two[order]
    node = np.arange(2 * count)
    # The best pair that is left at a vertex is mutual, so that each round joins some.
    while len(one):
        best = np.full(2 * count, -1)
        ends, first = np.unique(one, return_index=True)
        best[ends] = two[first]
        mutual = ends[(best[best[ends]] == ends) & (ends < best[ends])]
        if not len(mutual):
            break
        node[best[mutual]] = mutual
        joined = np.zeros(2 * count, bool)
        joined[mutual], joined[best[mutual]] = True, True
        free = ~joined[one] & ~joined[two]
        one, two = one[free], two[free]
    return np.stack([node[:count], node[count:]], axis=1)


def _pairs(group: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """All ordered pairs of different rows with the same number in `group` (r,)."""
    order = np.argsort(group, kind="stable")
    _, start, count = np.unique(group[order], return_index=True, return_counts=True)
    each = np.repeat(count, count)
    one = np.repeat(np.arange(len(group)), each)
    two = spans(np.repeat(start, count), each)
    differ = one != two
    return order[one[differ]], order[two[differ]]


def _bridged(strong: np.ndarray, path: np.ndarray) -> np.ndarray:
    """Places along paths (e,) that are strong, or in a gap of at most `GAP` between such."""
    place = np.arange(len(strong))
    before = np.maximum.accumulate(np.where(strong, place, -1))
    after = np.minimum.accumulate(np.where(strong, place, len(strong))[::-1])[::-1]
    inside = (before >= 0) & (after < len(strong)) & (after - before - 1 <= GAP)
    low, high = before.clip(0), after.clip(0, max(len(strong) - 1, 0))
    inside &= (path[low] == path) & (path[high] == path)
    return np.flatnonzero(strong | inside)


def _swerve(
    direction: np.ndarray, normal: np.ndarray, piece: np.ndarray, count: np.ndarray
) -> np.ndarray:
    """(l,) mean degrees by which the turn of each piece on the surface changes from one vertex to
    the next, halved: nothing along straight lines and circles, the turn itself in a zigzag.

    Parameters
    ----------
    direction, normal, piece:
        (e, 3) of the edges in order, (e, 3) rough normals there, and (e,) their pieces.
    count:
        (l,) edges of each piece.
    """
    before, after = direction[:-1], direction[1:]
    upright = unit(normal[1:] + normal[:-1])
    sine = np.einsum("ec,ec->e", np.cross(before, after), upright)
    turn = np.degrees(np.arctan2(sine, np.einsum("ec,ec->e", before, after)))
    change = 0.5 * np.abs(np.diff(turn))
    inner = piece[2:] == piece[:-2]
    total = np.bincount(piece[2:][inner], weights=change[inner], minlength=len(count))
    return total / np.maximum(count - 2, 1)
