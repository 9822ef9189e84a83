"""What the command says while it runs: sentences for people, events for programs.

With `--progress jsonl` every event is one JSON object a line on standard output;
docs/schemas/event.schema.json says what they hold. Blender's own lines stand between them; none of
those begins with a brace.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import time
from typing import Any, TextIO

from ... import core
from .stopping import Stop

# Why a file that was begun is not done.
STOPPED = "stopped before the end."
# Seconds between two events on the progress of one mesh.
_PAUSE = 0.2


def hold_streams() -> None:
    """Have something behind the three standard streams: a file that is opened next would take the
    number of one that is closed, and get what is said. What nobody reads is an error to be heeded,
    not the end of the process, as it is in some builds of Blender."""
    if hasattr(signal, "SIGPIPE"):
        signal.signal(signal.SIGPIPE, signal.SIG_IGN)
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            # Takes the lowest number that is free.
            os.open(os.devnull, os.O_RDWR)


def say(text: str, stream: TextIO | None = None) -> None:
    """Write text to a stream, standard output if it is not said which.

    Nobody may be there to take it, as after `| head`, or the disk is full that it goes to. The work
    goes on then, and no more is said there.
    """
    stream = sys.stdout if stream is None else stream
    text = text.encode("utf-8", "backslashreplace").decode()
    try:
        stream.write(text)
        stream.flush()
    except OSError as error:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)
        if stream is sys.stdout:
            complain(f"standard output takes no more ({error.strerror}); the work goes on.")


def complain(text: str) -> None:
    """One line on standard error, whatever letters are in the text."""
    say(f"umbilics: {' '.join(text.splitlines())}\n", sys.stderr)


def tell(event: str, **facts: object) -> None:
    """Write one event."""
    say(json.dumps({"event": event, **facts}, allow_nan=False) + "\n")


class Watched:
    """A report to hand to `core.Progress`: an event now and then for one mesh. Its share never goes
    back: works that run beside one another, or try again, say less than was said before."""

    def __init__(self, about: dict[str, Any]) -> None:
        self._about = about
        self._told = 0.0
        self._share = 0.0

    def __call__(self, share: float, part: str) -> None:
        now = time.monotonic()
        share = self._share = max(share, self._share)
        if now - self._told >= _PAUSE:
            self._told = now
            tell("progress", **self._about, share=round(share, 4), part=part)


def progress_until(deadline: float | None, stop: Stop, watched: Watched | None) -> core.Progress:
    """Progress that is told as events, and ends the work at a time of the monotonic clock or when
    it is asked to stop."""
    if deadline is None:
        return core.Progress(watched, stop.asked)
    return core.Progress(watched, lambda: stop.asked() or time.monotonic() > deadline)
