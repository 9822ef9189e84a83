"""How long the guidance of a large mesh takes beside its detection: docs/guidance_speed.md.

    benchmarks/guidance [--level N] [--rounds N] [--out FILE]

Every round runs in a process of its own.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from pathlib import Path
from statistics import median

from surfaces import ellipsoid, noisy

import core
from core.base.progress import Progress
from core.retopology.crosses.cross_field import cross_field

from . import ROOT
from .pages import machine, publish, table

AXES = (3.0, 2.0, 1.0)
# Spacing at which both families have some 500 lines together.
SPACING = 0.027
# Noise in edges under which operators from normals swirl in one triangle of six or so.
NOISE = 0.12

PAGE = """# Speed of the guidance

Written by `benchmarks/guidance` on {machine}.

The mesh is the ellipsoid with half axes 3, 2 and 1, a subdivided icosahedron of {triangles:,}
triangles; figures are medians of {rounds} rounds, each in a process of its own.

{steps}

The cross field without the poles takes {field:.1f} times the detection.

## A dense field

The same ellipsoid with {noise:g} % of noise, its curvature by normals: {dropped:,} umbilics that
are dropped leave the field before crosses and lines follow it.

{dense}

They leave in {share:.2f} of the automatic cross field's processor time.
"""
_STEPS = ("Step", "Seconds", "Processor seconds", "times the detection's")


_LEAVE, _CROSSES = "dropped umbilics leave", "automatic cross field"


def measured(level: int) -> dict:
    """Seconds by the clock and of the processor of each step, in this process."""
    mesh = ellipsoid(AXES, level)
    found = {}

    def timed(name, work):
        clock, processor = time.perf_counter(), time.process_time()
        result = work()
        found[name] = time.perf_counter() - clock, time.process_time() - processor
        return result

    settings = core.GuidanceSettings(spacing=SPACING)
    detection = timed("detection", lambda: core.detect(mesh.vertices, mesh.triangles))
    guide = core.Guide(mesh.vertices, mesh.triangles, detection)
    guidance = timed("cross field and poles", lambda: guide.guidance(settings))
    lines = timed("lines of curvature", lambda: guide.lines(settings))
    timed("separatrices", lambda: guide.separatrices(settings))
    del guide
    mesh = noisy(mesh, NOISE, seed=1)
    dense = core.detect(mesh.vertices, mesh.triangles, core.Settings(curvature="normals"))
    guide = core.Guide(mesh.vertices, mesh.triangles, dense)
    steps, found = found, {}
    timed(_LEAVE, lambda: guide.simplified(Progress()))
    field = guide.measured(Progress())
    features = guide.features(settings)
    timed(
        _CROSSES,
        lambda: cross_field(
            guide.surface,
            field,
            settings,
            Progress(),
            undirected=guide.undirected,
            features=features,
        ),
    )
    return {
        "triangles": len(mesh.triangles),
        "seconds": steps,
        "dense": found,
        "dropped": len(dense.candidates) - len(dense.umbilics),
        "lines": len(lines),
        "field": guidance.timings["cross field"],
    }


def page(runs: list[dict], where: str) -> str:
    """The page, from what `measured` has found in each round on the machine described."""
    whole = median(run["seconds"]["detection"][0] for run in runs)
    rows = []
    for name in runs[0]["seconds"]:
        clock, processor = (median(run["seconds"][name][k] for run in runs) for k in (0, 1))
        label = f"{median(run['lines'] for run in runs):g} {name}" if "lines" in name else name
        rows.append((label, f"{clock:.2f}", f"{processor:.2f}", f"{clock / whole:.1f}"))
    dense = {
        name: [median(run["dense"][name][k] for run in runs) for k in (0, 1)]
        for name in (_LEAVE, _CROSSES)
    }
    return PAGE.format(
        machine=where,
        noise=100 * NOISE,
        dropped=round(median(run["dropped"] for run in runs)),
        dense=table(
            _STEPS[:3],
            [(name, f"{clock:.2f}", f"{work:.2f}") for name, (clock, work) in dense.items()],
        ),
        share=median(run["dense"][_LEAVE][1] / run["dense"][_CROSSES][1] for run in runs),
        triangles=runs[0]["triangles"],
        rounds=len(runs),
        steps=table(_STEPS, rows),
        field=median(run["field"] / run["seconds"]["detection"][0] for run in runs),
    )


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="benchmarks/guidance", description=__doc__)
    parser.add_argument("--level", type=int, default=8, help="20 * 4^level triangles (8)")
    parser.add_argument("--rounds", type=int, default=3, help="how often it is measured (3)")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "guidance_speed.md")
    parser.add_argument("--one", action="store_true", help="one round, as JSON")
    options = parser.parse_args(arguments)
    if options.one:
        print(json.dumps(measured(options.level)))
        return 0
    where = machine()
    command = [sys.executable, "-m", "benchmarks.guidance_speed", "--one"]
    runs = []
    for _ in range(options.rounds):
        done = subprocess.run(
            [*command, "--level", str(options.level)],
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=True,
        )
        runs.append(json.loads(done.stdout))
    text = page(runs, where)
    return publish(text, options.out)


if __name__ == "__main__":
    raise SystemExit(main())
