"""One file in a Blender process of its own, so that no file can bring down the others."""

from __future__ import annotations

import os
import subprocess
import time
from pathlib import Path

from . import machine
from .plan import Task

# A process that failed with this part of its bound in use has run out of memory: what is asked
# for last may be large, and native code says nothing of it.
_NEARLY_FULL = 0.75


class Worker:
    """A running process; its results lie in a scratch folder until they are complete."""

    def __init__(self, task: Task, command: list[str], scratch: Path, kinds: tuple[str, ...]):
        self.task = task
        self.started = time.monotonic()
        self.peak = 0
        self._bound = self._fullest = 0
        self.timed_out = False
        self._made = {kind: scratch / f"result.{kind}" for kind in kinds}
        self._log = scratch / "log"
        scratch.mkdir(parents=True)
        for kind, path in self._made.items():
            command = [*command, f"--{kind}", str(path)]
        # Ctrl-C is for the batch alone, which then stops its workers.
        apart = {"start_new_session": True} if os.name == "posix" else {}
        with open(self._log, "wb") as log:
            self._process = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=log, stderr=log, **apart
            )

    def limit_memory(self, size: int) -> None:
        """Bound its memory, if the system can."""
        if machine.limit_memory(self._process.pid, size):
            self._bound = size

    def has_ended(self, time_limit: float) -> bool:
        """Look after the process, and end one that takes longer than `time_limit` seconds."""
        peak, data = machine.memory_of(self._process.pid)
        self.peak, self._fullest = max(self.peak, peak), max(self._fullest, data)
        if self._process.poll() is not None:
            return True
        if self.seconds > time_limit:
            self.timed_out = True
            self.stop()
            return True
        return False

    @property
    def seconds(self) -> float:
        return time.monotonic() - self.started

    @property
    def succeeded(self) -> bool:
        return self._process.returncode == 0 and not self.timed_out

    def stop(self) -> None:
        """End the process now."""
        self._process.kill()
        self._process.wait()

    def result(self) -> bytes | None:
        """The JSON report, if there is one."""
        try:
            return self._made["json"].read_bytes()
        except OSError:
            return None

    def why(self) -> str:
        """Why the file failed, from what the process has said."""
        if self.timed_out:
            return f"given up after {self.seconds:.0f} s"
        lines = self._log.read_text("utf-8", errors="replace").splitlines()
        said = [line.removeprefix("umbilics: ") for line in lines if line.startswith("umbilics: ")]
        if said:
            return " ".join(said)
        code = self._process.returncode
        full = self._bound and self._fullest > _NEARLY_FULL * self._bound
        if full or any("MemoryError" in line or "alloc" in line.lower() for line in lines[-20:]):
            return "out of memory: give it more with fewer --jobs"
        end = f"signal {-code}" if code < 0 else f"exit code {code}"
        last = next((line.strip() for line in reversed(lines) if line.strip()), "it said nothing")
        return f"Blender ended with {end} ({last[:200]})"

    def deliver(self, out: Path) -> dict[str, str]:
        """Move what was made to its place, the JSON last; names of the files by kind.

        Each appears whole or not at all, because scratch and place are on one file system.
        """
        delivered = {}
        for kind in sorted(self._made, key=lambda kind: kind == "json"):
            if self._made[kind].exists():
                place = out / f"{self.task.name}.{kind}"
                place.parent.mkdir(parents=True, exist_ok=True)
                os.replace(self._made[kind], place)
                delivered[kind] = place.relative_to(out).as_posix()
        return delivered
