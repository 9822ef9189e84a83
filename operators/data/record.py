"""What is kept of a detection in the file, so that it can be filtered again at any time.

The record is text in a property of the object: it comes back with undo, redo and reload by
itself. Only the decoded form is kept in memory, by the stamp of its detection.
"""

from __future__ import annotations

import base64
import io
import json
import uuid
from dataclasses import asdict, dataclass
from functools import cached_property

import bpy
import numpy as np

from ... import core
from ..mesh.read import MeshArrays


@dataclass(frozen=True)
class Record:
    """A detection as it is kept; no value at a vertex or triangle is in it.

    Attributes
    ----------
    detection:
        Its candidates and numbers, see `core.unpack`; lengths and places are the world's.
    settings:
        The settings it was made with, by name.
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
    settings: dict
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


# By stamp. A record never changes, so that undo and copies of an object need no care.
_decoded: dict[str, Record | None] = {}
_MOST = 64
# Bytes that are put into words at a time, a multiple of three: in one piece a window beside it
# would stand still.
_PIECE = 3 << 18


@dataclass(frozen=True)
class Packed:
    """A record and the text that it becomes in the file."""

    record: Record
    text: str


def pack(arrays: MeshArrays, settings: core.Settings, detection: core.Detection) -> Packed:
    """The record of a detection on these arrays; touches arrays only, so that any thread may
    take its time over it."""
    corners = arrays.triangles[detection.candidates.triangle]
    places = arrays.vertices[corners]
    edge = np.linalg.norm(places - np.roll(places, 1, axis=1), axis=2).mean(axis=1)
    target = io.BytesIO()
    np.savez(
        target,
        detection=np.frombuffer(core.pack(detection), np.uint8),
        settings=np.array(json.dumps(asdict(settings))),
        matrix=arrays.matrix,
        corners=corners,
        edge=edge.astype(np.float32),
        extent=float(np.ptp(arrays.vertices, axis=0).max()),
    )
    packed = target.getvalue()
    pieces = (packed[first : first + _PIECE] for first in range(0, len(packed), _PIECE))
    text = "".join(base64.b64encode(piece).decode("ascii") for piece in pieces)
    # As it will be read from the file, without the values at the vertices.
    return Packed(_read(packed), text)


def store(obj: bpy.types.Object, packed: Packed) -> None:
    """Put the record away with the object, in place of an earlier one."""
    obj.umbilics.record = packed.text
    obj.umbilics.stamp = uuid.uuid4().hex
    _remember(obj.umbilics.stamp, packed.record)


def of(obj: bpy.types.Object | None) -> Record | None:
    """The object's record; None if it has none, or one that another version wrote."""
    if obj is None or not obj.umbilics.detected:
        return None
    stamp = obj.umbilics.stamp
    if stamp not in _decoded:
        _remember(stamp, _decode(obj.umbilics.record))
    return _decoded[stamp]


def movement(obj: bpy.types.Object, record: Record) -> np.ndarray:
    """(4, 4) from where the record's places are to where they are now."""
    return np.array(obj.matrix_world) @ np.linalg.inv(record.matrix)


def place_now(obj: bpy.types.Object, record: Record, row: int) -> tuple[np.ndarray, np.ndarray]:
    """(3,) position and (3,) unit normal of a candidate in the world as it is now."""
    moved = movement(obj, record)
    candidates = record.detection.candidates
    position = moved[:3, :3] @ candidates.position[row] + moved[:3, 3]
    normal = np.linalg.inv(moved[:3, :3]).T @ candidates.normal[row]
    return position, normal / max(np.linalg.norm(normal), 1e-30)


def _remember(stamp: str, record: Record | None) -> None:
    if len(_decoded) >= _MOST:
        _decoded.clear()
    _decoded[stamp] = record


def _decode(text: str) -> Record | None:
    try:
        return _read(base64.b64decode(text))
    except ValueError:
        return None


def _read(packed: bytes) -> Record | None:
    try:
        with np.load(io.BytesIO(packed), allow_pickle=False) as found:
            return Record(
                detection=core.unpack(found["detection"].tobytes()),
                settings=json.loads(str(found["settings"])),
                matrix=found["matrix"],
                corners=found["corners"],
                edge=found["edge"].astype(float),
                extent=float(found["extent"]),
            )
    except (ValueError, LookupError, OSError, EOFError):
        return None
