"""Results as attributes of a mesh."""

from __future__ import annotations

from collections.abc import Collection

import bpy
import numpy as np

from ..base.errors import AttributeNameError
from .fetch import LAYOUT, fetch
from .scope import KEPT

_LARGEST = float(np.finfo(np.float32).max)

# What a detection leaves on a mesh: name, domain and type.
RESULTS = {
    "umbilics_k1": ("POINT", "FLOAT"),
    "umbilics_k2": ("POINT", "FLOAT"),
    "umbilics_gap": ("POINT", "FLOAT"),
    "umbilics_d1": ("POINT", "FLOAT_VECTOR"),
    "umbilics_d2": ("POINT", "FLOAT_VECTOR"),
    "umbilics_surface_type": ("POINT", "INT"),
    "umbilics_conformal_scale": ("POINT", "FLOAT"),
    "umbilics_index": ("FACE", "FLOAT"),
    "umbilics_region": ("FACE", "INT"),
    KEPT: ("FACE", "INT"),
}
# Of these a detection leaves some with some settings only.
_OPTIONAL = {"umbilics_conformal_scale", KEPT}


def check_result_names(
    obj: bpy.types.Object, layouts: dict[str, tuple[str, str]], ours: bool
) -> None:
    """Raise `AttributeNameError` if a result's name is taken by something that is not ours; what
    has our types is, where what is called like results is `ours`."""
    mesh = obj.data
    taken = [
        name
        for name in layouts
        if name in mesh.attributes and not (ours and _fits(mesh, name, layouts))
    ]
    if len(taken) > 1:
        raise AttributeNameError(
            f"{mesh.name} has attributes that are not results of Umbilics: {', '.join(taken)}. "
            "Rename them in the mesh's properties, under Attributes."
        )
    for name in taken:
        raise AttributeNameError(
            f"{mesh.name} has an attribute {name} that is not a result of Umbilics. "
            "Rename it in the mesh's properties, under Attributes."
        )
    for name in layouts:
        if name not in mesh.attributes and name in obj.vertex_groups:
            raise AttributeNameError(
                f"{obj.name} has a vertex group {name}. Rename it: the result needs the name."
            )


def is_whole(mesh: bpy.types.Mesh, layouts: dict[str, tuple[str, str]]) -> bool:
    """Whether a mesh has all that we leave of a kind: then it is ours, though it came with a mesh
    that was joined or imported, without the stamp. One of the names may be the user's own."""
    return all(_fits(mesh, name, layouts) for name in layouts if name not in _OPTIONAL)


def _fits(mesh: bpy.types.Mesh, name: str, layouts: dict[str, tuple[str, str]]) -> bool:
    """Whether a mesh has an attribute of a result's name, domain and type."""
    found = mesh.attributes.get(name)
    return found is not None and (found.domain, found.data_type) == layouts[name]


def write_results(mesh: bpy.types.Mesh, results: dict[str, np.ndarray]) -> None:
    """Store results as attributes, making or replacing ours; the mesh is not in Edit Mode.

    `results` holds arrays for names in RESULTS; of those it has not, an earlier one is removed.
    What is not finite is stored as 0, so that nothing downstream meets a NaN.
    """
    remove_results(mesh, RESULTS.keys() - results.keys())
    write_attributes(mesh, results, RESULTS)


def write_attributes(
    mesh: bpy.types.Mesh, results: dict[str, np.ndarray], layouts: dict[str, tuple[str, str]]
) -> None:
    """Store arrays under their names, with the domains and types of `layouts`; as above."""
    for name, array in results.items():
        domain, kind = layouts[name]
        _, dtype, key, _ = LAYOUT[kind]
        attribute = mesh.attributes.get(name) or mesh.attributes.new(name, kind, domain)
        values = np.nan_to_num(array, nan=0.0, posinf=0.0, neginf=0.0)
        # Curvatures of a tiny mesh may be beyond single precision.
        values = np.clip(values, -_LARGEST, _LARGEST).astype(dtype)
        attribute.data.foreach_set(key, np.ascontiguousarray(values).ravel())
    mesh.update()


def remove_results(
    mesh: bpy.types.Mesh,
    names: Collection[str] = RESULTS.keys(),
    layouts: dict[str, tuple[str, str]] = RESULTS,
) -> int:
    """Remove our attributes from a mesh that is not in Edit Mode; says how many there were."""
    removed = 0
    for name in names:
        if _fits(mesh, name, layouts):
            mesh.attributes.remove(mesh.attributes[name])
            removed += 1
    return removed


def read_result(
    mesh: bpy.types.Mesh, name: str, layouts: dict[str, tuple[str, str]] = RESULTS
) -> np.ndarray | None:
    """A result as an array (count,) or (count, 3), float32 or int32; None if it is not there.

    The mesh must not be in Edit Mode: then there is nothing to read.
    """
    if not _fits(mesh, name, layouts) or not len(mesh.attributes[name].data):
        return None
    found = mesh.attributes[name]
    width, dtype, key, _ = LAYOUT[found.data_type]
    return fetch(found.data, key, width, dtype)


def to_corners(mesh: bpy.types.Mesh, values: np.ndarray) -> np.ndarray:
    """Values of the faces (p,) at each of their corners."""
    return np.repeat(values, fetch(mesh.polygons, "loop_total", 1, np.int32))
