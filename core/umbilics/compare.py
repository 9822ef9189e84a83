"""Methods S, I and C, and what they are measured against, side by side on one mesh."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from ..base.blas import one_blas_thread
from ..base.errors import ChartError
from ..base.progress import Progress
from ..base.settings import Settings
from ..curvature.field import CurvatureField
from ..mesh.input_map import places_in_input
from ..mesh.mending.repair import clean
from ..mesh.surface import Surface
from .detect import detect
from .methods.at_vertices import alike, least_difference, least_gap
from .methods.vertex_index import a_corner
from .result import KINDS, UNCERTAIN, Detection, Umbilics

# Edges within which a point of one method is one of another.
NEAR = 2.0
METHODS = ("S", "I", "C")
LEAST_GAP, LEAST_DIFFERENCE, ALIKE_RATIO = "k1-k2", "H2-K", "ratio"
BASELINES = (LEAST_GAP, LEAST_DIFFERENCE, ALIKE_RATIO)


@dataclass(frozen=True)
class MethodResult:
    """What one method made of the mesh.

    Attributes
    ----------
    method:
        "S", "I" or "C", or one of the `BASELINES`.
    detection:
        Its result, None where it could not be done. Baselines find vertices without index or
        kind: 0 and "uncertain".
    refusal:
        Why not, in a sentence for the user; else empty.
    seconds:
        Time from shape operators to umbilics.
    confirmed:
        How many umbilics of method S have one of this method's points within two edges.
    missed:
        How many have none.
    unmatched:
        How many of this method's points are farther than two edges from every umbilic of S.
    error:
        Median distance of the confirmed umbilics to this method's nearest point, in edges; NaN
        without any.
    """

    method: str
    detection: Detection | None
    refusal: str
    seconds: float
    confirmed: int
    missed: int
    unmatched: int
    error: float = float("nan")


@one_blas_thread()
def compare(
    vertices: np.ndarray,
    triangles: np.ndarray,
    settings: Settings | None = None,
    progress: Progress | None = None,
    *,
    given: CurvatureField | None = None,
    seams: np.ndarray | None = None,
    uv: np.ndarray | None = None,
    sharp: np.ndarray | None = None,
) -> tuple[MethodResult, ...]:
    """Run all three methods on the same shape operators, and the usual ways beside them.

    The arguments are those of `core.detect`; `Settings.method` is not read. The operators are
    estimated once, for method S, and handed to the others. A chart that method C cannot unfold
    is not an error here: the result says why. Then follow the `BASELINES`: vertices where the
    gap, or H^2 - K, is less than around them, and those where the curvatures are nearly alike.

    Raises
    ------
    InvalidMeshError, CancelledError
        As `core.detect` does.

    Examples
    --------
    On an ellipsoid of `vertices` and `triangles`, as in `detect`:

    >>> results = core.compare(vertices, triangles)
    >>> [result.method for result in results][:3]
    ['S', 'I', 'C']
    >>> results[0].detection.umbilics.counts()["lemon"]
    4
    """
    settings = settings or Settings()
    progress = progress or Progress()
    extra = {"seams": seams, "uv": uv}
    first = replace(settings, method="S")
    part = progress.part("Method S", 0.0, 0.6)
    by_shape = detect(vertices, triangles, first, part, given=given, sharp=sharp, **extra)
    results = [_result("S", by_shape, by_shape, vertices, triangles, _after_operators(by_shape))]
    # Given operators are used as they are, so a filter of the normals must not come again.
    other = replace(settings, curvature="given", normal_smoothing=0)
    for number, method in enumerate(METHODS[1:]):
        part = progress.part(f"Method {method}", 0.6 + 0.15 * number, 0.75 + 0.15 * number)
        start = time.perf_counter()
        try:
            found = detect(
                vertices,
                triangles,
                replace(other, method=method),
                part,
                given=by_shape.curvature,
                **extra,
            )
        except ChartError as error:
            seconds = time.perf_counter() - start
            results.append(
                MethodResult(method, None, str(error), seconds, 0, len(by_shape.umbilics), 0)
            )
            continue
        seconds = _after_operators(found)
        results.append(_result(method, found, by_shape, vertices, triangles, seconds))
    progress.part("Vertices", 0.9, 1.0)
    surface, _ = clean(vertices, triangles, settings.join_borders)
    for method in BASELINES:
        start = time.perf_counter()
        found = _at_vertices(method, surface, by_shape)
        seconds = time.perf_counter() - start
        results.append(_result(method, found, by_shape, vertices, triangles, seconds))
    progress.step(1.0)
    return tuple(results)


def _at_vertices(method: str, surface: Surface, by_shape: Detection) -> Detection:
    """What a baseline finds, with the same shape operators, as a detection."""
    field = by_shape.curvature
    at_surface = CurvatureField(
        **{name: value[surface.source_vertex] for name, value in vars(field).items()}
    )
    if method == LEAST_GAP:
        vertex = least_gap(surface, at_surface)
    elif method == LEAST_DIFFERENCE:
        vertex = least_difference(surface)
    else:
        vertex = alike(surface, at_surface)
    triangle, corner = a_corner(surface, vertex)
    input_triangle, barycentric = places_in_input(surface, triangle, np.eye(3)[corner])
    umbilics = replace(
        _unknown(by_shape.candidates, len(vertex)),
        position=surface.vertices[vertex] * surface.unit + surface.origin,
        normal=at_surface.normal[vertex],
        triangle=input_triangle,
        barycentric=barycentric,
        vertex=surface.source_vertex[vertex],
        index=np.zeros(len(vertex)),
        kind=np.full(len(vertex), UNCERTAIN),
        curvature=0.5 * (at_surface.k1 + at_surface.k2)[vertex],
    )
    return replace(
        by_shape,
        umbilics=umbilics,
        candidates=umbilics,
        regions=(),
        triangle_index=np.zeros(len(by_shape.triangle_index)),
        index_sum=float("nan"),
        warnings=(),
    )


def _unknown(like: Umbilics, count: int) -> Umbilics:
    """So many umbilics of which nothing is known: NaN, -1 and False."""
    fill = {"f": np.nan, "i": -1, "b": False, "U": UNCERTAIN}
    return Umbilics(
        **{
            name: np.full((count, *value.shape[1:]), fill[value.dtype.kind], value.dtype)
            for name, value in vars(like).items()
        }
    )


def _after_operators(detection: Detection) -> float:
    return sum(detection.timings.values()) - detection.timings.get("curvature", 0.0)


def _result(
    method: str,
    found: Detection,
    by_shape: Detection,
    vertices: np.ndarray,
    triangles: np.ndarray,
    seconds: float,
) -> MethodResult:
    ours, theirs = found.umbilics, by_shape.umbilics
    away = edges_away(vertices, triangles, theirs.triangle, theirs.position, ours.position)
    here = within_edges(vertices, triangles, ours.triangle, ours.position, theirs.position)
    there = away <= NEAR
    confirmed = int(there.sum())
    error = float(np.median(away[there])) if confirmed else float("nan")
    return MethodResult(
        method, found, "", seconds, confirmed, len(theirs) - confirmed, int((~here).sum()), error
    )


def within_edges(
    vertices: np.ndarray,
    triangles: np.ndarray,
    triangle: np.ndarray,
    points: np.ndarray,
    others: np.ndarray,
    edges: float = NEAR,
) -> np.ndarray:
    """(k,) bool, whether points (k, 3) in the triangles (k,) have one of the others (j, 3)
    within so many times the mean side of their triangle, in a straight line."""
    return edges_away(vertices, triangles, triangle, points, others) <= edges


def edges_away(
    vertices: np.ndarray,
    triangles: np.ndarray,
    triangle: np.ndarray,
    points: np.ndarray,
    others: np.ndarray,
) -> np.ndarray:
    """(k,) distance of points (k, 3) in the triangles (k,) to the nearest of the others (j, 3)
    over the mean side of their triangle; infinite without others."""
    if not len(points) or not len(others):
        return np.full(len(points), np.inf)
    corners = np.asarray(vertices, dtype=np.float64)[np.asarray(triangles)[triangle]]
    side = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).mean(axis=1)
    distance, _ = cKDTree(others).query(points)
    return np.asarray(distance / np.maximum(side, np.finfo(float).tiny))


def comparison_rows(results: tuple[MethodResult, ...]) -> list[list[str]]:
    """The comparison as rows of text, a heading first.

    Examples
    --------
    On an ellipsoid of `vertices` and `triangles`, as in `detect`:

    >>> rows = core.comparison_rows(core.compare(vertices, triangles))
    >>> rows[0][:2], rows[1][:2]
    (['method', 'points'], ['S', '4'])
    """
    heading = ["method", "points", *KINDS, "index sum", "near S", "missed", "elsewhere"]
    rows = [[*heading, "edges away", "seconds"]]
    for result in results:
        if result.detection is None:
            rows.append([result.method, "refused"] + ["–"] * (len(rows[0]) - 2))
            continue
        umbilics = result.detection.umbilics
        counts = umbilics.counts()
        named = result.method in METHODS
        rows.append(
            [
                result.method,
                str(len(umbilics)),
                *(str(counts[kind]) if named else "–" for kind in KINDS),
                f"{result.detection.index_sum:+g}" if named else "–",
                str(result.confirmed),
                str(result.missed),
                str(result.unmatched),
                f"{result.error:.2f}" if result.confirmed else "–",
                f"{result.seconds:.2f}",
            ]
        )
    return rows


def comparison_table(results: tuple[MethodResult, ...]) -> str:
    """The comparison as lines of aligned columns, and why a method was refused.

    Examples
    --------
    On an ellipsoid of `vertices` and `triangles`, as in `detect`:

    >>> core.comparison_table(core.compare(vertices, triangles)).splitlines()[0]
    'method  points  star  lemon...'
    """
    rows = comparison_rows(results)
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    lines = [
        "  ".join(
            cell.ljust(width) if k == 0 else cell.rjust(width)
            for k, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]
    lines += [f"{result.method}: {result.refusal}" for result in results if result.refusal]
    return "\n".join(lines)
