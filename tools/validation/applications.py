"""The uses that the paper names: ship hulls, progressive lenses, telling objects apart."""

from __future__ import annotations

import numpy as np
from surfaces.design import power, progressive_lens, wigley_hull

import core
from core.base.words import counted
from core.matching.closest_points import rotation_by
from core.matching.rotation import axis_and_angle

from .model import Model
from .page import Page, number
from .surfaces_found import local_edges

# What the preset "Hull or lens" changes: creases are not fitted across.
_DESIGN = core.Settings(crease_angle=30.0)
_OBJECTS = ("hand_closed_os", "rocker-arm", "stanford-bunny", "torso_vtk")


def write(page: Page) -> None:
    page.heading("Applications (Sections 1 and 2)")
    _hull(page)
    _lens(page)
    _identification(page)


def _hull(page: Page) -> None:
    page.heading("A ship's hull", 3)
    rows = []
    for name, cells, size in (
        ("deep", 30, (0.3, 0.3)),
        ("deep", 60, (0.3, 0.3)),
        ("deep", 120, (0.3, 0.3)),
        ("Wigley's", 80, (0.1, 0.0625)),
        ("Wigley's", 160, (0.1, 0.0625)),
    ):
        mesh = wigley_hull(cells, *size)
        found = core.detect(mesh.vertices, mesh.triangles, _DESIGN)
        points = found.candidates.position
        distance = np.linalg.norm(points[:, None] - mesh.umbilics.position[None], axis=2)
        error = distance.min(axis=0) if len(points) else np.full(len(mesh.umbilics), np.inf)
        near = error / local_edges(mesh)
        rows.append(
            [name, f"{len(mesh.triangles):,}", len(points), np.count_nonzero(near < 2.0),
             number(float(near.max()), 2) if near.max() < 2.0 else "–", len(found.umbilics),
             len(found.regions)]
        )  # fmt: skip
    page.text(
        """Hulls of Wigley's form, one side with its image above the waterline: length 1, the usual
        one of breadth 0.1 and draught 1/16, a deep one of 0.3 and 0.3. Each has two stars on the
        waterline, of the usual one four thousandths of the length from stem and stern: there the
        mesh ends, fits are one-sided, and what is found stays a candidate."""
    )
    page.table(
        ["hull", "triangles", "candidates", "umbilics found", "error, edges", "reported",
         "regions"],
        rows,
    )
    file = "ship_wigley_of.stl"
    if page.models is None or not (page.models / file).is_file():
        page.left_out.append(f"The hull as a triangle soup: needs {file}.")
        return
    model = Model(page.models / file)
    found = model.detect(_DESIGN)
    each = found.umbilics.counts().items()
    counts = ", ".join(f"{count} {kind}" for kind, count in each if count)
    kinds = sorted({region.kind for region in found.regions})
    page.text(
        f"""The same hull as a program for flow simulation has it, {len(model.arrays.triangles):,}
        triangles of a soup with its deck, tilted walls and doubled faces: {len(found.candidates)}
        candidates, {len(found.umbilics)} umbilics kept ({counts or "none"}),
        {counted(len(found.regions), "region")}{f" ({', '.join(kinds)})" if kinds else ""}. In the
        words of the extension: “{" ".join(found.warnings) or "nothing to say"}”"""
    )


def _lens(page: Page) -> None:
    page.heading("A progressive lens", 3)
    rows, worst = [], 0.0
    for count in (2_000, 8_000, 32_000):
        mesh = progressive_lens(count)
        found = core.detect(mesh.vertices, mesh.triangles, core.Settings())
        field = found.curvature
        x, y = mesh.vertices[:, 0], mesh.vertices[:, 1]
        inside = (np.abs(x) < 0.7) & (np.abs(y) < 0.7)
        on_line = inside & (np.abs(x) < 0.05)
        mean = -0.5 * (field.k1 + field.k2)
        wanted, growth = power(y)
        error = np.abs(mean - wanted)[on_line].max() / wanted[on_line].min()
        # Off the line the gap grows twice as fast as the curvature along it.
        beside = inside & (np.abs(x) > 0.05) & (np.abs(x) < 0.15) & (growth > 0.1)
        ratio = np.median(field.gap[beside] / (np.abs(x) * 2.0 * growth)[beside])
        least = float(np.median(field.gap[inside & (np.abs(x) < 0.01)]) / np.median(field.gap))
        worst = max(worst, abs(float(ratio) - 1.0))
        kinds = [region.kind for region in found.regions]
        rows.append(
            [f"{len(mesh.triangles):,}", number(100.0 * error, 2), number(least, 2),
             number(float(ratio)), len(found.umbilics),
             ", ".join(sorted(set(kinds))) if kinds else "–"]
        )  # fmt: skip
    page.text(
        """A surface whose curvature grows from far to near along a line on which it is bent alike
        in
        all directions: the umbilic line of a progressive lens. Here the whole line is known. Where
        the curvature grows, lines beside it cannot be umbilical: Minkwitz's theorem (1963) says
        that the gap grows twice as fast across the line as the curvature along it. Random
        points."""
    )
    page.table(
        ["triangles", "power on the line off by, %", "gap on the line / median gap",
         "gap beside it / Minkwitz", "umbilics", "regions"],
        rows,
    )  # fmt: skip
    page.differences.append(
        f"""Progressive lenses: beside the umbilic line the measured gap is that of Minkwitz's
        theorem to {100 * worst:.1f} %."""
    )


