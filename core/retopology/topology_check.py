"""How well a mesh of the user's own follows a surface: its irregular vertices, edges, distance.

Any polygons may be checked, made by hand or by a remesher; only quads have an angle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph
from scipy.spatial import cKDTree

from ..base.arguments import in_range, numbers
from ..base.blas import one_blas_thread
from ..base.errors import InvalidMeshError
from ..base.progress import Progress
from ..base.subsets import spans
from ..fields.planes import FaceFrames, in_plane
from ..mesh.half_edges import edge_keys
from ..mesh.input_map import places_on_surface
from ..mesh.surface import Surface
from .planner import Guide
from .poles import Poles
from .quads.conformity import scaled_jacobian
from .quads.finishing.faults.last_check import wrong_quads
from .quads.finishing.projection import ClosestPoints
from .quads.result import QuadMesh

# Mean edges of the checked mesh within which an irregular vertex stands for a planned pole: one
# that an artist has moved out of the way of a crease or a joint is still that pole. So is one in
# the pole's triangle or beside it, where these are larger.
REACH = 3.0
# Places of the surface, each of as much area, that are looked for on the checked mesh.
SAMPLES = 20_000
# Vertices of the surface whose distance is looked for exactly at a time, the farthest first.
EXACTLY = 2048
# Fractions of the sequence of Roberts (2018), which fills a square evenly from any row on.
_PLASTIC = np.array([0.7548776662466927, 0.5698402909980532])


@dataclass(frozen=True)
class TopologyCheck:
    """A mesh of n vertices and f faces held against a surface and its pole plan.

    Attributes
    ----------
    irregular:
        (k,) int64 vertices whose valence is not what a regular grid has: 4, on a border 3.
    valence:
        (k,) int64 their edges; one more is counted on a border, so that 4 is always regular.
    pole:
        (k,) int64 planned pole that each stands for, -1 for none: it is extra.
    missing:
        (r,) int64 planned poles that no vertex stands for.
    quads:
        How many of the faces have four corners.
    angle:
        (f,) float64 degrees, 0 to 45, from the directions of a quad to the principal directions
        below it; NaN for other faces and where the surface has no direction.
    mean_angle:
        Their mean in degrees, by area and by the gap of the curvatures; NaN without any.
    jacobian:
        (f,) float64 scaled Jacobian, the least sine at a corner of each quad: 1 for rectangles, 0
        or less for degenerate and folded ones; NaN for other faces.
    folded:
        (f,) bool quads that are folded or face against the surface: away from it or from the quads
        around, as the remeshing counts them. A corner may be open all the same.
    distance:
        (n,) float64 length from each vertex to the surface.
    covered:
        Share of the surface's area, 0 to 1, within a mean edge of the mesh: what is far from it is
        missing, however near to the surface the vertices are.
    farthest:
        The largest length from a vertex of the surface, or one of `SAMPLES` places all over it, to
        the mesh: how much of its shape the faces between the vertices cut off.
    edge:
        Mean length of the edges.
    """

    irregular: np.ndarray
    valence: np.ndarray
    pole: np.ndarray
    missing: np.ndarray
    quads: int
    angle: np.ndarray
    mean_angle: float
    jacobian: np.ndarray
    folded: np.ndarray
    distance: np.ndarray
    covered: float
    farthest: float
    edge: float

    @property
    def matched(self) -> int:
        """How many planned poles have a vertex that stands for them."""
        return int(np.count_nonzero(self.pole >= 0))

    @property
    def extra(self) -> int:
        """How many irregular vertices no planned pole asks for."""
        return int(np.count_nonzero(self.pole < 0))

    @property
    def least_jacobian(self) -> float:
        """Of the worst quad; NaN without quads."""
        return float(np.nanmin(self.jacobian)) if self.quads else float("nan")

    @property
    def edges_away(self) -> float:
        """The largest distance of a vertex from the surface in mean edges."""
        return float(self.distance.max(initial=0.0)) / self.edge if self.edge > 0.0 else 0.0

    @property
    def surface_edges_away(self) -> float:
        """The largest distance of the surface from the mesh in mean edges."""
        return self.farthest / self.edge if self.edge > 0.0 else 0.0


@one_blas_thread()
def check_topology(
    vertices: np.ndarray,
    corners: np.ndarray,
    start: np.ndarray,
    guide: Guide,
    poles: Poles,
    progress: Progress | None = None,
) -> TopologyCheck:
    """Hold a mesh against a surface.

    Parameters
    ----------
    vertices:
        (n, 3) float64 positions of the mesh that is checked, in the coordinates of the surface.
    corners, start:
        (c,) int vertices of its faces one behind the other, and (f + 1,) int where each begins.
    guide:
        The surface and its detection.
    poles:
        The plan to compare with, `guide.guidance().poles`.
    progress:
        Told how far the work is, and asked whether to stop.

    Raises
    ------
    InvalidMeshError
        The mesh has no faces, or its arrays do not fit each other.

    Examples
    --------
    Quads on an ellipsoid of `vertices` and `triangles`, as in `remesh`, have the eight poles of
    its plan and no others:

    >>> import numpy as np
    >>> guide = core.Guide(vertices, triangles, core.detect(vertices, triangles))
    >>> made = core.remesh(vertices, triangles, core.RemeshSettings(quads=300))
    >>> start = 4 * np.arange(len(made.quads) + 1)
    >>> poles = guide.guidance().poles
    >>> found = core.check_topology(made.vertices, made.quads.ravel(), start, guide, poles)
    >>> found.matched, len(found.missing), found.extra
    (8, 0, 0)
    """
    vertices, corners, start = _polygons(vertices, corners, start)
    progress = progress or Progress()
    whole = guide.surface
    progress.part("Looking for the surface", 0.0, 0.5)
    closest = ClosestPoints(whole.vertices, whole.triangles, whole.twin)
    own = (vertices - whole.origin) / whole.unit
    below, there = closest(own)
    one, two, uses = _edges(corners, start, len(vertices))
    irregular, valence = _irregular(one, two, uses, len(vertices))
    edge = float(np.linalg.norm(vertices[one] - vertices[two], axis=1).mean())
    reach = np.maximum(REACH * edge, _extent(whole, poles) * whole.unit)
    pole = _matched(vertices[irregular], valence, poles, reach)
    missing = np.setdiff1d(np.arange(len(poles)), pole)
    quads = np.flatnonzero(np.diff(start) == 4)
    angle = np.full(len(start) - 1, np.nan)
    weight = np.zeros(len(start) - 1)
    jacobian = np.full(len(start) - 1, np.nan)
    folded = np.zeros(len(start) - 1, bool)
    if len(quads):
        four = corners[start[quads][:, None] + np.arange(4)]
        at = own[four]
        jacobian[quads] = scaled_jacobian(own, four)
        folded[quads] = wrong_quads(own, four, below[four[:, 0]], whole)
        planes = guide.planes(progress.part("Comparing directions", 0.5, 1.0))
        angle[quads], weight[quads] = _angles(at, whole, planes, closest)
    covered, farthest = _from_surface(whole, own, _fans(corners, start), edge / whole.unit)
    progress.step(1.0)
    known = np.isfinite(angle) & (weight > 0.0)
    return TopologyCheck(
        irregular=irregular,
        valence=valence,
        pole=pole,
        missing=missing,
        quads=len(quads),
        angle=angle,
        mean_angle=float(np.average(angle[known], weights=weight[known]))
        if known.any()
        else float("nan"),
        jacobian=jacobian,
        folded=folded,
        distance=np.linalg.norm(there - own, axis=1) * whole.unit,
        covered=covered,
        farthest=farthest * whole.unit,
        edge=edge,
    )


@one_blas_thread()
def check_quads(
    mesh: QuadMesh, guide: Guide, progress: Progress | None = None
) -> TopologyCheck:
    """Hold the quads that the remeshing made against their own surface and the poles that they were
    laid out with: the plan of a guide may be another one, as it was smoothed otherwise or has poles
    nearer than an edge of the quads; otherwise as `check_topology`.

    Examples
    --------
    Quads on an ellipsoid of `vertices` and `triangles`, as in `remesh`:

    >>> guide = core.Guide(vertices, triangles, core.detect(vertices, triangles))
    >>> made = core.remesh(vertices, triangles, core.RemeshSettings(quads=300))
    >>> core.check_quads(made, guide).matched
    8
    """
    start = np.arange(0, mesh.quads.size + 1, 4)
    quads = mesh.quads.ravel()
    return check_topology(mesh.vertices, quads, start, guide, mesh.planned, progress)


def _from_surface(
    whole: Surface, vertices: np.ndarray, triangles: np.ndarray, reach: float
) -> tuple[float, float]:
    """Share of a surface's area that is within reach of a mesh (n, 3), (t, 3), by `SAMPLES`, and
    how far from it the farthest of these and of the vertices is."""
    # The mesh need not be a manifold: no triangle is told of those beside it.
    closest = ClosestPoints(vertices, triangles, np.full(triangles.size, -1))
    away = _away(_places(whole), closest)
    return float(np.mean(away <= reach)), _farthest(whole.vertices, closest, float(away.max()))


def _away(points: np.ndarray, closest: ClosestPoints) -> np.ndarray:
    return np.linalg.norm(closest(points)[1] - points, axis=1)


def _farthest(points: np.ndarray, closest: ClosestPoints, least: float) -> float:
    """The largest distance of points (p, 3), or `least` if that is more.

    The exact search is slow for a million points. A quick one is never too near: those for which it
    finds no more than what was found exactly, from the farthest on, need no other.
    """
    # Without a side to face all triangles count alike.
    _, there = closest(points, np.zeros_like(points))
    most = np.linalg.norm(there - points, axis=1)
    rows = np.flatnonzero(most > least)
    rows = rows[np.argsort(-most[rows], kind="stable")]
    for first in range(0, len(rows), EXACTLY):
        some = rows[first : first + EXACTLY]
        if most[some[0]] <= least:
            break
        least = max(least, float(_away(points[some], closest).max()))
    return least


def _places(whole: Surface) -> np.ndarray:
    """(`SAMPLES`, 3) places of a surface. Triangles are drawn by rows at equal steps of their
    summed area, so that each place stands for as much of it."""
    corner = whole.vertices[whole.triangles]
    side = corner[:, 1:] - corner[:, :1]
    area = np.linalg.norm(np.cross(side[:, 0], side[:, 1]), axis=1)
    summed = np.cumsum(area)
    row = np.arange(SAMPLES)
    drawn = np.searchsorted(summed, (row + 0.5) * (summed[-1] / SAMPLES))
    part = (row[:, None] * _PLASTIC) % 1.0
    beyond = part.sum(axis=1) > 1.0
    part[beyond] = 1.0 - part[beyond]
    found: np.ndarray = corner[drawn, 0] + np.einsum("sk,skc->sc", part, side[drawn])
    return found


def _fans(corners: np.ndarray, start: np.ndarray) -> np.ndarray:
    """(t, 3) triangles of faces, each a fan about its first corner."""
    count = np.maximum(np.diff(start) - 2, 0)
    first = np.repeat(start[:-1], count)
    second = spans(start[:-1] + 1, count)
    return corners[np.column_stack([first, second, second + 1])]


def _polygons(
    vertices: np.ndarray, corners: np.ndarray, start: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The arrays of `check_topology` in its types, once they make faces."""
    vertices = numbers(vertices, "The vertices must be numbers, three to a vertex.")
    corners, start = np.asarray(corners, np.int64), np.asarray(start, np.int64)
    if start.ndim != 1 or len(start) < 2 or not len(corners):
        raise InvalidMeshError("The mesh that is to be checked has no faces.")
    ends = corners.ndim == 1 and start[0] == 0 and start[-1] == len(corners)
    if not ends or (np.diff(start) < 1).any():
        raise InvalidMeshError(
            "The faces of the mesh that is to be checked need all corners in one row, and where "
            "each begins among them, 0 first and their number last."
        )
    if vertices.ndim != 2 or vertices.shape[1] != 3:
        raise InvalidMeshError(f"The vertices must have shape (n, 3), not {vertices.shape}.")
    in_range(corners, len(vertices), "faces")
    if not np.isfinite(vertices).all():
        raise InvalidMeshError(
            "The mesh that is to be checked has vertices that are nowhere: their coordinates are "
            "not finite numbers. Delete or repair them."
        )
    return vertices, corners, start


