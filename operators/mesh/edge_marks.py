"""Seams and sharp edges: reading, marking and unmarking them."""

from __future__ import annotations

import bpy
import numpy as np

from .fetch import fetch

# Where Blender keeps the marks. Up to Blender 4 the seams' name began with a dot.
_SEAMS, _SHARP = ("uv_seam", ".uv_seam"), ("sharp_edge",)
EDGE_ATTRIBUTES = (*_SEAMS, *_SHARP)


def mark_edges(mesh: bpy.types.Mesh, chosen: np.ndarray, mark: str) -> np.ndarray:
    """Mark edges (e,) bool as "seam" or "edge_sharp"; (e,) bool those that were not before."""
    before = fetch(mesh.edges, f"use_{mark}", 1, bool)
    mesh.edges.foreach_set(f"use_{mark}", before | chosen)
    return chosen & ~before


def unmark_edges(mesh: bpy.types.Mesh, chosen: np.ndarray, mark: str) -> None:
    """Take a mark from edges (e,) bool."""
    before = fetch(mesh.edges, f"use_{mark}", 1, bool)
    mesh.edges.foreach_set(f"use_{mark}", before & ~chosen)


def marked_edges(mesh: bpy.types.Mesh) -> tuple[np.ndarray, np.ndarray]:
    """(s, 2) int32 vertices of the edges marked as seams, and of those marked sharp."""
    return _edges_with(mesh, _SEAMS), _edges_with(mesh, _SHARP)


def _edges_with(mesh: bpy.types.Mesh, names: tuple[str, ...]) -> np.ndarray:
    """(s, 2) vertices of the edges at which the attribute is true that has one of these names."""
    found = next((mesh.attributes[name] for name in names if name in mesh.attributes), None)
    if found is None:
        return np.empty((0, 2), dtype=np.int32)
    edges = np.flatnonzero(fetch(found.data, "value", 1, bool))
    if not len(edges):
        return np.empty((0, 2), dtype=np.int32)
    return fetch(mesh.edges, "vertices", 2, np.int32)[edges]
