"""Who is told when the user changes a property: "filter", "glyphs", "view", "map",
"active" (of the umbilics), "pole" or "mark" (of a check)."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import bpy

_listeners: dict[str, list[Callable[[bpy.types.Context], None]]] = {}


def listen(what: str, listener: Callable[[bpy.types.Context], None]) -> None:
    """Call `listener` after each change of that sort, until `forget`."""
    _listeners.setdefault(what, []).append(listener)


def forget(what: str, listener: Callable[[bpy.types.Context], None]) -> None:
    """No longer call `listener`."""
    _listeners[what].remove(listener)


@contextmanager
def silence(what: str) -> Iterator[None]:
    """Within the block nobody is told: for values that the add-on itself sets."""
    listeners = _listeners.pop(what, [])
    try:
        yield
    finally:
        _listeners[what] = listeners


def notify(what: str, context: bpy.types.Context) -> None:
    """Tell all that listen to that sort of change."""
    for listener in tuple(_listeners.get(what, ())):
        listener(context)
