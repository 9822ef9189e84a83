"""The mesh that modifiers and shape keys make of an object, as Object Mode shows it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import bpy

from ..base.errors import ObjectError


@contextmanager
def evaluated_mesh(
    obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph
) -> Iterator[bpy.types.Mesh]:
    """A temporary copy of the evaluated mesh of an object that is not in Edit Mode.

    Raises
    ------
    ObjectError
        The object is not in the view layer, where alone Blender evaluates objects.
    """
    if not is_in(depsgraph.view_layer, obj):
        raise ObjectError(outside(obj))
    if obj.visible_get(view_layer=depsgraph.view_layer):
        with _taken(obj.evaluated_get(depsgraph)) as mesh:
            yield mesh
        return
    # Blender does not evaluate what is hidden, or leaves it as it last was; a visible twin is.
    twin = obj.copy()
    try:
        depsgraph.scene.collection.objects.link(twin)
        twin.hide_viewport = False
        depsgraph.view_layer.update()
        with _taken(twin.evaluated_get(depsgraph)) as mesh:
            yield mesh
    finally:
        bpy.data.objects.remove(twin)
        depsgraph.view_layer.update()


def is_in(layer: bpy.types.ViewLayer, obj: bpy.types.Object) -> bool:
    """Whether the view layer has the object; names are not enough where files are linked."""
    return layer.objects.get(obj.name) == obj or any(other == obj for other in layer.objects)


def outside(obj: bpy.types.Object) -> str:
    """Why an object that the view layer does not have cannot be analysed as it is seen."""
    return (
        f"{obj.name} is not in this view layer: its collection is excluded, or belongs to another "
        "scene. Include the collection in the Outliner, or choose Source: Base Mesh."
    )


def works_on(obj: bpy.types.Object) -> tuple[str, ...]:
    """What makes the object look other than its own mesh: names of modifiers, shape keys."""
    names = [modifier.name for modifier in obj.modifiers if modifier.show_viewport]
    keys = obj.data.shape_keys
    return (*names, "Shape Keys") if keys is not None and not obj.show_only_shape_key else (*names,)


@contextmanager
def _taken(evaluated: bpy.types.Object) -> Iterator[bpy.types.Mesh]:
    try:
        yield evaluated.to_mesh()
    finally:
        evaluated.to_mesh_clear()
