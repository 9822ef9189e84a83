"""Found, missed and false umbilics on surfaces whose umbilics are known: one table.

    benchmarks/accuracy [--seeds N] [--out FILE]
    benchmarks/accuracy --meshes [--seeds N] [--first N] [--out FILE]

Writes docs/accuracy.md, or docs/accuracy_meshes.md about the meshes that people have. CGAL's
compute_umbilics is built and run on the same meshes where it and a C++ compiler are installed.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from surfaces import seed_patch

import core

from . import ROOT
from .cases import COUNT, STRETCH, Case, cases
from .pages import publish
from .peers.cgal import Cgal, CgalError
from .scoring import REACH, SPLIT_REACH, Score, score

NOISES = (0.0, 0.01, 0.02, 0.05, 0.1)

HEADER = """# Accuracy

Umbilics found on surfaces whose umbilics are known exactly, with the default settings. Written
by `benchmarks/accuracy`; {seeds}. Coarse and decimated meshes and marching
cubes are on [another page](accuracy_meshes.md).

- **Meshes**: about {count} vertices. *Regular*: a subdivided icosahedron or a grid. *Random*:
  uniformly random points, Delaunay triangles. *Stretched*: triangles {stretch:g} times longer
  than wide.
- **Noise**: standard deviation of each coordinate, in percent of the mean edge around the vertex.
- **Found**: true umbilics for which the indices of the umbilics and regions found within
  {reach:g} edges add up to theirs ({split:g} edges for the flat points of index +1, which any error
  splits into two). **False**: umbilics that no true one needs, whether or not they are marked as
  uncertain. **Error**: mean and largest distance of the found ones of index ±½, in edges. Edges
  are the mean ones around the true umbilic. **Kind**: how many of these have the right kind.
  **Σ**: ✓ where the indices of umbilics and regions sum to the Euler characteristic of a closed
  surface exactly.
- **Regions**: spherical and planar regions reported. On a sphere the right answer is one region
  and no umbilic.
- **CGAL**: {cgal}. It reports vertices and no sum that could be checked.

"""
PATCHES, PATCH_POINTS = 100, 5400
PATCH_WORDS = """
The patch whose three umbilics were published, on {meshes} meshes of {points} random points each:
all three are found on {found}, none more than {worst:.2f} edges away, and no other with them
on {right}.
"""
CGAL_RAN = (
    "version {version}, `compute_umbilics` with jets of degree 3 and neighbourhood size 2, on the "
    "same meshes (`benchmarks/peers`)"
)
CGAL_LEFT_OUT = "left out of this run, because {reason}"
COLUMNS = (
    "Surface", "Mesh", "Noise %", "True", "Found", "False", "Error", "Kind", "Σ", "Regions",
    "CGAL found", "CGAL false", "CGAL error",
)  # fmt: skip


@dataclass(frozen=True)
class Row:
    """Both programs on one mesh."""

    case: Case
    ours: Score
    sum_is_right: bool | None
    regions: int
    cgal: Score | None


def measure(case: Case, cgal: Cgal | None) -> Row:
    """Run the project's default detection, and CGAL if there is one, on a case."""
    detection = core.detect(case.vertices, case.triangles)
    umbilics = detection.umbilics
    # A region at a true umbilic stands for it: its index counts at its middle.
    centres = [
        case.vertices[case.triangles[region.triangles]].mean(axis=(0, 1))
        for region in detection.regions
    ]
    index = [region.index for region in detection.regions]
    ours = score(case, umbilics.position, umbilics.index, umbilics.kind, centres, index)
    peer = None
    if cgal is not None:
        vertex, peer_index = cgal.umbilics(case.vertices, case.triangles)
        peer = score(case, case.vertices[vertex], peer_index, None)
    right = None if case.euler is None else detection.index_sum == case.euler
    return Row(case, ours, right, len(detection.regions), peer)


