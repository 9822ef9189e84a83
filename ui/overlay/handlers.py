"""Ties the overlay to Blender's 3D views."""

from __future__ import annotations

from typing import Any

import bpy
import gpu

from ...operators.base import changes
from . import legend, painter, shader
from .camera import Camera

_handles: list[Any] = []
# Seconds between looks at threads that prepare what is to be drawn.
_PATIENCE = 0.1


def draw_results() -> None:
    """Called by Blender for every region of a 3D view."""
    context = bpy.context
    space, region = context.space_data, context.region
    display = context.scene.umbilics_display
    if not display.overlay or not space.overlay.show_overlays:
        return
    objects = [obj for obj in context.visible_objects if is_drawn(obj, space)]
    if not objects:
        return
    camera = Camera.of(region, context.region_data)
    gpu.state.blend_set("ALPHA")
    gpu.state.depth_mask_set(False)
    gpu.state.depth_test_set("NONE" if _sees_through(space.shading) else "LESS_EQUAL")
    try:
        for obj in objects:
            painter.draw(context, obj, camera)
    finally:
        gpu.state.depth_test_set("NONE")
        gpu.state.blend_set("NONE")
    if painter.is_waiting() and not bpy.app.timers.is_registered(_look_again):
        bpy.app.timers.register(_look_again, first_interval=_PATIENCE)


def draw_legend() -> None:
    """Called by Blender for every region of a 3D view, in its pixels."""
    context = bpy.context
    display = context.scene.umbilics_display
    if display.legend and context.space_data.overlay.show_overlays:
        legend.draw(context)


def is_drawn(obj: bpy.types.Object, space: bpy.types.SpaceView3D) -> bool:
    """Whether the object has results to draw in this view, local view included."""
    made = obj.type == "MESH" and (
        obj.umbilics.detected or obj.umbilics_plan.planned or obj.umbilics_check.checked
    )
    return made and obj.visible_in_viewport_get(space)


def redraw(_context: bpy.types.Context | None = None) -> None:
    """Have all 3D views drawn again."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


def _sees_through(shading: bpy.types.View3DShading) -> bool:
    if shading.type == "WIREFRAME":
        return shading.show_xray_wireframe
    return shading.type == "SOLID" and shading.show_xray


def _look_again() -> float | None:
    waiting = painter.collect()
    if not waiting:
        redraw()
    return _PATIENCE if waiting else None


def register() -> None:
    changes.listen("view", redraw)
    for draw, kind in ((draw_results, "POST_VIEW"), (draw_legend, "POST_PIXEL")):
        _handles.append(bpy.types.SpaceView3D.draw_handler_add(draw, (), "WINDOW", kind))


def unregister() -> None:
    for handle in _handles:
        bpy.types.SpaceView3D.draw_handler_remove(handle, "WINDOW")
    _handles.clear()
    changes.forget("view", redraw)
    if bpy.app.timers.is_registered(_look_again):
        bpy.app.timers.unregister(_look_again)
    painter.forget()
    shader.forget()
    redraw()
