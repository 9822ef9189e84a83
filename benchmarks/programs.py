"""The programs that `benchmarks.speed` compares: this project's detection and its peers."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from . import ROOT
from .peers.cgal import Cgal, CgalError
from .peers.libigl import Libigl, LibiglError
from .peers.measurement import LIMIT, Measurement

OURS = "Umbilics, the whole detection"
# Rounds of ours at least, of which the first meets memory that is new to the process; others need
# little of it, and differ by a hundredth or so from round to round.
LEAST_ROUNDS = 5


class Ours:
    """This project's `core.detect`."""

    def measure(self, mesh: Path, rounds: int, directions: Path | None = None) -> Measurement:
        command = [sys.executable, "-m", "benchmarks.speed_task", str(mesh), str(rounds)]
        command += [str(directions)] if directions else []
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
        found = json.loads(done.stdout)
        return Measurement(
            OURS,
            found["seconds"],
            found["input_mb"],
            found["peak_mb"],
            found["stages"],
            found["processor"],
        )


def peers(cache: Path) -> tuple[list[Callable], str]:
    """What measures each other program that can be had here, and a word on each."""
    found, words = [], []
    try:
        cgal = Cgal()
        found.append(cgal.measure)
        words.append(
            f"- CGAL {cgal.version}: `Monge_via_jet_fitting` of degree 3, then `compute_umbilics` "
            "with neighbourhood size 2 (`benchmarks/peers/cgal_umbilics.cpp`, -O3)."
        )
    except CgalError as error:
        words.append(f"- CGAL was left out of this run: {error}.")
    try:
        libigl = Libigl(cache)
        found.append(libigl.measure)
        words.append(
            f"- libigl {libigl.version}: `principal_curvature` with radius 3; curvatures only."
        )
    except LibiglError as error:
        words.append(f"- libigl was left out of this run: {error}.")
    return found, "\n".join(words) + "\n"


def measure_all(
    vertices: np.ndarray,
    triangles: np.ndarray,
    others: list[Callable],
    rounds: int,
    limit: float = LIMIT,
) -> tuple[list[tuple[Measurement, np.ndarray]], list[str]]:
    """What each program measures on the mesh, one after the other, and its directions; and a word
    on each of the others that cannot take it within so many seconds."""
    with tempfile.TemporaryDirectory() as name:
        mesh, directions = Path(name) / "mesh.npz", Path(name) / "d1.npy"
        np.savez(mesh, vertices=vertices, triangles=triangles)
        results = [
            (Ours().measure(mesh, max(rounds, LEAST_ROUNDS), directions), np.load(directions))
        ]
    stopped = []
    for measure in others:
        try:
            measured, d1 = measure(vertices, triangles, rounds, limit)
        except (CgalError, LibiglError) as error:
            stopped.append(f"{'CGAL' if isinstance(error, CgalError) else 'libigl'}: {error}")
            print(stopped[-1], file=sys.stderr)
            continue
        results += [(single, d1) for single in measured]
    return results, stopped
