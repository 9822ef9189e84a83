"""How long the guidance of a large mesh takes beside its detection.

    benchmarks/guidance [LEVEL [ROUNDS]]

The ellipsoid with half axes 3, 2 and 1 as an icosahedron subdivided LEVEL times (8: 1.3 million
triangles). Every round runs in a process of its own; printed are the medians, as Markdown.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from statistics import median

from surfaces import ellipsoid

import core

from . import ROOT
from .speed import machine

AXES = (3.0, 2.0, 1.0)
# Spacing at which both families have some 500 lines together.
SPACING = 0.027


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
    return {"seconds": found, "lines": len(lines), "field": guidance.timings["cross field"]}


def main(level: int = 8, rounds: int = 3) -> None:
    command = [sys.executable, "-m", "benchmarks.guidance_speed", "--one", str(level)]
    runs = []
    for _ in range(rounds):
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
        runs.append(json.loads(done.stdout))
    print(f"{20 * 4**level:,} triangles, {rounds} rounds, {machine()}\n")
    print("| Step | Seconds | Processor seconds | times the detection's |")
    print("|---|---|---|---|")
    whole = median(run["seconds"]["detection"][0] for run in runs)
    for name in runs[0]["seconds"]:
        clock, processor = (median(run["seconds"][name][k] for run in runs) for k in (0, 1))
        label = f"{median(run['lines'] for run in runs):g} {name}" if "lines" in name else name
        print(f"| {label} | {clock:.2f} | {processor:.2f} | {clock / whole:.1f} |")
    field = median(run["field"] / run["seconds"]["detection"][0] for run in runs)
    print(f"\nThe cross field alone takes {field:.1f} times the detection.")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--one"]:
        print(json.dumps(measured(int(sys.argv[2]))))
    else:
        main(*map(int, sys.argv[1:]))
