"""Seams and sharp edges: marking and unmarking them."""

from __future__ import annotations

import bpy
import numpy as np

from .fetch import fetch


def mark_edges(mesh: bpy.types.Mesh, chosen: np.ndarray, mark: str) -> np.ndarray:
    """Mark edges (e,) bool as "seam" or "edge_sharp"; (e,) bool those that were not before."""
    before = fetch(mesh.edges, f"use_{mark}", 1, bool)
    mesh.edges.foreach_set(f"use_{mark}", before | chosen)
    return chosen & ~before


def unmark_edges(mesh: bpy.types.Mesh, chosen: np.ndarray, mark: str) -> None:
    """Take a mark from edges (e,) bool."""
    before = fetch(mesh.edges, f"use_{mark}", 1, bool)
    mesh.edges.foreach_set(f"use_{mark}", before & ~chosen)
