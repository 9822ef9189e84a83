"""Ridges, ravines and crest lines of a surface: extracted, judged, joined into chains.

Along a ridge a principal curvature is extremal along its own lines of curvature (Porteous 2001).
A crest is one that shows: the larger curvature in size, a maximum on convex edges, a minimum in
hollows (Yoshizawa, Belyaev & Seidel 2005; Hildebrandt, Polthier & Wardetzky 2005).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ...base.progress import Progress
from ...base.unit import unit
from ...mesh.half_edges import ends_of
from ...mesh.surface import Surface
from .bend import ROUND, bend_of
from .crossings import FIRST, SECOND, Crossings, at_nodes, crossings, edge_signs
from .paths import Paths, ordered_paths
from .slopes import Slopes

# How far e changes over the radius of its fit, in its standard errors: a chain goes on above the
# first and must rise above the second somewhere (Canny's hysteresis). Noise crossings measure 1.
WEAK, CERTAIN = 5.0, 20.0
# A chain must be longer than this many radii of the fits: shorter ones say the same thing once.
# Two lose crests at the corners of a stretched quartic under noise, one leaves false ones on
# marching cubes of a skewed ellipsoid; x^8 + y^8 + z^8 = 1 is the same with all three.
# One that was found before its place was corrected may have come out shorter: of a decimated
# quartic under 5 % of noise one of four short crests was lost. Confirmed on its marching cubes, on
# those of x^6 + y^6 + z^6 = 1 and on random meshes of x^4 + y^4 + z^4 = 1, which are the same.
SHORTEST, SHOWN = 1.5, 1.0
# Kinds, by number: elliptic means a maximum of the larger curvature or a minimum of the smaller.
KINDS = ("crest", "maximal", "minimal", "hyperbolic maximal", "hyperbolic minimal")
CREST = 0


@dataclass(frozen=True)
class Chains:
    """Ridges of a `Surface` as l chains of p points, in its coordinates.

    Attributes
    ----------
    start:
        (l + 1,) int64: the points of chain i are rows start[i]:start[i + 1].
    position, d:
        (p, 3) float64 points on edges, and the unit direction across the ridge there.
    triangle, barycentric:
        (p,) int64 triangle, in which the chord that ends at the point lies, and weights (p, 3).
    curvature, bending:
        (p,) float64 principal curvature, and its second derivative across the ridge.
    bend:
        (p,) float64 degrees that the normal turns across the ridge.
    certainty:
        (p,) float64 change of e over the radius of its fit, in standard errors.
    family, kind:
        (l,) int8 family, and number in `KINDS`.
    closed:
        (l,) bool.
    """

    start: np.ndarray
    position: np.ndarray
    d: np.ndarray
    triangle: np.ndarray
    barycentric: np.ndarray
    curvature: np.ndarray
    bending: np.ndarray
    bend: np.ndarray
    certainty: np.ndarray
    family: np.ndarray
    kind: np.ndarray
    closed: np.ndarray

    def __len__(self) -> int:
        return len(self.family)


@dataclass(frozen=True)
class Ridges:
    """Chains of a surface and the slopes that they come from."""

    chains: Chains
    slopes: Slopes


def find_ridges(
    surface: Surface,
    slopes: Slopes,
    *,
    crests_only: bool = True,
    least_bend: float = 0.0,
    progress: Progress | None = None,
) -> Ridges:
    """The ridges of both families that stand out of the noise.

    Parameters
    ----------
    crests_only:
        Leave out what is not a crest.
    least_bend:
        Degrees that the normal turns across each somewhere; half of that along all of it.
    """
    progress = progress or Progress()
    signs = edge_signs(surface, slopes)
    parts = []
    for family in progress.track((FIRST, SECOND), 2):
        found = crossings(surface, slopes, signs, family)
        progress.ask()
        parts.append(_family_chains(surface, slopes, found, family, crests_only, least_bend))
    return Ridges(_joined(parts), slopes)


def _family_chains(
    surface: Surface,
    slopes: Slopes,
    found: Crossings,
    family: int,
    crests_only: bool,
    least_bend: float,
) -> Chains:
    def middle(values: np.ndarray) -> np.ndarray:
        begin, end = (at_nodes(surface, one, found.along, values) for one in found.node.T)
        return np.asarray(0.5 * (begin + end))

    k, other = middle(slopes.k[family]), middle(slopes.k[1 - family])
    radius, error = middle(slopes.radius), middle(slopes.error[family])
    # That of the fit: the slope of e in a sliver of marching cubes may have either sign.
    slope = middle(slopes.bending[family])
    certainty = np.abs(slope) * radius / np.maximum(error, np.finfo(float).tiny)
    kind = _kinds(k, other, slope, family)
    bend = bend_of(k, slope)
    shows = (certainty > WEAK) & (bend < ROUND) & (bend >= 0.5 * least_bend)
    rows = np.flatnonzero(shows & ((kind == CREST) | (not crests_only)))
    begin, end = (at_nodes(surface, one, found.along, surface.vertices) for one in found.node.T)
    length = np.linalg.norm(end - begin, axis=1)
    # Where the kind changes, chains part: a node is one for each kind.
    nodes = found.node[rows] * len(KINDS) + kind[rows, None]
    names, ends = np.unique(nodes, return_inverse=True)
    ends = ends.reshape(-1, 2)
    graph = sparse.coo_array((np.ones(len(rows)), tuple(ends.T)), shape=(len(names),) * 2)
    pieces, label = csgraph.connected_components(graph, directed=False)
    piece = label[ends[:, 0]]
    highest, reach, most, shown = np.zeros((4, pieces))
    corners = surface.triangles[found.triangle[rows]]
    np.maximum.at(shown, piece, slopes.shown[family][corners].all(axis=1))
    np.maximum.at(highest, piece, certainty[rows])
    np.maximum.at(reach, piece, radius[rows])
    np.maximum.at(most, piece, bend[rows])
    total = np.bincount(piece, weights=length[rows], minlength=pieces)
    shortest = np.where(shown > 0.0, SHOWN, SHORTEST) * reach
    kept = (highest >= CERTAIN) & (total >= shortest) & (most >= least_bend)
    rows = rows[kept[piece]]
    paths = ordered_paths(found.node[rows] * len(KINDS) + kind[rows, None])
    values = {"curvature": k, "bending": slope, "bend": bend, "certainty": certainty}
    return _chains(surface, slopes, found, rows, paths, values, kind, family)


def _kinds(k: np.ndarray, other: np.ndarray, slope: np.ndarray, family: int) -> np.ndarray:
    """(s,) numbers in `KINDS`."""
    outward = 1.0 if family == FIRST else -1.0
    elliptic = slope * outward < 0
    crest = elliptic & (np.abs(k) > np.abs(other)) & (k * outward > 0)
    usual = 1 if family == FIRST else 2
    return np.where(crest, CREST, np.where(elliptic, usual, usual + 2))


def _chains(
    surface: Surface,
    slopes: Slopes,
    found: Crossings,
    rows: np.ndarray,
    paths: Paths,
    values: dict[str, np.ndarray],
    kind: np.ndarray,
    family: int,
) -> Chains:
    """Chains of the segments `rows` in the order of `paths`; `values` (s,) are of segments."""
    segment = rows[paths.segment]
    node = np.where(paths.forward[:, None], found.node[segment], found.node[segment][:, ::-1])
    count = np.diff(paths.start)
    # Each path has the head of every segment; an open one its first tail before them.
    opening = np.where(paths.closed, 0, 1)
    start = np.concatenate([[0], np.cumsum(count + opening)])
    path = np.repeat(np.arange(len(paths)), count)
    slot = np.arange(len(segment)) + np.cumsum(opening)[path]
    first = start[:-1][~paths.closed]
    begin = paths.start[:-1][~paths.closed]
    total = int(start[-1])
    point = np.empty(total, np.int64)
    before, after = np.empty(total, np.int64), np.empty(total, np.int64)
    point[slot], before[slot] = node[:, 1], segment
    point[first], before[first] = node[begin, 0], segment[begin]
    # A point has the mean of the segments at both of its sides.
    last = paths.start[1:] - 1
    following = np.append(segment[1:], 0)
    following[last] = np.where(paths.closed, segment[paths.start[:-1]], segment[last])
    after[slot], after[first] = following, segment[begin]
    triangle = found.triangle[before]
    name = paths.start[:-1]
    return Chains(
        start=start.astype(np.int64),
        position=at_nodes(surface, point, found.along, surface.vertices),
        d=_across(surface, slopes, found, point, family),
        triangle=triangle,
        barycentric=_weights(surface, triangle, point, found.along[point]),
        **{key: 0.5 * (value[before] + value[after]) for key, value in values.items()},
        family=np.full(len(paths), family, np.int8),
        kind=kind[segment[name]].astype(np.int8),
        closed=paths.closed,
    )


def _across(
    surface: Surface, slopes: Slopes, found: Crossings, point: np.ndarray, family: int
) -> np.ndarray:
    """(p, 3) unit directions at nodes: of the ends of their edges, made to agree."""
    tail, head = ends_of(surface.triangles, point)
    one, two = slopes.d[family][tail], slopes.d[family][head]
    agree = np.where(np.einsum("pc,pc->p", one, two) < 0, -1.0, 1.0)
    t = found.along[point]
    return unit((1.0 - t)[:, None] * one + (t * agree)[:, None] * two)


def _weights(
    surface: Surface, triangle: np.ndarray, node: np.ndarray, along: np.ndarray
) -> np.ndarray:
    """(p, 3) weights in `triangle` of the points `along` the half-edges `node`."""
    own = node // 3 == triangle
    half_edge = np.where(own, node, surface.twin[node])
    t = np.where(own, along, 1.0 - along)
    rows, side = np.arange(len(node)), half_edge % 3
    weights = np.zeros((len(node), 3))
    weights[rows, side], weights[rows, (side + 1) % 3] = 1.0 - t, t
    return weights


def _joined(parts: list[Chains]) -> Chains:
    """Chains one after the other."""
    values = {
        name: np.concatenate([getattr(part, name) for part in parts])
        for name in vars(parts[0])
        if name != "start"
    }
    offset = np.cumsum([0] + [len(part.position) for part in parts[:-1]])
    start = [part.start[:-1] + at for part, at in zip(parts, offset, strict=True)]
    return Chains(start=np.append(np.concatenate(start), len(values["position"])), **values)
