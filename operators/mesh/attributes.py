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


def check_result_names(
    obj: bpy.types.Object, layouts: dict[str, tuple[str, str]] = RESULTS
) -> None:
    """Raise `AttributeNameError` if a result's name is taken by something that is not ours."""
    mesh = obj.data
    for name, (domain, kind) in layouts.items():
        found = mesh.attributes.get(name)
        if found is not None and (found.domain, found.data_type) != (domain, kind):
            raise AttributeNameError(
                f"{mesh.name} has an attribute {name} that is not a result of Umbilics. "
                "Rename it in the mesh's properties, under Attributes."
            )
        if found is None and name in obj.vertex_groups:
            raise AttributeNameError(
                f"{obj.name} has a vertex group {name}. Rename it: the result needs the name."
            )


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
        layout = layouts[name]
        found = mesh.attributes.get(name)
        if found is not None and (found.domain, found.data_type) == layout:
            mesh.attributes.remove(found)
            removed += 1
    return removed


def read_result(
    mesh: bpy.types.Mesh, name: str, layouts: dict[str, tuple[str, str]] = RESULTS
) -> np.ndarray | None:
    """A result as an array (count,) or (count, 3), float32 or int32; None if it is not there.

    The mesh must not be in Edit Mode: then there is nothing to read.
    """
    found = mesh.attributes.get(name)
    if found is None or (found.domain, found.data_type) != layouts[name] or not len(found.data):
        return None
    width, dtype, key, _ = LAYOUT[found.data_type]
    return fetch(found.data, key, width, dtype)


def to_corners(mesh: bpy.types.Mesh, values: np.ndarray) -> np.ndarray:
    """Values of the faces (p,) at each of their corners."""
    return np.repeat(values, fetch(mesh.polygons, "loop_total", 1, np.int32))
