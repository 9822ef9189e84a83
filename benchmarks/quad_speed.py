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
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import core

from . import ROOT
from .pages import machine, table
from .peers.measurement import memory_mb
from .peers.quad_meshers import PeerError

TITLE = "## Speed"
# Larger surfaces than this are not handed to the other programs, nor are more quads asked of them.
PEERS_UP_TO, PEERS_QUADS = 400_000, 5_000

_TEXT = """{title}

Written by `benchmarks/quads --speed` on {machine}.
The detection is included. Stages are seconds by the clock and depend on
the load; *processor* is what all threads took together. *Memory* is what the process takes at most
less what it takes with the input alone, in MB.
{words}
{table}
"""


@dataclass(frozen=True)
class Asked:
    """A surface and how many quads are asked of it."""

    name: str
    vertices: np.ndarray
    triangles: np.ndarray
    quads: int


def speed_section(asked: list[Asked], peers: dict[str, Callable], words: str) -> str:
    """The table of all that is asked, as a section of the page."""
    where = machine()
    found = []
    for one in asked:
        figures = _measured(one)
        stages = figures.get("stages", {})
        beside = [_of_peer(make, one) for make in peers.values()]
        found.append((one, figures, stages, beside))
        print(one.name, len(one.triangles), one.quads, figures, beside, flush=True)
    columns = list(dict.fromkeys(stage for row in found for stage in row[2]))
    head = ["Surface", "Triangles", "Asked", "Quads", *map(str.capitalize, columns)]
    head += ["Seconds", "Processor", "Memory", *peers]
    rows = []
    for one, figures, stages, beside in found:
        cells = [f"{stages[stage]:.2f}" if stage in stages else "" for stage in columns]
        if "error" in figures:
            last = [figures["error"], "", ""]
        else:
            last = [
                f"{figures['seconds']:.1f}",
                f"{figures['processor']:.1f}",
                f"{figures['peak_mb'] - figures['input_mb']:,.0f}",
            ]
        counts = (len(one.triangles), one.quads, figures.get("quads", 0))
        rows.append([one.name, *(f"{count:,}" for count in counts), *cells, *last, *beside])
    words = words and f"{words}\n"
    return _TEXT.format(title=TITLE, machine=where, words=words, table=table(head, rows))


def with_speed(page: str, section: str) -> str:
    """A page with this section at its end, in place of the one that was there."""
    return f"{page.partition(TITLE)[0].rstrip()}\n\n{section}"


def speed_of(page: str) -> str:
    """The section of a page, nothing where it has none."""
    _, title, after = page.partition(TITLE)
    return title + after


def _of_peer(make: Callable, one: Asked) -> str:
    if len(one.triangles) > PEERS_UP_TO or one.quads > PEERS_QUADS:
        return "not run"
    try:
        return f"{make(one.vertices, one.triangles, one.quads)[2]:.1f}"
    except PeerError as error:
        return str(error)


def _measured(one: Asked) -> dict:
    """Figures of a process of its own; only an error where there is one."""
    with tempfile.TemporaryDirectory() as folder:
        mesh = Path(folder) / "mesh.npz"
        np.savez(mesh, vertices=one.vertices, triangles=one.triangles)
        done = subprocess.run(
            [sys.executable, "-m", "benchmarks.quad_speed", str(mesh), str(one.quads)],
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
