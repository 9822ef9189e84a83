"""What the command says while it runs: sentences for people, events for programs.

With `--progress jsonl` every event is one JSON object a line on standard output;
docs/schemas/event.schema.json says what they hold. Blender's own lines stand between them; none of
those begins with a brace.
"""

from __future__ import annotations

import json
import sys
import time
from typing import Any

from ... import core

# Seconds between two events on the progress of one mesh.
_PAUSE = 0.2


def complain(text: str) -> None:
    """One line on standard error, whatever letters are in the text."""
    line = " ".join(text.split("\n")).encode("utf-8", "backslashreplace").decode()
    print(f"umbilics: {line}", file=sys.stderr, flush=True)


def tell(event: str, **facts: object) -> None:
    """Write one event."""
    sys.stdout.write(json.dumps({"event": event, **facts}, allow_nan=False) + "\n")
    sys.stdout.flush()


class Watched:
    """A report to hand to `core.Progress`: an event now and then for one mesh."""

    def __init__(self, about: dict[str, Any]) -> None:
        self._about = about
        self._told = 0.0

    def __call__(self, share: float, part: str) -> None:
        now = time.monotonic()
        if now - self._told >= _PAUSE:
            self._told = now
            tell("progress", **self._about, share=round(share, 4), part=part)


def progress_until(deadline: float | None, watched: Watched | None) -> core.Progress:
    """Progress that is told as events, and ends the work at a time of the monotonic clock."""
    cancelled = None if deadline is None else lambda: time.monotonic() > deadline
    return core.Progress(watched, cancelled)
