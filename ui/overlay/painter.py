"""Draws the results of one object from batches that are kept by the content that they show."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import Any

import bpy
import gpu
import numpy as np

from ...operators.data import record
from ...operators.data.preferences import Appearance
from ...operators.drawing import poles, umbilics
from ...operators.drawing.shapes import Shape
from ...operators.scene import filters, staleness
from ...operators.scene.view import facing_shapes, umbilic_shapes
from . import directions, shader
from .camera import Camera

# So many objects' marks stay on the GPU; the diamonds of a crowd are larger.
_MOST, _MOST_CROWDS = 64, 8
# Glyphs that lie on one another are drawn at no less than this part of their size, at which their
# numbers can just be read.
_SMALLEST = 0.6


@dataclass(frozen=True)
class _Drawn:
    """What is drawn at once."""

    batch: gpu.types.GPUBatch
    on_top: bool = False
    opacity: float = 1.0


class _Kept:
    """At most so many values, those that were drawn last, by all that they were made of."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._values: OrderedDict[Hashable, Any] = OrderedDict()

    def of(self, content: Hashable, make: Callable[[], Any]) -> Any:
        if content not in self._values:
            self._values[content] = make()
        self._values.move_to_end(content)
        while len(self._values) > self._most:
            self._values.popitem(last=False)
        return self._values[content]

    def clear(self) -> None:
        self._values.clear()


_marks, _crowds, _gaps = _Kept(_MOST), _Kept(_MOST_CROWDS), _Kept(_MOST)


def draw(context: bpy.types.Context, obj: bpy.types.Object, camera: Camera) -> None:
    """Draw what the scene's choices ask for."""
    display = context.scene.umbilics_display
    program = shader.place(camera, obj.matrix_world)
    if display.directions:
        directions.draw(context, obj, camera, program)
    depth_test = gpu.state.depth_test_get()
    for drawn in _drawn_umbilics(context, obj, staleness.is_edited(context, obj)):
        gpu.state.depth_test_set("NONE" if drawn.on_top else depth_test)
        program.uniform_float("size", (1.0, camera.pixel, drawn.opacity, 0.0))
        drawn.batch.draw(program)
    gpu.state.depth_test_set(depth_test)
    _draw_facing(context, obj, camera, program)


def forget() -> None:
    """Let go of everything on the GPU, and of the threads."""
    directions.forget()
    _marks.clear()
    _crowds.clear()
    _gaps.clear()


def is_waiting() -> bool:
    """Whether something is prepared that was not drawn yet; `collect` ends the waiting."""
    return directions.is_waiting()


def collect() -> bool:
    """Take over what the threads have finished; whether any still work."""
    return directions.collect()


def _drawn_umbilics(context: bpy.types.Context, obj: bpy.types.Object, faint: bool) -> list[_Drawn]:
    """Crowds, discs, rays and glyphs, in the order they are drawn."""

    def make() -> list[_Drawn]:
        drawn = []
        for rows, opacity in umbilic_shapes.crowds(context, obj, faint):
            if len(rows):
                diamonds = _diamonds(obj, Appearance(context))
                some = shader.batch_of(diamonds, umbilics.diamonds_of(rows))
                drawn.append(_Drawn(some, opacity=opacity))
        return drawn + _batches(umbilic_shapes.shapes_of(context, obj, faint))

    return _marks.of(_signature(context, obj, faint), make)


def _signature(
    context: bpy.types.Context, obj: bpy.types.Object, faint: bool
) -> tuple[object, ...]:
    """All that the drawing of the umbilics hangs on."""
    display, look = context.scene.umbilics_display, Appearance(context)
    mine = obj.umbilics
    # The empties say by their number and visibility which glyphs they take over.
    visible = umbilic_shapes.shown_by_empties(obj).tobytes() if display.glyphs else b""
    return (
        mine.stamp,
        filters.shown_rows(obj, context.scene).tobytes(),
        filters.left_out_rows(obj, context.scene).tobytes() if display.dropped else b"",
        mine.active_row,
        faint,
        visible,
        (display.glyphs, display.rays, display.discs, display.dropped),
        (look.glyph_size, look.stroke_width, tuple(look.colours.values())),
    )


