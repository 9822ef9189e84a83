"""What is kept of a detection in the file, so that it can be filtered again at any time.

The record is text in a property of the object: it comes back with undo, redo and reload by
itself. A second property, its stamp, is the digest of that text; what was read of a text is
remembered by it (`base.caches`). A text that is not the one of its stamp, or that holds anything
that cannot be, is refused as a whole: a file may come from anywhere.
"""

from __future__ import annotations

import base64
import hashlib
import struct
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from typing import Any

import bpy
import numpy as np

from ... import core
from ...core.base import rows
from ..base import caches
from ..mesh.fetch import unit_vectors
from ..mesh.fingerprint import Fingerprint
from ..mesh.read import MeshArrays

UNREADABLE = (
    "The results cannot be read: another version of this add-on made them, or the file is damaged."
)


@dataclass(frozen=True)
class Record:
    """A detection as it is kept; no value at a vertex or triangle is in it.

    Attributes
    ----------
    detection:
        Its candidates and numbers, see `core.unpack`; lengths and places are the world's.
    settings:
        The settings it was made with.
    given_names:
        Names of the attributes that given curvatures came from.
    fingerprint:
        Of all that was read of the object.
    matrix:
        (4, 4) float64 from the object's space to the world, then.
    corners:
        (k, 3) int32 vertices around each candidate.
    edge:
        (k,) float64 mean edge of the triangle of each candidate.
    extent:
        Largest side of the mesh's bounding box, in the world.
    """

    detection: core.Detection
    settings: core.Settings
    given_names: tuple[str, ...]
    fingerprint: Fingerprint
    matrix: np.ndarray
    corners: np.ndarray
    edge: np.ndarray
    extent: float

    @cached_property
    def kind_codes(self) -> np.ndarray:
        """(k,) int8 place of each candidate's kind in `core.KINDS`: names compare slowly."""
        codes = np.zeros(len(self.detection.candidates), np.int8)
        for code, kind in enumerate(core.KINDS):
            codes[self.detection.candidates.kind == kind] = code
        return codes

    @cached_property
    def numbers(self) -> np.ndarray:
        """(k,) the number of each candidate, see `core.numbers`."""
        return core.numbers(self.detection.candidates)

    @cached_property
    def top(self) -> float:
        """The largest finite persistence of the candidates; 0 without any."""
        values = self.detection.candidates.persistence
        return float(values[np.isfinite(values)].max(initial=0.0))

    @cached_property
    def automatic_level(self) -> float:
        """The persistence below which there are as many umbilics as the automatic choice drops.

        It judges each pair by its own noise, so that no one persistence parts what it drops from
        what it keeps; but from here a slider goes on without a jump in their number. It takes
        too long for every drawing of a panel, and is found once.
        """
        everything, chosen = (
            core.kept_rows(self.detection, core.Settings(persistence=level))
            for level in (0.0, core.AUTO)
        )
        dropped = len(everything) - len(chosen)
        values = np.sort(self.detection.candidates.persistence[everything])
        return float(np.nextafter(values[dropped - 1], np.inf)) if dropped else 0.0

    @cached_property
    def _order(self) -> np.ndarray:
        """(k,) rows of the candidates, the most persistent first, the unknown last."""
        persistence = self.detection.candidates.persistence
        return np.argsort(-np.where(np.isnan(persistence), -1.0, persistence), kind="stable")

    def most_persistent(self, rows: np.ndarray, count: int) -> np.ndarray:
        """At most `count` of the candidates `rows` (k,), in ascending order."""
        if len(rows) <= count:
            return rows
        chosen = np.zeros(len(self._order), bool)
        chosen[rows] = True
        return np.sort(self._order[chosen[self._order]][:count])


# Bytes that are put into words at a time, a multiple of three: in one piece a window beside it
# would stand still.
_PIECE = 3 << 18
_DIGEST = 16
_LENGTH = struct.Struct("<Q")


@dataclass(frozen=True)
class _Rows:
    """What the record keeps of each candidate beside the detection."""

    corners: np.ndarray = field(metadata=rows.column(np.int32, 3, low=0))
    edge: np.ndarray = field(metadata=rows.column(np.float32, low=0.0))


_COLUMNS = rows.columns_of(_Rows)


@dataclass(frozen=True)
class RecordText:
    """A record, the text that it becomes in the file, and the digest of that."""

    record: Record
    text: str
    stamp: str


def of_detection(arrays: MeshArrays, settings: core.Settings, detection: core.Detection) -> Record:
    """The record of a detection on these arrays, which still holds all of the detection.

    Its candidates' triangles are counted as Blender counts them, whatever part was analysed.
    """
    candidates = detection.candidates
    corners = arrays.triangles[candidates.triangle]
    candidates = replace(candidates, triangle=arrays.loop_triangle[candidates.triangle])
    places = arrays.vertices[corners]
    edge = np.linalg.norm(places - np.roll(places, 1, axis=1), axis=2).mean(axis=1)
    return Record(
        detection=replace(detection, candidates=candidates),
        settings=settings,
        given_names=arrays.given_names,
        fingerprint=arrays.fingerprint,
        matrix=arrays.matrix,
        corners=corners,
        # A mesh may be larger than single precision.
        edge=np.minimum(edge, np.finfo(np.float32).max),
        extent=_extent_of(arrays.vertices),
    )


