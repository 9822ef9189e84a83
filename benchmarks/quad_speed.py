"""How long remeshing to quads takes and how much memory, stage by stage.

    python -m benchmarks.quad_speed MESH.npz QUADS

remeshes in a process of its own, so that its memory is its own, and prints the figures as JSON.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import core

from . import ROOT
from .pages import machine, table
from .peers.measurement import memory_mb
from .peers.quad_meshers import PeerError

TITLE = "## Speed"
# Larger surfaces than this are not handed to the other programs.
PEERS_UP_TO = 400_000

_TEXT = """{title}

Written by `benchmarks/quads --speed` on {machine}.
{quads:,} quads asked for, the detection included. Stages are seconds by the clock and depend on
the load; *processor* is what all threads took together. *Memory* is what the process takes at most
less what it takes with the input alone, in MB.
{words}
{table}
"""


def speed_section(
    surfaces: list[tuple[str, np.ndarray, np.ndarray]],
    peers: dict[str, Callable],
    quads: int,
    words: str,
) -> str:
    """The table of all surfaces, name, vertices and triangles of each, as a section of the page."""
    where = machine()
    found = []
    for name, vertices, triangles in surfaces:
        figures = _measured(vertices, triangles, quads)
        stages = figures.get("stages", {})
        beside = [_of_peer(make, vertices, triangles, quads) for make in peers.values()]
        found.append((name, f"{len(triangles):,}", figures, stages, beside))
        print(name, len(triangles), figures, beside, flush=True)
    columns = list(dict.fromkeys(stage for row in found for stage in row[3]))
    head = ["Surface", "Triangles", "Quads", *map(str.capitalize, columns)]
    head += ["Seconds", "Processor", "Memory", *peers]
    rows = []
    for name, count, figures, stages, beside in found:
        cells = [f"{stages[stage]:.2f}" if stage in stages else "" for stage in columns]
        if "error" in figures:
            last = [figures["error"], "", ""]
        else:
            last = [
                f"{figures['seconds']:.1f}",
                f"{figures['processor']:.1f}",
                f"{figures['peak_mb'] - figures['input_mb']:,.0f}",
            ]
        rows.append([name, count, f"{figures.get('quads', 0):,}", *cells, *last, *beside])
    words = words and f"{words}\n"
    made = table(head, rows)
    return _TEXT.format(title=TITLE, machine=where, quads=quads, words=words, table=made)


def with_speed(page: str, section: str) -> str:
    """A page with this section at its end, in place of the one that was there."""
    return f"{page.partition(TITLE)[0].rstrip()}\n\n{section}"


def speed_of(page: str) -> str:
    """The section of a page, nothing where it has none."""
    _, title, after = page.partition(TITLE)
    return title + after


def _of_peer(make: Callable, vertices: np.ndarray, triangles: np.ndarray, quads: int) -> str:
    if len(triangles) > PEERS_UP_TO:
        return "not run"
    try:
        return f"{make(vertices, triangles, quads)[2]:.1f}"
    except PeerError as error:
        return str(error)


def _measured(vertices: np.ndarray, triangles: np.ndarray, quads: int) -> dict:
    """Figures of a process of its own; only an error where there is one."""
    with tempfile.TemporaryDirectory() as folder:
        mesh = Path(folder) / "mesh.npz"
        np.savez(mesh, vertices=vertices, triangles=triangles)
        done = subprocess.run(
            [sys.executable, "-m", "benchmarks.quad_speed", str(mesh), str(quads)],
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=False,
        )
    if done.returncode:
        return {"error": done.stderr.strip().splitlines()[-1]}
    return json.loads(done.stdout)


def main(mesh: str, quads: str) -> None:
    with np.load(mesh) as file:
        vertices, triangles = file["vertices"], file["triangles"]
    before = memory_mb("VmRSS")
    clock, processor = time.perf_counter(), time.process_time()
    made = core.remesh(vertices, triangles, core.RemeshSettings(quads=int(quads)))
    figures = {
        "seconds": time.perf_counter() - clock,
        "processor": time.process_time() - processor,
        "stages": made.timings,
        "input_mb": before,
        "peak_mb": memory_mb("VmHWM"),
        "quads": len(made.quads),
    }
    print(json.dumps(figures))


if __name__ == "__main__":
    main(*sys.argv[1:])
