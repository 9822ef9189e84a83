"""Draws the results of one object from batches that are kept until what they show changes."""

from __future__ import annotations

import math
import threading
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, field

import bpy
import gpu
import numpy as np

from ...operators.data import record
from ...operators.data.preferences import Appearance
from ...operators.drawing import strokes, umbilics
from ...operators.scene import filters, staleness
from ...operators.scene.view import direction_fields, maps, umbilic_shapes
from . import shader
from .camera import Camera

# Directions of this many objects stay in memory.
_MOST = 8
# Vertices that are arranged while the user waits.
_QUICK = 20000
# Strokes lie flat: they are lifted by this part of their length to clear a curved surface.
_LIFT = 0.1
# Points that tell how far away the visible surface is; the first are the most widely spread.
_SAMPLE = 4000

_directions: OrderedDict[str, _Directions] = OrderedDict()
_umbilics: dict[str, _Umbilics] = {}


@dataclass
class _Directions:
    """Strokes of one field; arranged by a thread, since a million take a second."""

    strokes: strokes.Strokes | None = None
    thread: threading.Thread | None = None
    batches: dict[tuple[object, ...], gpu.types.GPUBatch] = field(default_factory=dict)


@dataclass(frozen=True)
class _Drawn:
    """What is drawn at once."""

    batch: gpu.types.GPUBatch
    on_top: bool = False
    opacity: float = 1.0


@dataclass
class _Umbilics:
    """Glyphs and what goes with them, and the signature of what they were made from.

    A crowd is drawn by choosing among the diamonds of all candidates.
    """

    signature: tuple[object, ...] = ()
    drawn: list[_Drawn] = field(default_factory=list)
    diamonds_signature: tuple[object, ...] = ()
    diamonds: gpu.types.GPUVertBuf | None = None


def draw(context: bpy.types.Context, obj: bpy.types.Object, camera: Camera) -> None:
    """Draw what the scene's choices ask for."""
    display = context.scene.umbilics_display
    program = shader.place(camera, obj.matrix_world)
    if display.directions:
        _draw_directions(context, obj, camera, program)
    depth_test = gpu.state.depth_test_get()
    for drawn in _drawn_umbilics(context, obj, staleness.is_edited(context, obj)):
        gpu.state.depth_test_set("NONE" if drawn.on_top else depth_test)
        program.uniform_float("size", (1.0, camera.pixel, drawn.opacity, 0.0))
        drawn.batch.draw(program)
    gpu.state.depth_test_set(depth_test)


def forget() -> None:
    """Let go of everything on the GPU, and of the threads."""
    for kept in _directions.values():
        if kept.thread is not None:
            kept.thread.join()
    _directions.clear()
    _umbilics.clear()


def is_waiting() -> bool:
    """Whether strokes are arranged that were not drawn yet; `collect` ends the waiting."""
    return any(kept.thread is not None for kept in _directions.values())


def collect() -> bool:
    """Take over what the threads have finished; whether any still work."""
    for kept in _directions.values():
        if kept.thread is not None and not kept.thread.is_alive():
            kept.thread.join()
            kept.thread = None
    return is_waiting()


