"""Leave the user's modes and selection as they were found, and write where was read."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager, nullcontext

import bpy

from ..base.errors import ObjectError

# A scene and one of its view layers, by their names.
Place = tuple[str, str]


def place_of(context: bpy.types.Context) -> Place:
    """The scene and the view layer that are worked in."""
    return context.scene.name_full, context.view_layer.name


@contextmanager
def in_place(context: bpy.types.Context, place: Place) -> Iterator[None]:
    """Work in a scene and view layer that may no longer be those in the window.

    Raises
    ------
    ObjectError
        The scene is gone.
    """
    if place == place_of(context):
        yield
        return
    name, layer = place
    scene = next((one for one in bpy.data.scenes if one.name_full == name), None)
    if scene is None:
        raise ObjectError(f"The scene {name} is no longer there: nothing was written.")
    chosen = scene.view_layers.get(layer) or scene.view_layers[0]
    with context.temp_override(scene=scene, view_layer=chosen):
        yield


@contextmanager
def object_mode(
    context: bpy.types.Context, obj: bpy.types.Object, push: bool = True
) -> Iterator[None]:
    """Take the meshes being edited out of Edit Mode, and put them back afterwards.

    Only in Object Mode can attributes be written without a Python loop, and are modifiers and
    shape keys evaluated as they show there. With `push` the state after the block is pushed as
    an undo step while no mesh is being edited: a step taken in Edit Mode would hold the edited
    mesh only, and undoing it would leave new objects behind.
    """
    if obj.mode != "EDIT":
        yield
        return
    layer = context.view_layer
    active = layer.objects.active
    edited = [other for other in layer.objects if other.mode == "EDIT"]
    selected = [other for other in layer.objects if other.select_get()]
    bpy.ops.object.mode_set(mode="OBJECT")
    try:
        layer.update()
        yield
        if push:
            bpy.ops.ed.undo_push(message="Umbilics")
    finally:
        _select(layer, edited)
        layer.objects.active = active
        bpy.ops.object.mode_set(mode="EDIT")
        _select(layer, selected)


@contextmanager
def objects_mode(context: bpy.types.Context, objects: Iterable[bpy.types.Object]) -> Iterator[None]:
    """As `object_mode`, if one of several objects is in Edit Mode."""
    edited = next((obj for obj in objects if obj.mode == "EDIT"), None)
    with nullcontext() if edited is None else object_mode(context, edited):
        yield


def finished(result: set[str], edited: bool) -> set[str]:
    """What an operator of the window returns after work that may have left Edit Mode.

    `object_mode` has pushed the undo step then. Blender pushes another one for FINISHED, which
    would hold nothing but the edited mesh and cost the user a second undo; for CANCELLED it
    does not.
    """
    return {"CANCELLED"} if edited else result


def _select(layer: bpy.types.ViewLayer, wanted: list[bpy.types.Object]) -> None:
    for other in layer.objects:
        if other.select_get() != (other in wanted):
            other.select_set(other in wanted)
