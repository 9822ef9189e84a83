"""Files that are torn, or not what their names say: told before an importer of Blender sees them.

Some importers read what is left of a torn file as if it were all, and some end Blender itself.
"""

from __future__ import annotations

import codecs
import os
import re
import stat
import struct
from collections.abc import Callable, Collection, Iterator
from pathlib import Path
from typing import BinaryIO

import numpy as np

from ...base.errors import FileError
from .guard import shown

# Bytes that tell how a file is written, and that hold its last triangle.
_SOME = 1 << 16
# Bytes that are searched at a time.
_PIECE = 1 << 22
_WIDE = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
# A binary STL: a title, the number of triangles, and so many bytes for each.
_STL_TITLE, _STL_TRIANGLE = 80, 50
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
# A vertex of an OBJ whose numbers are not all plain ones; a number, which may be none; what most
# lines are made of, and letters and an exponent that no vertex has where all is well: looked for
# first, as that is faster than to go through all lines.
_PLAIN = rb"[-+.\d]+(?:[eE]-\d+|[eE]\+?0*[0-2]?\d)?"
_OBJ_VERTEX = re.compile(
    rb"(?:^|[\r\n])[ \t]*v[ \t]+(?!%b[ \t]+%b[ \t]+%b(?!\S))(\S+)[ \t]+(\S+)[ \t]+(\S+)"
    % (_PLAIN, _PLAIN, _PLAIN)
)
_NUMBER_IN_TEXT = re.compile(
    rb"[+-]?(?:(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|nan(?:\([^)]*\))?|inf(?:inity)?)", re.IGNORECASE
)
_USUAL = b"0123456789.+-/vntf \t\r\n"
_ODD = re.compile(rb"[,aid]", re.IGNORECASE)
_FAR = re.compile(rb"[eE]\+?0*(?:3[89]|[4-9]\d|[1-9]\d\d)")
_FARTHEST = float(np.finfo(np.float32).max)
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
        return "this is a folder, not a file"
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
    head = _head(path)
    if head.startswith(_WIDE):
        raise FileError(f"{shown(path)}: is text in UTF-16; save it in UTF-8 or ASCII.")
    look = _LOOKS.get(path.suffix.lower())
    wrong = look(path, head) if look else ""
    if wrong:
        raise FileError(f"{shown(path)}: {wrong}.")


def doubts(path: Path, faces: int) -> list[str]:
    """Sentences on what is missing in what was read of a file: so many `faces`."""
    head = _head(path)
    found = []
    if path.suffix.lower() == ".stl" and not is_binary_stl(path, head) and not _is_closed(path):
        found.append(
            "The file does not end with endsolid, as an STL in text does: it may have been cut "
            "off, and triangles may be missing."
        )
    if path.suffix.lower() == ".stl":
        found += _behind_stl(path, head)
    if path.suffix.lower() == ".obj":
        found += _nowhere_in_obj(path)
    named = _faces_named(path, head)
    if named > faces:
        found.append(
            f"{named - faces} of the {named} faces in the file were left out: they are damaged, "
            "stand there twice, or have fewer than three corners that are there."
        )
        if path.suffix.lower() == ".obj" and any(map(_NO_VERTEX.search, lines_of(path))):
            found.append(
                "Faces in the file name vertex 0, while OBJ counts from 1: all of them may name "
                "the wrong vertices."
            )
    return found


def lines_of(path: Path) -> Iterator[bytes]:
    """A text in pieces of whole lines, each with the line end before it; where there are none, no
    more than a beginning. Mapped into memory instead, a file that somebody cuts short meanwhile
    would end Blender."""
    rest = b""
    with open(path, "rb") as file:
        while piece := file.read(_PIECE):
            cut = max(piece.rfind(b"\n"), piece.rfind(b"\r"))
            if cut >= 0:
                yield rest + piece[:cut]
                rest = piece[cut:]
            elif len(rest) < _PIECE:
                rest += piece
    yield rest


def why_unread(path: Path) -> str:
    """Why Blender may not read a file, where its importer does not say."""
    if path.suffix.lower() != ".ply":
        return "its importer does not say why; the file may be torn"
    head = _head(path)
    elements = head[: max(head.find(b"end_header"), 0)].split(b"element ")
    if any(one.startswith(b"vertex ") and b"property list" in one for one in elements):
        return "its vertices have lists; save it without them"
    return (
        "its importer does not say why; a face may have more corners than the 255 that it takes, "
        "or the file may be torn"
    )


def _obj(path: Path, _: bytes) -> str:
    for place in _odd_places(path):
        for word in place:
            if not _NUMBER_IN_TEXT.fullmatch(word):
                text = word[:40].decode("utf-8", "backslashreplace")
                return f"a vertex has {shown(text)}, which is no number such as 1.5e-3"
    return ""


