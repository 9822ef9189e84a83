"""What the machine holds: processors and memory."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
from pathlib import Path

# Assumed where the system does not say.
_UNKNOWN_MEMORY = 4 << 30
LACK = "out of memory: give it more with fewer --jobs or a larger --memory-limit"
# Blender itself, before it has read a file.
BLENDER = 500 << 20
# Signals that no fault of a program's own sends: 9 is SIGKILL, which not every system names.
_FROM_OUTSIDE = (9, signal.SIGTERM)
# A process that failed with this part of its bound in use has run out of memory.
_NEARLY_FULL = 0.75


def processors() -> int:
    """Processors that this process may run on."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def free_memory() -> int:
    """Bytes of memory that new processes may use without swapping, about."""
    if sys.platform == "win32":
        return _windows_memory()
    known = [size for size in (_meminfo(), _cgroup_memory()) if size is not None]
    if known:
        return min(known)
    try:
        # macOS does not say simply what is free: half of all is a careful guess.
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") // 2
    except (OSError, ValueError):
        return _UNKNOWN_MEMORY


def memory_of(process: int) -> tuple[int, int]:
    """Bytes that a running process has held at most so far, and those of the data that
    `limit_memory` bounds as they are now; zeros where that is not known."""
    try:
        text = Path(f"/proc/{process}/status").read_text()
    except OSError:
        return 0, 0
    sizes = dict(line.split(":", 1) for line in text.splitlines() if line.startswith("Vm"))
    held, data = (int(sizes.get(name, "0 kB").split()[0]) << 10 for name in ("VmHWM", "VmData"))
    return held, data


def limit_memory(process: int, size: int) -> bool:
    """Bound the data of a process to `size` bytes; says whether the system can (Linux does)."""
    try:
        import resource

        resource.prlimit(process, resource.RLIMIT_DATA, (size, size))
    except (ImportError, AttributeError, OSError, ValueError):
        return False
    return True


class Memory:
    """The memory of a running process, and the bound on it, if it has one."""

    def __init__(self, process: int) -> None:
        self._process = process
        self._bound = self._fullest = 0
        self.peak = 0

    def limit(self, size: int) -> None:
        """Bound it to `size` bytes, if the system can."""
        if limit_memory(self._process, size):
            self._bound = size

    def look(self) -> None:
        """See how much of it is in use."""
        peak, data = memory_of(self._process)
        self.peak, self._fullest = max(self.peak, peak), max(self._fullest, data)

    def is_spent(self) -> bool:
        """Whether a process that ended without a word of its own has run out of it: what is asked
        for last may be large, and native code says nothing of it. With less than Blender alone
        takes, it ends in as many ways as there are systems, mostly too soon for a look at it."""
        full = self._fullest > _NEARLY_FULL * self._bound
        return bool(self._bound) and (full or self._bound < BLENDER)

    def lack(self) -> str:
        """What to say when it is spent."""
        if not self._bound:
            return LACK
        return f"{LACK} (it had {self._bound >> 20} MB; Blender alone takes up to {BLENDER >> 20})"


def end_in_words(code: int) -> str:
    """How Blender ended, from what `subprocess` says of it, and what that may come from."""
    words = f"Blender ended with {'signal' if code < 0 else 'exit code'} {abs(code)}"
    if -code in _FROM_OUTSIDE:
        return f"{words}: something else ended it, as a system does that runs out of memory"
    return f"{words}: the file may be damaged"


def _meminfo() -> int | None:
    try:
        text = Path("/proc/meminfo").read_text()
    except OSError:
        return None
    for line in text.splitlines():
        if line.startswith("MemAvailable:"):
            return int(line.split()[1]) << 10
    return None


def _cgroup_memory() -> int | None:
    """What a container's bound leaves (control groups, version 2)."""
    folder = Path("/sys/fs/cgroup")
    try:
        bound = (folder / "memory.max").read_text().strip()
        used = (folder / "memory.current").read_text().strip()
        return None if bound == "max" else max(int(bound) - int(used), 0)
    except (OSError, ValueError):
        return None


if sys.platform == "win32":

    def _windows_memory() -> int:
        class Status(ctypes.Structure):
            _fields_ = [
                ("size", ctypes.c_ulong),
                ("load", ctypes.c_ulong),
                *(
                    (name, ctypes.c_ulonglong)
                    for name in ("total", "free", "a", "b", "c", "d", "e")
                ),
            ]

        status = Status()
        status.size = ctypes.sizeof(status)
        if not ctypes.windll.kernel32.GlobalMemoryStatusEx(ctypes.byref(status)):
            return _UNKNOWN_MEMORY
        return status.free
