"""Blocks of work in threads: NumPy and SciPy release the interpreter lock inside them."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from contextlib import contextmanager
from functools import partial
from typing import Any

from .progress import Progress

# Begins a work beside what follows, and gives what waits for its result.
Begin = Callable[[Callable[[], Any]], Callable[[], Any]]
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
        tasks = [_begun(pool, partial(work, first)) for first in firsts]
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
        results[number] = _alone(works[number])

    run(one, range(len(works)), Progress())
    return results


@contextmanager
def beside() -> Iterator[Begin]:
    """What begins works in threads beside what follows in the block, and returns what waits for
    the result of each; the block ends after them.

    Raises
    ------
    MemoryError
        As for `run`.
    """
    with ThreadPoolExecutor(threads()) as pool:
        yield lambda work: _begun(pool, partial(_alone, work)).result


def _alone(work: Callable[[], Any]) -> Any:
    """What a work gives that asks for no more threads."""
    _busy.thread = True
    return work()


def _begun(pool: ThreadPoolExecutor, work: Callable[[], Any]) -> Future[Any]:
    try:
        return pool.submit(work)
    except RuntimeError as error:
        raise MemoryError("There is no memory for another thread.") from error
