"""Time of the detection against the number of triangles, operators given (Section 7.4)."""

from __future__ import annotations

import numpy as np
from surfaces import ellipsoid

import core

from . import plots
from .page import Page, number
from .surfaces_found import raw

_SUBDIVISIONS = (3, 4, 5, 6, 7, 8)
# What method S itself does once the operators are known.
_STAGES = ("index", "location")


def write(page: Page) -> None:
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
