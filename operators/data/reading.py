"""What of an object is analysed: the choices that are made before its mesh is read.

One definition serves the panel, the scripts and the command line, as for the core's settings.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import bpy
from bpy.props import StringProperty

from ... import core
from ..mesh.scope import Scope
from .properties import annotations_of

GROUP_LABEL = "Group"
GROUP_HELP = "Vertex group whose faces are analysed: those all of whose vertices are in it"


@dataclass(frozen=True)
class Reading:
    """Source and scope, each with its `core.Option` as metadata."""

    source: str = core.setting(
        "EVALUATED",
        label="Source",
        kind="choice",
        help="Which form of the mesh is analysed",
        choices=(
            core.Choice(
                "EVALUATED",
                "As Seen",
                "What the view shows: the mesh as modifiers and shape keys make it",
            ),
            core.Choice("BASE", "Base Mesh", "The mesh itself, without modifiers and shape keys"),
        ),
    )
    scope: str = core.setting(
        "WHOLE",
        label="Scope",
        kind="choice",
        help="Which faces are analysed; the others are treated as if they were not there",
        choices=(
            core.Choice("WHOLE", "Whole Object", "All faces"),
            core.Choice("VISIBLE", "Visible Faces", "Faces that are not hidden in Edit Mode"),
            core.Choice("SELECTED", "Selected Faces", "Faces that are selected in Edit Mode"),
            core.Choice("GROUP", "Vertex Group", GROUP_HELP),
        ),
    )

    def __post_init__(self) -> None:
        core.check(self)


def properties() -> dict[str, Any]:
    """The choices as Blender properties."""
    made = annotations_of(Reading)
    made["scope_group"] = StringProperty(name=GROUP_LABEL, description=GROUP_HELP)
    return made


def scope_of(display: bpy.types.PropertyGroup) -> Scope:
    """The scope that a scene's choices ask for."""
    return Scope(display.scope, display.scope_group.strip() if display.scope == "GROUP" else "")
