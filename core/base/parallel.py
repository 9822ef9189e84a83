"""Blocks of work in threads: NumPy and SciPy release the interpreter lock inside them."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from typing import Any

from .progress import Progress

# Whether a thread is one of those that works share: what these ask of more would be in their way.
_busy = threading.local()


def threads() -> int:
    """How many threads to use: the processors that this process may run on."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def run(work: Callable[[int], None], firsts: Sequence[int], progress: Progress) -> None:
    """Call `work` with each of `firsts`; the first error ends the run and is raised here.

    Raises
    ------
    MemoryError
        There is not enough for the threads, which Python would call a `RuntimeError`.
    """
    if len(firsts) == 1 or getattr(_busy, "thread", False):
        # Of many small tasks in turn most of the time would go into threads that begin and end.
        for first in progress.track(firsts, 1):
            work(first)
        return
    with ThreadPoolExecutor(threads()) as pool:
        try:
            tasks = [pool.submit(work, first) for first in firsts]
        except RuntimeError as error:
            raise MemoryError("There is no memory for another thread.") from error
        try:
            for task in progress.track(as_completed(tasks), len(tasks)):
                task.result()
        except BaseException:
            pool.shutdown(wait=True, cancel_futures=True)
            raise


def at_once(*works: Callable[[], Any]) -> list[Any]:
    """What works, two at least, that ask nothing of each other give, each done in a thread."""
    results: list[Any] = [None] * len(works)

    def one(number: int) -> None:
        _busy.thread = True
        results[number] = works[number]()

    run(one, range(len(works)), Progress())
    return results
