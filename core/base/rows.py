"""Tables of numbers as bytes, and back again.

Bytes may come with a file from anywhere: how much they unfold to is known before anything is
unfolded, nothing in them says how they are to be read, and every value is looked at before it is
used.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
import struct
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

_MAGIC = b"umbilics"
# Magic, digest of the columns, bytes of the text, rows.
_HEADER = struct.Struct("<8s8sII")
# What may be unfolded: so much in any case, and so many times the packed bytes. A row holds a
# dozen numbers of noise, which hardly shrink, so that true tables stay below ten times.
_FREE, _FOLD = 1 << 24, 64
# The fastest level: numbers of noise do not shrink more for more work.
_LEVEL = 1
# Whole numbers up to here are floats too.
_WHOLE = 1 << 53


@dataclass(frozen=True)
class Column:
    """What one column of a table holds, row by row.

    Attributes
    ----------
    dtype:
        NumPy type of the values, in a fixed byte order.
    shape:
        Of one row; () for a number.
    low, high:
        Bounds of the values, themselves included.
    unknown:
        Whether NaN may stand for what is not known.
    """

    dtype: np.dtype
    shape: tuple[int, ...]
    low: float
    high: float
    unknown: bool

    @property
    def size(self) -> int:
        """Bytes of one row."""
        return self.dtype.itemsize * math.prod(self.shape)

    def allows(self, values: np.ndarray) -> bool:
        """Whether all values are in bounds; a bool is read as the byte behind it."""
        if not values.size:
            return True
        inside = (values >= self.low) & (values <= self.high)
        if self.unknown:
            inside |= np.isnan(values)
        return bool(inside.all())


def column(
    dtype: type,
    *shape: int,
    low: float | None = None,
    high: float | None = None,
    unknown: bool = False,
) -> dict[str, Column]:
    """Metadata of a field that is an array (k, *shape); numbers are finite by default."""
    kind = np.dtype(dtype).newbyteorder("<")
    limits: tuple[float, float] = 0, 1
    if kind.kind == "f":
        limits = float(np.finfo(kind).min), float(np.finfo(kind).max)
    elif kind.kind == "i":
        limits = int(np.iinfo(kind.str).min), int(np.iinfo(kind.str).max)
    low, high = (limits[0] if low is None else low), (limits[1] if high is None else high)
    return {"column": Column(kind, shape, low, high, unknown)}


def columns_of(table: type) -> dict[str, Column]:
    """The columns of a dataclass whose fields all have the metadata of `column`, by name."""
    return {item.name: item.metadata["column"] for item in dataclasses.fields(table)}


def encode(columns: Mapping[str, Column], arrays: Mapping[str, np.ndarray], text: Any) -> bytes:
    """Arrays (k, …) under the names of their columns, and what JSON can hold, as bytes."""
    words = json.dumps(text, default=float).encode()
    packer = zlib.compressobj(_LEVEL)
    parts = [packer.compress(words)]
    rows = len(next(iter(arrays.values())))
    for name, one in columns.items():
        values = np.ascontiguousarray(arrays[name], one.dtype)
        parts.append(packer.compress(values.reshape(-1).view(np.uint8).data))
    parts.append(packer.flush())
    return b"".join([_HEADER.pack(_MAGIC, _layout(columns), len(words), rows), *parts])


def decode(columns: Mapping[str, Column], data: bytes) -> tuple[Any, dict[str, np.ndarray]]:
    """What `encode` was given: the text, and the arrays by name.

    Raises
    ------
    ValueError
        The bytes are not a table of these columns, or a value is out of its bounds.
    """
    if len(data) < _HEADER.size:
        raise ValueError("too short")
    magic, layout, length, rows = _HEADER.unpack_from(data)
    if (magic, layout) != (_MAGIC, _layout(columns)):
        raise ValueError("of another version")
    whole = length + rows * sum(one.size for one in columns.values())
    if whole > max(_FREE, _FOLD * len(data)):
        raise ValueError("claims more than it can hold")
    unfolded = _unfold(data[_HEADER.size :], whole)
    try:
        text = json.loads(unfolded[:length])
    except (UnicodeDecodeError, RecursionError) as error:
        raise ValueError("not a text") from error
    arrays, start = {}, length
    for name, one in columns.items():
        end = start + rows * one.size
        kind = np.dtype(np.uint8) if one.dtype == np.dtype(bool) else one.dtype
        values = np.frombuffer(unfolded[start:end], kind).reshape(rows, *one.shape)
        if not one.allows(values):
            raise ValueError(f"{name} is out of bounds")
        arrays[name] = values.astype(one.dtype.newbyteorder("="))
        start = end
    return text, arrays


def is_number(value: Any, low: float = -math.inf, high: float = math.inf) -> bool:
    """Whether something read from a text is a number in bounds, or an unknown one (NaN)."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    if isinstance(value, int) and abs(value) > _WHOLE:
        return False
    return value != value or low <= value <= high


def _unfold(data: bytes, whole: int) -> bytes:
    unpacker = zlib.decompressobj()
    try:
        unfolded = unpacker.decompress(data, whole + 1)
    except zlib.error as error:
        raise ValueError(f"damaged ({error})") from error
    # What was asked for is there to the last byte, and the check sum at its end was right.
    if len(unfolded) != whole or not unpacker.eof or unpacker.unused_data:
        raise ValueError("of another length than it says")
    return unfolded


def _layout(columns: Mapping[str, Column]) -> bytes:
    """Eight bytes that differ where names, types or shapes do: a version that keeps itself."""
    layout = [(name, one.dtype.str, one.shape) for name, one in columns.items()]
    return hashlib.blake2b(repr(layout).encode(), digest_size=8).digest()
