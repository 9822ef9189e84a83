"""Arrays that are used again block after block, instead of new ones for each."""

from __future__ import annotations

import math

import numpy as np


class Workspace:
    """Named float64 buffers. A fresh array of this size costs a page fault every 4 KB, which
    is more than the arithmetic that fills it; a block's arrays are overwritten by the next."""

    def __init__(self) -> None:
        self._buffers: dict[str, np.ndarray] = {}

    def array(self, name: str, *shape: int) -> np.ndarray:
        """An uninitialized array of that shape; the last one of that name is no longer valid."""
        size = math.prod(shape)
        buffer = self._buffers.get(name)
        if buffer is None or buffer.size < size:
            buffer = self._buffers[name] = np.empty(size)
        return buffer[:size].reshape(shape)