def _edges(
    corners: np.ndarray, start: np.ndarray, count: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(e,) both ends of every edge once, and how many faces have it."""
    following = np.arange(len(corners)) + 1
    following[start[1:] - 1] = start[:-1]
    tail, head = corners, corners[following]
    edge, uses = np.unique(edge_keys(tail, head, count), return_counts=True)
    return edge // count, edge % count, uses


def _irregular(
    one: np.ndarray, two: np.ndarray, uses: np.ndarray, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """(k,) irregular vertices and their valence, one more on a border; corners of a border, where
    a single face ends, are none."""
    ends = np.concatenate([one, two])
    valence = np.bincount(ends, minlength=count)
    single = uses == 1
    on_border = np.zeros(count, bool)
    on_border[one[single]] = on_border[two[single]] = True
    corner = on_border & (valence == 2)
    valence = valence + on_border
    rows = np.flatnonzero((valence != 4) & (valence > 0) & ~corner)
    return rows, valence[rows]


def _extent(whole: Surface, poles: Poles) -> np.ndarray:
    """(k,) how far each pole is from the farthest corner of its triangle and of those beside it: a
    field that is given in triangles says no more of where it is singular, and beside creases, where
    all directions of a triangle are given, it is so in the next one."""
    row, weights = places_on_surface(whole, poles.triangle, poles.barycentric)
    place = np.einsum("kc,kcx->kx", weights, whole.vertices[whole.triangles[row]])
    beside = whole.twin.reshape(-1, 3)[row] // 3
    around = np.column_stack([row, np.where(beside < 0, row[:, None], beside)])
    corner = whole.vertices[whole.triangles[around]].reshape(len(row), 12, 3)
    far = np.linalg.norm(corner - place[:, None], axis=2).max(axis=1)
    return np.where(row < 0, 0.0, far)


def _matched(
    positions: np.ndarray, valence: np.ndarray, poles: Poles, reach: np.ndarray
) -> np.ndarray:
    """(k,) the planned pole of each vertex, -1 for none: as many as can have one, and of all such
    ways the shortest in sum.

    A vertex stands for a pole that lacks or exceeds four edges like itself, and is no farther from
    it than the pole's reach (p,).
    """
    pole = np.full(len(positions), -1)
    if not len(poles) or not len(positions):
        return pole
    near = cKDTree(positions).query_ball_point(poles.position, reach)
    planned = np.repeat(np.arange(len(poles)), [len(some) for some in near])
    row = np.concatenate([np.asarray(some, np.int64) for some in near])
    alike = np.sign(valence[row] - 4) == np.sign(poles.valence[planned] - 4)
    row, planned = row[alike], planned[alike]
    away = np.linalg.norm(positions[row] - poles.position[planned], axis=1) / reach[planned]
    # To stay without costs more than any way of standing for all the others; a cost of nothing
    # would be no edge of the graph.
    alone = np.arange(len(poles))
    costs = sparse.csr_matrix(
        (
            np.concatenate([1.0 + away, np.full(len(poles), 2.0 + len(poles))]),
            (np.concatenate([planned, alone]), np.concatenate([row, len(positions) + alone])),
        ),
        shape=(len(poles), len(positions) + len(poles)),
    )
    planned, row = csgraph.min_weight_full_bipartite_matching(costs)
    stands = row < len(positions)
    pole[row[stands]] = planned[stands]
    return pole


def _angles(
    at: np.ndarray, whole: Surface, planes: FaceFrames, closest: ClosestPoints
) -> tuple[np.ndarray, np.ndarray]:
    """(q,) degrees to the principal directions of quads (q, 4, 3), and their weights."""
    across = np.cross(at[:, 2] - at[:, 0], at[:, 3] - at[:, 1])
    triangle, _ = closest.below(at.mean(axis=1), across)
    deviator = planes.deviator(triangle, planes.corner[triangle].mean(axis=1))
    first = at[:, 1] - at[:, 0] + at[:, 2] - at[:, 3]
    second = at[:, 3] - at[:, 0] + at[:, 2] - at[:, 1]
    # The cross of the quad: the mean of its two directions, the second turned by a right angle.
    cross = in_plane(whole, triangle, first) - 1j * in_plane(whole, triangle, second)
    turn = np.angle(cross) - 0.5 * np.angle(deviator)
    quarter = 0.5 * np.pi
    off = np.degrees(np.abs(turn - quarter * np.rint(turn / quarter)))
    gap = np.abs(deviator)
    known = (gap > 0.0) & (np.abs(cross) > 1e-9)
    return np.where(known, off, np.nan), gap * np.linalg.norm(across, axis=1)
