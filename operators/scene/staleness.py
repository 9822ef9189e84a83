"""Whether results still belong to the mesh and the settings, and why not."""

from __future__ import annotations

import bpy
import numpy as np
from bpy.app.handlers import persistent

from ... import core
from ..base import app_handlers
from ..data import properties, record
from ..mesh.fingerprint import mesh_signature
from . import filters
from .display_objects import source_of

# Two transforms give the same curvatures if lengths agree to this part.
_SAME_SCALE = 1e-4

# What is known, by object and stamp, until the object's geometry is touched.
_edited: dict[tuple[str, str], bool] = {}


def reasons(context: bpy.types.Context, obj: bpy.types.Object) -> list[str]:
    """Why the object's results need a new detection, in words; empty if they do not."""
    kept = record.of(obj)
    if kept is None:
        unreadable = "The results are of another version of this add-on."
        return [unreadable] if obj.umbilics.detected else []
    found = []
    if is_edited(context, obj):
        found.append("The mesh was edited.")
    if not _same_scale(np.array(obj.matrix_world), kept.matrix):
        found.append("The object was scaled.")
    changed = _changed_settings(context.scene.umbilics, kept)
    source = context.scene.umbilics_display.source
    if obj.umbilics.source and source != obj.umbilics.source:
        changed.append(context.scene.umbilics_display.bl_rna.properties["source"].name)
    if changed:
        found.append(f"Changed since: {', '.join(changed)}.")
    return found


def filters_differ(context: bpy.types.Context, obj: bpy.types.Object) -> bool:
    """Whether the object's results went through other filters than the scene's."""
    used, chosen = filters.used_filters(obj), filters.chosen_filters(context.scene)
    return (used.persistence, used.opening > 0) != (chosen.persistence, chosen.opening > 0)


def _changed_settings(group: bpy.types.PropertyGroup, kept: record.Record) -> list[str]:
    """Labels of the settings that differ from those of the detection."""
    try:
        settings = properties.to_settings(group)
    except core.InvalidSettingsError:
        return []
    changed = []
    for name, option in core.options().items():
        now, then = getattr(settings, name), kept.settings.get(name)
        if name == "opening":
            # Whether it is on is a filter; its strength is part of the detection.
            then = then or core.USUAL_OPENING
            now = now or then
        if name == "persistence" or now == then or not _is_read(name, settings):
            continue
        changed.append(option.label)
    return changed


def _is_read(name: str, settings: core.Settings) -> bool:
    """Whether a setting plays a part beside the others."""
    return {
        "parametrization": settings.method == "S",
        "charts": settings.method == "C",
        "scale": settings.curvature == "jets",
        "scale_unit": settings.curvature == "jets" and settings.scale != core.AUTO,
    }.get(name, True)


def _same_scale(now: np.ndarray, then: np.ndarray) -> bool:
    """Whether two transforms (4, 4) differ by a movement only."""
    metrics = [matrix[:3, :3].T @ matrix[:3, :3] for matrix in (now, then)]
    return bool(
        np.allclose(*metrics, rtol=_SAME_SCALE, atol=_SAME_SCALE * np.abs(metrics[1]).max())
    )


def is_edited(context: bpy.types.Context, obj: bpy.types.Object) -> bool:
    """Whether the mesh is no longer the one that was analysed, as far as is known now."""
    return _is_other(context, obj, obj.umbilics)


def plan_is_edited(context: bpy.types.Context, obj: bpy.types.Object) -> bool:
    """Whether the mesh is no longer the one that poles were planned on, as far as is known."""
    return _is_other(context, obj, obj.umbilics_plan)


def _is_other(context: bpy.types.Context, obj: bpy.types.Object, made) -> bool:
    """Whether the mesh differs from the one that `made` was made of, by its signature."""
    key = obj.name_full, made.stamp
    if key not in _edited:
        if not made.stamp or obj.mode != "OBJECT" or not source_of(obj).visible_get():
            # While the mesh is worked on its arrays are not up to date, and Blender does not
            # evaluate what is hidden; it is looked at after.
            return False
        _edited[key] = _compare(context, obj, made)
    return _edited[key]


def _compare(context: bpy.types.Context, obj: bpy.types.Object, made) -> bool:
    obj = source_of(obj)
    if made.source != "EVALUATED":
        return mesh_signature(obj.data) != made.signature
    evaluated = obj.evaluated_get(context.view_layer.depsgraph)
    # Its data may be what is subdivided while it is drawn.
    try:
        return mesh_signature(evaluated.to_mesh()) != made.signature
    finally:
        evaluated.to_mesh_clear()


@persistent
def _touched(scene, depsgraph):
    if not _edited:
        return
    names = {
        update.id.name_full
        for update in depsgraph.updates
        if update.is_updated_geometry and isinstance(update.id, bpy.types.Object)
    }
    for key in [key for key in _edited if key[0] in names]:
        del _edited[key]


@persistent
def _restored(*_):
    _edited.clear()


_HANDLERS = (
    ("depsgraph_update_post", _touched),
    ("undo_post", _restored),
    ("redo_post", _restored),
    ("load_post", _restored),
)


def register() -> None:
    app_handlers.add(_HANDLERS)


def unregister() -> None:
    app_handlers.remove(_HANDLERS)
    _edited.clear()
