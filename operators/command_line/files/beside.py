"""The files that go with the one that is open: pictures, libraries, materials, buffers, layers."""

from __future__ import annotations

import contextlib
import importlib.util
import os
import re
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import bpy

from .... import core
from ...base.errors import FileError
from .content import gltf, pieces
from .guard import shown

_MATERIALS = re.compile(rb"(?:^|[\r\n])[ \t]*mtllib[ \t]+([^\r\n]+)")
_LAYERS = (".usd", ".usda", ".usdc", ".usdz")


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
        except (OSError, ValueError, TypeError, AttributeError, struct.error) as error:
            raise FileError(f"{shown(path)}: its list of files cannot be read.") from error
    places = {os.path.realpath(one): one for one in reversed(found) if _is_name(one)}
    places.pop("" if path is None else os.path.realpath(path), None)
    return sorted(places.values())


def _is_name(text: str) -> bool:
    """Whether a file may be called so."""
    try:
        return b"\0" not in os.fsencode(text)
    except UnicodeEncodeError:
        return False


def _of_obj(path: Path) -> Iterator[str]:
    # Blender looks there too, whatever the file says.
    if path.with_suffix(".mtl").is_file():
        yield str(path.with_suffix(".mtl"))
    texts = (text for text in pieces.lines_of(path) if b"mtllib" in text)
    lines = {found[1] for text in texts for found in _MATERIALS.finditer(text)}
    for line in map(os.fsdecode, lines):
        # A line may name several files, and a file may have blanks in its name.
        name = line.strip().strip('"')
        names = [name] if _is_file(path.parent / name) else name.split()
        yield from (str(path.parent / name) for name in names)


def _of_gltf(path: Path) -> Iterator[str]:
    # Blender does not keep the names of the buffers.
    parts: dict[str, list[dict[str, Any]]] = gltf.json_of(path)
    for part in [*parts.get("buffers", []), *parts.get("images", [])]:
        place = gltf.place_of(path, part)
        if place is not None:
            yield str(place)


def _of_usd(path: Path) -> list[str]:
    """Layers and assets, by USD's own library where Blender has it for scripts, else by the words
    in them that name a file."""
    if importlib.util.find_spec("pxr") is not None:
        from pxr import UsdUtils

        layers, assets, missing = UsdUtils.ComputeAllDependencies(str(path))
        return [*(layer.realPath for layer in layers), *assets, *missing]
    found: dict[str, None] = {}
    waiting = [path]
    while waiting:
        layer = waiting.pop()
        names: list[str] = []
        # Blender goes on without a layer that it cannot read.
        with contextlib.suppress(core.FormatError):
            names = core.usd_names(layer)
        for name in names:
            place = layer.parent / name
            # A word may mean anything.
            if str(place) not in found and _is_file(place):
                found[str(place)] = None
                waiting += [place] if place.suffix.lower() in _LAYERS else []
    return list(found)


def _is_file(path: Path) -> bool:
    # What stands in a file may be longer than any name, or have what no name has.
    with contextlib.suppress(OSError, ValueError):
        return path.is_file()
    return False


_NAMED = {
    ".obj": _of_obj,
    **dict.fromkeys((".gltf", ".glb"), _of_gltf),
    **dict.fromkeys(_LAYERS, _of_usd),
}