def _draw_directions(
    context: bpy.types.Context, obj: bpy.types.Object, camera: Camera, program: gpu.types.GPUShader
) -> None:
    display, look = context.scene.umbilics_display, Appearance(context)
    crosses = display.field == "CROSS"
    if crosses and not staleness.plan_is_edited(context, obj):
        kept = _arranged(obj, obj.umbilics_plan.stamp, direction_fields.read_cross)
    elif not crosses and not staleness.is_edited(context, obj):
        kept = _arranged(obj, obj.umbilics.stamp, direction_fields.read_field)
    else:
        return
    if kept is None or kept.strokes is None:
        return
    found = kept.strokes
    if not len(found.blocks):
        return
    scale = max(obj.matrix_world.to_scale(), key=abs)
    scale = abs(scale) or 1.0
    swapped = maps.is_dark(obj)
    spacing = display.density * context.preferences.system.ui_scale
    wanted = spacing * camera.pixel_on(found.places[:_SAMPLE], obj.matrix_world)
    # Layers up to the whole part are drawn, the next one fades in.
    level = math.log2(max(found.cell * scale / wanted, 1e-9))
    last = max(math.ceil(level), 0)
    shown = (found.blocks[:, 2] <= last) & camera.sees(found.sphere, obj.matrix_world)
    for block in shown.nonzero()[0].tolist():
        layer = int(found.blocks[block, 2])
        opacity = min(max(level - layer + 1.0, 0.0), 1.0) if layer else 1.0
        if opacity <= 0.02:
            continue
        program.uniform_float("size", (wanted, camera.pixel, opacity, _LIFT * wanted))
        for second in (False, True)[: 1 + (crosses or display.crosses)]:
            # On a map that is dark the colours change places; the arms of a cross are alike.
            colour = look.stroke_colours[(second and not crosses) != swapped]
            key = block, second, look.stroke_width, colour
            if key not in kept.batches:
                shape = strokes.shape_of(found, block, second, look.stroke_width, colour)
                kept.batches[key] = shader.batch(shape)
            kept.batches[key].draw(program)


def _arranged(
    obj: bpy.types.Object,
    stamp: str,
    read: Callable[[bpy.types.Object], tuple[np.ndarray, ...] | None],
) -> _Directions | None:
    """The strokes of what has the stamp; the first time a thread begins to arrange them."""
    kept = _directions.get(stamp)
    if kept is None:
        arrays = read(obj)
        if arrays is None:
            return None
        kept = _directions[stamp] = _Directions()
        _arrange(kept, arrays)
        while len(_directions) > _MOST:
            _, oldest = _directions.popitem(last=False)
            if oldest.thread is not None:
                oldest.thread.join()
    _directions.move_to_end(stamp)
    return kept


def _arrange(kept: _Directions, arrays: tuple[np.ndarray, ...]) -> None:
    """In a thread if it takes longer than a blink."""

    def work() -> None:
        kept.strokes = strokes.arranged(*arrays)

    if len(arrays[0]) < _QUICK:
        work()
        return
    kept.thread = threading.Thread(target=work, name="umbilics strokes")
    kept.thread.start()


def _drawn_umbilics(context: bpy.types.Context, obj: bpy.types.Object, faint: bool) -> list[_Drawn]:
    """Crowds, discs, rays and glyphs, in the order they are drawn."""
    look, signature = Appearance(context), _signature(context, obj, faint)
    kept = _umbilics.setdefault(obj.name_full, _Umbilics())
    if kept.signature != signature:
        kept.drawn = []
        for rows, opacity in umbilic_shapes.crowds(context, obj, faint):
            if len(rows):
                some = shader.batch_of(_diamonds(kept, obj, look), umbilics.diamonds_of(rows))
                kept.drawn.append(_Drawn(some, opacity=opacity))
        kept.drawn += [
            _Drawn(shader.batch(shape), shape.on_top)
            for shape in umbilic_shapes.shapes_of(context, obj, faint)
            if len(shape.triangles)
        ]
        kept.signature = signature
    return kept.drawn


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


def _diamonds(kept: _Umbilics, obj: bpy.types.Object, look: Appearance) -> gpu.types.GPUVertBuf:
    """The diamonds of all candidates, made anew for each detection and change of its look."""
    signature = obj.umbilics.stamp, look.glyph_size, tuple(look.colours.values())
    found = record.of(obj)
    if found is not None and kept.diamonds_signature != signature:
        kept.diamonds = shader.corners(
            umbilics.diamonds(
                found.detection.candidates, found.kind_codes, np.linalg.inv(found.matrix), look
            )
        )
        kept.diamonds_signature = signature
    return kept.diamonds
