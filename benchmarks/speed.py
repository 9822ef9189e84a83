"""Time and memory of the whole detection, other programs beside it: docs/speed.md.

    benchmarks/speed [--quick] [--rounds N] [--limit SECONDS] [--out FILE]

Every program runs in a process of its own, one after the other on the same mesh, and does its
work several rounds; the figures are medians. Other programs are built or installed where that can
be (benchmarks/peers).
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from surfaces import AnalyticSurface, ellipsoid, random_ellipsoid, seed_patch

from . import ROOT
from .awkward_meshes import AXES, awkward_meshes
from .pages import machine, publish, table
from .peers.measurement import LIMIT, Measurement
from .programs import LEAST_ROUNDS, OURS, Ours, measure_all, peers

# Vertices where the directions are clear: the gap is more than this part of its median.
CLEAR = 0.1
# Subdivisions of the icosahedron: 20 * 4^level triangles.
LEVELS, QUICK_LEVELS = (5, 6, 7, 8, 9), (5, 6, 7)
COMPARED, QUICK_COMPARED = (6, 8), (6,)
AWKWARD, QUICK_AWKWARD = 7, 5
# The largest mesh: so many ellipsoids of the last level, beside each other.
LARGEST = 2
# Errors on the patch are taken this far inside, in half its width.
INTERIOR = 0.9

HEADER = """# Speed

Written by `benchmarks/speed`{options} on {machine}.

The mesh is the ellipsoid with half axes 3, 2 and 1, a subdivided icosahedron, in double precision
and as Blender keeps it, in single. The programs run one
after the other, each in a process of its own that does the work {rounds} times, ours at least
{least} times: "seconds" is the median, "first" the first time, when memory is new to the process.
Reading the mesh is not counted. "Above the input" is peak memory less that after reading. The
error is the root mean square angle between the first principal directions and the true ones, where
the gap of the curvatures is above {clear:.0%} of its median. Umbilics does everything that
`core.detect` does with its defaults: curvature, the certified index, location, kinds and
persistence, in as many threads as there are processors; the others use one thread as they come.

