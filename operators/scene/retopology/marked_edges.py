"""What the guidance leaves on the edges of a mesh: marks of seams, creases and sharp edges, and the
ridges that run along them.

Which marks are ours is kept beside them, so that the user's own outlive them.
"""

from __future__ import annotations

import bpy
import numpy as np

from .... import core
from ...mesh.attributes import is_whole, remove_results, write_attributes
from ...mesh.edge_marks import EDGE_ATTRIBUTES, mark_edges, unmark_edges
from ..targets import is_local
from ..transaction import Transaction

# 1 where we marked a seam, 2 where a sharp edge, 4 where a crease, and sums: to be undone.
MARKS = {"umbilics_marked": ("EDGE", "INT")}
# 1 on ridges, 2 on ravines; how far the normal turns across them, and the curvature there.
RIDGE_EDGES = {
    "umbilics_ridge": ("EDGE", "INT"),
    "umbilics_ridge_bend": ("EDGE", "FLOAT"),
    "umbilics_ridge_strength": ("EDGE", "FLOAT"),
}
_BIT = {"seam": 1, "edge_sharp": 2, "crease": 4}


def mark(obj: bpy.types.Object, chosen: np.ndarray, kind: str, transaction: Transaction) -> int:
    """Mark edges (e,) bool as "seam", "edge_sharp" or "crease" and remember which; how many are
    new."""
    transaction.keep_attributes(obj.data, (*MARKS, *EDGE_ATTRIBUTES))
    unmark(obj, kind)
    fresh = mark_edges(obj.data, chosen, kind)
    ours = _marks(obj.data)
    ours[fresh] |= _BIT[kind]
    write_attributes(obj.data, {"umbilics_marked": ours}, MARKS)
    return int(fresh.sum())


def unmark(obj: bpy.types.Object, kind: str) -> bool:
    """Take back the marks that `mark` made; whether there were any."""
    ours = _marks(obj.data)
    mine = (ours & _BIT[kind]) > 0
    if not mine.any():
        return False
    unmark_edges(obj.data, mine, kind)
    write_attributes(obj.data, {"umbilics_marked": ours & ~_BIT[kind]}, MARKS)
    return True


def _marks(mesh: bpy.types.Mesh) -> np.ndarray:
    found = mesh.attributes.get("umbilics_marked")
    values = np.zeros(len(mesh.edges), np.int32)
    if found is not None and (found.domain, found.data_type) == MARKS["umbilics_marked"]:
        found.data.foreach_get("value", values)
    return values


def write_ridge_edges(
    obj: bpy.types.Object, found: core.RidgeEdges | None, transaction: Transaction
) -> None:
    """Attributes on the edges of the object's mesh, in place of earlier ones; None takes these."""
    if not is_local(obj.data):
        return
    transaction.keep_attributes(obj.data, tuple(RIDGE_EDGES))
    if is_whole(obj.data, RIDGE_EDGES):
        remove_results(obj.data, RIDGE_EDGES.keys(), RIDGE_EDGES)
    if found is not None:
        arrays = found.kind, np.radians(found.bend), found.strength
        write_attributes(obj.data, dict(zip(RIDGE_EDGES, arrays, strict=True)), RIDGE_EDGES)


def remove_all(obj: bpy.types.Object, transaction: Transaction) -> bool:
    """Have our marks and ridges go from the object's mesh; whether there were any."""
    transaction.keep_attributes(obj.data, (*MARKS, *RIDGE_EDGES, *EDGE_ATTRIBUTES))
    found = [unmark(obj, kind) for kind in _BIT]
    for layouts in (MARKS, RIDGE_EDGES):
        if is_whole(obj.data, layouts):
            found.append(remove_results(obj.data, layouts.keys(), layouts) > 0)
    return any(found)
