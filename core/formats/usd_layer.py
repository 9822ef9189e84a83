"""What a USD file says of itself, in text (.usda), binary (.usdc) or a package (.usdz): the axis
that points up, and the files that it is made of.

Importers turn what has y up and do not say so, nor what they read besides. The binary format is
that of Pixar's crate files:
https://github.com/PixarAnimationStudios/OpenUSD/blob/release/pxr/usd/sdf/crateFile.h
"""

from __future__ import annotations

import contextlib
import re
import struct
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ..base.errors import FormatError

_CRATE = b"PXR-USDC"
_PACKAGE = b"PK"
# Of a value in the binary format: the number of the type "token", and that it stands in place.
_TOKEN, _INLINED = 11, 1 << 62
# What comes of reading bytes that mean nothing.
_DAMAGED = (
    *(struct.error, IndexError, KeyError, ValueError, OverflowError, RuntimeError),
    *(zipfile.BadZipFile, zlib.error),
)
# What USD takes where a file says nothing.
_USUAL = "Y"
# What stands between @ in the text of USD is an asset; three of them where it has one in its name.
_ASSET = re.compile(rb"@@@(.+?)@@@|@([^@\r\n]+)@")


def up_axis(path: Path | str) -> str:
    """ "Y" or "Z", by the outermost layer, which is the one that decides.

    Raises
    ------
    FormatError
        The file cannot be read, or is damaged.

    Examples
    --------
    >>> from pathlib import Path
    >>> layer = ("#usda 1.0", "(", '    upAxis = "Y"', ")", "")
    >>> _ = Path("up.usda").write_text(chr(10).join(layer))
    >>> core.up_axis("up.usda")
    'Y'
    """
    with _told(path) as data:
        if data.startswith(_PACKAGE):
            with zipfile.ZipFile(path) as package:
                data = package.read(package.namelist()[0])
        found = _in_crate(data) if data.startswith(_CRATE) else _in_text(data)
    return found if found in ("Y", "Z") else _USUAL


def usd_names(path: Path | str) -> list[str]:
    """Everything in a layer that may be the name of another file, as it stands there: layers,
    pictures, and in a binary layer each of its words. A package names none but its own.

    Raises
    ------
    FormatError
        The file cannot be read, or is damaged.

    Examples
    --------
    >>> from pathlib import Path
    >>> _ = Path("top.usda").write_text("#usda 1.0 (subLayers = [@./sub.usda@])")
    >>> core.usd_names("top.usda")
    ['./sub.usda']
    """
    with _told(path) as data:
        if data.startswith(_PACKAGE):
            return []
        if data.startswith(_CRATE):
            found = _tokens(_sections(data)[b"TOKENS"])
        else:
            found = [one[1] or one[2] for one in _ASSET.finditer(data)]
        return [name.decode("utf-8", "replace") for name in dict.fromkeys(found) if name]


@contextlib.contextmanager
def _told(path: Path | str) -> Iterator[bytes]:
    """What is in a file; what goes wrong with it is an error of the format."""
    try:
        with open(path, "rb") as file:
            data = file.read()
        yield data
    except OSError as error:
        raise FormatError(f"{path}: cannot be read ({error.strerror}).") from error
    except _DAMAGED as error:
        raise FormatError(f"{path}: is damaged; it cannot be read as USD.") from error


def _in_text(data: bytes) -> str:
    # The layer's own settings stand before its first prim.
    head = re.split(rb"^\s*(?:def|over|class)\b", data, maxsplit=1, flags=re.MULTILINE)[0]
    found = re.search(rb'^\s*upAxis\s*=\s*"(\w)"', head, re.MULTILINE)
    return found[1].decode() if found else _USUAL


def _sections(data: bytes) -> dict[bytes, bytes]:
    (table,) = struct.unpack_from("<q", data, 16)
    (count,) = struct.unpack_from("<Q", data, table)
    sections = {}
    for number in range(min(count, 64)):
        name, start, size = struct.unpack_from("<16sqq", data, table + 8 + 32 * number)
        sections[name.rstrip(b"\0")] = data[start : start + size]
    if data[8:11] < b"\0\4\0":
        raise ValueError("older than the compressed tables")
    return sections


