"""Valence and stretch of the mesh: which of S and I minds them more (Section 7.2)."""

from __future__ import annotations

import numpy as np
from surfaces import AnalyticSurface
from surfaces.closed import ellipsoid_on
from surfaces.sampling import icosphere

from core.matching.closest_points import rotation_by

from .page import Page, number
from .surfaces_found import Match, detect, match, operators, raw
from .symmetry import flipped_edges

_AXES = (3.0, 2.0, 1.0)
_SEEDS = range(4)
_FLIPS = (0.0, 0.1, 0.2, 0.3)
_STRETCHES = (1.0, 2.0, 3.0, 4.0)


def write(page: Page) -> None:
    page.heading("Irregular meshes: valence and stretch (Section 7.2)")
    page.text(
        f"""“The index-based method is more sensitive to the irregularity of the mesh”: the ellipsoid
        3 : 2 : 1 with its four lemons on an icosphere of 5,120 triangles, turned at random,
        {len(_SEEDS)} meshes each, once with a share of its edges flipped, so that valences differ,
        once with the points drawn together along an axis of the sphere, so that triangles are
        stretched. Found: umbilics with a point within two edges; points: how many there are for
        each that is found; spurious: points farther away, for each mesh."""
    )
    rows: list[list[object]] = []
    total = {method: 0.0 for method in ("S", "I")}
    for what, values in (("flipped", _FLIPS), ("stretched", _STRETCHES)):
        for value in values:
            for source in ("exact", "normals"):
                told = {"S": [], "I": []}
                spread = 0.0
                for seed in _SEEDS:
                    mesh = _mesh(what, value, seed)
                    spread += _irregularity(what, mesh) / len(_SEEDS)
                    field = operators(mesh, source)
                    for method, results in told.items():
                        found = detect(mesh, raw(method), field).candidates
                        results.append(match(mesh, found.position))
                label = f"{100 * value:.0f} % of edges" if what == "flipped" else f"{value:g} times"
                cells: list[object] = [what, label, number(spread, 2), source]
                for method, results in told.items():
                    cells += _counts(results)
                    total[method] += sum(result.spurious for result in results)
                rows.append(cells)
    page.table(
        ["mesh", "how much", "irregularity", "operators", "S: found", "points", "spurious",
         "I: found", "points", "spurious"],
        rows,
    )  # fmt: skip
    page.text(
        """Irregularity is the standard deviation of the valences of flipped meshes, and the median
        ratio of the longest to the shortest side of stretched ones."""
    )
    page.differences.append(
        f"""I minds irregular meshes more, as the paper says: over all runs it has
        {total["I"]:.0f} spurious points where S has {total["S"]:.0f}."""
        if total["I"] > total["S"]
        else f"""I does not mind irregular meshes more here: it has {total["I"]:.0f} spurious points
        where S has {total["S"]:.0f}."""
    )


def _counts(results: list[Match]) -> list[object]:
    found = sum(int(np.isfinite(result.error).sum()) for result in results)
    wanted = sum(len(result.error) for result in results)
    near = sum(int(result.near.sum()) for result in results)
    spurious = sum(result.spurious for result in results) / len(results)
    return [f"{found} of {wanted}", number(near / max(found, 1), 2), number(spurious, 2)]


def _mesh(what: str, value: float, seed: int) -> AnalyticSurface:
    random = np.random.default_rng(seed)
    points, triangles = icosphere(4)
    points = points @ rotation_by(2.0 * random.normal(size=3)).T
    if what == "stretched":
        points = points * (1.0, 1.0, value)
        points /= np.linalg.norm(points, axis=1)[:, None]
    points = points @ rotation_by(2.0 * random.normal(size=3)).T
    if what == "flipped" and value:
        triangles = flipped_edges(points * _AXES, triangles, value, random)
    return ellipsoid_on(points * _AXES, triangles, _AXES)


def _irregularity(what: str, mesh: AnalyticSurface) -> float:
    if what == "flipped":
        return float(np.bincount(mesh.triangles.ravel()).std())
    corner = mesh.vertices[mesh.triangles]
    side = np.linalg.norm(np.roll(corner, -1, axis=1) - corner, axis=2)
    return float(np.median(side.max(axis=1) / side.min(axis=1)))


