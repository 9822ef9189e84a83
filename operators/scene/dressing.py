"""Empties show what they are where the overlay does not, in the whole scene alike."""

from __future__ import annotations

import bpy

from ..base import changes
from . import empties, targets
from .retopology import guidance_objects, pole_shapes


def _glyphs_changed(context: bpy.types.Context) -> None:
    overlaid = pole_shapes.is_overlaid(context)
    for obj in context.scene.objects:
        if obj.type != "MESH" or not targets.is_local(obj):
            continue
        if obj.umbilics.detected:
            empties.dress_all(context, obj)
        if obj.umbilics_plan.planned:
            poles = guidance_objects.parts_of(obj, guidance_objects.POLES)
            pole_shapes.dress_all(poles, overlaid)


def register() -> None:
    changes.listen("glyphs", _glyphs_changed)


def unregister() -> None:
    changes.forget("glyphs", _glyphs_changed)
