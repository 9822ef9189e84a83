"""Draws strokes along fields of directions, from batches kept by the content that they show."""

from __future__ import annotations

import math
import threading
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, field

import bpy
import gpu
import numpy as np

from ...operators.base import caches
from ...operators.data.preferences import Appearance
from ...operators.drawing import strokes
from ...operators.mesh import fingerprint
from ...operators.scene import staleness
from ...operators.scene.view import direction_fields, maps
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

# Reads the arrays that strokes are made of from an object.
_Read = Callable[[bpy.types.Object], tuple[np.ndarray, ...] | None]

_directions: OrderedDict[str, _Directions] = OrderedDict()


@dataclass
class _Directions:
    """Strokes of one field; arranged by a thread, since a million take a second."""

    strokes: strokes.Strokes | None = None
    thread: threading.Thread | None = None
    batches: dict[tuple[object, ...], gpu.types.GPUBatch] = field(default_factory=dict)


def draw(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    camera: Camera,
    program: gpu.types.GPUShader,
) -> None:
    """Draw the strokes that the scene asks for: those of the plan where the object has one that
    fits it, else along the principal directions."""
    display, look = context.scene.umbilics_display, Appearance(context)
    crosses = display.field == "CROSS" and _has_crosses(context, obj)
    kept = _arranged(context, obj, crosses)
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


def _has_crosses(context: bpy.types.Context, obj: bpy.types.Object) -> bool:
    return obj.umbilics_plan.planned and not staleness.plan_is_edited(context, obj)


def _arranged(
    context: bpy.types.Context, obj: bpy.types.Object, crosses: bool
) -> _Directions | None:
    """The strokes of the object's field; the first time a thread begins to arrange them."""
    if obj.mode != "OBJECT" or not (crosses or not staleness.is_edited(context, obj)):
        return None
    read = direction_fields.read_cross if crosses else direction_fields.read_field
    content = content_of(obj, crosses, read)
    kept = _directions.get(content)
    if kept is None:
        arrays = read(obj)
        if arrays is None:
            return None
        kept = _directions[content] = _Directions()
        _arrange(kept, arrays)
        while len(_directions) > _MOST:
            _, oldest = _directions.popitem(last=False)
            if oldest.thread is not None:
                oldest.thread.join()
    _directions.move_to_end(content)
    return kept


def content_of(obj: bpy.types.Object, crosses: bool, read: _Read) -> str:
    """A digest of what is drawn; looked at anew when Blender has said that the object was
    touched, or after a detection, a plan or a stretch of it."""
    stamp = obj.umbilics_plan.stamp if crosses else obj.umbilics.stamp
    metric = fingerprint.metric_of(np.array(obj.matrix_world))
    key = obj.name_full, "strokes", crosses, stamp, metric
    return caches.FINGERPRINTS.of(key, lambda: fingerprint.digest(*(read(obj) or ())))


def _arrange(kept: _Directions, arrays: tuple[np.ndarray, ...]) -> None:
    """In a thread if it takes longer than a blink."""

    def work() -> None:
        kept.strokes = strokes.arranged(*arrays)

    if len(arrays[0]) < _QUICK:
        work()
        return
    kept.thread = threading.Thread(target=work, name="umbilics strokes")
    kept.thread.start()


def forget() -> None:
    """Let go of everything on the GPU, and of the threads."""
    for kept in _directions.values():
        if kept.thread is not None:
            kept.thread.join()
    _directions.clear()


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
