"""Time of the detection against the number of triangles, operators given (Section 7.4)."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
from surfaces import ellipsoid, seed_patch

import core
from core.mesh.mending.repair import clean
from core.umbilics.methods.curvature_tensor import unfolded_along_seams

from . import plots
from .model import TRIVIAL, Model
from .page import Page, number
from .surfaces_found import raw

_SUBDIVISIONS = (3, 4, 5, 6, 7, 8)
# What method S itself does once the operators are known.
_STAGES = ("index", "location")


def write(page: Page) -> None:
    _method_s(page)
    _unfolding(page)


def _method_s(page: Page) -> None:
    page.heading("Cost (Section 7.4)")
    page.text(
        """Method S on the ellipsoid with operators given: time to find the zero-crossing
        triangles and the points in them (best of five runs), for all of `core.detect` with the
        operators given, and with jets. Three decades of triangles."""
    )
    count, found, given, jets = [], [], [], []
    for subdivisions in _SUBDIVISIONS:
        mesh = ellipsoid(subdivisions=subdivisions)
        runs = [
            core.detect(mesh.vertices, mesh.triangles, raw("S"), given=mesh.curvature).timings
            for _ in range(5)
        ]
        count.append(len(mesh.triangles))
        found.append(min(sum(run[stage] for stage in _STAGES) for run in runs))
        given.append(min(sum(run.values()) for run in runs))
        jets.append(
            min(
                sum(core.detect(mesh.vertices, mesh.triangles).timings.values())
                for _ in range(5 if subdivisions < 7 else 2)
            )
        )
    count, found, given, jets = (np.array(row, dtype=float) for row in (count, found, given, jets))
    page.table(
        ["triangles", "method S, ms", "per million, s", "all, operators given, s", "all, jets, s"],
        [
            [f"{int(m):,}", number(1e3 * s), number(1e6 * s / m), number(g), number(j)]
            for m, s, g, j in zip(count, found, given, jets, strict=True)
        ],
    )
    order, _ = plots.fitted_order(count, found)
    late, _ = plots.fitted_order(count[2:], found[2:])
    # Relative weights, so that the small meshes count as much as the large ones.
    slope, offset = np.polyfit(count, found, 1, w=1.0 / found)
    fit = offset + slope * count
    page.text(
        f"""Fit: {1e3 * offset:.2f} ms + {1e6 * slope:.3f} s per million triangles, off by
        {100 * np.abs(found / fit - 1).max():.0f} % at most; as a power of the number of
        triangles the order is {order:.2f} over all sizes and {late:.2f} from
        {int(count[2]):,} triangles up."""
    )
    path = page.figure("cost", "Time against the number of triangles.")
    plots.write(
        path,
        [
            (
                "Cost",
                "triangles",
                "seconds",
                [
                    plots.Series("method S, operators given", count, found),
                    plots.Series("all of it, operators given", count, given),
                    plots.Series("all of it, jets", count, jets),
                ],
            )
        ],
    )
    linear = 0.85 < late < 1.15
    page.differences.append(
        f"""Cost: {"linear" if linear else "not quite linear"} in the number of triangles, as the
        paper says (order {late:.2f} beyond the fixed costs of small meshes); method S takes
        {number(1e6 * found[-1] / count[-1])} s per million triangles, the jets
        {number((jets[-1] - given[-1]) / found[-1], 2)} times as long as that."""
    )


def methods_row(model: Model) -> list[object]:
    """Seconds that each method takes on a model once the operators are known, the best of three."""
    arrays = model.arrays
    given = model.detect(TRIVIAL).curvature
    taken = {}
    for method in core.METHODS:
        runs = [
            core.detect(arrays.vertices, arrays.triangles, raw(method), given=given)
            for _ in range(3)
        ]
        taken[method] = min(run.timings["index"] for run in runs)
    return [model.name, len(arrays.triangles), *(taken[method] for method in core.METHODS)]


def methods_table(page: Page, rows: list[list[object]]) -> None:
    """What S saves against C, on the same meshes with the same operators."""
    page.heading("Time of S, I and C on the same meshes", 3)
    page.text(
        """Seconds from shape operators at the vertices to points with an index, the best of three
        runs; C with its automatic seams, which it needs on closed meshes: cutting, unfolding and
        interpolating."""
    )
    page.table(
        ["model", "triangles", "S", "I", "C", "C / S"],
        [
            [name, f"{count:,}", number(s), number(i), number(c), f"{c / s:.0f}"]
            for name, count, s, i, c in rows
        ],
    )
    ratios = [c / s for _, _, s, _, c in rows]
    page.differences.append(
        f"""S saves time against C, as the paper says: C takes {min(ratios):.0f} to
        {max(ratios):.0f} times as long on the same operators of the same meshes."""
    )


def _unfolding(page: Page) -> None:
    """Time and memory of the conformal map of large charts."""
    page.heading("Cost of the unfolding (method C)", 3)
    rows = []
    for points in (5_000, 25_000, 100_000):
        mesh = seed_patch(points)
        surface, _ = clean(mesh.vertices, mesh.triangles)
        before = _resident_megabytes(forget_peak=True)
        start = time.perf_counter()
        unfolding = unfolded_along_seams(surface, np.zeros((0, 2), dtype=np.int64))
        seconds = time.perf_counter() - start
        peak = _resident_megabytes() - before
        flipped = np.count_nonzero(np.abs(unfolding.shear) > np.abs(unfolding.similarity))
        rows.append(
            [
                f"{len(mesh.triangles):,}",
                number(seconds),
                f"{peak:.0f}" if peak > 0 else "–",
                flipped,
            ]
        )
    page.text(
        """One chart of random points, least squares conformal map by a sparse factorization of
        the Hermitian normal equations. Memory is the rise of the process's peak."""
    )
    page.table(["triangles of the chart", "seconds", "memory, MB", "flipped triangles"], rows)


def _resident_megabytes(forget_peak: bool = False) -> float:
    """Peak memory of this process, or with `forget_peak` what it has now, the peak starting
    anew; NaN where the system does not say."""
    try:
        if forget_peak:
            Path("/proc/self/clear_refs").write_text("5")
        lines = Path("/proc/self/status").read_text().splitlines()
    except OSError:
        return float("nan")
    field = "VmRSS:" if forget_peak else "VmHWM:"
    return next(int(line.split()[1]) / 1024 for line in lines if line.startswith(field))
