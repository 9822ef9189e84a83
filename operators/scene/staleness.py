"""Whether results still belong to the mesh and the settings, and why not.

What an object is made of now is looked at when it is asked for, and again after Blender has said
that the object was touched; in between the answer is remembered (`base.caches.FINGERPRINTS`).
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import bpy
import numpy as np
from bpy.app.handlers import persistent

from ... import core
from ..base import app_handlers, caches
from ..data import plans, properties, reading, record, topology
from ..mesh import fingerprint
from ..mesh.fingerprint import Fingerprint
from ..mesh.read import fingerprint_of
from ..mesh.scope import Scope, scope_in_file
from . import filters, homes, targets
from .display_objects import source_of
from .retopology import by_hand, checks

# Two placements are the same to this part of their largest number: single precision's rounding.
_SAME = 1e-5


def reasons(context: bpy.types.Context, obj: bpy.types.Object) -> list[str]:
    """Why the object's results need a new detection, in words; empty if they do not."""
    kept = record.of(obj)
    if kept is None:
        return [record.UNREADABLE] if obj.umbilics.detected else []
    found = [fingerprint.WORDS[part] for part in _changed_parts(context, obj, kept)]
    changed = _changed_settings(context.scene.umbilics, kept)
    made = obj.umbilics
    changed += _changed_reading(context, made.source, scope_in_file(made.scope, made.group))
    if changed:
        labels = ", ".join(changed)
        found.append(f"Changed since: {labels}.")
    return found


def plan_reasons(context: bpy.types.Context, obj: bpy.types.Object) -> list[str]:
    """Why the object's plan needs to be made again, in words; empty if it does not."""
    if not obj.umbilics_plan.planned:
        return []
    made = plans.origin_of(obj)
    if made is None:
        return [plans.UNREADABLE]
    return _plan_reasons(context, obj, made, obj.umbilics_plan.source)


def check_reasons(context: bpy.types.Context, obj: bpy.types.Object) -> list[str]:
    """Why the check of an object's topology needs to be made again, in words; empty if it does
    not. What is not known, while a mesh is worked on or hidden, is no reason."""
    kept = obj.umbilics_check
    if not kept.checked:
        return []
    found = ["The mesh was edited since."] if checks.is_old(context, obj) else []
    made, surface = topology.origin_of(kept), targets.named(kept.against)
    if surface is None or not surface.users_scene:
        return [*found, f"{kept.against} was deleted or renamed."]
    if made is None:
        return found
    owner = homes.owner_of(surface)
    own = kept.by_own_plan
    of_surface = _plan_reasons(context, owner, made, kept.source, anew=not own)
    found += [f"{kept.against}: {reason}" for reason in of_surface]
    if own != (topology.own_plan(kept) is not None):
        labels = kept.bl_rna.properties["own_plan"].name
        found.append(f"Changed since: {labels}.")
    if not own and by_hand.digest_of_poles(owner) != kept.steered:
        found.append("Poles were moved, added or deleted by hand.")
    then = np.array(kept.apart)
    if not np.allclose(topology.apart(obj, surface), then, rtol=0.0, atol=_SAME * abs(then).max()):
        found.append("The mesh and the surface were moved apart.")
    return found


def _plan_reasons(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    made: plans.Origin,
    source: str,
    anew: bool = True,
) -> list[str]:
    """Why a plan on an object, made of that, would be another one now; or, if it is not made
    `anew`, what is below it."""
    changed_parts = _changed_plan_parts(context, obj, made, source)
    found = [fingerprint.WORDS[part] for part in changed_parts]
    known = record.of(obj)
    # What is kept of an older detection says nothing of a plan that was made from a new one.
    is_current = known is not None and not _changed_parts(context, obj, known)
    if is_current and filters.kept_digest(obj) != made.kept:
        found.append("Other umbilics are kept.")
    if anew and by_hand.digest_of(context.scene) != made.strokes:
        found.append("The guide strokes are others.")
    changed = plans.changed_settings(context.scene.umbilics_guidance, made) if anew else []
    if not obj.umbilics.detected:
        # Else it is the detection that says what of the object counts.
        changed += _changed_reading(context, source, made.scope)
    if changed:
        labels = ", ".join(changed)
        found.append(f"Changed since: {labels}.")
    return found


def filters_differ(context: bpy.types.Context, obj: bpy.types.Object) -> bool:
    """Whether the object's results went through other filters than the scene's."""
    used, chosen = (
        (one.persistence, one.opening > 0, one.at_most)
        for one in (filters.used_filters(obj), filters.chosen_filters(context.scene))
    )
    return used != chosen


def is_edited(context: bpy.types.Context, obj: bpy.types.Object) -> bool:
    """Whether vertices or faces are no longer those analysed, so that values do not fit them."""
    kept = record.of(obj)
    return kept is not None and _is_edited(_changed_parts(context, obj, kept))


def plan_is_edited(context: bpy.types.Context, obj: bpy.types.Object) -> bool:
    """Whether vertices or faces are no longer those that poles were planned on."""
    made = plans.origin_of(obj)
    source = obj.umbilics_plan.source
    return made is not None and _is_edited(_changed_plan_parts(context, obj, made, source))


def _is_edited(changed: Collection[str]) -> bool:
    return any(part in fingerprint.GEOMETRY for part in changed)


