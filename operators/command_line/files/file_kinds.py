"""The kinds of mesh files: how Blender opens each, and how its coordinates lie in Blender's world.

Each loader brings the meshes of a file into the scene, without changing their size, and answers
with the (3, 3) turn from the world to the coordinates that docs/json.md promises for the file.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix

from .... import core
from ...base.errors import FileError
from ...mesh.build import from_polygons
from . import damage, fbx_check
from .guard import shown
from .quiet import overheard
from .quirks import readable

UPRIGHT = np.eye(3)
# Of a format with y up: Blender's importers turn (x, y, z) into (x, -z, y).
_FROM_Y_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
# What Blender prints where it puts the first vertex in the place of one that is not there.
_WRONG_FACE = re.compile(rb"Invalid PLY vertex index in face (\d+)")
# Blender's own directions to the right, up and to the front.
_RIGHT, _UP, _FRONT = np.eye(3)[0], np.eye(3)[2], -np.eye(3)[1]


def _obj(path: str) -> np.ndarray:
    damage.check(Path(path))
    with readable(path) as place:
        bpy.ops.wm.obj_import(filepath=place, forward_axis="Y", up_axis="Z")
    return UPRIGHT


def _ply(path: str) -> np.ndarray:
    damage.check(Path(path))
    with readable(path) as place, overheard() as said:
        bpy.ops.wm.ply_import(filepath=place, forward_axis="Y", up_axis="Z")
        wrong = set(_WRONG_FACE.findall(said()))
    if wrong:
        faces = "1 face names" if len(wrong) == 1 else f"{len(wrong)} faces name"
        raise FileError(f"{shown(path)}: {faces} vertices that are not there.")
    return UPRIGHT


def _stl(path: str) -> np.ndarray:
    damage.check(Path(path))
    with readable(path) as place:
        bpy.ops.wm.stl_import(filepath=place, forward_axis="Y", up_axis="Z")
    return UPRIGHT


def _off(path: str) -> np.ndarray:
    mesh = from_polygons(*core.read_off(path))
    name = Path(path).stem
    mesh.name = name
    bpy.context.scene.collection.objects.link(bpy.data.objects.new(name, mesh))
    return UPRIGHT


def _gltf(path: str) -> np.ndarray:
    # Else each skeleton brings a mesh for its bones that is in no file.
    bpy.ops.import_scene.gltf(
        filepath=path, **_known(bpy.ops.import_scene.gltf, disable_bone_shape=True)
    )
    return _FROM_Y_UP


def _fbx(path: str) -> np.ndarray:
    # FBX counts in centimetres, Blender's importers in metres.
    if has_operator("wm.fbx_import"):
        bpy.ops.wm.fbx_import(filepath=path, global_scale=100.0)
        return _turn_of_fbx(Path(path).read_bytes())
    if not fbx_check.is_whole(Path(path)):
        raise FileError(f"{shown(path)}: is damaged: its parts do not fit into each other.")
    bpy.ops.import_scene.fbx(
        filepath=path,
        use_manual_orientation=True,
        axis_forward="Y",
        axis_up="Z",
        global_scale=100.0,
    )
    return UPRIGHT


def _usd(path: str) -> np.ndarray:
    _need(path, "wm.usd_import", "USD")
    # Lengths as they stand in the file; older versions never change them. Copies of a prim are
    # meshes where they stand.
    options = {"apply_unit_conversion_scale": False, "support_scene_instancing": False}
    collections = set(bpy.data.collections)
    bpy.ops.wm.usd_import(filepath=path, **_known(bpy.ops.wm.usd_import, **options))
    if core.up_axis(path) != "Y":
        return UPRIGHT
    turn = Matrix(_FROM_Y_UP.T).to_4x4()
    # What Blender has for points to show is the only thing that it does not turn upwards.
    for collection in set(bpy.data.collections) - collections:
        for obj in collection.objects:
            if obj.parent is None:
                obj.matrix_world = turn @ obj.matrix_world
    return _FROM_Y_UP


def _alembic(path: str) -> np.ndarray:
    _need(path, "wm.alembic_import", "Alembic")
    damage.check(Path(path))
    bpy.ops.wm.alembic_import(filepath=path, as_background_job=False, set_frame_range=True)
    return _FROM_Y_UP


def _blend(path: str) -> np.ndarray:
    bpy.ops.wm.open_mainfile(filepath=path, load_ui=False, use_scripts=False)
    return UPRIGHT


# Ending of the file: how it is opened, and the axis that usually points up in it, empty for the
# one that Blender turns upwards.
LOADERS: dict[str, tuple[Callable[[str], np.ndarray], str]] = {
    ".obj": (_obj, "Y"),
    ".ply": (_ply, "Y"),
    ".stl": (_stl, "Z"),
    ".off": (_off, "Y"),
    ".gltf": (_gltf, "Y"),
    ".glb": (_gltf, "Y"),
    ".fbx": (_fbx, "Y"),
    ".usd": (_usd, ""),
    ".usda": (_usd, ""),
    ".usdc": (_usd, ""),
    ".usdz": (_usd, ""),
    ".abc": (_alembic, "Y"),
    ".blend": (_blend, "Z"),
}


def _known(operator: Any, **options: bool) -> dict[str, bool]:
    """Those options that this version of an operator has."""
    known = operator.get_rna_type().properties.keys()
    return {name: value for name, value in options.items() if name in known}


def has_operator(name: str) -> bool:
    """Whether this build of Blender has an operator, such as "wm.usd_import"."""
    group, operator = name.split(".")
    return operator in dir(getattr(bpy.ops, group))


def _need(path: str, operator: str, format_name: str) -> None:
    if not has_operator(operator):
        raise FileError(
            f"{shown(path)}: this Blender ({bpy.app.version_string}) was built without "
            f"{format_name}. Take one from blender.org, or save the mesh in another format."
        )


def _turn_of_fbx(data: bytes) -> np.ndarray:
    """World to file, from the axes that the file names: its right, up and front are Blender's."""
    usual = {"Coord": (0, 1), "Up": (1, 1), "Front": (2, 1)}
    turn = np.zeros((3, 3))
    for name, direction in (("Coord", _RIGHT), ("Up", _UP), ("Front", _FRONT)):
        axis = _fbx_number(data, f"{name}Axis", usual[name][0])
        turn[axis] = _fbx_number(data, f"{name}AxisSign", usual[name][1]) * direction
    return turn


def _fbx_number(data: bytes, name: str, otherwise: int) -> int:
    """A whole number of the file's settings, be it binary or text."""
    # In binary files texts are "S", their length and letters, whole numbers "I" and four bytes.
    texts = b"".join(
        b"S" + struct.pack("<i", len(text)) + text for text in (b"int", b"Integer", b"")
    )
    found = re.search(re.escape(name.encode() + texts) + b"I(.{4})", data, re.DOTALL)
    if found:
        return struct.unpack("<i", found[1])[0]
    found = re.search(
        rb'P:\s*"' + name.encode() + rb'",\s*"int",\s*"Integer",\s*"",\s*(-?\d+)', data
    )
    return int(found[1]) if found else otherwise
