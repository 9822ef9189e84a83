"""Lines as Grease Pencil strokes, to draw over: one object, a layer for each family.

Blender 4.3 made Grease Pencil anew; 4.2 keeps strokes as objects of their own. Layers that the
user adds, and what is drawn on them, are never removed.
"""

from __future__ import annotations

import math

import bpy
import numpy as np

from .... import core
from ..transaction import Transaction

SMALLER, LARGER, SEPARATRICES = "Smaller Curvature", "Larger Curvature", "Separatrices"
RIDGES, RAVINES = "Ridges", "Ravines"
FAMILIES = (SMALLER, LARGER)
_COLOUR = {
    SMALLER: (0.1, 0.35, 0.85, 1.0),
    LARGER: (0.85, 0.2, 0.1, 1.0),
    SEPARATRICES: (0.3, 0.05, 0.45, 1.0),
    RIDGES: (0.95, 0.55, 0.05, 1.0),
    RAVINES: (0.05, 0.6, 0.55, 1.0),
}
OBJECT_TYPES = ("GREASEPENCIL", "GPENCIL")
# In 4.2 a width of 2000 is a radius of one unit. Widths are whole and end at 1000; the pressure of
# points makes up the rest.
_OLD_UNIT, _OLD_WIDEST = 2000.0, 1000


def layers_of(
    lines: core.Lines, separatrices: core.Lines, ridges: core.RidgeLines
) -> dict[str, core.Lines]:
    """The lines of each layer, from the lowest layer to the highest; empty ones are left out."""
    layers = {
        SMALLER: lines.select(lines.family == 1),
        LARGER: lines.select(lines.family == 0),
        SEPARATRICES: separatrices,
        RAVINES: ridges.select(ridges.family == 1),
        RIDGES: ridges.select(ridges.family == 0),
    }
    return {name: some for name, some in layers.items() if len(some)}


def make(
    name: str,
    layers: dict[str, tuple[core.Lines, np.ndarray, float]],
    frame: int,
    transaction: Transaction,
) -> bpy.types.Object:
    """A new Grease Pencil object, in no collection yet.

    Parameters
    ----------
    layers:
        For each layer its lines, their points (p, 3) in the object's space, and the radius of
        the strokes.
    frame:
        The keyframe that the strokes are on; they are seen from it onwards.
    """
    # From 4.3 to 4.5 `grease_pencils` are annotations.
    data = getattr(bpy.data, "grease_pencils_v3", bpy.data.grease_pencils).new(name)
    transaction.made(data)
    data.stroke_depth_order = "3D"
    for number, (title, (lines, points, radius)) in enumerate(layers.items()):
        data.materials.append(_material(title, transaction))
        key = data.layers.new(title).frames.new(frame)
        write = _draw if hasattr(key, "drawing") else _draw_old
        write(key, lines, points.astype(np.float32), radius, number)
    return transaction.made(bpy.data.objects.new(name, data))


def is_ours(obj: bpy.types.Object) -> bool:
    """Whether nothing of the user's is on the object: no layer but our own."""
    return all(map(is_our_layer, obj.data.layers))


def is_our_layer(layer: bpy.types.GreasePencilLayer) -> bool:
    """Whether `make` called a layer so."""
    return _title(layer) in _COLOUR


def remove_layers(obj: bpy.types.Object) -> None:
    """Remove our layers from an object on which the user has some too."""
    data = obj.data
    for layer in list(filter(is_our_layer, data.layers)):
        data.layers.remove(layer)


def parts_of(obj: bpy.types.Object) -> list[bpy.types.ID]:
    """The object, with its strokes and materials where nothing else uses them."""
    data = obj.data
    found = [obj, *(one for one in (data,) if one.users == 1)]
    if data.users == 1:
        found += [one for one in data.materials if one is not None and one.users == 1]
    return found


def _title(layer: bpy.types.GreasePencilLayer) -> str:
    return layer.name if hasattr(layer, "name") else layer.info


def _material(title: str, transaction: Transaction) -> bpy.types.Material:
    material = transaction.made(bpy.data.materials.new(title))
    bpy.data.materials.create_gpencil_data(material)
    material.grease_pencil.color = _COLOUR[title]
    return material


def _draw(
    key: bpy.types.GreasePencilFrame,
    lines: core.Lines,
    points: np.ndarray,
    radius: float,
    material: int,
) -> None:
    drawing = key.drawing
    drawing.add_strokes(np.diff(lines.start).tolist())
    values = {
        "radius": ("FLOAT", "POINT", np.full(len(points), radius, np.float32)),
        "opacity": ("FLOAT", "POINT", np.ones(len(points), np.float32)),
        "cyclic": ("BOOLEAN", "CURVE", lines.closed),
        "material_index": ("INT", "CURVE", np.full(len(lines), material, np.int32)),
    }
    for name, (kind, domain, of_it) in values.items():
        attribute = drawing.attributes.get(name) or drawing.attributes.new(name, kind, domain)
        attribute.data.foreach_set("value", of_it)
    drawing.attributes["position"].data.foreach_set("vector", points.ravel())
    drawing.tag_positions_changed()


def _draw_old(
    key: bpy.types.GPencilFrame,
    lines: core.Lines,
    points: np.ndarray,
    radius: float,
    material: int,
) -> None:
    width = min(max(1, math.ceil(radius * _OLD_UNIT)), _OLD_WIDEST)
    for row in range(len(lines)):
        place = points[lines.start[row] : lines.start[row + 1]]
        stroke = key.strokes.new()
        stroke.display_mode = "3DSPACE"
        stroke.line_width = width
        stroke.use_cyclic = bool(lines.closed[row])
        stroke.material_index = material
        stroke.points.add(len(place), pressure=radius * _OLD_UNIT / width)
        stroke.points.foreach_set("co", place.ravel())
        stroke.points.update()