def _changed_reading(context: bpy.types.Context, source: str, scope: Scope) -> list[str]:
    """Labels of what else of the object would be read now."""
    display = context.scene.umbilics_display
    wanted = reading.scope_of(display)
    differs = {
        # Files of earlier versions do not tell.
        "source": bool(source) and source != display.source,
        "scope": bool(source) and (scope.kind, scope.group) != (wanted.kind, wanted.group),
    }
    return [display.bl_rna.properties[name].name for name in differs if differs[name]]


def _changed_settings(group: bpy.types.PropertyGroup, kept: record.Record) -> list[str]:
    """Labels of the settings that differ from those of the detection."""
    try:
        settings = properties.to_settings(group)
    except core.InvalidSettingsError:
        return []
    changed = []
    for name, option in core.options().items():
        now, then = getattr(settings, name), getattr(kept.settings, name)
        if name == "opening":
            # Whether it is on is a filter; its strength is part of the detection.
            then = then or core.USUAL_OPENING
            now = now or then
        if name == "persistence" or now == then or not _is_read(name, settings):
            continue
        changed.append(option.label)
    if settings.curvature == kept.settings.curvature == "given":
        names = zip(
            properties.GIVEN_NAMES,
            properties.given_names(group),
            kept.given_names,
            strict=True,
        )
        changed += [label for label, now, then in names if now != then]
    return changed


def _is_read(name: str, settings: core.Settings) -> bool:
    """Whether a setting plays a part beside the others."""
    return {
        "parametrization": settings.method == "S",
        "charts": settings.unfolds,
        "normal_filter": settings.normal_smoothing > 0,
        "scale": settings.curvature == "jets",
        "scale_unit": settings.curvature == "jets" and settings.scale != core.AUTO,
    }.get(name, True)


def _changed_parts(
    context: bpy.types.Context, obj: bpy.types.Object, kept: record.Record
) -> list[str]:
    """What the detection read and is another now, as far as is known."""
    made = obj.umbilics
    return _changed(
        context,
        obj,
        kept.fingerprint,
        fingerprint.read_by(kept.settings),
        made.source == "EVALUATED",
        scope_in_file(made.scope, made.group),
        kept.given_names,
    )


def _changed_plan_parts(
    context: bpy.types.Context, obj: bpy.types.Object, made: plans.Origin, source: str
) -> list[str]:
    """What a plan, and the detection behind it, read and is another now."""
    parts = fingerprint.read_by(made.detecting)
    if made.settings.align_sharp:
        parts = (*parts, fingerprint.SHARP)
    names, then = made.given_names, made.fingerprint
    is_seen = source == "EVALUATED"
    return _changed(context, obj, then, parts, is_seen, made.scope, names, made.zone)


def _changed(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    then: Fingerprint,
    parts: Collection[str],
    evaluated: bool,
    scope: Scope,
    given_names: tuple[str, ...],
    zone: str = "",
) -> list[str]:
    """Which of the parts that were read then are others now; none where it cannot be known.

    While a mesh is worked on its arrays are not up to date, and Blender does not evaluate what is
    hidden; it is looked at after.
    """
    source = source_of(obj)
    if obj.mode != "OBJECT" or not source.visible_get():
        return []
    wanted = dict.fromkeys(parts)
    # What is visible or selected was an argument of the click: nothing hangs on it any more.
    if scope.kind == "GROUP":
        wanted[fingerprint.SCOPE] = None
    if zone:
        wanted[fingerprint.ZONE] = None
    names = given_names if fingerprint.GIVEN in wanted else ()
    read = fingerprint.UV in wanted, names, scope, zone
    now = caches.FINGERPRINTS.of(
        (source.name_full, evaluated, *read), lambda: _look(context, source, evaluated, *read)
    )
    # A transform is known at once, and changes without the geometry being touched.
    now = Fingerprint(now.digests, fingerprint.metric_of(np.array(source.matrix_world)))
    return then.changed(now, wanted)


def _look(
    context: bpy.types.Context, obj: bpy.types.Object, evaluated: bool, *read: Any
) -> Fingerprint:
    if not evaluated:
        return fingerprint_of(obj, obj.data, *read)
    shown = obj.evaluated_get(context.view_layer.depsgraph)
    # Its data may be what is subdivided while it is drawn.
    try:
        return fingerprint_of(obj, shown.to_mesh(), *read)
    finally:
        shown.to_mesh_clear()


@persistent
def _touched(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    if not len(caches.FINGERPRINTS):
        return
    names = {
        update.id.name_full
        for update in depsgraph.updates
        if update.is_updated_geometry and isinstance(update.id, bpy.types.Object)
    }
    if names:
        caches.FINGERPRINTS.drop(lambda key: isinstance(key, tuple) and key[0] in names)


@persistent
def _restored(*_: object) -> None:
    caches.FINGERPRINTS.clear()


_HANDLERS = (
    ("depsgraph_update_post", _touched),
    # Modifiers and shape keys may be animated.
    ("frame_change_post", _restored),
    ("undo_post", _restored),
    ("redo_post", _restored),
)


def register() -> None:
    app_handlers.add(_HANDLERS)


def unregister() -> None:
    app_handlers.remove(_HANDLERS)
