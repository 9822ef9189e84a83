"""Functions that Blender calls on undo, load and the like, as long as the add-on is on."""

from collections.abc import Callable, Sequence
from typing import Any

import bpy

# Name in `bpy.app.handlers`, and what is called.
Handlers = Sequence[tuple[str, Callable[..., Any]]]


def add(handlers: Handlers) -> None:
    for name, handler in handlers:
        getattr(bpy.app.handlers, name).append(handler)


def remove(handlers: Handlers) -> None:
    for name, handler in handlers:
        getattr(bpy.app.handlers, name).remove(handler)
