"""What stands in a glTF, as far as it is looked at before or beside Blender's importer."""

from __future__ import annotations

import base64
import json
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import unquote, unquote_to_bytes

import numpy as np

# Of a binary glTF: magic, version and length, then length and kind of each part, the first of which
# is its JSON and the second its buffer.
_HEAD, _PART = struct.Struct("<4sII"), struct.Struct("<II")
# https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html#accessor-data-types
_FLOAT, _PLACE = 5126, np.dtype("<f4")


def json_of(path: Path) -> dict[str, Any]:
    """The JSON of a glTF in text or binary.

    Raises
    ------
    OSError, ValueError, struct.error
        It cannot be read.
    """
    return json.loads(path.read_bytes() if path.suffix.lower() == ".gltf" else _part(path, 0))


def place_of(path: Path, part: dict[str, Any]) -> Path | None:
    """Where the file of a buffer or a picture is, None if it is in the glTF itself."""
    uri = part.get("uri", "data:")
    return None if uri.startswith("data:") else path.parent / unquote(uri)


def positions(path: Path) -> Iterator[np.ndarray]:
    """The positions (n, 3) of the meshes' vertices that are written in single precision; packed
    ones are left out.

    Raises
    ------
    OSError, ValueError, KeyError, IndexError, TypeError, struct.error
        The file is damaged.
    """
    parts = json_of(path)
    primitives = [one for mesh in parts.get("meshes", []) for one in mesh["primitives"]]
    used = {one["attributes"].get("POSITION") for one in primitives} - {None}
    for number in sorted(used):
        accessor = parts["accessors"][number]
        if accessor["componentType"] != _FLOAT:
            continue
        if "bufferView" in accessor:
            yield _rows(path, parts, accessor, accessor["count"])
        if "sparse" in accessor:
            sparse = accessor["sparse"]
            yield _rows(path, parts, sparse["values"], sparse["count"])


def _rows(
    path: Path, parts: dict[str, Any], accessor: dict[str, Any], count: int
) -> np.ndarray:
    view = parts["bufferViews"][accessor["bufferView"]]
    if "extensions" in view:
        return np.empty((0, 3), _PLACE)
    data = _buffer(path, parts["buffers"][view["buffer"]])
    start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
    step = view.get("byteStride", 3 * _PLACE.itemsize)
    return np.ndarray((count, 3), _PLACE, data, start, (step, _PLACE.itemsize))


def _buffer(path: Path, buffer: dict[str, Any]) -> bytes:
    place = place_of(path, buffer)
    if place is not None:
        return place.read_bytes()
    if "uri" not in buffer:
        return _part(path, 1)
    kind, _, text = buffer["uri"].partition(",")
    return base64.b64decode(unquote_to_bytes(text)) if kind.endswith(";base64") else b""


def _part(path: Path, number: int) -> bytes:
    """A part of a binary glTF."""
    with open(path, "rb") as file:
        file.seek(_HEAD.size)
        for _ in range(number):
            length, _ = _PART.unpack(file.read(_PART.size))
            file.seek(length, 1)
        length, _ = _PART.unpack(file.read(_PART.size))
        return file.read(length)
