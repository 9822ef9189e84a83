"""What a check leaves on the mesh that was checked, and whether it is still of that mesh."""

from __future__ import annotations

import bpy
import numpy as np

from .... import core
from ...base import caches
from ...data import topology
from ...mesh.attributes import remove_results, write_attributes
from ...mesh.fingerprint import mesh_signature
from ...mesh.read import current_mesh, positions
from ..homes import same_faces
from ..targets import is_local
from ..transaction import Transaction

# 1 for a vertex that stands for a planned pole, 2 for an extra one.
ATTRIBUTES = {
    "umbilics_check_pole": ("POINT", "INT"),
    "umbilics_check_distance": ("POINT", "FLOAT"),
    "umbilics_check_angle": ("FACE", "FLOAT"),
}


SEEN = "EVALUATED"


def depsgraph_of(context: bpy.types.Context, source: str) -> bpy.types.Depsgraph | None:
    """What shows modifiers and shape keys, where they count; `source` as in the scene's choice."""
    return context.evaluated_depsgraph_get() if source == SEEN else None


def source_in(stamp: str) -> str:
    """Which form of the mesh a signature is of."""
    return stamp.partition(" ")[0]


def signature_of(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None) -> str:
    """What tells the mesh that is checked from another; with a `depsgraph` as modifiers and
    shape keys make it."""
    with current_mesh(obj, depsgraph) as mesh:
        return f"{'BASE' if depsgraph is None else SEEN} {mesh_signature(mesh)}"


def write(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    against: topology.Against,
    found: core.TopologyCheck,
    poles: core.Poles,
    stamp: str,
    transaction: Transaction,
) -> None:
    """Numbers, table and, where the object's own mesh has the faces that were checked, attributes.

    The object is not in Edit Mode.
    """
    transaction.keep_properties(obj, "umbilics_check")
    back = np.linalg.inv(np.array(obj.matrix_world))
    places = poles.position[found.missing] @ back[:3, :3].T + back[:3, 3]
    with current_mesh(obj, depsgraph_of(context, source_in(stamp))) as seen:
        irregular = positions(seen)[found.irregular]
        fits = same_faces(seen, obj.data)
    topology.store(obj, against, stamp, found, irregular, poles.valence[found.missing], places)
    if not fits:
        return
    pole = np.zeros(len(found.distance), np.int32)
    pole[found.irregular] = np.where(found.pole >= 0, 1, 2)
    values = {
        "umbilics_check_pole": pole,
        "umbilics_check_distance": found.distance,
        "umbilics_check_angle": found.angle,
    }
    transaction.keep_attributes(obj.data, tuple(ATTRIBUTES))
    write_attributes(obj.data, values, ATTRIBUTES)


def remove(obj: bpy.types.Object, transaction: Transaction) -> bool:
    """Have the check of an object go that is not in Edit Mode, but not the surface that was chosen
    for it; whether there was one."""
    if not obj.umbilics_check.checked:
        return False
    transaction.keep_properties(obj, "umbilics_check")
    topology.forget(obj)
    if is_local(obj.data) and not are_held(obj.data, but=obj):
        transaction.keep_attributes(obj.data, tuple(ATTRIBUTES))
        remove_results(obj.data, ATTRIBUTES.keys(), ATTRIBUTES)
    return True


def are_held(mesh: bpy.types.Mesh, but: bpy.types.Object | None = None) -> bool:
    """Whether a mesh has the values of a check of one of its objects, `but` one."""
    return any(
        obj != but and obj.data == mesh and obj.umbilics_check.checked for obj in bpy.data.objects
    )


def is_old(context: bpy.types.Context, obj: bpy.types.Object) -> bool:
    """Whether the mesh is another one than was checked, as far as is known: not while it is worked
    on or hidden."""
    kept = obj.umbilics_check
    if not kept.checked or obj.mode != "OBJECT" or not obj.visible_get():
        return False
    now = caches.FINGERPRINTS.of(
        (obj.name_full, "check", source_in(kept.stamp)), lambda: _look(context, obj, kept.stamp)
    )
    return bool(now != kept.stamp)


def _look(context: bpy.types.Context, obj: bpy.types.Object, stamp: str) -> str:
    if source_in(stamp) != SEEN:
        return signature_of(obj, None)
    shown = obj.evaluated_get(context.view_layer.depsgraph)
    # Its data may be what is subdivided while it is drawn.
    try:
        return f"{SEEN} {mesh_signature(shown.to_mesh())}"
    finally:
        shown.to_mesh_clear()