def _odd_places(path: Path) -> Iterator[tuple[bytes, ...]]:
    """Places of vertices in an OBJ whose numbers are not all plain ones."""
    for text in lines_of(path):
        rest = text.translate(None, _USUAL)
        if _ODD.search(rest) or (b"e" in rest.lower() and _FAR.search(text)):
            yield from (found.groups() for found in _OBJ_VERTEX.finditer(text))


def _nowhere_in_obj(path: Path) -> list[str]:
    """What Blender puts somewhere else without a word."""
    count = sum(not all(map(_is_in_reach, place)) for place in _odd_places(path))
    if not count:
        return []
    which = "1 vertex in the file is" if count == 1 else f"{count} vertices in the file are"
    return [
        f"{which} nowhere (not a number, infinite or too far away); Blender has them elsewhere, "
        "and what is around there is not the surface."
    ]


def _is_in_reach(word: bytes) -> bool:
    """Whether a number of a text has a place in single precision."""
    try:
        return abs(float(word)) <= _FARTHEST
    except ValueError:
        return False


def _behind_stl(path: Path, head: bytes) -> list[str]:
    whole, size = size_of_binary_stl(head), path.stat().st_size
    if not is_binary_stl(path, head) or whole is None or size <= whole:
        return []
    return [
        f"{size - whole} bytes behind the triangles that the file announces were left out: it may "
        "be damaged, and triangles may be missing."
    ]


def size_of_binary_stl(head: bytes) -> int | None:
    """Bytes that a binary STL has by its number of triangles."""
    if len(head) < _STL_TITLE + 4:
        return None
    (count,) = struct.unpack_from("<I", head, _STL_TITLE)
    return _STL_TITLE + 4 + _STL_TRIANGLE * count


def is_binary_stl(path: Path, head: bytes) -> bool:
    """Whether an STL is none in text, by its length or what no text holds."""
    return size_of_binary_stl(head) == path.stat().st_size or b"\0" in head


def _stl(path: Path, head: bytes) -> str:
    if is_binary_stl(path, head):
        whole = size_of_binary_stl(head)
        if whole is None or whole > path.stat().st_size:
            return f"ends before all the triangles that it announces. {_TORN}"
        return ""
    if b"facet" not in head.lower():
        return "Blender cannot read it as STL: there are no triangles in it"
    _, _, rest = _tail(path).rpartition(b"endfacet")
    return f"ends within a triangle. {_TORN}" if b"facet" in rest else ""


def _is_closed(path: Path) -> bool:
    """Whether the last solid in an STL in text is closed."""
    lines = [line.strip() for line in _tail(path).split(b"\n")]
    solids = [line for line in lines if line.startswith((b"solid", b"endsolid"))]
    return bool(solids) and solids[-1].startswith(b"endsolid")


def _ply(path: Path, head: bytes) -> str:
    # Each takes a byte at least.
    if _count_of_ply(head, rb"\S+") > path.stat().st_size:
        return f"ends before all the elements that its head announces. {_TORN}"
    return ""


def _count_of_ply(head: bytes, element: bytes) -> int:
    """Elements of that name that a PLY announces."""
    end = max(head.find(b"end_header"), 0)
    line = rb"^\s*element\s+" + element + rb"\s+(\d+)\s*$"
    return sum(map(int, re.findall(line, head[:end], re.MULTILINE)))


def _faces_named(path: Path, head: bytes) -> int:
    """Faces that are in a file before it is read, as far as that is known; else 0."""
    kind = path.suffix.lower()
    if kind == ".obj":
        return _count(path, _OBJ_FACE)
    if kind == ".ply":
        return _count_of_ply(head, b"face")
    if kind != ".stl":
        return 0
    if is_binary_stl(path, head):
        return struct.unpack_from("<I", head, _STL_TITLE)[0]
    return _count(path, _STL_FACE)


def _count(path: Path, words: tuple[bytes, ...]) -> int:
    """How often words of one length are in a file."""
    found, last = 0, b"\n"
    with open(path, "rb") as file:
        while piece := file.read(_PIECE):
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
    ".obj": _obj,
    ".stl": _stl,
    ".ply": _ply,
    ".abc": _alembic,
}


def _head(path: Path) -> bytes:
    with open(path, "rb") as file:
        return file.read(_SOME)


def _tail(path: Path) -> bytes:
    """The last bytes of a text, in small letters with one kind of line ends."""
    with open(path, "rb") as file:
        file.seek(-min(_SOME, path.stat().st_size), os.SEEK_END)
        return file.read().lower().replace(b"\r", b"\n")
