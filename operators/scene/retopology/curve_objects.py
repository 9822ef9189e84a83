"""Lines of the guidance as curve objects and as Grease Pencil strokes.

Custom properties of a curve: `umbilics_family` (0 larger, 1 smaller curvature) and
`umbilics_lengths`, a length for each spline; of ridges also `umbilics_kinds` and `umbilics_bends`,
the mean bend in degrees of each.
"""

from __future__ import annotations

import bpy
import numpy as np

from .... import core
from ...mesh.read import MeshArrays
from ..transaction import Transaction
from . import grease_pencil
from .guidance_objects import GUIDES, LAYOUT, LINES, SEPARATRICES, TAG, adopt, replaced

_FAMILY_NAME = ("Larger Curvature", "Smaller Curvature")
_FAMILY_COLOUR = ((1.0, 0.15, 0.08, 1.0), (0.08, 0.35, 1.0, 1.0))
_RIDGE_NAME = ("Ridges", "Ravines")
_RIDGE_COLOUR = ((0.95, 0.55, 0.05, 1.0), (0.05, 0.6, 0.55, 1.0))
_LAYOUT_LOOK = (
    ("Patch Layout", (0.62, 0.1, 0.75, 1.0)),
    ("Patch Layout: Creases and Borders", (0.25, 0.25, 0.25, 1.0)),
)
# Fractions of the mesh's extent.
_LIFT, _BEVEL = 0.0005, 0.0014


def write_lines(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    arrays: MeshArrays,
    lines: core.Lines,
    part: str,
    transaction: Transaction,
) -> None:
    """A curve object of poly splines for each family, in place of the earlier ones."""
    collection = replaced(obj, part, transaction)
    points = _lifted(arrays, lines)
    ridges = lines if isinstance(lines, core.RidgeLines) else None
    for family, name in enumerate(_FAMILY_NAME if ridges is None else _RIDGE_NAME):
        rows = np.flatnonzero(lines.family == family)
        if not len(rows):
            continue
        title = f"{part.capitalize()}: {name}" if ridges is None else name
        colour = (_FAMILY_COLOUR if ridges is None else _RIDGE_COLOUR)[family]
        places = [points[lines.start[row] : lines.start[row + 1]] for row in rows]
        made = _curve(
            title, colour, places, lines.closed[rows], _thickness(arrays, part), transaction
        )
        made["umbilics_family"] = family
        made["umbilics_lengths"] = lines.length[rows].tolist()
        if ridges is not None:
            made["umbilics_kinds"] = ridges.kind[rows].tolist()
            bends = np.add.reduceat(ridges.bend, ridges.start[:-1]) / np.diff(ridges.start)
            made["umbilics_bends"] = bends[rows].tolist()
        collection = adopt(context, obj, made, part, collection, transaction)


def write_layout(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    arrays: MeshArrays,
    layout: core.QuadLayout,
    transaction: Transaction,
) -> None:
    """Curve objects of the lines between the patches, in place of the earlier ones: one of those
    between poles, one of those along creases and borders."""
    collection = replaced(obj, LAYOUT, transaction)
    to_object = np.linalg.inv(arrays.matrix)
    points = layout.position @ to_object[:3, :3].T + to_object[:3, 3]
    for (title, colour), mine in zip(
        _LAYOUT_LOOK, (layout.kind == 0, layout.kind != 0), strict=True
    ):
        rows = np.flatnonzero(mine)
        if not len(rows):
            continue
        places = [points[layout.start[row] : layout.start[row + 1]] for row in rows]
        closed = np.zeros(len(rows), bool)
        made = _curve(title, colour, places, closed, _thickness(arrays, LAYOUT), transaction)
        collection = adopt(context, obj, made, LAYOUT, collection, transaction)


def _curve(
    title: str,
    colour: tuple[float, ...],
    places: list[np.ndarray],
    closed: np.ndarray,
    thickness: float,
    transaction: Transaction,
) -> bpy.types.Object:
    """A curve object of poly splines through places (q, 3), in no collection yet."""
    curve = transaction.made(bpy.data.curves.new(title, "CURVE"))
    curve.dimensions = "3D"
    curve.resolution_u = 1
    curve.bevel_depth = thickness
    curve.bevel_resolution = 1
    for place, is_closed in zip(places, closed, strict=True):
        spline = curve.splines.new("POLY")
        spline.points.add(len(place) - 1)
        co = np.ones((len(place), 4), dtype=np.float32)
        co[:, :3] = place
        spline.points.foreach_set("co", co.ravel())
        spline.use_cyclic_u = bool(is_closed)
    made = transaction.made(bpy.data.objects.new(curve.name, curve))
    curve.materials.append(_coloured(title, colour, transaction))
    made.color = colour
    return made


def _coloured(name: str, colour: tuple[float, ...], transaction: Transaction) -> bpy.types.Material:
    """A material of that colour, which Solid view shows as it is set up from the start."""
    material = transaction.made(bpy.data.materials.new(name))
    material.diffuse_color = colour
    material[TAG] = True
    return material


def write_guides(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    arrays: MeshArrays,
    lines: core.Lines,
    separatrices: core.Lines,
    ridges: core.RidgeLines,
    transaction: Transaction,
) -> None:
    """Lines, separatrices and ridges as Grease Pencil strokes, in place of the earlier ones."""
    collection = replaced(obj, GUIDES, transaction)
    layers = {}
    for name, some in grease_pencil.layers_of(lines, separatrices, ridges).items():
        part = LINES if name in grease_pencil.FAMILIES else SEPARATRICES
        layers[name] = some, _lifted(arrays, some), _thickness(arrays, part)
    frame = min(context.scene.frame_start, context.scene.frame_current)
    made = grease_pencil.make(f"Guides of {obj.name}", layers, frame, transaction)
    adopt(context, obj, made, GUIDES, collection, transaction)


def _lifted(arrays: MeshArrays, lines: core.Lines) -> np.ndarray:
    """(p, 3) points in the object's space, a hair's breadth above the mesh, to be seen on it."""
    extent = float(np.ptp(arrays.vertices, axis=0).max())
    to_object = np.linalg.inv(arrays.matrix)
    lifted = lines.position + _LIFT * extent * lines.normal
    return lifted @ to_object[:3, :3].T + to_object[:3, 3]


def _thickness(arrays: MeshArrays, part: str) -> float:
    """Radius of lines in the object's space."""
    extent = float(np.ptp(arrays.vertices, axis=0).max())
    scale = float(np.cbrt(abs(np.linalg.det(arrays.matrix[:3, :3]))))
    return (1.0 if part == LINES else 1.5) * _BEVEL * extent / scale
