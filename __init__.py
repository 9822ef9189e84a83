"""Umbilics: find the umbilical points of a mesh and their kind."""

from . import operators, ui

_PARTS = (operators, ui)


def register() -> None:
    """What Blender calls when the extension is enabled."""
    for part in _PARTS:
        part.register()


def unregister() -> None:
    """What Blender calls when it is disabled."""
    for part in reversed(_PARTS):
        part.unregister()
