"""Whether a mesh is still the one that was read."""

from __future__ import annotations

import zlib

import bpy
import numpy as np

from .fetch import fetch


def mesh_signature(mesh: bpy.types.Mesh) -> str:
    """Differs where vertices or faces differ, of a mesh that is not in Edit Mode.

    The part before the last dash is that of the places, the part behind that of the faces.
    """
    position = mesh.attributes.get("position")
    places = fetch(position.data, "vector", 3, np.float32) if position else np.empty(0)
    # An attribute again: reading loops is much slower.
    corner = mesh.attributes.get(".corner_vert")
    corners = fetch(corner.data, "value", 1, np.int32) if corner else np.empty(0, np.int32)
    faces = f"{len(mesh.vertices)}.{len(mesh.polygons)}.{zlib.crc32(corners):08x}"
    return f"{zlib.crc32(places):08x}-{faces}"
