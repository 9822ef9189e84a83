"""How the error of an umbilic's place falls with the edge length (Proposition 5.2)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from surfaces import AnalyticSurface, ellipsoid, random_ellipsoid, seed_patch

import core

from . import plots
from .page import Page, number
from .surfaces_found import operators, raw

KINDS = {
    "exact": "exact operators",
    "jets": "jets, interpolated",
    "refined": "jets, refined (default)",
    "normals": "normals",
}


# What is measured, what it is called, and meshes of each size.
SURFACES = {
    "ellipsoid": (
        "the ellipsoid 3 : 2 : 1, subdivided icosphere",
        [[lambda s=s: ellipsoid(subdivisions=s)] for s in (3, 4, 5, 6, 7)],
    ),
    "random ellipsoid": (
        "the ellipsoid 3 : 2 : 1, random points",
        [
            [lambda n=n, k=k: random_ellipsoid(n, seed=k) for k in range(repeats)]
            for n, repeats in ((1200, 8), (4800, 6), (19200, 4), (76800, 3), (307200, 1))
        ],
    ),
    "patch": (
        "the patch, random points",
        [
            [lambda n=n, k=k: seed_patch(n, seed=200 + k) for k in range(repeats)]
            for n, repeats in ((1350, 8), (5400, 6), (21600, 4), (86400, 3), (345600, 1))
        ],
    ),
}


def write(page: Page) -> None:
    page.heading("Convergence (Proposition 5.2, Corollary 5.4)")
    page.text(
        """The distance between each true umbilic and the nearest point of its index that method
        S finds, without filters, against h, the mean edge length near the umbilics; root mean
        square over the umbilics and over several random meshes of each size. p is the fitted
        order of error = c h^p over all sizes. "Refined" is what the extension does by default
        with jets: a new fit at the point itself, in place of the interpolation. An umbilic without
        a point within five edges is missed and does not enter the error."""
    )
    orders = {}
    series = {}
    for name, (label, meshes) in SURFACES.items():
        h, errors, missed = _measure(meshes)
        page.text(f"**{label[0].upper()}{label[1:]}.**")
        order = {kind: plots.fitted_order(h, errors[kind])[0] for kind in KINDS}
        page.table(*_table(h, errors, missed, order))
        orders[name], series[name] = order, (h, errors)
    path = page.figure(
        "convergence", "Error of the umbilics' places against the mean edge length h."
    )
    plots.write(
        path,
        [
            (
                name.capitalize(),
                "h",
                "error",
                [
                    plots.Series(f"{text}: p = {orders[name][kind]:.2f}", h, errors[kind])
                    for kind, text in KINDS.items()
                ],
            )
            for name, (h, errors) in series.items()
        ],
    )
    _judge(page, orders)


def _table(
    h: np.ndarray,
    errors: dict[str, np.ndarray],
    missed: dict[str, list[int]],
    order: dict[str, float],
) -> tuple[list[str], list[list[str]]]:
    """Head and rows: what `_measure` gives, and the fitted order."""

    def cell(kind: str, k: int) -> str:
        text = f"{errors[kind][k]:.2e} ({number(errors[kind][k] / h[k], 2)})"
        return f"{text}, {missed[kind][k]} missed" if missed[kind][k] else text

    rows = [[number(h[k]), *(cell(kind, k) for kind in KINDS)] for k in range(len(h))]
    rows.append(["p", *(f"**{order[kind]:.2f}**" for kind in KINDS)])
    return ["h", *(f"{text}: error (edges)" for text in KINDS.values())], rows


def _measure(
    sizes: list[list[Callable[[], AnalyticSurface]]],
) -> tuple[np.ndarray, dict[str, np.ndarray], dict[str, list[int]]]:
    """Mean edge near the umbilics, root mean square error and count of umbilics not found
    within five edges, for each size and kind of operators."""
    h, errors, missed = [], {kind: [] for kind in KINDS}, {kind: [] for kind in KINDS}
    for makers in sizes:
        edges, squares = [], {kind: [] for kind in KINDS}
        lost = dict.fromkeys(KINDS, 0)
        for make in makers:
            mesh = make()
            edge = _edges(mesh)
            edges += edge.tolist()
            for kind, points in _points(mesh).items():
                distance = np.array([_nearest(points, mesh, k) for k in range(len(edge))])
                near = distance < 5.0 * edge
                lost[kind] += int(np.count_nonzero(~near))
                squares[kind] += (distance[near] ** 2).tolist()
        h.append(np.mean(edges))
        for kind in KINDS:
            errors[kind].append(np.sqrt(np.mean(squares[kind])) if squares[kind] else np.nan)
            missed[kind].append(lost[kind])
    return np.array(h), {kind: np.array(rows) for kind, rows in errors.items()}, missed


def _points(mesh: AnalyticSurface) -> dict[str, core.Umbilics]:
    settings = core.Settings(persistence=0.0, regions=False)
    by_jets = core.detect(mesh.vertices, mesh.triangles, settings)
    fields = {
        "exact": mesh.curvature,
        "jets": by_jets.curvature,
        "normals": operators(mesh, "normals"),
    }
    found = {"refined": by_jets.candidates}
    for kind, field in fields.items():
        detection = core.detect(mesh.vertices, mesh.triangles, raw("S"), given=field)
        found[kind] = detection.candidates
    return found


def _nearest(points: core.Umbilics, mesh: AnalyticSurface, k: int) -> float:
    same = points.position[points.index == mesh.umbilics.index[k]]
    if not len(same):
        return np.inf
    return float(np.linalg.norm(same - mesh.umbilics.position[k], axis=1).min())


def _edges(mesh: AnalyticSurface) -> np.ndarray:
    """(t,) mean edge length among the 200 vertices nearest to each umbilic."""
    local = mesh.local_edge
    count = min(200, len(local) // 8)
    return np.array(
        [
            local[
                np.argpartition(np.linalg.norm(mesh.vertices - point, axis=1), count)[:count]
            ].mean()
            for point in mesh.umbilics.position
        ]
    )


def _judge(page: Page, orders: dict[str, dict[str, float]]) -> None:
    def span(kind: str) -> str:
        values = [order[kind] for order in orders.values()]
        return f"{min(values):.2f} to {max(values):.2f}"

    def least(kind: str) -> float:
        return min(order[kind] for order in orders.values())

    page.differences.append(
        f"""Proposition 5.2 (between O(h) and O(h²) with exact operators): the fitted orders are
        {span("exact")}. Linear interpolation of t errs by h² wherever the slope of t is not
        small against its curvature, so the upper end is what one should expect."""
    )
    irregular = min(orders[name]["normals"] for name in orders if name != "ellipsoid")
    page.differences.append(
        f"""Corollary 5.4 (O(h) with estimated operators): with jets the orders are
        {span("jets")} by interpolation and {span("refined")} refined"""
        + (", better than stated" if least("jets") > 1.2 else "")
        + f""". With operators from normals they are {orders["ellipsoid"]["normals"]:.2f} on the
        regular icosphere, where errors of neighbours cancel, and down to {irregular:.2f} on
        random points: """
        + (
            """there the point nearest to the truth comes closer only because spurious points
            become denser; the operators themselves do not converge on irregular meshes, since
            the normals are right to O(h²) at best and the operator divides by h."""
            if irregular < 1.4
            else "the nearest of many spurious points also comes closer as the mesh is refined."
        )
    )
