"""The paper's patch with three known umbilics: its tables 1 and 2, figures 2, 4, 5 and 8."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from surfaces import AnalyticSurface, seed_patch

import core

from . import pictures
from .page import Page, number
from .surfaces_found import detect, in_patch, local_edges, match, operators, paper_points, raw

NAMES = ("p1", "p2", "p3")
_FEW, _MANY = 5400, 21600
_SEEDS = range(20)


def write(page: Page) -> None:
    page.heading("The patch")
    page.text(
        f"""z = ½(x² + y²) + 1.2x³ − ½x²y + 0.2xy² + 1.6y³ on [−1.2, 1.2]², {_FEW:,} random
        points (seed 0), triangulated by Delaunay. Its three umbilics are known. The border of
        such a mesh has long slivers where no estimate is sound and even exact operators are
        interpolated over many edges; as usual, "inside" means |x|, |y| < 1.1."""
    )
    few, many = seed_patch(_FEW), seed_patch(_MANY)
    _tables_1_and_2(page, few)
    _methods(page, few, many)
    _opening(page, few)


def _tables_1_and_2(page: Page, mesh: AnalyticSurface) -> None:
    page.heading("Numerical behaviour with exact operators (Tables 1 and 2)", 3)
    page.text(
        """Each triangle is tested alone, as in the paper: it is zero-crossing if the
        interpolated t vanishes inside it. Exact principal curvatures and directions at the
        vertices."""
    )
    places, edges = {}, local_edges(mesh)
    for table, kind in ((1, "projection"), (2, "conformal")):
        points, triangles = paper_points(mesh, kind)
        distance = np.linalg.norm(points[:, None] - mesh.umbilics.position[None], axis=2)
        nearest = distance.argmin(axis=0)
        places[kind] = points[nearest]
        inside = np.count_nonzero(in_patch(points))
        page.text(
            f"""**Table {table}**, {_parametrization(kind)}: {inside} zero-crossing triangles
            inside, {len(points) - inside} on the border."""
        )
        rows = []
        for k, row in enumerate(nearest):
            rows.append(
                [
                    NAMES[k],
                    _point(mesh.umbilics.position[k]),
                    _point(points[row]),
                    triangles[row],
                    f"{distance[row, k]:.2e}",
                    number(distance[row, k] / edges[k]),
                ]
            )
        page.table(["umbilic", "true", "found", "triangle", "error", "in edges"], rows)
    gap = np.linalg.norm(places["projection"] - places["conformal"], axis=1) / edges
    worst, mean, complete = _many_meshes()
    page.text(
        f"""The two parametrizations give points {gap.max():.1e} of an edge apart at most. Over
        {len(_SEEDS)} other random meshes of the same size they are never farther apart than
        {worst:.1e} of an edge; the mean errors at p1, p2, p3 are
        {", ".join(number(value) for value in mean["projection"])} edges by projection and
        {", ".join(number(value) for value in mean["conformal"])} by rotation; exactly the three
        umbilics are found inside in {complete["projection"]} and {complete["conformal"]} of the
        {len(_SEEDS)} meshes."""
    )
    page.differences.append(
        f"""Projection or conformal transformation: the paper sees no appreciable difference, and
        there is none here: at most {worst:.1e} of an edge, far below the error itself."""
        if worst < 0.05
        else f"""Projection and conformal transformation differ by up to {number(worst)} of an
        edge here; the paper sees no appreciable difference."""
    )


def _many_meshes() -> tuple[float, dict[str, np.ndarray], dict[str, int]]:
    """Largest distance in edges between the two parametrizations' points, their mean errors,
    and how many meshes have exactly three points inside, over random meshes."""
    worst, errors, complete = 0.0, {}, {}
    for seed in _SEEDS:
        mesh = seed_patch(_FEW, seed=100 + seed)
        place = {}
        for kind in ("projection", "conformal"):
            points, _ = paper_points(mesh, kind)
            distance = np.linalg.norm(points[:, None] - mesh.umbilics.position[None], axis=2)
            place[kind] = points[distance.argmin(axis=0)]
            errors.setdefault(kind, []).append(distance.min(axis=0) / local_edges(mesh))
            exact = np.count_nonzero(in_patch(points)) == 3
            complete[kind] = complete.get(kind, 0) + int(exact)
        apart = np.linalg.norm(place["projection"] - place["conformal"], axis=1)
        worst = max(worst, float(apart.max() / mesh.edge_length))
    return worst, {kind: np.mean(rows, axis=0) for kind, rows in errors.items()}, complete


def _methods(page: Page, few: AnalyticSurface, many: AnalyticSurface) -> None:
    page.heading("S, I and C (Figures 2, 4 and 5)", 3)
    page.text(
        """The three methods on the same operators, without any filter. An umbilic counts as
        found if a point lies within two edges of it; a point inside that is farther from all
        three is spurious. "On the border" counts points outside |x|, |y| < 1.1. Below them what
        the paper starts from (section 2.1): vertices where k1 - k2 or H^2 - K (by Meyer et al.
        2003, from the mesh alone) is less than at all neighbours, and those whose curvatures have
        one sign and are alike to 5 %."""
    )
    rows, kept = [], {}
    for mesh, count in ((few, _FEW), (many, _MANY)):
        for source in ("exact", "jets", "normals"):
            field = operators(mesh, source)
            # As in the paper the whole patch is one chart.
            settings = raw("S", charts="seams")
            for result in core.compare(mesh.vertices, mesh.triangles, settings, given=field):
                kept[count, source, result.method] = result.detection
                row = _row(mesh, result.detection)
                rows.append([f"{count:,}", source, result.method, *row])
    page.table(
        ["points", "operators", "method", *(f"{name}: error (points)" for name in NAMES),
         "spurious inside", "on the border"],
        rows,
    )  # fmt: skip
    default = detect(many, core.Settings())
    inside = in_patch(default.umbilics.position)
    result = match(many, default.umbilics.position, inside)
    page.text(
        f"""With the default settings (jets, the place refined by a fit at the point itself,
        automatic persistence) {_MANY:,} points give {np.count_nonzero(inside)} umbilics inside,
        at {", ".join(number(value) for value in result.error)} edges from p1, p2, p3, and
        {np.count_nonzero(~inside & default.umbilics.certain)} outside that are called
        certain."""
    )
    for source, name, label in (
        ("exact", "patch-exact", "exact operators (Figure 4)"),
        ("normals", "patch-normals", "operators from normals (Figures 2 and 5)"),
    ):
        path = page.figure(
            name,
            f"""The patch laid flat, {_FEW:,} random points, {label}, by S, I and C. Strokes are
            the direction of the larger curvature; rings mark the true umbilics.""",
        )
        pictures.write(
            path,
            [_panel(few, kept[_FEW, source, method], method) for method in ("S", "I", "C")],
            3,
        )
    _judge_methods(page, few, kept)
    _judge_baselines(page, few, kept)


def _judge_methods(page: Page, mesh: AnalyticSurface, kept: dict) -> None:
    by = {method: kept[_FEW, "exact", method] for method in ("S", "I", "C")}
    places = {
        method: found.candidates.position[in_patch(found.candidates.position)]
        for method, found in by.items()
    }
    if len(places["S"]) == len(places["C"]):
        distance = np.linalg.norm(places["S"][:, None] - places["C"][None], axis=2)
        apart = distance.min(axis=1).max() / mesh.edge_length
        page.differences.append(
            f"""S and C on the patch with exact operators: comparable, as the paper says; their
            points are {number(apart)} of an edge apart at most."""
        )
    near = match(mesh, places["I"]).near
    page.differences.append(
        f"""I on the patch with exact operators gives {", ".join(map(str, near))} vertices near
        the three umbilics: clusters, as the paper says, because the rings of neighbouring
        vertices overlap."""
    )
    spurious = {
        source: match(
            mesh,
            kept[_FEW, source, "S"].candidates.position,
            in_patch(kept[_FEW, source, "S"].candidates.position),
        ).spurious
        for source in ("jets", "normals")
    }
    page.differences.append(
        f"""The spurious points of the paper's Figures 2 and 5(d) belong to its estimator, not to
        the surface or to S: on {_FEW:,} points S has {spurious["normals"]} spurious points inside
        with operators from normals and {spurious["jets"]} with cubic jets on the same mesh. A
        one-ring estimator errs by a constant share on irregular meshes however fine they are;
        the jets converge."""
    )


def _judge_baselines(page: Page, mesh: AnalyticSurface, kept: dict) -> None:
    told = {}
    for method in ("S", *core.BASELINES):
        candidates = kept[_FEW, "exact", method].candidates
        told[method] = match(mesh, candidates.position, in_patch(candidates.position))
    gap, difference, ratio = (told[name] for name in core.BASELINES)
    page.differences.append(
        f"""The ways at vertices alone, with exact operators on the patch: minima of k1 - k2 lie
        {", ".join(number(value, 2) for value in gap.error)} edges from the three umbilics, where S
        lies {", ".join(number(value, 2) for value in told["S"].error)}, with {gap.spurious} more
        inside; minima of H^2 - K are {difference.spurious} inside that are none, since one ring of
        an irregular mesh tells H and K to a constant error only; the ratio marks
        {int(ratio.near.sum())} vertices around the three and {ratio.spurious} elsewhere."""
    )


def _opening(page: Page, mesh: AnalyticSurface) -> None:
    page.heading("The opening (Figure 8)", 3)
    field = operators(mesh, "normals")
    rows, panels = [], []
    for passes in (0, 1, 2, 3, 4):
        found = detect(mesh, raw("S", opening=passes), field)
        points = found.umbilics.position
        result = match(mesh, points, in_patch(points))
        rows.append(
            [
                passes,
                len(points),
                ", ".join(name for name, e in zip(NAMES, result.error, strict=True) if e <= 2),
                result.spurious,
                result.outside,
            ]
        )
        if passes in (0, 2):
            panel = _panel(mesh, found, f"S, {passes} erosions and dilations")
            elliptic = pictures.elliptic_rows(mesh.vertices, mesh.triangles, found, passes)
            dropped = found.candidates.select(~found.candidates.elliptic)
            panels.append(
                replace(
                    panel,
                    tints=[(elliptic, pictures.ELLIPTIC)],
                    dropped=pictures.laid_flat(dropped) if passes else None,
                )
            )
    page.text(
        f"""Operators from normals, {_FEW:,} points. n erosions, then n dilations of the part of
        type peak or pit; points outside are dropped. Points beside the open border are kept
        back here, as always."""
    )
    page.table(["n", "kept", "umbilics kept", "spurious inside", "on the border"], rows)
    path = page.figure(
        "patch-opening",
        """Method S on the patch, operators from normals, without and with the opening (n = 2).
        The elliptic part is shown in green as it is and after the opening; grey points were
        dropped.""",
    )
    pictures.write(path, panels, 2)
    none, two = rows[0], rows[2]
    page.differences.append(
        f"""The opening (n = 2) on the patch takes the spurious points inside from {none[3]} to
        {two[3]} and keeps {two[2] or "none of the three"}. It only asks where the surface is
        elliptic: umbilics near the edge of that part may go, as the paper says, and spurious
        points inside it stay."""
    )


def _row(mesh: AnalyticSurface, found: core.Detection) -> list[str]:
    candidates = found.candidates
    inside = in_patch(candidates.position)
    result = match(mesh, candidates.position, inside)
    cells = [
        f"{number(error)} ({near})" if np.isfinite(error) else "missed"
        for error, near in zip(result.error, result.near, strict=True)
    ]
    return [*cells, str(result.spurious), str(result.outside)]


def _panel(mesh: AnalyticSurface, found: core.Detection, method: str) -> pictures.Panel:
    shown = found.umbilics
    if method == "I":
        shown = pictures.by_index(shown)
    label = f"method {method}" if len(method) == 1 else method
    return pictures.from_above(mesh, found, shown, f"{label}: {len(shown)} points")


def _parametrization(kind: str) -> str:
    return {"projection": "orthogonal projection", "conformal": "conformal transformation"}[kind]


def _point(point: np.ndarray) -> str:
    return ", ".join(f"{value:.6f}" for value in point)