def table(groups: Iterable[list[Row]]) -> str:
    """Markdown; the rows of a group are the same case with different seeds, added up."""
    lines = ["| " + " | ".join(COLUMNS) + " |", "|" + "---|" * len(COLUMNS)]
    for rows in groups:
        case = rows[0].case
        ours, peers = [row.ours for row in rows], [row.cgal for row in rows if row.cgal]
        sums = [row.sum_is_right for row in rows]
        named = sum(single.matched for single in ours)
        cells = [
            case.surface,
            case.mesh,
            f"{100 * case.noise:g}",
            "everywhere" if case.everywhere else str(len(rows) * len(case.umbilics)),
            str(sum(single.found for single in ours)),
            str(sum(single.false for single in ours)),
            _error(ours),
            f"{sum(single.kinds for single in ours)}/{named}" if named else "",
            "" if None in sums else "✓" if all(sums) else "**✗**",
            str(sum(row.regions for row in rows) or ""),
            str(sum(single.found for single in peers)) if peers else "",
            str(sum(single.false for single in peers)) if peers else "",
            _error(peers),
        ]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def _error(scores: list[Score]) -> str:
    matched = [single for single in scores if single.matched]
    if not matched:
        return ""
    mean = np.average([s.mean_error for s in matched], weights=[s.matched for s in matched])
    return f"{mean:.2f}, {max(s.worst_error for s in matched):.2f}"


def patches(count: int, points: int) -> str:
    """What is found of the published patch on so many random meshes, in words."""
    right, found, worst = 0, 0, 0.0
    for seed in range(count):
        surface = seed_patch(points, seed=seed)
        umbilics = core.detect(surface.vertices, surface.triangles).umbilics
        away = np.linalg.norm(umbilics.position[:, None] - surface.umbilics.position, axis=2)
        away[umbilics.index[:, None] != surface.umbilics.index] = np.inf
        nearest = away.min(axis=0, initial=np.inf) / surface.edge_length
        here = bool((nearest <= REACH).all())
        found += here
        right += here and len(umbilics) == len(surface.umbilics)
        worst = max(worst, float(nearest[nearest <= REACH].max(initial=0.0)))
    return PATCH_WORDS.format(meshes=count, points=points, right=right, found=found, worst=worst)


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="benchmarks.accuracy", description=__doc__)
    parser.add_argument("--seeds", type=int, default=1, help="meshes of each kind (default 1)")
    parser.add_argument("--meshes", action="store_true", help="the meshes that people have")
    parser.add_argument("--first", type=int, default=0, help="first seed of their surfaces")
    parser.add_argument("--out", type=Path)
    options = parser.parse_args(arguments)
    if options.seeds < 1:
        parser.error("--seeds must be at least 1")
    try:
        cgal: Cgal | None = Cgal()
        about = CGAL_RAN.format(version=cgal.version)
    except CgalError as error:
        cgal, about = None, CGAL_LEFT_OUT.format(reason=error)
        print(f"CGAL: {about}", file=sys.stderr)
    if options.meshes:
        from .people import page

        seeds = range(options.first, options.first + options.seeds)
        text = page(seeds, cgal, about, lambda name: print(name, file=sys.stderr))
        return publish(text, options.out or ROOT / "docs" / "accuracy_meshes.md")
    groups: dict[tuple[str, str, float], list[Row]] = {}
    for seed in range(options.seeds):
        for case in cases(NOISES, seed):
            print(f"{case.surface}, {case.mesh}, {100 * case.noise:g} %", file=sys.stderr)
            key = (case.surface, case.mesh, case.noise)
            groups.setdefault(key, []).append(measure(case, cgal))
    seeds = (
        "one mesh of each kind" if options.seeds == 1 else f"{options.seeds} meshes of each kind"
    )
    header = HEADER.format(
        seeds=seeds, count=COUNT, stretch=STRETCH, reach=REACH, split=SPLIT_REACH, cgal=about
    )
    print("the published patch", file=sys.stderr)
    text = header + table(groups.values()) + patches(PATCHES, PATCH_POINTS)
    return publish(text, options.out or ROOT / "docs" / "accuracy.md")


if __name__ == "__main__":
    sys.exit(main())
