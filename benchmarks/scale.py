"""One scale for a whole mesh against one for every vertex, where umbilics are known: one table.

    python3 -m benchmarks.scale [--seeds N] [--out FILE]

Writes docs/scale.md.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path

import numpy as np

from . import ROOT
from .accuracy import Row, measure
from .cases import GRADED, GRADING, Case, make
from .scale_per_vertex import PATCH_RINGS, scale_per_vertex

SURFACES = (
    "ellipsoid 3 2 1", "ellipsoid 1.3 1 0.8", "Möbius image 2", "x⁴ + y⁴ + z⁴ = 1", "paraboloid",
    "patch",
)  # fmt: skip
CLOSED = SURFACES[:4]
EVERYWHERE, HALF, CONSTANT = "everywhere alike", "on one half only", "constant, graded mesh"

HEADER = """# One scale, or one for every vertex?

With *Scale* on *Auto* one neighbourhood is chosen for the whole mesh, the largest that still agrees
with the smaller ones within their noise. Here it is compared with the same rule at every vertex,
its medians taken over the patch of {rings} rings around it. Written by
`python3 -m benchmarks.scale --seeds {seeds}`; random points, the surfaces and columns of
[accuracy](accuracy.md), {seeds} of each mesh added up.

- **Noise**: in percent of the mean edge around each vertex; *{half}*: none on the other;
  *{constant}*: points {ratio:.0f} times denser at one end than at the other, noise in percent of
  the median edge, so that it is strongest where the mesh is finest.

"""
TITLE = "| Surface | Noise | % | True | One: found | false | error | Each: found | false | error |"


def cases(seed: int) -> Iterator[tuple[str, Case]]:
    """Meshes of random points, and the name of their kind of noise."""
    for surface in SURFACES:
        clean = make(surface, "random", seed)
        for noise in (0.0, 0.02, 0.05, 0.1):
            yield EVERYWHERE, clean.with_noise(noise, seed + 1)
        x = clean.vertices[:, 0]
        for noise in (0.05, 0.1):
            yield HALF, clean.with_noise(noise, seed + 1, x > np.median(x))
    for surface in CLOSED:
        clean = make(surface, GRADED, seed)
        edges = clean.edge_at(clean.vertices)
        for noise in (0.0, 0.02, 0.05):
            yield CONSTANT, clean.with_noise(noise, seed + 1, np.median(edges) / edges)


def table(groups: dict[tuple[str, str, float], list[tuple[Row, Row]]]) -> str:
    """Markdown: a line for each group, the rows of all seeds added up, and their sum."""
    lines = [TITLE, "|" + "---|" * 10]
    for (kind, surface, noise), rows in groups.items():
        lines.append(_line([surface, kind, f"{100 * noise:g}"], rows))
    for kind in (EVERYWHERE, HALF, CONSTANT):
        rows = [pair for key, pairs in groups.items() if key[0] == kind for pair in pairs]
        lines.append(_line(["**all**", kind, ""], rows))
    return "\n".join(lines) + "\n"


def summary(rows: list[tuple[Row, Row]]) -> str:
    """What both find of all the rows, in a sentence."""
    true = sum(len(one.case.umbilics) for one, _ in rows)
    found, false = (
        [sum(getattr(row.ours, name) for row in side) for side in zip(*rows, strict=True)]
        for name in ("found", "false")
    )
    return (
        f"In all, one scale finds {found[0]} of {true} with {false[0]} false ones, a scale of each "
        f"vertex {found[1]} of {true} with {false[1]}.\n"
    )


def _line(names: list[str], rows: list[tuple[Row, Row]]) -> str:
    cells = [*names, str(sum(len(one.case.umbilics) for one, _ in rows))]
    for scores in zip(*[[row.ours for row in pair] for pair in rows], strict=True):
        matched = [single for single in scores if single.matched]
        weights = [single.matched for single in matched]
        error = np.average([s.mean_error for s in matched], weights=weights) if matched else 0.0
        cells += [str(sum(single.found for single in scores))]
        cells += [str(sum(single.false for single in scores))]
        cells += [f"{error:.2f}" if matched else ""]
    return "| " + " | ".join(cells) + " |"


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="benchmarks.scale", description=__doc__)
    parser.add_argument("--seeds", type=int, default=1, help="meshes of each kind (default 1)")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "scale.md")
    options = parser.parse_args(arguments)
    if options.seeds < 1:
        parser.error("--seeds must be at least 1")
    groups: dict[tuple[str, str, float], list[tuple[Row, Row]]] = {}
    for seed in range(options.seeds):
        for kind, case in cases(seed):
            print(f"{case.surface}, {kind}, {100 * case.noise:g} %", file=sys.stderr)
            pair = []
            for context in (nullcontext, scale_per_vertex):
                with context():
                    pair.append(measure(case, None))
            groups.setdefault((kind, case.surface, case.noise), []).append(tuple(pair))
    header = HEADER.format(
        rings=PATCH_RINGS,
        seeds=options.seeds,
        half=HALF,
        constant=CONSTANT,
        ratio=np.exp(2 * GRADING),
    )
    pairs = [pair for rows in groups.values() for pair in rows]
    text = f"{header}{table(groups)}\n{summary(pairs)}"
    options.out.write_text(text, encoding="utf-8")
    print(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
