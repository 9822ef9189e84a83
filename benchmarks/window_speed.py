"""How Blender's window keeps up with a large mesh: docs/window_speed.md.

    benchmarks/window_speed [--level N] [--out FILE]

The extension is built and installed apart from the user's settings, in a Blender whose window is on
a virtual screen: everything is drawn by the processor, which is what the ratios are for.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

from . import ROOT
from .pages import machine, publish, table

PAGE = """# Speed of the window

Written by `benchmarks/window_speed` on {machine}.

The mesh is an ellipsoid with a little noise and {triangles:,} triangles, and curvature is fitted
over two rings only, so that {candidates:,} umbilics are there to be filtered. The window is on a
virtual screen, 1600 × 900 pixels, where the processor draws everything: frames are slow with or
without the add-on, and the ratio of the two is what carries over to a graphics card.

## While it detects

Blender's loop is asked every few milliseconds how long it was kept waiting. Only the sidebar and
the status bar are drawn again while it computes; the 3D view is not.

{detections}

## Orbit

Seconds from one turn of the view until the next frame is drawn.

{orbit}

## A drag of the slider

*Strength* is moved in {steps} steps, from {most:,} umbilics to {least:,}. Our own work in a step is
filtering, the list, the empties, and building what the overlay draws. The rest of a frame is
Blender's own drawing.

{drag}

{frames}
"""

_DETECTION = (
    "",
    "whole detection",
    "reading, at the click",
    "longest freeze in between",
    "the final write",
    "draws of the 3D view",
)
_DRAG = ("umbilics shown", "filtering, list, empties", "building the overlay", "own steps a second")
_FRAMES = ("", "frame without overlay", "frame with overlay", "frame rate with / without")
_PLACES = {"away": "mesh out of view", "seen": "mesh in view"}


def page(found: dict, where: str) -> str:
    """The page, from what window_speed_in_blender.py has found on the machine described."""
    drawn = found["seen, overlay"]
    detections, drag = [], []
    for name, label in _PLACES.items():
        run = found[f"detect_{name}"]
        freezes = [f"{run[part]:.2f} s" for part in ("reading", "longest", "writing")]
        detections.append([label, f"{run['seconds']:.1f} s", *freezes, str(run["draws"])])
    # The first step changes nothing yet.
    steps = zip(drawn["shown"], drawn["filtering"], drawn["building"], strict=True)
    for shown, filtering, building in list(steps)[1:]:
        times = [f"{seconds * 1e3:.0f} ms" for seconds in (filtering, building)]
        drag.append([f"{shown:,}", *times, f"{1.0 / (filtering + building):.0f}"])
    return PAGE.format(
        machine=where,
        triangles=found["triangles"],
        candidates=found["candidates"],
        detections=table(_DETECTION, detections),
        orbit=table(_FRAMES, _frames(found, "orbit")),
        drag=table(_DRAG, drag),
        frames=table(_FRAMES, _frames(found, "drag")),
        steps=len(drawn["shown"]),
        most=max(drawn["shown"]),
        least=min(drawn["shown"]),
    )


def _frames(found: dict, kind: str) -> list[list[str]]:
    """Seconds a frame takes, without the overlay and with it."""
    rows = []
    for name, label in _PLACES.items():
        before, after = (found[f"{name}, {what}"][kind] for what in ("no overlay", "overlay"))
        rows.append([label, f"{before:.2f} s", f"{after:.2f} s", f"{before / after:.2f}"])
    return rows


def measure(level: int) -> dict:
    """Build, install and measure."""
    sys.path.insert(0, str(ROOT / "tools"))
    from run_umbilics import set_up

    script = ROOT / "benchmarks" / "window_speed_in_blender.py"
    with set_up("window_speed") as environment, tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.json"
        command = [ROOT / "tools" / "window", "--python", script, "--", str(level), report]
        subprocess.run(command, env=environment, check=True)
        return json.loads(report.read_text())


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="benchmarks/window_speed", description=__doc__)
    parser.add_argument("--level", type=int, default=8, help="20 * 4^level triangles (8)")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "window_speed.md")
    options = parser.parse_args(arguments)
    where = machine()
    text = page(measure(options.level), where)
    return publish(text, options.out)


if __name__ == "__main__":
    raise SystemExit(main())
