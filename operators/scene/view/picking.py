"""Which glyph of the overlay is under the mouse."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import bpy
import numpy as np
from bpy_extras import view3d_utils
from mathutils import Vector

from ...data import record
from ...data.preferences import Appearance
from ...drawing import poles
from .. import filters
from . import facing_shapes

# How far from its place an umbilic's glyph is taken for hit, in its sizes.
_REACH = 1.0
# A surface hides what lies behind it by more than this part of the way to the viewer.
_BEHIND = 2e-3


@dataclass(frozen=True)
class Picked:
    """The glyph under the mouse: of the candidate `row` of an object, or of the pole of a name."""

    obj: bpy.types.Object
    row: int = -1
    pole: str = ""


def pick(context: bpy.types.Context, mouse: tuple[float, float]) -> Picked | None:
    """The nearest glyph at a place of the region, in its pixels, that is not behind a surface."""
    hits = sorted(_under(context, Vector(mouse)), key=lambda hit: hit[0])
    return next((found for _, place, found in hits if not _is_hidden(context, place)), None)


def _under(context: bpy.types.Context, mouse: Vector) -> Iterator[tuple[float, Vector, Picked]]:
    """Glyphs at the mouse, each with its distance in pixels and its place in the world."""
    display, look = context.scene.umbilics_display, Appearance(context)
    region, view = context.region, context.region_data
    if not display.overlay or not context.space_data.overlay.show_overlays:
        return
    matrix = np.array(view.perspective_matrix)
    size = np.array((region.width, region.height))
    for obj in context.visible_objects:
        if obj.type != "MESH" or not obj.visible_in_viewport_get(context.space_data):
            continue
        if display.poles and obj.umbilics_plan.planned:
            names = [one.name for one in facing_shapes.poles_seen(obj)]
            places = [one.matrix_world.translation for one in facing_shapes.poles_seen(obj)]
            for at, far in _near(places, matrix, size, mouse, poles.reach(look.glyph_size)):
                yield far, Vector(places[at]), Picked(obj, pole=names[at])
        kept = record.of(obj) if display.glyphs else None
        if kept is not None:
            rows = filters.shown_rows(obj, context.scene)
            moved = record.movement(obj, kept)
            places = kept.detection.candidates.position[rows] @ moved[:3, :3].T + moved[:3, 3]
            for at, far in _near(places, matrix, size, mouse, _REACH * look.glyph_size):
                yield far, Vector(places[at]), Picked(obj, row=int(rows[at]))


def _near(
    places: np.ndarray | list[Vector],
    matrix: np.ndarray,
    size: np.ndarray,
    mouse: Vector,
    reach: float,
) -> list[tuple[int, float]]:
    """Which of the places (k, 3) are drawn within `reach` pixels of the mouse, and how far."""
    places = np.array(places, float).reshape(-1, 3)
    clip = places @ matrix[:, :3].T + matrix[:, 3]
    depth = clip[:, 3]
    in_front = depth > 1e-9
    seen = 0.5 * (clip[:, :2] / np.where(in_front, depth, 1.0)[:, None] + 1.0) * size
    far = np.hypot(*(seen - np.array(mouse)).T)
    return [(int(at), float(far[at])) for at in np.flatnonzero(in_front & (far <= reach))]


def _is_hidden(context: bpy.types.Context, place: Vector) -> bool:
    """Whether a surface lies between the viewer and a place."""
    shading = context.space_data.shading
    if (shading.type == "WIREFRAME" and shading.show_xray_wireframe) or (
        shading.type == "SOLID" and shading.show_xray
    ):
        return False
    region, view = context.region, context.region_data
    at = view3d_utils.location_3d_to_region_2d(region, view, place)
    if at is None:
        return True
    begin = view3d_utils.region_2d_to_origin_3d(region, view, at)
    way = place - begin
    depsgraph = context.evaluated_depsgraph_get()
    hit, where, *_ = context.scene.ray_cast(
        depsgraph, begin, way.normalized(), distance=way.length * (1.0 - _BEHIND)
    )
    return hit and (where - place).length > _BEHIND * way.length
