"""A worker ends when the process that started it ends, however that ends."""

from __future__ import annotations

import os
import signal
import sys
import threading

# <linux/prctl.h>
_SET_PARENT_DEATH_SIGNAL = 1


def end_with_parent() -> None:
    """From now on end at once when the other end of standard input is closed."""
    if sys.platform == "linux":
        _have_the_kernel_end_it()
    threading.Thread(target=_wait_for_the_end, name="umbilics parent", daemon=True).start()


def _wait_for_the_end() -> None:
    while os.read(0, 4096):
        pass
    os._exit(1)


def _have_the_kernel_end_it() -> None:
    """The kernel acts at once, also while native code keeps Python's threads waiting."""
    import ctypes

    ctypes.CDLL(None).prctl(_SET_PARENT_DEATH_SIGNAL, signal.SIGKILL, 0, 0, 0)
