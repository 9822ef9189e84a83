"""The command line: `blender -b --command umbilics FILE…`."""

from typing import Any

import bpy

from .command import run

_handles: list[Any] = []


def register() -> None:
    _handles.append(bpy.utils.register_cli_command("umbilics", run))


def unregister() -> None:
    while _handles:
        bpy.utils.unregister_cli_command(_handles.pop())