{peers}
"""

_COMPARED = (
    "Program",
    "Seconds",
    "times ours",
    "first",
    "Peak MB",
    "above the input",
    "Direction error",
)
_AWKWARD = ("Mesh", "Triangles", "Seconds", "µs a triangle", "times the even one's")
_GROWTH = ("Triangles", "Seconds", "µs a triangle", "MB above the input", "bytes a triangle")


def direction_error(
    surface: AnalyticSurface, d1: np.ndarray, where: np.ndarray | None = None
) -> float:
    """Root mean square angle in degrees between lines d1 (n, 3) and the true ones, at the
    vertices `where` (n,) or all."""
    gap = surface.k1 - surface.k2
    clear = gap > CLEAR * np.median(gap)
    if where is not None:
        clear &= where
    cross = np.linalg.norm(np.cross(d1, surface.d1), axis=1)
    dot = np.abs(np.einsum("ij,ij->i", d1, surface.d1))
    angle = np.degrees(np.arctan2(cross, dot))[clear]
    return float(np.sqrt(np.mean(angle**2)))


def compare(level: int, others: list[Callable], rounds: int) -> str:
    """Markdown: all programs on one ellipsoid in both precisions, a row for each."""
    exact = ellipsoid(AXES, level)
    title = f"{len(exact.triangles):,} triangles"
    parts = []
    for precision, number in (("double", np.float64), ("single", np.float32)):
        print(f"{title}, {precision} precision, all programs", file=sys.stderr)
        rounded = exact.vertices.astype(number).astype(float)
        results, stopped = measure_all(rounded, exact.triangles, others, rounds)
        ours = results[0][0]
        rows = [
            (
                run.program,
                f"{run.seconds:.2f}",
                "1" if run.program == OURS else f"{run.seconds / ours.seconds:.1f}",
                f"{run.rounds[0]:.2f}",
                f"{run.peak_mb:.0f}",
                f"{run.peak_mb - run.input_mb:.0f}",
                f"{direction_error(exact, d1):.4f}°",
            )
            for run, d1 in results
        ]
        parts.append(
            f"## {title}, {precision} precision\n\n{table(_COMPARED, rows)}\n\n"
            f"Our threads worked {ours.processor:.2f} s together.\n{_words(stopped)}"
        )
    return "\n".join(parts)


def _words(stopped: list[str]) -> str:
    """A paragraph on the programs that did not end, or nothing."""
    return "\n" + "; ".join(stopped) + ".\n" if stopped else ""


def compare_awkward(level: int, others: list[Callable], rounds: int, limit: float) -> str:
    """Markdown: every program on meshes that are not even, and its time there for each triangle
    against the even mesh; others get so many seconds on each."""
    words: list[str] = []
    rows: list[tuple[str, ...]] = []
    even: dict[str, float] = {}
    for name, (vertices, triangles) in awkward_meshes(level):
        print(f"{name}, {len(triangles):,} triangles", file=sys.stderr)
        results, stopped = measure_all(vertices.astype(float), triangles, others, rounds, limit)
        words += [f"{name}: {word}" for word in stopped]
        for run, _ in results:
            each = run.seconds / len(triangles)
            even.setdefault(run.program, each)
            rows.append(
                (
                    f"{name}: {run.program}",
                    f"{len(triangles):,}",
                    f"{run.seconds:.2f}",
                    f"{1e6 * each:.2f}",
                    f"{each / even[run.program]:.2f}",
                )
            )
    return (
        "## Awkward meshes\n\n"
        f"Other programs get {limit:g} s for their rounds on a mesh.\n\n"
        f"{table(_AWKWARD, rows)}\n{_words(words)}"
    )


def compare_directions(others: list[Callable]) -> str:
    """Markdown: every program's error in the directions on meshes of random points."""
    hull, patch = random_ellipsoid(count=40_962), seed_patch(5400)
    half = np.abs(patch.vertices[:, :2]).max()
    cases = [
        (f"{len(hull.vertices):,} random points on the ellipsoid, their hull", hull, None),
        (
            f"{len(patch.vertices):,} random points of the test patch, its interior",
            patch,
            (np.abs(patch.vertices[:, :2]) < INTERIOR * half).all(axis=1),
        ),
    ]
    errors: dict[str, list[str]] = {}
    for _, surface, where in cases:
        for run, d1 in measure_all(surface.vertices, surface.triangles, others, 1)[0]:
            error = direction_error(surface, d1, where)
            errors.setdefault(run.program, []).append(f"{error:.3f}°")
    rows = [(program, *found) for program, found in errors.items()]
    return (
        "## Direction error on random points\n\n"
        "The interior is all that is further from a side than a twentieth of the patch's width.\n\n"
        f"{table(('Program', *(name for name, _, _ in cases)), rows)}\n"
    )


def largest(level: int) -> str:
    """A sentence on a mesh of several ellipsoids, for the memory that large ones take."""
    one = ellipsoid(AXES, level)
    count = len(one.vertices)
    beside = [np.array([3.0 * AXES[0] * k, 0.0, 0.0]) for k in range(LARGEST)]
    vertices = np.concatenate([one.vertices + shift for shift in beside])
    with tempfile.TemporaryDirectory() as name:
        mesh = Path(name) / "mesh.npz"
        np.savez(
            mesh,
            vertices=vertices.astype(np.float32),
            triangles=np.concatenate([one.triangles + count * k for k in range(LARGEST)]),
        )
        size = LARGEST * len(one.triangles)
        print(f"{size:,} triangles", file=sys.stderr)
        run = Ours().measure(mesh, 1)
    return (
        f"{LARGEST} such ellipsoids beside each other, {size:,} triangles in single precision, "
        f"take {run.seconds:.0f} s and {run.peak_mb / 1024:.1f} GB in all.\n"
    )


