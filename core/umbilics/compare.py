"""Methods S, I and C side by side on one mesh."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from ..base.errors import ChartError
from ..base.progress import Progress
from ..base.settings import Settings
from ..curvature.field import CurvatureField
from .detect import detect
from .result import KINDS, Detection

METHODS = ("S", "I", "C")


@dataclass(frozen=True)
class MethodResult:
    """What one method made of the mesh.

    Attributes
    ----------
    method:
        "S", "I" or "C".
    detection:
        Its result, None where it could not be done.
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
    """

    method: str
    detection: Detection | None
    refusal: str
    seconds: float
    confirmed: int
    missed: int
    unmatched: int


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
    """Run all three methods on the same shape operators.

    The arguments are those of `core.detect`; `Settings.method` is not read. The operators are
    estimated once, for method S, and handed to the others. A chart that method C cannot unfold
    is not an error here: the result says why.

    Raises
    ------
    InvalidMeshError, CancelledError
        As `core.detect` does.
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
        part = progress.part(f"Method {method}", 0.6 + 0.2 * number, 0.8 + 0.2 * number)
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
    return tuple(results)


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
    there = within_edges(vertices, triangles, theirs.triangle, theirs.position, ours.position)
    here = within_edges(vertices, triangles, ours.triangle, ours.position, theirs.position)
    confirmed = int(there.sum())
    return MethodResult(
        method, found, "", seconds, confirmed, len(theirs) - confirmed, int((~here).sum())
    )


def within_edges(
    vertices: np.ndarray,
    triangles: np.ndarray,
    triangle: np.ndarray,
    points: np.ndarray,
    others: np.ndarray,
    edges: float = 2.0,
) -> np.ndarray:
    """(k,) bool, whether points (k, 3) in the triangles (k,) have one of the others (j, 3)
    within so many times the mean side of their triangle, in a straight line."""
    if not len(points) or not len(others):
        return np.zeros(len(points), dtype=bool)
    corners = np.asarray(vertices, dtype=np.float64)[np.asarray(triangles)[triangle]]
    side = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).mean(axis=1)
    distance, _ = cKDTree(others).query(points)
    return distance <= edges * side


def table(results: tuple[MethodResult, ...]) -> list[list[str]]:
    """The comparison as rows of text, a heading first."""
    rows = [["method", "points", *KINDS, "index sum", "near S", "missed", "elsewhere", "seconds"]]
    for result in results:
        if result.detection is None:
            rows.append([result.method, "refused"] + ["–"] * (len(rows[0]) - 2))
            continue
        umbilics = result.detection.umbilics
        counts = umbilics.counts()
        rows.append(
            [
                result.method,
                str(len(umbilics)),
                *(str(counts[kind]) for kind in KINDS),
                f"{result.detection.index_sum:+g}",
                str(result.confirmed),
                str(result.missed),
                str(result.unmatched),
                f"{result.seconds:.2f}",
            ]
        )
    return rows


def comparison_table(results: tuple[MethodResult, ...]) -> str:
    """The comparison as lines of aligned columns, and why a method was refused."""
    rows = table(results)
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
