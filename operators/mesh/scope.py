"""Which faces of a mesh are analysed."""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np

from ..base.errors import ObjectError
from .fetch import fetch

# A vertex belongs to a group above this weight.
_WEIGHT = 0.5


@dataclass(frozen=True)
class Scope:
    """A part of an object.

    Attributes
    ----------
    kind:
        "WHOLE", "VISIBLE" (faces that are not hidden in Edit Mode), "SELECTED" (faces that are
        selected there) or "GROUP".
    group:
        Name of the vertex group of "GROUP": faces all of whose vertices weigh more than a half.
    kept:
        Not what is visible or selected now, but the faces that the object's detection analysed,
        as the mesh with its results remembers them (`KEPT`).
    """

    kind: str = "WHOLE"
    group: str = ""
    kept: bool = False

    @property
    def is_momentary(self) -> bool:
        """Whether it is what the user happens to see or select when the faces are read."""
        return self.kind in ("VISIBLE", "SELECTED")


WHOLE = Scope()
KINDS = ("WHOLE", "VISIBLE", "SELECTED", "GROUP")
# The attribute of faces, 1 inside: a selection is soon another one.
KEPT = "umbilics_scope"


def scope_in_file(kind: str, group: str) -> Scope:
    """The scope of a detection, as a file tells of it; the whole object where it tells of none
    that there is."""
    return Scope(kind, group, kept=True) if kind in KINDS else WHOLE


def faces_in(obj: bpy.types.Object, mesh: bpy.types.Mesh, scope: Scope) -> np.ndarray | None:
    """(p,) bool faces of the mesh in the scope, or None for all.

    `mesh` is the object's own or what modifiers make of it, not in Edit Mode.

    Raises
    ------
    ObjectError
        No face is in the scope; the text says what to do.
    """
    if scope.kind == "WHOLE":
        return None
    remembered = _remembered(obj, mesh) if scope.kept else None
    if remembered is not None:
        found = remembered
        missing = f"None of the faces of {obj.name} that were analysed is left."
    elif scope.kind == "GROUP":
        inside = in_vertex_group(obj, mesh, scope.group)
        if inside is None:
            name = f" {scope.group}" if scope.group else ""
            raise ObjectError(
                f"{obj.name} has no vertex group{name}. Choose another group under Scope, or "
                "Whole Object."
            )
        corners = fetch(mesh.loops, "vertex_index", 1, np.int32)
        starts = fetch(mesh.polygons, "loop_start", 1, np.int32)
        found = np.logical_and.reduceat(inside[corners], starts)
        missing = f"No face of {obj.name} lies in the vertex group {scope.group}."
    elif scope.kind == "SELECTED":
        found = fetch(mesh.polygons, "select", 1, bool) & ~fetch(mesh.polygons, "hide", 1, bool)
        missing = f"No face of {obj.name} is selected. Select faces in Edit Mode."
    else:
        found = ~fetch(mesh.polygons, "hide", 1, bool)
        missing = f"All faces of {obj.name} are hidden. Show some in Edit Mode: Mesh > Show/Hide."
    if not found.any():
        raise ObjectError(f"{missing} Or choose Scope: Whole Object.")
    return found


def _remembered(obj: bpy.types.Object, mesh: bpy.types.Mesh) -> np.ndarray | None:
    """(p,) bool faces of the mesh that the object's detection analysed; None where nothing tells.

    Results on the object's own mesh go with it through edits and modifiers.
    """
    home = obj.umbilics.mesh or mesh
    found = home.attributes.get(KEPT)
    if found is None or len(found.data) != len(mesh.polygons):
        return None
    return fetch(found.data, "value", 1, np.int32) > 0


def in_vertex_group(obj: bpy.types.Object, mesh: bpy.types.Mesh, name: str) -> np.ndarray | None:
    """(n,) bool vertices that weigh more than a half in a group; None without the group."""
    group = obj.vertex_groups.get(name) if name else None
    if group is None:
        return None
    return weights_in(mesh, group.index) > _WEIGHT


def weights_in(mesh: bpy.types.Mesh, group: int) -> np.ndarray:
    """(n,) float32 weights of the vertices in the group of that number, 0 outside it.

    Blender hands weights out one by one only. What it has that copies them all at once (an
    attribute of nodes, the mix of shape keys) takes objects of its own, and those cannot be made
    while a panel asks whether results are out of date.
    """
    weights = np.zeros(len(mesh.vertices), np.float32)
    for row, vertex in enumerate(mesh.vertices):
        for one in vertex.groups:
            if one.group == group:
                weights[row] = one.weight
    return weights