def _diamonds(obj: bpy.types.Object, look: Appearance) -> gpu.types.GPUVertBuf:
    """The diamonds of all candidates of a detection."""

    def make() -> gpu.types.GPUVertBuf:
        found = record.of(obj)
        assert found is not None, "only what has a record has a crowd"
        back = np.linalg.inv(found.matrix)
        candidates = found.detection.candidates
        return shader.corners(umbilics.diamonds(candidates, found.kind_codes, back, look))

    return _crowds.of((obj.umbilics.stamp, look.glyph_size, tuple(look.colours.values())), make)


def _draw_facing(
    context: bpy.types.Context, obj: bpy.types.Object, camera: Camera, program: gpu.types.GPUShader
) -> None:
    """Poles and numbers, which stand upright to the viewer, clear of the surface behind them."""
    display, size = context.scene.umbilics_display, Appearance(context).glyph_size
    back = np.array(obj.matrix_world.inverted_safe())[:3, :3]
    upright = camera.upright @ back.T
    places, valence = facing_shapes.pole_places(obj)
    if display.poles and len(places):
        faint = staleness.plan_is_edited(context, obj)
        key = "poles", places.tobytes(), valence.tobytes(), upright.tobytes(), size, faint
        drawn = _marks.of(
            key, lambda: _batches(facing_shapes.shapes_of_poles(context, obj, upright, faint))
        )
        _draw_with_room(drawn, camera, program, places, obj, size)
    if display.checks and len(obj.umbilics_check.marks):
        _draw_check(context, obj, camera, program, upright, size)
    rows = facing_shapes.numbered_rows(context, obj)
    if len(rows):
        faint = staleness.is_edited(context, obj)
        key = "numbers", obj.umbilics.stamp, rows.tobytes(), upright.tobytes(), size, faint
        drawn = _marks.of(
            key,
            lambda: _batches(facing_shapes.shapes_of_numbers(context, obj, upright, faint)),
        )
        _draw_lifted(drawn, camera, program, size * camera.pixel)


def _draw_check(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    camera: Camera,
    program: gpu.types.GPUShader,
    upright: np.ndarray,
    size: float,
) -> None:
    places, faint = facing_shapes.check_marks(obj)[0], bool(staleness.check_reasons(context, obj))
    kept = obj.umbilics_check
    key = "check", kept.stamp, places.tobytes(), kept.active, upright.tobytes(), size, faint
    drawn = _marks.of(
        key, lambda: _batches(facing_shapes.shapes_of_check(context, obj, upright, faint))
    )
    _draw_with_room(drawn, camera, program, places, obj, size)


def _draw_with_room(
    drawn: list[_Drawn],
    camera: Camera,
    program: gpu.types.GPUShader,
    places: np.ndarray,
    obj: bpy.types.Object,
    size: float,
) -> None:
    """Glyphs like poles at places (k, 3), smaller where most of them would lie on one another."""
    pixel, reach = camera.pixel_on(places, obj.matrix_world), poles.reach(size)
    scale = abs(obj.matrix_world.determinant()) ** (1.0 / 3.0)
    gap = _gaps.of(places.tobytes(), lambda: poles.usual_gap(places))
    room = scale * gap / (2.0 * reach * pixel)
    part = min(max(room, _SMALLEST), 1.0)
    _draw_lifted(drawn, camera, program, part * reach * pixel, part)


def _draw_lifted(
    drawn: list[_Drawn],
    camera: Camera,
    program: gpu.types.GPUShader,
    lift: float,
    part: float = 1.0,
) -> None:
    """`part` of their size."""
    program.uniform_float("size", (1.0, part * camera.pixel, 1.0, lift))
    for some in drawn:
        some.batch.draw(program)


def _batches(shapes: list[Shape]) -> list[_Drawn]:
    return [_Drawn(shader.batch(shape), shape.on_top) for shape in shapes if len(shape.triangles)]
