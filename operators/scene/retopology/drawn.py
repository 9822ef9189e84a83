"""Guide strokes as the user drew them: curve objects, and layers of Grease Pencil."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import bpy
import numpy as np

from ...mesh.fetch import fetch
from . import grease_pencil

# Marks objects that guidance made; on these, layers of ours are no strokes of the user's.
_OURS = "umbilics_guidance"


def polylines(obj: bpy.types.Object, scene: bpy.types.Scene) -> list[np.ndarray]:
    """(q, 3) points in the world of every stroke with two points or more, at the scene's frame;
    the last point of a closed one is its first.

    Curves are taken without their thickness and modifiers, Grease Pencil without hidden layers
    and without the layers that Draw Guides made.
    """
    if obj.type == "CURVE":
        return _moved(_chains_of(obj.data), np.array(obj.matrix_world))
    found = []
    for layer in _layers(obj):
        matrix = _matrix(obj, layer)
        found += _moved(_strokes_on(layer, scene.frame_current), matrix)
    return found


def raw_parts(obj: bpy.types.Object, scene: bpy.types.Scene) -> list[np.ndarray]:
    """Arrays that are others whenever `polylines` would be; cheap, and nothing is evaluated."""
    parts = [np.array(obj.matrix_world)]
    if obj.type == "CURVE":
        data = obj.data
        parts.append(np.array([data.resolution_u]))
        for spline in data.splines:
            kind = [ord(letter) for letter in spline.type]
            about = [spline.use_cyclic_u, spline.use_endpoint_u, spline.order_u]
            parts.append(np.array([*kind, *about, spline.resolution_u]))
            if spline.type == "BEZIER":
                for key in ("co", "handle_left", "handle_right"):
                    parts.append(fetch(spline.bezier_points, key, 3, np.float32))
            else:
                parts.append(fetch(spline.points, "co", 4, np.float32))
        return parts
    for layer in _layers(obj):
        parts.append(_matrix(obj, layer))
        parts += _strokes_on(layer, scene.frame_current)
    return parts


def _moved(lines: list[np.ndarray], matrix: np.ndarray) -> list[np.ndarray]:
    return [line @ matrix[:3, :3].T + matrix[:3, 3] for line in lines if len(line) > 1]


def _chains_of(data: bpy.types.Curve) -> list[np.ndarray]:
    """Points along the splines, as Blender draws them."""
    bare = data.copy()
    bare.bevel_depth = bare.extrude = bare.offset = 0.0
    bare.bevel_mode, bare.bevel_object, bare.taper_object = "ROUND", None, None
    bare.bevel_factor_start, bare.bevel_factor_end = 0.0, 1.0
    # Flat curves would be filled.
    bare.dimensions = "3D"
    carrier = bpy.data.objects.new("umbilics strokes", bare)
    try:
        mesh = carrier.to_mesh()
        points = fetch(mesh.vertices, "co", 3, np.float32).astype(float)
        edges = fetch(mesh.edges, "vertices", 2, np.int32)
        carrier.to_mesh_clear()
    finally:
        bpy.data.objects.remove(carrier)
        bpy.data.curves.remove(bare)
    # The points of a spline follow each other, and an edge back closes it.
    on = np.zeros(len(points) + 1, bool)
    low, high = edges.min(axis=1), edges.max(axis=1)
    on[high[high == low + 1]] = True
    begin = np.flatnonzero(~on[:-1])
    end = np.append(begin[1:], len(points))
    back = {(int(a), int(b)) for a, b in zip(low, high, strict=True) if b > a + 1}
    lines = []
    for first, last in zip(begin.tolist(), end.tolist(), strict=True):
        line = points[first:last]
        lines.append(np.vstack([line, line[:1]]) if (first, last - 1) in back else line)
    return lines


def _layers(obj: bpy.types.Object) -> list[Any]:
    """The layers that are seen and are the user's."""
    ours = _OURS in obj
    return [
        layer
        for layer in obj.data.layers
        if not layer.hide and not (ours and grease_pencil.is_our_layer(layer))
    ]


def _matrix(obj: bpy.types.Object, layer: Any) -> np.ndarray:
    """(4, 4) from a layer's space to the world."""
    own = layer.matrix_layer if hasattr(layer, "matrix_layer") else layer.matrix_local
    parent = layer.parent
    if parent is None:
        return np.array(obj.matrix_world @ own)
    inverse = (
        layer.matrix_inverse if hasattr(layer, "matrix_inverse") else layer.matrix_parent_inverse
    )
    return np.array(parent.matrix_world @ inverse @ own)


def _strokes_on(layer: Any, frame: int) -> list[np.ndarray]:
    """Points of the strokes of a layer at a frame, in the layer's space."""
    if hasattr(layer, "get_frame_at"):
        key = layer.get_frame_at(frame)
        if key is None or "position" not in key.drawing.attributes:
            return []
        points = fetch(key.drawing.attributes["position"].data, "vector", 3, np.float32)
        starts = fetch(key.drawing.curve_offsets, "value", 1, np.int32)
        closed = [bool(stroke.cyclic) for stroke in key.drawing.strokes]
        lines = [points[a:b].astype(float) for a, b in pairwise(starts)]
    else:
        keys = [key for key in layer.frames if key.frame_number <= frame]
        if not keys:
            return []
        strokes = max(keys, key=lambda key: key.frame_number).strokes
        closed = [bool(stroke.use_cyclic) for stroke in strokes]
        lines = [fetch(stroke.points, "co", 3, np.float32).astype(float) for stroke in strokes]
    return [
        np.vstack([line, line[:1]]) if ring and len(line) else line
        for line, ring in zip(lines, closed, strict=True)
    ]
