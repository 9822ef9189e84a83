"""libigl's principal_curvature, from its Python package in an environment of its own."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import venv
from pathlib import Path

import numpy as np

from .measurement import LIMIT, Measurement

PACKAGE = "libigl==2.6.3"
RADIUS = 3

# What the environment's Python runs: mesh in, seconds, memory and directions out.
_SCRIPT = """
import sys, time
import igl, numpy as np
vertices, triangles = (np.load(name) for name in sys.argv[1:3])
def memory(which):
    lines = dict(line.split(":", 1) for line in open("/proc/self/status"))
    return int(lines[which].split()[0]) / 1024
before, seconds = memory("VmRSS"), []
for _ in range(int(sys.argv[5])):
    start = time.perf_counter()
    d1 = igl.principal_curvature(vertices, triangles, int(sys.argv[4]))[0]
    seconds.append(time.perf_counter() - start)
print(before, memory("VmHWM"), *seconds)
np.save(sys.argv[3], d1)
"""


class LibiglError(Exception):
    """libigl cannot be installed or run here; the text says why."""


class Libigl:
    """libigl in a folder that is made once and kept.

    Raises
    ------
    LibiglError
        The package cannot be installed.
    """

    version = PACKAGE.partition("==")[2]

    def __init__(self, cache: Path) -> None:
        folder = cache / f"{PACKAGE}-python{sys.version_info.major}.{sys.version_info.minor}"
        self._python = folder / "bin" / "python"
        if (folder / "ready").exists():
            return
        venv.create(folder, with_pip=True, clear=True, symlinks=True)
        command = [self._python, "-m", "pip", "install", "--quiet", PACKAGE, "numpy"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            raise LibiglError(f"it could not be installed: {done.stderr.strip()[-200:]}")
        (folder / "ready").write_text(json.dumps(PACKAGE))

    def measure(
        self, vertices: np.ndarray, triangles: np.ndarray, rounds: int, limit: float = LIMIT
    ) -> tuple[list[Measurement], np.ndarray]:
        """Curvatures and directions d1 (n, 3); there are no umbilics in libigl."""
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            np.save(folder / "vertices.npy", vertices)
            np.save(folder / "triangles.npy", triangles)
            paths = [folder / f"{array}.npy" for array in ("vertices", "triangles", "d1")]
            command = [self._python, "-c", _SCRIPT, *paths, str(RADIUS), str(rounds)]
            try:
                done = subprocess.run(
                    command, capture_output=True, text=True, check=False, timeout=limit
                )
            except subprocess.TimeoutExpired as error:
                raise LibiglError(f"it took more than {limit:g} s") from error
            if done.returncode:
                raise LibiglError(f"it failed: {done.stderr.strip()[-200:]}")
            before, peak, *seconds = map(float, done.stdout.split())
            program = f"libigl, curvature, radius {RADIUS}"
            return [Measurement(program, seconds, before, peak)], np.load(paths[2])
