"""Binary FBX looked through before Blender's add-on reads it, which trusts every number in it: one
that is wrong can take all memory, and an array that cannot be unpacked may have it wait for ever.

The format is described by Alexander Gessler, 2013, as Blender's own developers do:
https://code.blender.org/2013/08/fbx-binary-file-format-specification/
"""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

_MARK = b"Kaydara FBX Binary  \x00"
# Behind the mark two bytes, then the version.
_VERSION = struct.Struct("<21s2xI")
# A node: where it ends, how many properties it has and of how many bytes, and the length of its
# name; from version 7500 on in eight bytes each.
_NODE, _LONG_NODE, _LONG = struct.Struct("<IIIB"), struct.Struct("<QQQB"), 7500
# Bytes of a property by its type, and of a value in arrays; texts and bytes have their length.
_PLAIN = {"Z": 1, "B": 1, "C": 1, "Y": 2, "I": 4, "F": 4, "D": 8, "L": 8}
_ARRAYS = {"b": 1, "c": 1, "i": 4, "f": 4, "l": 8, "d": 8}
_ARRAY, _LENGTH = struct.Struct("<III"), struct.Struct("<I")
# More than this a byte can never become.
# https://zlib.net/zlib_tech.html
_DEFLATE = 1032


class DamagedError(ValueError):
    """Something does not fit."""


def is_whole(path: Path) -> bool:
    """Whether all nodes, properties and arrays fit into each other; a text always does."""
    data = path.read_bytes()
    if not data.startswith(_MARK):
        return True
    try:
        _, version = _VERSION.unpack_from(data)
        _walk(data, _VERSION.size, _LONG_NODE if version >= _LONG else _NODE)
    except (struct.error, DamagedError, zlib.error):
        return False
    return True


def _walk(data: bytes, start: int, node: struct.Struct) -> None:
    """Go through all nodes; each is behind the one before it, so that there is an end."""
    ends = [len(data)]
    place = start
    while ends:
        if place == ends[-1]:
            ends.pop()
            continue
        end, count, size, name = node.unpack_from(data, place)
        if end == 0:
            # The end of a list; of the outermost one that of all nodes.
            if len(ends) == 1:
                return
            place = ends.pop()
            continue
        first = place + node.size + name
        if not first + size <= end <= ends[-1] or count > size:
            raise DamagedError
        for _ in range(count):
            first = _behind_property(data, first, end)
        place = first
        ends.append(end)
    # The last node of all has no end of its list behind it.
    raise DamagedError


def _behind_property(data: bytes, place: int, end: int) -> int:
    """Where a property ends that begins there, once it is looked at."""
    if place >= end:
        raise DamagedError
    kind, place = chr(data[place]), place + 1
    if kind in _PLAIN:
        place += _PLAIN[kind]
    elif kind in "SR":
        place += _LENGTH.size + _LENGTH.unpack_from(data, place)[0]
    elif kind in _ARRAYS:
        count, is_packed, size = _ARRAY.unpack_from(data, place)
        place += _ARRAY.size
        whole = count * _ARRAYS[kind]
        if place + size > end or whole > (_DEFLATE * size if is_packed else size):
            raise DamagedError
        if is_packed and len(zlib.decompress(data[place : place + size], bufsize=whole)) != whole:
            raise DamagedError
        place += size
    else:
        raise DamagedError
    if place > end:
        raise DamagedError
    return place