def scaling(levels: tuple[int, ...], rounds: int) -> tuple[str, list[Measurement]]:
    """Time against size: a table with the fitted exponent, and the medians."""
    rows = []
    with tempfile.TemporaryDirectory() as name:
        mesh = Path(name) / "mesh.npz"
        for level in levels:
            surface = ellipsoid(AXES, level)
            np.savez(mesh, vertices=surface.vertices, triangles=surface.triangles)
            print(f"{len(surface.triangles):,} triangles", file=sys.stderr)
            rows.append(Ours().measure(mesh, max(rounds, LEAST_ROUNDS)))
    sizes = [20 * 4**level for level in levels]
    exponent = np.polyfit(np.log(sizes), np.log([row.seconds for row in rows]), 1)[0]
    cells = []
    for size, row in zip(sizes, rows, strict=True):
        above = row.peak_mb - row.input_mb
        numbers = f"{row.seconds:.3f}", f"{1e6 * row.seconds / size:.2f}", f"{above:.0f}"
        cells.append((f"{size:,}", *numbers, f"{above * 2**20 / size:.0f}"))
    text = (
        f"## Growth with the size of the mesh\n\n{table(_GROWTH, cells)}\n\n"
        f"The time grows with the power {exponent:.2f} of the number of triangles.\n"
    )
    return text, rows


def profile(run: Measurement, triangles: int) -> str:
    """Where the time goes: the stages of one run."""
    rows = [
        (name, f"{seconds:.2f}", f"{seconds / run.seconds:.0%}")
        for name, seconds in sorted(run.stages.items(), key=lambda item: -item[1])
    ]
    return (
        f"## Where the time goes ({triangles:,} triangles)\n\n"
        f"{table(('Stage', 'Seconds', 'Share'), rows)}\n"
    )


def in_blender(level: int, rounds: int) -> str:
    """Reading and writing back beside the detection, in a real Blender."""
    sys.path.insert(0, str(ROOT / "tools"))
    from places import BLENDER
    from run_umbilics import set_up

    script = ROOT / "benchmarks" / "speed_in_blender.py"
    command = [BLENDER, "-b", "--python-exit-code", "1", "--python", script, "--", level, rounds]
    with set_up("speed") as environment:
        done = subprocess.run(
            [str(part) for part in command],
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
    lines = [line.split()[1:] for line in done.stdout.splitlines() if line.startswith("SECONDS")]
    if done.returncode or not lines:
        return f"## In Blender\n\nNot measured in this run: {done.stderr.strip()[-300:]}\n"
    read, detect, write = np.median(np.array(lines, float), axis=0)
    return (
        f"## In Blender ({20 * 4**level:,} triangles)\n\n"
        f"Reading and triangulating take {read:.2f} s, the detection {detect:.2f} s, writing "
        f"attributes and empties back {write:.2f} s: reading and writing together are "
        f"{(read + write) / detect:.2f} of the detection.\n"
    )


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="benchmarks/speed", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="small meshes only")
    parser.add_argument(
        "--rounds", type=int, default=3, metavar="N", help="how often each does its work (3)"
    )
    parser.add_argument(
        "--limit",
        type=float,
        default=LIMIT,
        metavar="SECONDS",
        help=f"what another program gets on each awkward mesh ({LIMIT})",
    )
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "speed.md")
    options = parser.parse_args(arguments)
    if options.rounds < 1:
        parser.error("--rounds must be at least 1")
    levels, compared = (QUICK_LEVELS, QUICK_COMPARED) if options.quick else (LEVELS, COMPARED)
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    others, words = peers(Path(base) / "umbilics" / "peers")
    text = HEADER.format(
        options=" --quick" if options.quick else "",
        machine=machine(),
        rounds=options.rounds,
        least=LEAST_ROUNDS,
        clear=CLEAR,
        peers=words,
    )
    for level in compared:
        compared_here = compare(level, others, options.rounds)
        text += compared_here + "\n"
        print(compared_here, flush=True)
    level = QUICK_AWKWARD if options.quick else AWKWARD
    awkward = compare_awkward(level, others, options.rounds, options.limit)
    text += awkward + "\n"
    print(awkward, flush=True)
    text += compare_directions(others) + "\n"
    grown, medians = scaling(levels, options.rounds)
    text += grown + "\n"
    if not options.quick:
        text += largest(levels[-1]) + "\n"
    at = levels.index(compared[-1])
    text += profile(medians[at], 20 * 4 ** levels[at])
    text += "\n" + in_blender(compared[-1], options.rounds)
    notes = ROOT / "benchmarks" / "speed_notes.md"
    if notes.exists():
        text += "\n" + notes.read_text("utf-8")
    return publish(text, options.out)


if __name__ == "__main__":
    raise SystemExit(main())
