"""How far a work is, whether to stop it, and how long its stages took.

`Progress` is handed down and divided into nested parts.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TypeVar

from .errors import CancelledError

T = TypeVar("T")


class Progress:
    """A share of the whole work, with a name.

    Parameters
    ----------
    report:
        Called with (fraction of the whole work in 0..1, name of the running part).
        It may be called from worker threads.
    cancelled:
        Asked at every step; once it answers True the work ends with `CancelledError`.
    """

    def __init__(
        self,
        report: Callable[[float, str], None] | None = None,
        cancelled: Callable[[], bool] | None = None,
    ) -> None:
        self._report = report
        self._cancelled = cancelled
        self._start = 0.0
        self._share = 1.0
        self._name = ""

    def part(self, name: str, start: float, end: float) -> Progress:
        """The stretch from `start` to `end` (fractions of this part) as a part of its own."""
        part = Progress(self._report, self._cancelled)
        part._start = self._start + start * self._share
        part._share = (end - start) * self._share
        part._name = name
        part.step(0.0)
        return part

    def quiet(self) -> Progress:
        """This part for work whose length nobody knows: it asks whether to stop, and says
        nothing."""
        return Progress(None, self._cancelled)

    def ask(self) -> None:
        """Raise `CancelledError` if the user wants to stop."""
        if self._cancelled is not None and self._cancelled():
            raise CancelledError("Cancelled.")

    def step(self, fraction: float) -> None:
        """Say how much of this part is done; raises `CancelledError` if the user wants to stop."""
        self.ask()
        if self._report is not None:
            self._report(self._start + min(max(fraction, 0.0), 1.0) * self._share, self._name)

    def track(self, items: Iterable[T], total: int) -> Iterator[T]:
        """Pass `items` on, stepping after each of `total`."""
        for done, item in enumerate(items, start=1):
            yield item
            self.step(done / max(total, 1))


@dataclass(frozen=True)
class Clock:
    """Seconds spent in stages, by name."""

    seconds: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Time what is done within."""
        start = time.perf_counter()
        yield
        self.seconds[name] = time.perf_counter() - start
