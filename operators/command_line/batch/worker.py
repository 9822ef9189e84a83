"""One file in a Blender process of its own, so that no file can bring down the others."""

from __future__ import annotations

import os
import shutil
import subprocess
import time
from pathlib import Path
from tempfile import TemporaryFile

from ....core.formats.whole import replace
from ..files.guard import shown
from . import machine, summary
from .plan import Task

# As little as a file system gives out at a time, mostly: less may fit where nothing is free.
_BLOCK = 4096
# Name of the results in the scratch folder.
_RESULT = "result"


class DeliveryError(Exception):
    """A result cannot be put into its place; the text says why."""


class Worker:
    """A running process; its results lie in a scratch folder until they are complete."""

    def __init__(
        self,
        task: Task,
        command: list[str],
        arguments: tuple[str, ...],
        scratch: Path,
        places: dict[str, Path],
        guide: tuple[Path, Path] | None = None,
    ) -> None:
        """Start `command` with `arguments` on the task's file.

        `places` are those of the results by kind. `guide` is the folder that the files of the
        guidance go to, and one on the same file system where they are made.
        """
        self.task = task
        # As it is now: what is saved while the process reads it is another file.
        self.source = identity(task.source)
        self.started, self._since = time.monotonic(), time.time_ns()
        self.timed_out = False
        self._places = places
        self._guide = guide
        self._scratch = scratch
        self._log = scratch / "log"
        scratch.mkdir(parents=True)
        command = [*command, *arguments, "--worker"]
        for kind, place in places.items():
            command += [f"--{kind}={scratch / f'{_RESULT}.{kind}'}", f"--final={place}"]
        if guide:
            command += [f"--guide={guide[1]}", f"--final={guide[0]}"]
        # A name may look like an option.
        command += ["--", task.source]
        # Ctrl-C is for the batch alone, which then stops its workers. The end of the pipe tells a
        # worker that the batch has ended, however it did.
        with open(self._log, "wb") as log:
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=log,
                stderr=log,
                start_new_session=os.name == "posix",
            )
        self.memory = machine.Memory(self._process.pid)
        assert self._process.stdin is not None
        self._pipe = self._process.stdin

    def has_ended(self, time_limit: float) -> bool:
        """Look after the process, and end one that takes longer than `time_limit` seconds."""
        self.memory.look()
        if self._process.poll() is not None:
            self._pipe.close()
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
        self._pipe.close()

    def result(self) -> bytes | None:
        """The JSON report, if there is one."""
        try:
            return (self._scratch / f"{_RESULT}.json").read_bytes()
        except OSError:
            return None

    def beside(self) -> dict[str, list[int] | None]:
        """The other files that it has read, each with what tells it from another; nothing does
        if it has changed since the process began."""
        found = {name: identity(name) for name in summary.beside_in(self.result())}
        return {
            name: one if one is None or one[1] < self._since else [] for name, one in found.items()
        }

    def why(self) -> str:
        """Why the file failed, from what the process has said; never empty."""
        if self.timed_out:
            return f"given up after {self.seconds:.0f} s"
        try:
            lines = self._log.read_text("utf-8", errors="replace").split("\n")
        except OSError as error:
            lines = [f"its log cannot be read: {error.strerror}"]
        said = [line.removeprefix("umbilics: ") for line in lines if line.startswith("umbilics: ")]
        said = [line.strip() for line in said if line.strip()]
        if said:
            return self._with_places(" ".join(said))
        reason = self._takes_no_more()
        if reason:
            place = shown(self._places["json"].parent)
            return f"{place}: nothing more can be written there ({reason})"
        code = self._process.returncode
        words = ("memoryerror", "alloc")
        told = any(word in line.lower() for line in lines[-20:] for word in words)
        if told or self.memory.is_spent():
            return self.memory.lack()
        if code == 0:
            return "its report is missing or incomplete, although Blender ended well"
        last = next((line.strip() for line in reversed(lines) if line.strip()), "it said nothing")
        return f"{machine.end_in_words(code)} ({last[:200]})"

    def _takes_no_more(self) -> str:
        """Why the process cannot even have written what it said; empty if it could."""
        try:
            with TemporaryFile(dir=self._scratch) as trial:
                trial.write(bytes(_BLOCK))
        except OSError as error:
            return error.strerror or type(error).__name__
        return ""

    def _with_places(self, text: str) -> str:
        """What a process says of its files, with the places where they would have come to lie."""
        for kind, place in self._places.items():
            text = text.replace(str(self._scratch / f"{_RESULT}.{kind}"), shown(place))
        return text.replace(str(self._guide[1]), shown(self._guide[0])) if self._guide else text

    def makes(self, out: Path) -> dict[str, list[str]]:
        """What has been made: the places of the results by kind, as seen from a folder."""
        made: dict[str, list[str]] = {}
        for kind, _, place in self._moves():
            made.setdefault(kind, []).append(_seen_from(out, place))
        return made

    def deliver(self) -> None:
        """Move what was made to its place, the JSON last, as it says that all is there.

        Each file appears whole or not at all, because scratch and place are on one file system
        and the process itself writes it whole or not at all.

        Raises
        ------
        DeliveryError
            A place is taken by a folder or cannot be written.
        """
        for _, made, place in self._moves():
            try:
                place.parent.mkdir(parents=True, exist_ok=True)
                replace(made, place)
            except OSError as error:
                reason = "it is a folder" if place.is_dir() else error.strerror
                raise DeliveryError(f"{shown(place)}: cannot be written ({reason}).") from error

    def clear(self) -> None:
        """Remove what was not delivered."""
        for folder in (self._scratch, *(self._guide[1:] if self._guide else ())):
            shutil.rmtree(folder, ignore_errors=True)

    def _moves(self) -> list[tuple[str, Path, Path]]:
        """Kind, path and place of everything that was made, the JSON last."""
        moves = []
        if self._guide and self._guide[1].is_dir():
            # A process that was killed leaves what it was writing.
            moves += [
                ("guide", path, self._guide[0] / path.relative_to(self._guide[1]))
                for path in sorted(self._guide[1].rglob("*"))
                if path.is_file() and not path.name.startswith(".umbilics-")
            ]
        for path in sorted(self._scratch.glob(f"{_RESULT}*"), key=lambda p: p.suffix == ".json"):
            place = self._places[path.suffix[1:]]
            # Between name and ending stands the frame, if there are several.
            frame = path.name[len(_RESULT) : -len(path.suffix)]
            place = place.with_name(f"{place.stem}{frame}{place.suffix}")
            moves.append((path.suffix[1:], path, place))
        return moves


def identity(source: str) -> list[int] | None:
    """Size and time of change of a file, None if there is none."""
    try:
        status = Path(source).stat()
    except (OSError, ValueError):
        return None
    return [status.st_size, status.st_mtime_ns]


def _seen_from(folder: Path, path: Path) -> str:
    try:
        return Path(os.path.relpath(path, folder)).as_posix()
    except ValueError:
        # On another drive of Windows.
        return str(path.resolve())
