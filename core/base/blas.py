"""The linear algebra under NumPy and SciPy in one thread.

OpenBLAS divides sums among as many threads as the machine has processors: the last bits of a dot
product, and of the factors of a sparse matrix, hang on their number, and where a decision is a
close one so do the quads. SuperLU, which calls it for thousands of small blocks, is no faster for
it either: the threads wait for each other, the longer the more else the machine does.
"""

from __future__ import annotations

import ctypes
import importlib
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

# Compiled modules that call it, of each library their package comes with.
_CALLERS = ("numpy.linalg._umath_linalg", "scipy.linalg._flapack")
# Its functions end differently with 64-bit integers and begin differently in wheels.
_NAMES = [
    f"{first}openblas_{{}}_num_threads{last}"
    for first in ("", "scipy_")
    for last in ("", "64_")
]


class _Switch:
    """How many are within, and how many threads there were before the first of them."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._inside = 0
        self._before: list[int] = []

    def enter(self) -> None:
        with self._lock:
            if not self._inside:
                self._before = [get() for get, _ in libraries()]
                for _, set_ in libraries():
                    set_(1)
            self._inside += 1

    def leave(self) -> None:
        with self._lock:
            self._inside -= 1
            if not self._inside:
                for (_, set_), count in zip(libraries(), self._before, strict=True):
                    set_(count)


_switch = _Switch()


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Everything within, also a function that this decorates, has OpenBLAS work in one thread;
    after the last that is within at a time as many as before. Other libraries (MKL, Accelerate)
    are left as they are."""
    _switch.enter()
    try:
        yield
    finally:
        _switch.leave()


@cache
def libraries() -> list[tuple[Callable[[], int], Callable[[int], None]]]:
    """How many threads each library uses, and what changes that."""
    found: dict[int | None, tuple[Callable[[], int], Callable[[int], None]]] = {}
    for name in _CALLERS:
        for path in _files(name):
            with suppress(OSError):
                library = ctypes.CDLL(path)
                for words in _NAMES:
                    get = getattr(library, words.format("get"), None)
                    set_ = getattr(library, words.format("set"), None)
                    if get is not None and set_ is not None:
                        found[ctypes.cast(set_, ctypes.c_void_p).value] = get, set_
    return list(found.values())


def _files(name: str) -> list[str]:
    """A compiled module, through which most systems find what it is linked with, and the libraries
    that wheels for Windows have beside the package."""
    try:
        module = importlib.import_module(name)
    except ImportError:
        return []
    files = [str(module.__file__)]
    package = Path(str(importlib.import_module(name.partition(".")[0]).__file__)).parent
    beside = package.with_name(f"{package.name}.libs")
    return files + [str(path) for path in sorted(beside.glob("*openblas*.dll"))]
