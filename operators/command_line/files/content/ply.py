"""The head of a PLY: which elements it announces and how they are written.

Blender's importer trusts it: a line that is damaged there may end Blender itself, or give vertices
and faces that are in no file.
"""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

AXES = (b"x", b"y", b"z")
TYPES = {
    name: kind
    for kind, names in {
        "i1": (b"char", b"int8"),
        "u1": (b"uchar", b"uint8"),
        "i2": (b"short", b"int16"),
        "u2": (b"ushort", b"uint16"),
        "i4": (b"int", b"int32"),
        "u4": (b"uint", b"uint32"),
        "f4": (b"float", b"float32"),
        "f8": (b"double", b"float64"),
    }.items()
    for name in names
}
# Of the whole numbers, which alone can be the length of a list.
_CODES = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I"}
# The order of the bytes of a number, none in a text.
ORDERS = {b"ascii": "", b"binary_little_endian": "<", b"binary_big_endian": ">"}
_END = re.compile(rb"^end_header[ \t]*(?:\r\n|\r|\n|\Z)", re.MULTILINE)
# Where lines end with a carriage return alone, they begin behind it.
_END_OF_MAC = re.compile(rb"\rend_header[ \t]*\r")


@dataclass(frozen=True)
class Property:
    """A number of an element, or a list of them with its length in front, of type `counted`."""

    name: bytes
    kind: str
    counted: str = ""


@dataclass
class Element:
    name: bytes
    count: int
    properties: list[Property] = field(default_factory=list)

    def index(self, name: bytes) -> int:
        """Where a property stands among the others, -1 if nowhere."""
        return next((i for i, one in enumerate(self.properties) if one.name == name), -1)

    @property
    def has_lists(self) -> bool:
        return any(one.counted for one in self.properties)


@dataclass
class Head:
    """The elements of a PLY in its order, which byte order its numbers have (none in a text), and
    the `end` of the head in bytes."""

    order: str
    end: int
    elements: list[Element]

    def count(self, name: bytes) -> int:
        """How many of an element are announced."""
        return sum(one.count for one in self.elements if one.name == name)


def read_head(head: bytes) -> Head:
    """What the first bytes of a PLY announce.

    Raises
    ------
    ValueError
        It is no head of a PLY; the text says why.
    """
    found = _END.search(head) or _END_OF_MAC.search(head)
    if not head.startswith(b"ply") or not found:
        raise ValueError("there is no head of a PLY that ends with end_header")
    order: str | None = None
    elements: list[Element] = []
    for line in head[: found.start()].splitlines()[1:]:
        words = line.split()
        match words:
            case [] | [b"comment" | b"obj_info", *_]:
                pass
            case [b"format", name, *_] if name in ORDERS:
                order = ORDERS[name]
            case [b"element", name, number] if number.isdigit():
                elements.append(Element(name, int(number)))
            case [b"property", b"list", counted, kind, name] if (
                elements and kind in TYPES and TYPES.get(counted) in _CODES
            ):
                elements[-1].properties.append(Property(name, TYPES[kind], TYPES[counted]))
            case [b"property", kind, name] if elements and kind in TYPES:
                elements[-1].properties.append(Property(name, TYPES[kind]))
            case _:
                text = line.decode("utf-8", "backslashreplace").strip()[:60]
                raise ValueError(f"there is a line in its head that is none of a PLY: {text!r}")
    if order is None:
        raise ValueError("its head does not say how it is written (format)")
    return Head(order, found.end(), elements)


def wrong_in(head: Head) -> str:
    """What of a surface a PLY does not have, in words, empty if nothing."""
    vertices = [one for one in head.elements if one.name == b"vertex"]
    if not vertices or min(map(vertices[0].index, AXES)) < 0:
        return "its head has no vertices with x, y and z"
    return ""


def size_of(path: Path, head: Head) -> int:
    """Bytes that a binary PLY has by what it announces; some number beyond its size where it ends
    before that."""
    data = path.read_bytes()
    place = head.end
    for element in head.elements:
        if place > len(data):
            break
        place = _behind(data, place, element, head.order)
    return place


def _behind(data: bytes, place: int, element: Element, order: str) -> int:
    """Where an element ends that begins at a place."""
    sizes = [np.dtype(one.kind).itemsize for one in element.properties]
    if not element.has_lists:
        return place + element.count * sum(sizes)
    counts = [
        struct.Struct(order + _CODES[one.counted]) if one.counted else None
        for one in element.properties
    ]
    row = _same_rows(data, place, element, order, sizes)
    if row:
        return place + element.count * row
    beyond = len(data) + 1
    for _ in range(element.count):
        for size, count in zip(sizes, counts, strict=True):
            if count is None:
                place += size
                continue
            if place + count.size > len(data):
                return beyond
            (number,) = count.unpack_from(data, place)
            if number < 0:
                return beyond
            place += count.size + number * size
        if place > len(data):
            return beyond
    return place


def _same_rows(
    data: bytes, place: int, element: Element, order: str, sizes: list[int]
) -> int:
    """Bytes of each row where the only list of an element is as long in all of them; else 0."""
    lists = [i for i, one in enumerate(element.properties) if one.counted]
    if len(lists) != 1 or not element.count:
        return 0
    at = lists[0]
    counted = np.dtype(order + element.properties[at].counted)
    first = place + sum(sizes[:at])
    if first + counted.itemsize > len(data):
        return 0
    number = int(np.frombuffer(data, counted, 1, first)[0])
    row = sum(sizes[:at]) + counted.itemsize + number * sizes[at] + sum(sizes[at + 1 :])
    if number < 0 or place + element.count * row > len(data):
        return 0
    same = np.ndarray((element.count,), counted, data, first, (row,))
    return row if (same == number).all() else 0
