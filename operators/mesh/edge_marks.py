"""Seams, sharp edges and creases: reading, marking and unmarking them."""

from __future__ import annotations

import bpy
import numpy as np

from .fetch import fetch

# Where Blender keeps the marks. Up to Blender 4 the seams' name began with a dot.
_SEAMS, _SHARP, _CREASES = ("uv_seam", ".uv_seam"), ("sharp_edge",), "crease_edge"
EDGE_ATTRIBUTES = (*_SEAMS, *_SHARP, _CREASES)
CREASE = "crease"


def mark_edges(mesh: bpy.types.Mesh, chosen: np.ndarray, mark: str) -> np.ndarray:
    """Mark edges (e,) bool as "seam", "edge_sharp" or "crease"; (e,) bool those that were not
    before. An edge with a crease of its own keeps it."""
    if mark == CREASE:
        before = _creases(mesh)
        fresh = chosen & (before == 0.0)
        _set_creases(mesh, np.where(fresh, 1.0, before))
        return fresh
    before = fetch(mesh.edges, f"use_{mark}", 1, bool)
    mesh.edges.foreach_set(f"use_{mark}", before | chosen)
    return chosen & ~before


def unmark_edges(mesh: bpy.types.Mesh, chosen: np.ndarray, mark: str) -> None:
    """Take a mark from edges (e,) bool."""
    if mark == CREASE:
        before = _creases(mesh)
        # One that was changed since is the user's.
        _set_creases(mesh, np.where(chosen & (before == 1.0), 0.0, before))
        return
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


def _creases(mesh: bpy.types.Mesh) -> np.ndarray:
    """(e,) creases of the edges, 0 to 1."""
    found = mesh.attributes.get(_CREASES)
    if found is None or (found.domain, found.data_type) != ("EDGE", "FLOAT"):
        return np.zeros(len(mesh.edges), np.float32)
    return fetch(found.data, "value", 1, np.float32)


def _set_creases(mesh: bpy.types.Mesh, values: np.ndarray) -> None:
    found = mesh.attributes.get(_CREASES)
    if found is None:
        found = mesh.attributes.new(_CREASES, "FLOAT", "EDGE")
    found.data.foreach_set("value", values.astype(np.float32))
