"""Files that are torn, or not what their names say: told before an importer of Blender sees them.

Some importers read what is left of a torn file as if it were all, and some end Blender itself.
"""

from __future__ import annotations

import codecs
import os
import re
import stat
import struct
from collections.abc import Callable, Collection
from pathlib import Path
from typing import BinaryIO

import numpy as np

from ...base.errors import FileError
from .content import nowhere, pieces, ply, stl
from .guard import shown

_WIDE = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
# An Alembic file: its mark, whether it was closed, the version and where its root is. A group has
# the number of its parts and where they are, data the number of its bytes; places of data have the
# highest bit, and of nothing no other one. Blender has no reader for the older kind.
# https://github.com/alembic/alembic/tree/master/lib/Alembic/Ogawa
_ALEMBIC, _OLD_ALEMBIC, _CLOSED = b"Ogawa", b"\x89HDF\r\n\x1a\n", 0xFF
_ALEMBIC_HEAD = struct.Struct("<5sB2sQ")
_IS_DATA = np.uint64(1 << 63)
_NUMBER = np.dtype("<u8")
_STL_FACE = (b"endloop", b"ENDLOOP")
_OBJ_FACE = (b"\nf ", b"\nf\t", b"\rf ", b"\rf\t")
_OBJ_VERTEX = (b"\nv ", b"\nv\t", b"\rv ", b"\rv\t")
_OBJ_FACES, _OBJ_CORNER = re.compile(rb"[\r\n]f([ \t][^\r\n]*)"), re.compile(rb"[ \t](-?\d+)")
# The first vertex of an OBJ is 1.
_NO_VERTEX = re.compile(rb"[\r\n]f[^\r\n]*[ \t]0+(?![^/\s])")
_TORN = "It is torn: fetch or save it again"


def refusal(path: str, suffixes: Collection[str]) -> str:
    """Why a path can be no mesh file with one of these endings, whatever is in it; empty if it may
    be one."""
    try:
        status = os.stat(path)
    except (FileNotFoundError, NotADirectoryError):
        return "there is no such file"
    except OSError as error:
        return f"cannot be read ({error.strerror})"
    except ValueError as error:
        return f"cannot be read ({error})"
    if stat.S_ISDIR(status.st_mode):
        return "this is a folder, not a file; with --out DIR all meshes in it are taken"
    if not stat.S_ISREG(status.st_mode):
        return "this is not a file but a pipe, a socket or a device"
    if Path(path).suffix.lower() not in suffixes:
        return f"not a kind of file that can be read ({', '.join(suffixes)})"
    return "" if status.st_size else "the file is empty"


def check(path: Path) -> None:
    """See whether a file can be what its ending says and is whole, as far as that shows.

    Raises
    ------
    FileError
        It is not; the text says what shows that.
    """
    head = pieces.head_of(path)
    if head.startswith(_WIDE):
        raise FileError(f"{shown(path)}: is text in UTF-16; save it in UTF-8 or ASCII.")
    look = _LOOKS.get(path.suffix.lower())
    wrong = look(path, head) if look else ""
    if wrong:
        raise FileError(f"{shown(path)}: {wrong}.")


def doubts(path: Path, faces: int) -> list[str]:
    """Sentences on what is missing in what was read of a file: so many `faces`."""
    head = pieces.head_of(path)
    found = []
    if path.suffix.lower() == ".stl" and not stl.is_binary(path, head) and not _is_closed(path):
        found.append(
            "The file does not end with endsolid, as an STL in text does: it may have been cut "
            "off, and triangles may be missing."
        )
    if path.suffix.lower() == ".stl":
        found += _behind(path, stl.size_of_binary(head) if stl.is_binary(path, head) else None)
    if path.suffix.lower() == ".ply":
        announced = ply.read_head(head)
        found += _behind(path, ply.size_of(path, announced) if announced.order else None)
    if path.suffix.lower() == ".obj" and _is_obj_cut(path):
        found.append(
            "The file ends within a line, and vertices in it belong to no face: it may have been "
            "cut off, and faces may be missing."
        )
    found += _nowhere(path)
    named = _faces_named(path, head)
    if named > faces:
        found.append(
            f"{named - faces} of the {named} faces in the file were left out: they are damaged, "
            "stand there twice, or have fewer than three corners that are there."
        )
        if path.suffix.lower() == ".obj" and any(map(_NO_VERTEX.search, pieces.lines_of(path))):
            found.append(
                "Faces in the file name vertex 0, while OBJ counts from 1: all of them may name "
                "the wrong vertices."
            )
    return found


def why_unread(path: Path) -> str:
    """Why Blender may not read a file, where its importer does not say."""
    if path.suffix.lower() != ".ply":
        return "its importer does not say why; the file may be torn"
    elements = ply.read_head(pieces.head_of(path)).elements
    if any(one.name == b"vertex" and one.has_lists for one in elements):
        return "its vertices have lists; save it without them"
    return (
        "its importer does not say why; a face may have more corners than the 255 that it takes, "
        "or the file may be torn"
    )


def _in_numbers(path: Path, _: bytes) -> str:
    word = nowhere.word_in(path)
    if word is None:
        return ""
    if not word:
        return "a vertex has fewer than three numbers"
    text = shown(word[:40].decode("utf-8", "backslashreplace"))
    return f"a vertex has {text}, which is no number such as 1.5e-3"


def _nowhere(path: Path) -> list[str]:
    """What Blender puts somewhere else without a word."""
    count = nowhere.count(path)
    if not count:
        return []
    which = "1 vertex in the file is" if count == 1 else f"{count} vertices in the file are"
    return [
        f"{which} nowhere (not a number, infinite or too far away); Blender has them elsewhere, "
        "and what is around there is not the surface."
    ]


