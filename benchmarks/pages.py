"""What the pages that benchmarks write have in common: the machine, and tables."""

from __future__ import annotations

import os
import platform
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
import scipy


def machine() -> str:
    """The processor, how many of it this process may use, and the versions that matter."""
    model = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        names = [line for line in info.read_text().splitlines() if line.startswith("model name")]
        model = names[0].partition(":")[2].strip() if names else model
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return (
        f"{cores} cores of {model}, Python {platform.python_version()}, NumPy {np.__version__}, "
        f"SciPy {scipy.__version__}{_load()}"
    )


def _load() -> str:
    """How busy the machine is with other things: figures from a busy one are not to be quoted."""
    if not hasattr(os, "getloadavg"):
        return ""
    return f"; the load average at the start was {os.getloadavg()[0]:.1f}"


def table(names: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Markdown: a table of cells, without a line break at its end."""
    lines = [names, ["---"] * len(names), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def publish(text: str, out: Path) -> int:
    """Write a page and print it; the exit code of its command."""
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text(text, encoding="utf-8")
    print(text)
    return 0
