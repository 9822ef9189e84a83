"""Open mesh files with Blender's own importers, without turning or scaling them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import bmesh
import bpy
import numpy as np

from .... import core
from ...base.errors import FileError
from ...mesh.read import positions
from . import damage
from .file_kinds import LOADERS, UPRIGHT
from .guard import shown
from .quiet import quiet


@dataclass(frozen=True)
class Opened:
    """The meshes of a file.

    `to_file` (3, 3) turns world coordinates into the file's own; `up` is the world axis that
    points up in pictures, `file_up` the same axis as the file counts; `warnings` are sentences on
    what may be missing in them.
    """

    objects: list[bpy.types.Object]
    to_file: np.ndarray
    up: str
    file_up: str
    warnings: tuple[str, ...] = ()


SUFFIXES = tuple(LOADERS)
# What Blender and the libraries in it do not check before they trust it: a damaged one may end the
# process (seen of 30 damaged files of each kind on 2 to 10).
UNCHECKED = (".abc", ".blend", ".usd", ".usda", ".usdc", ".usdz")
_AXES = {"Y": np.eye(3)[1], "Z": np.eye(3)[2]}


def open_file(path: str | None, base: str) -> Opened:
    """The meshes of a file, brought into Blender.

    `base` is the .blend that meshes are imported into, or empty for an empty scene. With
    `path` None the meshes of the scene that is open already.

    Raises
    ------
    FileError
        The file is missing, empty, of another kind, damaged, or holds no mesh.
    """
    if path is None:
        return Opened(_meshes(set()), UPRIGHT, "Z", "Z")
    file, name = Path(path), shown(path)
    suffix = file.suffix.lower()
    if not file.exists():
        raise FileError(f"{name}: there is no such file.")
    if file.is_dir():
        raise FileError(f"{name}: this is a folder, not a file.")
    if not file.is_file():
        raise FileError(f"{name}: this is not a file but a pipe, a socket or a device.")
    if suffix not in LOADERS:
        raise FileError(f"{name}: not a kind of file that can be read ({', '.join(SUFFIXES)}).")
    if not file.stat().st_size:
        raise FileError(f"{name}: the file is empty.")
    load, file_up = LOADERS[suffix]
    before = set() if suffix == ".blend" else _start(base)
    real = str(file.resolve())
    try:
        with quiet():
            to_file = load(real)
    except (FileError, core.FormatError) as error:
        raise FileError(_by_name(str(error), real, name)) from error
    except OSError as error:
        raise FileError(f"{name}: cannot be read ({error.strerror}).") from error
    except RuntimeError as error:
        words = str(error).strip().splitlines() or ["it does not say why"]
        reason = _by_name(_reason(words), real, name)
        raise FileError(f"{name}: Blender cannot read it ({reason})") from error
    objects = _meshes(before)
    if not objects:
        raise FileError(f"{name}: no mesh was found in it.")
    warnings = damage.doubts(file, sum(len(obj.data.polygons) for obj in objects))
    if suffix in (".gltf", ".glb"):
        for obj in objects:
            _weld(obj.data)
    file_up = file_up or ("Z" if to_file[2, 2] > 0.5 else "Y")
    up = "Z" if (to_file.T @ _AXES[file_up])[2] > 0.5 else "Y"
    return Opened(objects, to_file, up, file_up, tuple(warnings))


def _by_name(words: str, real: str, name: str) -> str:
    """What is said of a file with the name that was given, by which the user knows it."""
    return words.replace(real, name).replace(shown(real), name)


def _reason(words: list[str]) -> str:
    """The last line that says something, without Blender's label; where in which script it was is
    nothing to the reader of the file, and its console is not there."""
    said = [line for line in words if line.strip() and not line.lstrip().startswith("Location:")]
    reason = (said or words)[-1].strip().removeprefix("Error: ")
    if reason.endswith("unknown error"):
        return "its importer does not say why; the file may be torn"
    return reason.removesuffix(", see console for detail")


def _start(base: str) -> set[str]:
    """Open the base scene anew; names of the objects that it has already."""
    with quiet():
        if base:
            bpy.ops.wm.open_mainfile(filepath=base, load_ui=False, use_scripts=False)
        else:
            bpy.ops.wm.read_homefile(use_empty=True)
    return {obj.name for obj in bpy.data.objects}


def _meshes(before: set[str]) -> list[bpy.types.Object]:
    """The scene's meshes that are not called as in `before`."""
    bpy.context.view_layer.update()
    scene = bpy.context.scene
    return [obj for obj in scene.objects if obj.type == "MESH" and obj.name not in before]


def _weld(mesh: bpy.types.Mesh) -> None:
    """Join vertices at the same place: glTF splits them along seams and creases."""
    work = bmesh.new()
    try:
        work.from_mesh(mesh)
        # Less than the rounding of single precision: 0 joins nothing before Blender 5.
        reach = float(np.abs(positions(mesh)).max(initial=0.0))
        bmesh.ops.remove_doubles(work, verts=work.verts, dist=1e-7 * reach)
        work.to_mesh(mesh)
    finally:
        work.free()
