"""Open mesh files with Blender's own importers, without turning or scaling them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import bmesh
import bpy
import numpy as np

from .... import core
from ...base.errors import FileError
from ...jobs.refusals import CONVERTIBLE
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
    if why := damage.refusal(path, SUFFIXES):
        raise FileError(f"{name}: {why}.")
    suffix = file.suffix.lower()
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
        reason = _by_name(_reason(words) or damage.why_unread(file), real, name)
        raise FileError(f"{name}: Blender cannot read it ({reason})") from error
    objects = _meshes(before)
    if not objects:
        raise FileError(f"{name}: no mesh was found in it.{_instead()}")
    warnings = damage.doubts(file, sum(len(obj.data.polygons) for obj in objects))
    warnings += _missing_libraries()
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
    """The last line that says something, without Blender's label, empty if none does; where in
    which script it was is nothing to the reader of the file, and its console is not there."""
    said = [line for line in words if line.strip() and not line.lstrip().startswith("Location:")]
    reason = (said or words)[-1].strip().removeprefix("Error: ")
    if reason.endswith("unknown error"):
        return ""
    return reason.removesuffix(", see console for detail")


def _missing_libraries() -> list[str]:
    """Sentences on the .blend files that the open one takes something from and that are gone."""
    return [
        f"The library {shown(library.filepath)} is missing: what was linked from it is not there."
        for library in bpy.data.libraries
        if library.is_missing
    ]


def _instead() -> str:
    """What is in the scene in place of meshes, and what to do with it; empty if nothing is."""
    objects = bpy.context.scene.objects
    said = _missing_libraries()
    if any(obj.type == "EMPTY" and obj.instance_type == "COLLECTION" for obj in objects):
        said.append("There are instances of collections: Object > Apply > Make Instances Real.")
    kinds = sorted({obj.type.lower() for obj in objects if obj.type in CONVERTIBLE})
    if kinds:
        said.append(f"There are other shapes ({', '.join(kinds)}): Object > Convert > Mesh.")
    return "".join(f" {sentence}" for sentence in said)


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
    """Join vertices whose places are the same to the bit: glTF splits them along seams and creases.

    By a distance Blender joins all of a mesh with a vertex far away, and none at 0 before 5.0.
    """
    # 0 for -0. Each row is one word, which is compared as such.
    places = np.ascontiguousarray(positions(mesh), np.float32) + np.float32(0.0)
    words = places.view(np.dtype((np.void, places.itemsize * 3))).ravel()
    _, first, group = np.unique(words, return_index=True, return_inverse=True)
    kept = first[group.ravel()]
    copies = np.flatnonzero(kept != np.arange(len(kept)))
    work = bmesh.new()
    try:
        work.from_mesh(mesh)
        vertices = list(work.verts)
        pairs = zip(copies.tolist(), kept[copies].tolist(), strict=True)
        targets = {vertices[copy]: vertices[one] for copy, one in pairs}
        bmesh.ops.weld_verts(work, targetmap=targets)
        work.to_mesh(mesh)
    finally:
        work.free()
