"""The one room for what is remembered between two clicks: it saves time and decides nothing.

Each cache is bounded, and is emptied with the add-on and when another file is opened. All but one
are found by the *content* that a value was made of, so that none can be out of date: change the
content, and it is another key. The exception is `FINGERPRINTS`, the contents' own keys, by the
object that they were taken of; `scene.staleness` drops those of an object as soon as Blender says
that the object was touched.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import Any

from bpy.app.handlers import persistent

from . import app_handlers


class Cache:
    """At most so many values, those that were asked for last; any thread may ask."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._values: OrderedDict[Hashable, Any] = OrderedDict()
        self._lock = threading.Lock()

    def of(self, key: Hashable, make: Callable[[], Any]) -> Any:
        """The value of a key; made if it is not known, which may take its time."""
        with self._lock:
            if key in self._values:
                self._values.move_to_end(key)
                return self._values[key]
        value = make()
        self.put(key, value)
        return value

    def put(self, key: Hashable, value: Any) -> None:
        with self._lock:
            self._values[key] = value
            self._values.move_to_end(key)
            while len(self._values) > self._most:
                self._values.popitem(last=False)

    def drop(self, is_old: Callable[[Hashable], bool]) -> None:
        """Let go of the values whose keys are old."""
        with self._lock:
            for key in [key for key in self._values if is_old(key)]:
                del self._values[key]

    def clear(self) -> None:
        with self._lock:
            self._values.clear()

    def __len__(self) -> int:
        return len(self._values)


# What `data.record` has read, by the digest of the text in the file.
RECORDS = Cache(64)
# Rows that pass the filters, by the digest of the record and all that the filters read.
ROWS = Cache(16)
# The last detection and the last mesh prepared for guidance, whole, by a digest of all their
# input: one of each, for at a million vertices they are hundreds of megabytes.
DETECTIONS = Cache(1)
GUIDES = Cache(1)
# See above; by the object's full name and what was read of it.
FINGERPRINTS = Cache(64)

_ALL = (RECORDS, ROWS, DETECTIONS, GUIDES, FINGERPRINTS)


@persistent
def _after_load(*_: object) -> None:
    for cache in _ALL:
        cache.clear()


_HANDLERS = (("load_post", _after_load),)


def register() -> None:
    app_handlers.add(_HANDLERS)


def unregister() -> None:
    app_handlers.remove(_HANDLERS)
    _after_load()
