"""Seams, sharp edges and creases: marking and unmarking them."""

from __future__ import annotations

import bpy
import numpy as np

from .fetch import fetch

CREASE = "crease"
# Where Blender keeps the creases of edges.
_ATTRIBUTE = "crease_edge"


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


def _creases(mesh: bpy.types.Mesh) -> np.ndarray:
    """(e,) creases of the edges, 0 to 1."""
    found = mesh.attributes.get(_ATTRIBUTE)
    if found is None or (found.domain, found.data_type) != ("EDGE", "FLOAT"):
        return np.zeros(len(mesh.edges), np.float32)
    return fetch(found.data, "value", 1, np.float32)


def _set_creases(mesh: bpy.types.Mesh, values: np.ndarray) -> None:
    found = mesh.attributes.get(_ATTRIBUTE)
    if found is None:
        found = mesh.attributes.new(_ATTRIBUTE, "FLOAT", "EDGE")
    found.data.foreach_set("value", values.astype(np.float32))
