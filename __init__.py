"""Umbilics: find the umbilical points of a mesh and their kind."""

from . import operators, ui

_PARTS = (operators, ui)


def register() -> None:
    for part in _PARTS:
        part.register()


def unregister() -> None:
    for part in reversed(_PARTS):
        part.unregister()