def _behind(path: Path, whole: int | None) -> list[str]:
    """What is behind the bytes that a file announces; None where it announces none."""
    if whole is None or path.stat().st_size <= whole:
        return []
    with open(path, "rb") as file:
        file.seek(whole)
        if not file.read(1 << 16).strip():
            return []
    return [
        f"{path.stat().st_size - whole} bytes behind the triangles that the file announces were "
        "left out: it may be damaged, and triangles may be missing."
    ]


def _is_obj_cut(path: Path) -> bool:
    """Whether an OBJ ends without a line end, and has vertices that none of its faces names."""
    if pieces.tail_of(path).endswith(b"\n"):
        return False
    vertices = _count(path, _OBJ_VERTEX)
    named = np.zeros(vertices + 1, bool)
    for text in pieces.lines_of(path):
        numbers = np.array(_OBJ_CORNER.findall(b" ".join(_OBJ_FACES.findall(text))), np.int64)
        # From the end of the list that there is so far: not followed.
        if (numbers < 0).any():
            return False
        named[numbers[numbers <= vertices]] = True
    return not named[1:].all()


def _stl(path: Path, head: bytes) -> str:
    if stl.is_binary(path, head):
        whole = stl.size_of_binary(head)
        if whole is None or whole > path.stat().st_size:
            return f"ends before all the triangles that it announces. {_TORN}"
        return ""
    if b"facet" not in head.lower():
        return "Blender cannot read it as STL: there are no triangles in it"
    _, _, rest = pieces.tail_of(path).rpartition(b"endfacet")
    if b"facet" in rest:
        return f"ends within a triangle. {_TORN}"
    return _in_numbers(path, head)


def _is_closed(path: Path) -> bool:
    """Whether the last solid in an STL in text is closed."""
    lines = [line.strip() for line in pieces.tail_of(path).split(b"\n")]
    solids = [line for line in lines if line.startswith((b"solid", b"endsolid"))]
    return bool(solids) and solids[-1].startswith(b"endsolid")


def _ply(path: Path, head: bytes) -> str:
    try:
        announced = ply.read_head(head)
    except ValueError as error:
        return str(error)
    # Each takes a byte at least.
    least = sum(element.count for element in announced.elements)
    if least > path.stat().st_size:
        return f"ends before all the elements that its head announces. {_TORN}"
    if wrong := ply.wrong_in(announced):
        return wrong
    if announced.order and ply.size_of(path, announced) > path.stat().st_size:
        return f"ends before all the elements that its head announces. {_TORN}"
    return _in_numbers(path, head)


def _faces_named(path: Path, head: bytes) -> int:
    """Faces that are in a file before it is read, as far as that is known; else 0."""
    kind = path.suffix.lower()
    if kind == ".obj":
        return _count(path, _OBJ_FACE)
    if kind == ".ply":
        return ply.read_head(head).count(b"face")
    if kind != ".stl":
        return 0
    if stl.is_binary(path, head):
        return stl.count_of_binary(head)
    return _count(path, _STL_FACE)


def _count(path: Path, words: tuple[bytes, ...]) -> int:
    """How often words of one length are in a file."""
    found, last = 0, b"\n"
    with open(path, "rb") as file:
        while piece := file.read(pieces.SIZE):
            piece = last + piece
            found += sum(map(piece.count, words))
            # Too short to be counted again.
            last = piece[1 - len(words[0]) :]
    return found


def _alembic(path: Path, head: bytes) -> str:
    if head.startswith(_OLD_ALEMBIC):
        return "is Alembic of the older kind (HDF5), which Blender cannot read; save it as Ogawa"
    if not head.startswith(_ALEMBIC) or len(head) < _ALEMBIC_HEAD.size:
        return "is not an Alembic file"
    _, closed, _, root = _ALEMBIC_HEAD.unpack_from(head)
    if closed != _CLOSED:
        return f"was never closed by the program that wrote it. {_TORN}"
    return "" if _alembic_is_whole(path, root) else f"ends before all that it announces. {_TORN}"


def _alembic_is_whole(path: Path, root: int) -> bool:
    """Whether all groups and data that a file names are in it."""
    with open(path, "rb") as file:
        size = os.fstat(file.fileno()).st_size
        waiting, seen, used = [root], {0}, 0
        while waiting:
            place = waiting.pop()
            if place in seen:
                continue
            seen.add(place)
            (count,) = _numbers(file, place, 1) or (size,)
            # No two groups share bytes, so that all of them together are no longer than the file.
            used += count
            if count > (size - place - 8) // 8 or 8 * used > size:
                return False
            named = _numbers(file, place + 8, count)
            if len(named) < count:
                return False
            parts = np.array(named, _NUMBER)
            is_data = parts >= _IS_DATA
            waiting += parts[~is_data].tolist()
            places = parts[is_data] ^ _IS_DATA
            # In the order of the file, most of them lie in what has been read already.
            for place in np.unique(places[places > 0]).tolist():
                (length,) = _numbers(file, place, 1) or (size,)
                if length > size - place - 8:
                    return False
    return True


def _numbers(file: BinaryIO, place: int, count: int) -> list[int]:
    """Numbers of eight bytes that stand in a file, as many as are there."""
    try:
        file.seek(place)
    except (OSError, OverflowError, ValueError):
        return []
    data = file.read(8 * count)
    return np.frombuffer(data[: len(data) // 8 * 8], _NUMBER).tolist()


_LOOKS: dict[str, Callable[[Path, bytes], str]] = {
    ".obj": _in_numbers,
    ".stl": _stl,
    ".ply": _ply,
    ".abc": _alembic,
}
