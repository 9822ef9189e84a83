"""Separatrices: the lines of curvature that run into an umbilic, the skeleton of a layout."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.spatial import cKDTree

from ...base.options import AUTO
from ...base.parallel import threads
from ...base.progress import Progress
from ...base.subsets import spans
from ...base.unit import unit
from ...fields.planes import FaceFrames, in_plane, places
from ...mesh.input_map import places_on_surface
from ...mesh.surface import Surface
from ...umbilics.result import Umbilics
from ..settings import GuidanceSettings
from .bundles import joined_bundles
from .polylines import Lines, lines_from, points_of, sparse_rows
from .streamlines import spacing_of
from .tracing import (
    BORDER,
    FEATURE,
    LIMIT,
    LOST,
    MET,
    OBSTACLE,
    TURN,
    Obstacles,
    Starts,
    Traces,
    trace,
)
from .truncation import Barriers, ended_on_features, laid, truncated

# Edges over which a separatrix keeps its exact direction: nearer to the umbilic the direction
# between vertices is not resolved.
STRAIGHT = 1.5
# A separatrix ends at an umbilic that it passes within this many edges, or its uncertainty.
CAPTURE = 2.0
# It may come back to its own umbilic once it has gone this many of those reaches.
LEAVE = 4.0
# Automatic limit of the length, in roots of the area.
AUTO_LIMIT = 4.0
# A separatrix without end is cut where it comes back beside itself nearer than this many spacings
# of the lines of curvature.
BESIDE = 0.5
# Separatrices that run beside each other nearer than this many spacings, over so many times that,
# go on as one; or nearer than two edges, over four, where these are longer.
BUNDLED, RUN = 0.25, 4.0
# Cosine of the angle (30 degrees) up to which the last chord of a separatrix turns to its umbilic;
# where it would turn more it begins earlier, up to so many of those reaches before.
STRAIGHT_IN, BEFORE = 0.866, 2.0
# Points are left out as long as this many edges lie between two.
DETAIL = 1.0
# What a separatrix may end at, by number. "itself": it came back beside itself and was cut there.
ENDS = ("umbilic", "region", "border", "feature", "limit", "turn", "itself")
_END_OF = {BORDER: 2, FEATURE: 3, LIMIT: 4, TURN: 5, LOST: 5, MET: 6, OBSTACLE: 1}


@dataclass(frozen=True)
class Separatrices(Lines):
    """Separatrices, see `Lines`.

    Attributes
    ----------
    end:
        (l,) int8 what each ends at, number in `ENDS`.
    """

    end: np.ndarray

    OF_LINES: ClassVar[tuple[str, ...]] = (*Lines.OF_LINES, "end")


@dataclass(frozen=True)
class _Stage:
    """The surface that separatrices run over, and k umbilics on it that they end at.

    Attributes
    ----------
    inner, z:
        (k,) int64 triangles of the umbilics, -1 for those on none, and (k,) complex128 their
        places in these.
    point:
        (k, 3) float64 the umbilics in the coordinates of the surface.
    edge, reach:
        (k,) float64 the edges around each, and how near to it a line has arrived at it.
    """

    surface: Surface
    planes: FaceFrames
    inner: np.ndarray
    z: np.ndarray
    point: np.ndarray
    edge: np.ndarray
    reach: np.ndarray

    @classmethod
    def of(cls, surface: Surface, planes: FaceFrames, umbilics: Umbilics) -> _Stage:
        inner, weights = places_on_surface(surface, umbilics.triangle, umbilics.barycentric)
        edge = surface.mean_sides(inner)
        return cls(
            surface,
            planes,
            inner,
            places(planes, inner, weights),
            (umbilics.position - surface.origin) / surface.unit,
            edge,
            _reach(surface, umbilics, edge),
        )


def separatrices(
    surface: Surface,
    planes: FaceFrames,
    umbilics: Umbilics,
    settings: GuidanceSettings,
    progress: Progress,
    undirected: np.ndarray | None = None,
    around: np.ndarray | None = None,
    barriers: Callable[[], Barriers] | None = None,
) -> Separatrices:
    """The separatrices of umbilics, both families: one each for a lemon, three each otherwise.

    A line of the larger curvature leaves along every direction of `Umbilics.separatrix`, one of
    the smaller curvature along its opposite. Each ends at another umbilic, a border, a region or
    the limit of its length; where the limit is automatic, one that comes to it ends at the last
    feature that it crosses before it runs beside itself, or there. `Lines.source` and
    `Lines.target` are rows of `umbilics`.

    Parameters
    ----------
    umbilics:
        k umbilics in input rows and coordinates.
    undirected:
        (m,) bool triangles of regions without directions.
    around:
        (m,) the `discs`, if they are known.
    barriers:
        Gives the features; asked only where a line winds.
    """
    stage = _Stage.of(surface, planes, umbilics)
    point, ray = np.nonzero(np.isfinite(umbilics.separatrix).all(axis=2))
    keep = stage.inner[point] >= 0
    point, ray = point[keep], ray[keep]
    tangent = umbilics.separatrix[point, ray]
    # The smaller curvature's separatrices run the other way.
    tangent = np.concatenate([tangent, -tangent])
    family = np.repeat([0, 1], len(point))
    point = np.concatenate([point, point])
    obstacle = discs(surface, umbilics) if around is None else around
    free = obstacle < 0
    if undirected is not None:
        obstacle = np.where(free & undirected, len(umbilics), obstacle)
    triangle, z = stage.inner[point], stage.z[point]
    starts = Starts(
        triangle,
        z + 1e-6 * (planes.corner[triangle].mean(axis=1) - z),
        in_plane(surface, triangle, tangent),
        family,
        np.full(len(point), length_limit(surface, settings)),
        STRAIGHT * stage.edge[point],
        point,
        LEAVE * stage.reach[point],
        np.zeros(len(point), bool),
    )
    obstacles = Obstacles(obstacle, _places_of(stage, obstacle))
    traces = trace(surface, planes, starts, obstacles, progress)
    # Those that then come to nothing end at the first umbilic that they pass after all.
    rows = np.flatnonzero(np.isin(traces.end, (LIMIT, TURN, LOST)))
    if len(rows):
        anyhow = Obstacles(obstacle)
        other = trace(surface, planes, starts.select(rows), anyhow, progress.quiet())
        traces = _replaced(traces, rows, other)
    if settings.length_limit in (AUTO, 0.0):
        traces = truncated(surface, planes, traces, BESIDE * spacing_of(surface, settings))
        if barriers is not None and (traces.end == MET).any():
            traces = ended_on_features(surface, planes, traces, barriers())
    arrived = (traces.end == OBSTACLE) & (traces.obstacle < len(umbilics))
    # What is no umbilic goes along as a negative number, through the joining of bundles.
    code = np.array([_END_OF.get(number, 0) for number in range(max(_END_OF) + 1)])
    target = np.where(arrived, traces.obstacle, -code[traces.end])
    apart = BUNDLED * spacing_of(surface, settings)
    return _lines(stage, traces, family, point, target, apart)


def _replaced(traces: Traces, rows: np.ndarray, other: Traces) -> Traces:
    """Traces with the others (r,) in place of the lines `rows` (r,)."""
    pick = np.arange(len(traces.end))
    pick[rows] = len(traces.end) + np.arange(len(rows))
    both = {
        name: np.concatenate([getattr(traces, name), getattr(other, name)])
        for name in ("triangle", "z", "travelled", "end", "obstacle", "direction")
    }
    first = np.concatenate([traces.start[:-1], len(traces.triangle) + other.start[:-1]])[pick]
    count = np.concatenate([np.diff(traces.start), np.diff(other.start)])[pick]
    points = spans(first, count)
    parts = {
        name: value[points if name in ("triangle", "z", "travelled") else pick]
        for name, value in both.items()
    }
    return Traces(start=np.concatenate([[0], np.cumsum(count)]), **parts)


def _places_of(stage: _Stage, obstacle: np.ndarray) -> np.ndarray:
    """(m,) complex128 places of the umbilics in the planes of the triangles around them, NaN in
    their own and elsewhere."""
    place = np.full(len(obstacle), complex(np.nan, np.nan))
    rows = np.flatnonzero((obstacle >= 0) & (obstacle < len(stage.inner)))
    place[rows] = laid(stage.surface, rows, stage.point[obstacle[rows]])
    place[stage.inner[stage.inner >= 0]] = np.nan
    return place


def length_limit(surface: Surface, settings: GuidanceSettings) -> float:
    """Longest separatrix in the coordinates of the surface."""
    if settings.length_limit == AUTO or settings.length_limit == 0.0:
        return AUTO_LIMIT * float(np.sqrt(surface.face_normal_area[1].sum()))
    return float(settings.length_limit) / surface.unit


def _reach(surface: Surface, umbilics: Umbilics, edge: np.ndarray) -> np.ndarray:
    """(k,) how near to an umbilic a line has arrived at it, by the edges (k,) around it."""
    error = np.nan_to_num(umbilics.uncertainty, nan=0.0, posinf=0.0) / surface.unit
    return np.clip(error, CAPTURE * edge, 2.0 * CAPTURE * edge)


def discs(surface: Surface, umbilics: Umbilics) -> np.ndarray:
    """(m,) int64 umbilic, of k in input rows, that each triangle is within reach of; -1: none."""
    rows, _ = places_on_surface(surface, umbilics.triangle, umbilics.barycentric)
    reach = _reach(surface, umbilics, surface.mean_sides(rows))
    obstacle = np.full(len(surface.triangles), -1, np.int64)
    normal, _ = surface.face_normal_area
    middle = surface.vertices[surface.triangles].mean(axis=1)
    place = (umbilics.position - surface.origin) / surface.unit
    # A tree of the few umbilics finds at once which of all the triangles are worth a tree.
    bound = float(reach.max(initial=0.0)) * (1.0 + 1e-9)
    far, _ = cKDTree(place).query(middle, distance_upper_bound=bound, workers=threads())
    some = np.flatnonzero(np.isfinite(far))
    near = cKDTree(middle[some]).query_ball_point(place, reach)
    nearest = np.full(len(obstacle), np.inf)
    for number, found in enumerate(near):
        if rows[number] < 0:
            continue
        found = some[np.asarray(found, np.int64)]
        # Not the other side of a thin sheet.
        found = found[normal[found] @ normal[rows[number]] > 0.0]
        distance = np.linalg.norm(middle[found] - place[number], axis=1)
        closer = distance < nearest[found]
        nearest[found[closer]] = distance[closer]
        obstacle[found[closer]] = number
        obstacle[rows[number]] = number
        nearest[rows[number]] = 0.0
    return obstacle


def _lines(
    stage: _Stage,
    traces: Traces,
    family: np.ndarray,
    point: np.ndarray,
    target: np.ndarray,
    apart: float,
) -> Separatrices:
    surface, planes, inner = stage.surface, stage.planes, stage.inner
    count = len(family)
    detail = DETAIL * float(np.median(stage.edge)) if len(inner) else 1.0
    rows = sparse_rows(traces, detail)
    line = np.repeat(np.arange(count), np.diff(traces.start))[rows]
    joined = joined_bundles(
        points_of(surface, planes, traces.triangle[rows], traces.z[rows]),
        surface.face_normal_area[0][traces.triangle[rows]],
        line,
        family,
        point,
        target,
        max(apart, 2.0 * detail),
        max(RUN * apart, 4.0 * detail),
    )
    rows, line, target = rows[joined.row], joined.line, joined.target
    straight = _straight_in(stage, traces, rows, line, target)
    rows, line = rows[straight], line[straight]
    # One more point for each line that reaches an umbilic: the umbilic itself.
    reached = np.flatnonzero(target >= 0)
    at = inner[target[reached]]
    triangle = np.concatenate([traces.triangle[rows], at])
    z = np.concatenate([traces.z[rows], stage.z[target[reached]]])
    line = np.concatenate([line, reached])
    order = np.argsort(line, kind="stable")
    made = lines_from(
        surface, planes, line[order], triangle[order], z[order], family, np.zeros(count, bool)
    )
    end = np.maximum(-target, 0).astype(np.int8)
    target = np.maximum(target, -1)
    return Separatrices(**{**vars(made), "source": point, "target": target}, end=end)


def _straight_in(
    stage: _Stage, traces: Traces, rows: np.ndarray, line: np.ndarray, target: np.ndarray
) -> np.ndarray:
    """(r,) bool points `rows` of a trace that lines keep: without the last ones beside an umbilic
    that a line ends at, from which it would turn aside to it; between two umbilics that near to
    each other none but the first where it would turn aside from all."""
    triangle = traces.triangle[rows]
    points = points_of(stage.surface, stage.planes, triangle, traces.z[rows])
    normal = stage.surface.face_normal_area[0][triangle]
    reach = BEFORE * stage.reach
    first = np.searchsorted(line, np.arange(len(target) + 1))
    kept = np.ones(len(rows), bool)
    for number in np.flatnonzero(target >= 0):
        # Of its points the first stays, and one whose chord into the umbilic is short enough.
        mine = np.arange(first[number] + 1, first[number + 1])
        way = stage.point[target[number]] - points[mine]
        near = np.linalg.norm(way, axis=1) <= reach[target[number]]
        far = np.flatnonzero(~near)
        mine, way = (some[far[-1] if len(far) else 0 :] for some in (mine, way))
        if not len(mine):
            continue
        before = points[mine] - points[mine - 1]
        aim = [
            unit(some - np.einsum("qc,qc->q", some, normal[mine])[:, None] * normal[mine])
            for some in (before, way)
        ]
        cosine = np.einsum("qc,qc->q", *aim)
        ahead = np.flatnonzero(cosine >= STRAIGHT_IN)
        if len(ahead):
            last = int(ahead[-1])
        elif len(far):
            last = int(cosine.argmax())
        else:
            # Between umbilics that near to each other no direction is resolved: straight across.
            last = -1
        kept[mine[last + 1 :]] = False
    return kept


def skeleton(lines: Separatrices) -> Separatrices:
    """Separatrices with each arc between two umbilics once, though both ends started it."""
    ends = np.sort(np.stack([lines.source, lines.target], axis=1), axis=1)
    drop = np.zeros(len(lines), bool)
    joined = np.flatnonzero(lines.target >= 0).tolist()
    for position, one in enumerate(joined):
        for two in joined[position + 1 :]:
            same = lines.family[one] == lines.family[two] and (ends[one] == ends[two]).all()
            if same and not drop[one] and _alike(lines, one, two):
                drop[two] = True
    return lines.select(~drop)


def _alike(lines: Lines, one: int, two: int) -> bool:
    """Whether two arcs are the same path: the middle of one lies on the other."""
    points = lines.points(one)
    middle = points[len(points) // 2]
    other = lines.points(two)
    step = np.linalg.norm(np.diff(other, axis=0), axis=1).max(initial=0.0)
    return bool(np.linalg.norm(other - middle, axis=1).min() <= 3.0 * step)