def _in_crate(data: bytes) -> str:
    sections = _sections(data)
    tokens = _tokens(sections[b"TOKENS"])
    if b"upAxis" not in tokens:
        return _USUAL
    names, values = _fields(sections[b"FIELDS"])
    for value in values[names == tokens.index(b"upAxis")].tolist():
        if value & _INLINED and (value >> 48) & 0xFF == _TOKEN:
            return tokens[value & ((1 << 48) - 1)].decode()
    return _USUAL


def _tokens(section: bytes) -> list[bytes]:
    _, size, packed = struct.unpack_from("<QQQ", section)
    return _unpacked(section[24 : 24 + packed], size).split(b"\0")


def _fields(section: bytes) -> tuple[np.ndarray, np.ndarray]:
    """The token of each field's name, and the fields' values as they are stored, uint64."""
    (count,) = struct.unpack_from("<Q", section)
    (packed,) = struct.unpack_from("<Q", section, 8)
    # At most four bytes and a code for each number.
    names = _numbers(_unpacked(section[16 : 16 + packed], 4 + 5 * count + 1), count)
    start = 16 + packed
    (packed,) = struct.unpack_from("<Q", section, start)
    values = _unpacked(section[start + 8 : start + 8 + packed], 8 * count)
    return names, np.frombuffer(values, "<u8", count)


def _numbers(data: bytes, count: int) -> np.ndarray:
    """Numbers kept as differences of 0, 1, 2 or 4 bytes; without bytes the commonest one."""
    (common,) = struct.unpack_from("<i", data)
    codes = np.frombuffer(data, np.uint8, (2 * count + 7) // 8, 4)
    code = (codes[:, None] >> np.array([0, 2, 4, 6], np.uint8) & 3).ravel()[:count]
    width = np.array([0, 1, 2, 4])[code]
    place = 4 + len(codes) + np.cumsum(width) - width
    steps = np.full(count, common, np.int64)
    for bytes_each, kind in ((1, "<i1"), (2, "<i2"), (4, "<i4")):
        rows = np.flatnonzero(width == bytes_each)
        raw = np.frombuffer(data, np.uint8)[place[rows, None] + np.arange(bytes_each)]
        steps[rows] = np.ascontiguousarray(raw).view(kind).ravel()
    return np.cumsum(steps)


def _unpacked(data: bytes, size: int) -> bytes:
    """What LZ4 has packed into one block, or into several with their lengths before them."""
    pieces = data[0]
    if not pieces:
        return _block(data[1:], size)
    unpacked, place = b"", 1
    for _ in range(pieces):
        (length,) = struct.unpack_from("<i", data, place)
        unpacked += _block(data[place + 4 : place + 4 + length], size - len(unpacked))
        place += 4 + length
    return unpacked


def _block(data: bytes, size: int) -> bytes:
    """A block of LZ4: literal bytes and copies of what came before, in turn.

    https://github.com/lz4/lz4/blob/dev/doc/lz4_Block_format.md
    """
    found, place = bytearray(), 0
    while place < len(data):
        lengths = data[place]
        literal, place = _length(data, place + 1, lengths >> 4)
        found += data[place : place + literal]
        place += literal
        if place >= len(data):
            break
        (back,) = struct.unpack_from("<H", data, place)
        copied, place = _length(data, place + 2, lengths & 15)
        start = len(found) - back
        if not back or start < 0 or len(found) > size:
            raise ValueError("a copy of what is not there")
        # It may run into what it makes itself.
        piece = bytes(found[start:])
        repeated = piece * ((copied + 4) // len(piece) + 1)
        found += repeated[: copied + 4]
    return bytes(found)


def _length(data: bytes, place: int, length: int) -> tuple[int, int]:
    """A length that goes on in further bytes where its four bits are full, and what follows."""
    if length == 15:
        while data[place] == 255:
            length, place = length + 255, place + 1
        length, place = length + data[place], place + 1
    return length, place