def _extent_of(vertices: np.ndarray) -> float:
    """The largest side of the bounding box of (n, 3) vertices, as far as they are somewhere."""
    known = vertices[np.isfinite(vertices).all(axis=1)]
    return float(np.ptp(known, axis=0).max()) if len(known) else 0.0


def pack(arrays: MeshArrays, settings: core.Settings, detection: core.Detection) -> RecordText:
    """As `of_detection`, with the text for the file; touches arrays only, so that any thread may
    take its time over it."""
    made = of_detection(arrays, settings, detection)
    words = {
        "settings": asdict(made.settings),
        "given_names": made.given_names,
        "fingerprint": made.fingerprint.to_text(),
        "matrix": made.matrix.tolist(),
        "extent": made.extent,
    }
    beside = rows.encode(_COLUMNS, {"corners": made.corners, "edge": made.edge}, words)
    packed = b"".join([_LENGTH.pack(len(beside)), beside, core.pack(made.detection)])
    pieces = (packed[first : first + _PIECE] for first in range(0, len(packed), _PIECE))
    text = "".join(base64.b64encode(piece).decode("ascii") for piece in pieces)
    # As it will be read from the file, without the values at the vertices.
    return RecordText(_read(packed), text, _digest(text))


def store(obj: bpy.types.Object, packed: RecordText) -> None:
    """Put the record away with the object, in place of an earlier one."""
    obj.umbilics.record = packed.text
    obj.umbilics.stamp = packed.stamp
    caches.RECORDS.put(packed.stamp, packed.record)


def of(obj: bpy.types.Object | None) -> Record | None:
    """The object's record; None if it has none, or one that cannot be read (`UNREADABLE`)."""
    if obj is None or not obj.umbilics.detected:
        return None
    kept = obj.umbilics
    return caches.RECORDS.of(kept.stamp, lambda: _decode(kept.record, kept.stamp))


def movement(obj: bpy.types.Object, record: Record) -> np.ndarray:
    """(4, 4) from where the record's places are to where they are now."""
    return np.array(obj.matrix_world) @ np.linalg.inv(record.matrix)


def place_now(obj: bpy.types.Object, record: Record, row: int) -> tuple[np.ndarray, np.ndarray]:
    """(3,) position and (3,) unit normal of a candidate in the world as it is now."""
    moved = movement(obj, record)
    candidates = record.detection.candidates
    position = moved[:3, :3] @ candidates.position[row] + moved[:3, 3]
    # An object that is scaled to nothing has no way back: the normal stays as it was.
    normal = np.linalg.pinv(moved[:3, :3]).T @ candidates.normal[row]
    return position, unit_vectors(normal)


def _digest(text: str) -> str:
    return hashlib.blake2b(text.encode(), digest_size=_DIGEST).hexdigest()


def _decode(text: str, stamp: str) -> Record | None:
    """What a text in a file holds; None if anything is wrong with it."""
    try:
        if _digest(text) != stamp:
            return None
        return _read(base64.b64decode(text, validate=True))
    except ValueError:
        return None


def _read(packed: bytes) -> Record:
    """What `pack` has packed; ValueError if it has not."""
    if len(packed) < _LENGTH.size:
        raise ValueError("too short")
    start = _LENGTH.size
    end = start + _LENGTH.unpack_from(packed)[0]
    words, arrays = rows.decode(_COLUMNS, packed[start:end])
    detection = core.unpack(packed[end:])
    if len(arrays["edge"]) != len(detection.candidates):
        raise ValueError("the candidates are not as many as their corners")
    try:
        return Record(
            detection=detection,
            settings=core.Settings(**words["settings"]),
            given_names=_names(words["given_names"]),
            fingerprint=Fingerprint.from_text(words["fingerprint"]),
            matrix=_matrix(words["matrix"]),
            corners=arrays["corners"],
            edge=arrays["edge"].astype(float),
            extent=_extent(words["extent"]),
        )
    except (LookupError, TypeError, AttributeError, core.InvalidSettingsError) as error:
        raise ValueError("something is missing or of another kind") from error


def _names(found: Any) -> tuple[str, ...]:
    if not isinstance(found, list) or not all(isinstance(name, str) for name in found):
        raise ValueError("attributes have no names")
    return tuple(found)


def _matrix(found: Sequence[Sequence[float]]) -> np.ndarray:
    """(4, 4) a transform that can be undone."""
    matrix = np.array(found)
    if matrix.shape != (4, 4) or matrix.dtype.kind not in "if" or not np.isfinite(matrix).all():
        raise ValueError("a transform is no matrix")
    matrix = matrix.astype(np.float64)
    if (matrix[3] != (0.0, 0.0, 0.0, 1.0)).any():
        raise ValueError("a transform is not of a place")
    try:
        back = np.linalg.inv(matrix)
    except np.linalg.LinAlgError as error:
        raise ValueError("a transform cannot be undone") from error
    if not np.isfinite(back).all():
        raise ValueError("a transform cannot be undone")
    return matrix


def _extent(found: Any) -> float:
    if not rows.is_number(found, 0.0, np.finfo(float).max) or found != found:
        raise ValueError("a length is none")
    return float(found)
