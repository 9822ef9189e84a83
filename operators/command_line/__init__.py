"""The command line: `blender -b --command umbilics FILE…`."""

import bpy

from .command import run

_handles = []


def register() -> None:
    _handles.append(bpy.utils.register_cli_command("umbilics", run))


def unregister() -> None:
    while _handles:
        bpy.utils.unregister_cli_command(_handles.pop())
