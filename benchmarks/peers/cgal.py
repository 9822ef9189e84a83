"""CGAL's compute_umbilics and its ridges: builds the drivers beside this file and runs them."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from .measurement import LIMIT, Measurement

UMBILICS, RIDGES = (Path(__file__).with_name(f"cgal_{what}.cpp") for what in ("umbilics", "ridges"))
PACKAGES = "libcgal-dev, libeigen3-dev and a C++ compiler (Debian: g++)"


class CgalError(Exception):
    """CGAL cannot be built or run here; the text says why."""


class Cgal:
    """A driver, built into a temporary folder that goes with the object.

    Parameters
    ----------
    source:
        `UMBILICS` or `RIDGES`.

    Raises
    ------
    CgalError
        There is no compiler or no CGAL, or they do not fit the driver.
    """

    def __init__(self, source: Path = UMBILICS) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="umbilics-cgal-")
        self._source, self._program = source, Path(self._folder.name) / source.stem
        self.version = ""
        self._build()

    def _build(self) -> None:
        compiler = shutil.which("g++") or shutil.which("clang++")
        if compiler is None:
            raise CgalError(f"there is no C++ compiler; it needs {PACKAGES}")
        probe = subprocess.run(
            [compiler, "-x", "c++", "-E", "-P", "-"],
            input="#include <CGAL/version.h>\nversion CGAL_VERSION_STR\n",
            capture_output=True,
            text=True,
            check=False,
        )
        if probe.returncode:
            raise CgalError(f"its headers are not installed; it needs {PACKAGES}")
        self.version = probe.stdout.split("version")[-1].strip().replace('"', "").strip()
        built = subprocess.run(
            [
                *(compiler, "-std=c++17", "-O3", "-DNDEBUG", "-DCGAL_EIGEN3_ENABLED"),
                *("-I/usr/include/eigen3", str(self._source), "-o", str(self._program)),
                *("-lgmp", "-lmpfr"),
            ],
            capture_output=True,
            text=True,
            check=False,
        )
        if built.returncode:
            first = next((line for line in built.stderr.splitlines() if "error" in line), "")
            raise CgalError(f"its driver did not compile ({first.split('error:')[-1].strip()})")

    def umbilics(
        self, vertices: np.ndarray, triangles: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """(k,) vertices and (k,) indices +-0.5 (0 where CGAL calls it non-generic)."""
        found = np.array(self._run(vertices, triangles).split(), dtype=np.int64).reshape(-1, 2)
        return found[:, 0], 0.5 * found[:, 1]

    def ridges(self, vertices: np.ndarray, triangles: np.ndarray) -> list[np.ndarray]:
        """(q, 3) points of each crest line; the driver must be `RIDGES`."""
        rows = np.array(self._run(vertices, triangles).split(), float).reshape(-1, 4)
        if not len(rows):
            return []
        return np.split(rows[:, 1:], np.flatnonzero(np.diff(rows[:, 0])) + 1)

    def measure(
        self, vertices: np.ndarray, triangles: np.ndarray, rounds: int, limit: float = LIMIT
    ) -> tuple[list[Measurement], np.ndarray]:
        """Jets, then jets and umbilics together, without the reading; d1 (n, 3)."""
        path = Path(self._folder.name) / "measured"
        self._run(vertices, triangles, path, rounds, limit=limit)
        line, _, directions = path.read_bytes().partition(b"\n")
        *seconds, before, peak = map(float, line.split()[1:])
        jets, umbilics = seconds[::2], seconds[1::2]
        both = [sum(pair) for pair in zip(jets, umbilics, strict=True)]
        memory = {"input_mb": before / 1024, "peak_mb": peak / 1024}
        measured = [
            Measurement("CGAL, jets of degree 3", jets, **memory),
            Measurement("CGAL, jets and umbilics", both, **memory),
        ]
        return measured, np.frombuffer(directions).reshape(-1, 3)

    def _run(
        self,
        vertices: np.ndarray,
        triangles: np.ndarray,
        *arguments: Path | int,
        limit: float = LIMIT,
    ) -> str:
        lines = [f"{len(vertices)} {len(triangles)}"]
        lines += [f"{x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
        lines += [f"{a} {b} {c}" for a, b, c in triangles.tolist()]
        command = [self._program, *map(str, arguments)]
        try:
            run = subprocess.run(
                command,
                input="\n".join(lines),
                capture_output=True,
                text=True,
                check=False,
                timeout=limit,
            )
        except subprocess.TimeoutExpired as error:
            raise CgalError(f"it took more than {limit:g} s") from error
        if run.returncode:
            raise CgalError(f"it failed: {run.stderr.strip()[-200:]}")
        return run.stdout
