"""How far a batch is: one moving line on a terminal, a line a file in a log."""

from __future__ import annotations

import shutil
import time
from typing import TextIO

from .. import messages


class Display:
    """Tells `stream` about `total` files."""

    def __init__(self, total: int, stream: TextIO) -> None:
        self._total = total
        self._stream = stream
        self._moving = stream.isatty()
        self._started = time.monotonic()
        self._done = 0
        self._failed = 0
        self._drawn = 0.0

    def say(self, text: str) -> None:
        """A line of its own."""
        self._print(("\r\033[K" if self._moving else "") + text + "\n")

    def ended(self, text: str, failed: bool) -> None:
        """A file has ended."""
        self._done += 1
        self._failed += failed
        if failed or not self._moving:
            left = "" if self._moving else f"[{self._done}/{self._total}] "
            self.say(left + text)
        self.tick(now=True)

    def tick(self, now: bool = False) -> None:
        """Draw the moving line again, if it is time to."""
        if not self._moving or (not now and time.monotonic() - self._drawn < 0.5):
            return
        self._drawn = time.monotonic()
        text = progress_line(
            self._done, self._total, self._failed, time.monotonic() - self._started
        )
        self._print("\r\033[K" + text[: shutil.get_terminal_size().columns - 1])

    def close(self) -> None:
        """Leave the moving line."""
        if self._moving:
            self._print("\r\033[K")

    def _print(self, text: str) -> None:
        messages.say(text, self._stream)


def progress_line(done: int, total: int, failed: int, seconds: float) -> str:
    """For example "[####------] 4/10, 1 failed, 2.0 files/s, 3 s left"."""
    share = done / max(total, 1)
    bar = "#" * round(20 * share)
    parts = [f"[{bar:-<20}] {done}/{total}"]
    if failed:
        parts.append(f"{failed} failed")
    if done and seconds > 0:
        rate = done / seconds
        parts.append(f"{rate:.1f} files/s" if rate >= 1 else f"{1 / rate:.1f} s a file")
        parts.append(f"{duration((total - done) / rate)} left")
    return ", ".join(parts)


def duration(seconds: float) -> str:
    """For example "45 s", "12 min", "3 h 20 min"."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 90 else f"{minutes // 60} h {minutes % 60} min"
