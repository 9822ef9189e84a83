"""What a program took for a mesh."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path


@dataclass(frozen=True)
class Measurement:
    """Seconds of one run, and the memory of its process: after reading the mesh, and at most.

    `stages` are the seconds of its parts, `error` the root mean square angle in degrees between
    its principal directions and the true ones.
    """

    program: str
    seconds: float
    input_mb: float
    peak_mb: float
    stages: dict[str, float] = field(default_factory=dict)
    error: float = float("nan")


def memory_mb(which: str) -> float:
    """Memory of this process, "VmRSS" now or "VmHWM" at most; NaN where there is no /proc."""
    status = Path("/proc/self/status")
    if not status.exists():
        return float("nan")
    lines = dict(line.split(":", 1) for line in status.read_text().splitlines())
    return int(lines[which].split()[0]) / 1024
