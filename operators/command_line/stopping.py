"""Ctrl-C, the wish to end and the end of the terminal stop the command in an orderly way."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager

_SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP")


class Stop:
    """Whether the command has been asked to end before it is done."""

    def __init__(self) -> None:
        self._asked = False

    def asked(self) -> bool:
        return self._asked

    @contextmanager
    def heard(self) -> Iterator[None]:
        """Listen to the signals meanwhile. The first asks; one more ends the process at once, as
        work that does not look up cannot be stopped otherwise."""

        def ask(number: int, _: object) -> None:
            self._asked = True
            signal.signal(number, signal.SIG_DFL)

        numbers = [getattr(signal, name) for name in _SIGNALS if hasattr(signal, name)]
        # What was started to be left alone, as by nohup, is left alone.
        numbers = [number for number in numbers if signal.getsignal(number) != signal.SIG_IGN]
        before = {number: signal.signal(number, ask) for number in numbers}
        try:
            yield
        finally:
            for number, handler in before.items():
                signal.signal(number, handler if handler is not None else signal.SIG_DFL)
