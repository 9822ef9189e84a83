"""What a program took for a mesh."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from statistics import median

# Seconds that another program gets for all its rounds on a mesh: around a vertex with thousands of
# neighbours some take hours.
LIMIT = 120

@dataclass(frozen=True)
class Measurement:
    """Seconds of each round in one process, and its memory in MB: after reading the mesh, and
    at most. `stages` are the seconds of the parts of the median round, `processor` the least
    seconds of all its threads together, where that was asked for."""

    program: str
    rounds: list[float]
    input_mb: float
    peak_mb: float
    stages: dict[str, float] = field(default_factory=dict)
    processor: float = float("nan")

    @property
    def seconds(self) -> float:
        """The median of the rounds."""
        return median(self.rounds)


def memory_mb(which: str) -> float:
    """Memory of this process, "VmRSS" now or "VmHWM" at most; NaN where there is no /proc."""
    status = Path("/proc/self/status")
    if not status.exists():
        return float("nan")
    lines = dict(line.split(":", 1) for line in status.read_text().splitlines())
    return int(lines[which].split()[0]) / 1024