def _identification(page: Page) -> None:
    page.heading("Telling objects apart", 3)
    known = []
    for name in _OBJECTS:
        if page.models is None or not (page.models / f"{name}.obj").is_file():
            page.left_out.append(f"Telling objects apart: needs {name}.obj.")
            return
        model = Model(page.models / f"{name}.obj")
        known.append((model, _shape(model.arrays.vertices, model.arrays.triangles)))
    scores, errors = [], []
    random = np.random.default_rng(5)
    for place, (model, _) in enumerate(known):
        vertices, triangles, turn, scale = _scan(model, random, 0.05, 0.3)
        scan = _shape(vertices, triangles)
        found = core.identify(scan, [shape for _, shape in known])
        scores.append(
            [model.name, len(scan.umbilics),
             *("–" if one is None else number(one.score, 2) for one in found)]
        )  # fmt: skip
        best = found[place]
        if best is not None:
            left = best.matrix[:3, :3] / best.scale @ turn
            errors.append(
                [model.name, f"{100 * best.overlap:.0f} %",
                 number(100.0 * best.error / known[place][1].size, 2),
                 number(float(np.degrees(axis_and_angle(left)[1])), 2),
                 number(best.rotation_error, 2), number(100.0 * abs(best.scale * scale - 1.0), 2)]
            )  # fmt: skip
    page.text(
        """Each model as another scan might have it: noise of 5 % of an edge, three tenths missing
        beyond a random plane, turned, moved and scaled at random, its umbilics detected anew. Pairs
        of umbilics with normals, curvatures and cubic invariants propose how it could lie on each
        of the four; the surfaces decide (`core.identify`, *Align to Other*, `--align-to`). The
        score is the share that overlaps, less where the distance left comes near what another shape
        leaves; a dash means another shape."""
    )
    page.table(["scan", "umbilics", *(f"on {name}" for name in _OBJECTS)], scores)
    page.text("How exactly each lies on its own model:")
    page.table(
        ["scan", "overlap", "apart, % of the size", "turned off, degrees", "stated",
         "scale off, %"],
        errors,
    )  # fmt: skip
    right = sum(
        row[2 + place] != "–"
        and all(cell == "–" or cell is row[2 + place] or float(cell) < float(row[2 + place])
                for cell in row[2:])
        for place, row in enumerate(scores)
    )  # fmt: skip
    page.differences.append(
        f"""Identifying objects: {right} of {len(known)} scans under noise, in part, in another pose
        and size are told from their umbilics."""
    )


def _shape(vertices: np.ndarray, triangles: np.ndarray) -> core.Shape:
    return core.Shape.of(vertices, triangles, core.detect(vertices, triangles))


def _scan(
    model: Model, random: np.random.Generator, noise: float, missing: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """The model rougher, in part, turned and scaled, with the turn and the scale."""
    vertices, triangles = model.arrays.vertices, model.arrays.triangles
    edge = np.linalg.norm(vertices[triangles[:, 0]] - vertices[triangles[:, 1]], axis=1).mean()
    rough = vertices + noise * edge * random.normal(size=vertices.shape)
    direction = random.normal(size=3)
    height = (vertices @ direction)[triangles].mean(axis=1)
    kept = triangles[height > np.quantile(height, missing)]
    turn, scale = rotation_by(2.0 * random.normal(size=3)), float(np.exp(random.normal()))
    return scale * rough @ turn.T + random.normal(size=3) * model.size, kept, turn, scale
