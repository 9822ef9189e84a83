"""The files that go with the one that is open: pictures, libraries, materials, buffers, layers."""

from __future__ import annotations

import importlib.util
import json
import mmap
import os
import re
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import bpy

from ...base.errors import FileError
from .guard import shown

_MATERIALS = re.compile(rb"^[ \t]*mtllib[ \t]+([^\r\n]+)", re.MULTILINE)
# What stands between @ in the text of USD is an asset; three of them where it has one in its name.
_ASSET = re.compile(r"@@@(.+?)@@@|@([^@\r\n]+)@")
# Of a binary glTF: magic, version and length, then length and kind of the first part, its JSON.
_GLB = struct.Struct("<4sIIII")


def files_beside(path: str | None) -> list[str]:
    """The files that are read with the one at `path`, or with the scene that is open; each once,
    those too that are named and missing.

    Raises
    ------
    FileError
        The file does not tell what it is made of.
    """
    found = list(bpy.utils.blend_paths(absolute=True, packed=False, local=False))
    if path is not None:
        try:
            found += _NAMED.get(Path(path).suffix.lower(), lambda _: ())(Path(path))
        except (OSError, ValueError, TypeError, AttributeError) as error:
            raise FileError(f"{shown(path)}: its list of files cannot be read.") from error
    places = {os.path.realpath(one): one for one in reversed(found)}
    places.pop("" if path is None else os.path.realpath(path), None)
    return sorted(places.values())


def _of_obj(path: Path) -> Iterator[str]:
    with open(path, "rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as text:
        for line in {os.fsdecode(one[1]).strip() for one in _MATERIALS.finditer(text)}:
            # A line may name several files, and a file may have blanks in its name.
            whole = path.parent / line
            names = [line] if whole.exists() else line.split()
            yield from (str(path.parent / name) for name in names)


def _of_gltf(path: Path) -> Iterator[str]:
    # Blender does not keep the names of the buffers.
    parts: dict[str, list[dict[str, Any]]] = json.loads(_json_of(path))
    for part in [*parts.get("buffers", []), *parts.get("images", [])]:
        uri = part.get("uri", "data:")
        if not uri.startswith("data:"):
            yield str(path.parent / unquote(uri))


def _json_of(path: Path) -> bytes:
    if path.suffix.lower() == ".gltf":
        return path.read_bytes()
    with open(path, "rb") as file:
        _, _, _, length, _ = _GLB.unpack(file.read(_GLB.size))
        return file.read(length)


def _of_usd(path: Path) -> list[str]:
    """Layers and assets, by USD's own library where Blender has it for scripts, else by what text
    says of itself."""
    if importlib.util.find_spec("pxr") is not None:
        from pxr import UsdUtils

        layers, assets, missing = UsdUtils.ComputeAllDependencies(str(path))
        return [*(layer.realPath for layer in layers), *assets, *missing]
    found: dict[str, None] = {}
    waiting = [path]
    while waiting:
        layer = waiting.pop()
        if layer.suffix.lower() not in (".usda", ".usd") or not layer.is_file():
            continue
        with open(layer, "rb") as file:
            if file.read(5) != b"#usda":
                continue
            text = file.read().decode("utf-8", "replace")
        for one in _ASSET.finditer(text):
            place = layer.parent / (one[1] or one[2])
            # In a comment or a text a sign like this may mean anything.
            if str(place) not in found and place.is_file():
                found[str(place)] = None
                waiting.append(place)
    return list(found)


_NAMED = {
    ".obj": _of_obj,
    **dict.fromkeys((".gltf", ".glb"), _of_gltf),
    **dict.fromkeys((".usd", ".usda", ".usdc", ".usdz"), _of_usd),
}
