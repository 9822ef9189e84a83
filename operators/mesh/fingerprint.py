"""What was read of an object, as a digest of each part: whether it is still the same, and if
not, which part changed.

A digest is BLAKE2b (Aumasson, Neves, Wilcox-O'Hearn, Winnerlein 2013, RFC 7693) of the part's
values as Blender keeps them: no two meshes that differ are taken for the same.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import bpy
import numpy as np

from ... import core
from .edge_marks import marked_edges
from .fetch import LAYOUT, fetch

POSITIONS, FACES, SHARP, SEAMS = "positions", "faces", "sharp", "seams"
UV, GIVEN, SCOPE, ZONE, SCALE = "uv", "given", "scope", "zone", "scale"
# What the user reads when a part is another one.
WORDS = {
    POSITIONS: "The mesh was edited or deformed: vertices were moved.",
    FACES: "The mesh was edited: its vertices or faces are others.",
    SHARP: "Edges were marked sharp, or no longer are.",
    SEAMS: "Seams were marked or removed.",
    UV: "The UV map was changed.",
    GIVEN: "The given curvatures were changed.",
    SCOPE: "Other faces are in the scope.",
    ZONE: "The vertex group that poles avoid was changed.",
    SCALE: "The object was scaled.",
}
# The parts without which nothing can be read at the places where it was written.
GEOMETRY = (POSITIONS, FACES)

# Two transforms give the same curvatures if lengths agree to this part.
_SAME_SCALE = 1e-4
_BYTES = 16


@dataclass(frozen=True)
class Fingerprint:
    """What was read of an object.

    Attributes
    ----------
    digests:
        A digest for each part that was read, by the names above.
    metric:
        The six numbers of the symmetric M^T M of the object's transform M: the transform up to
        rigid movements and mirrors, which change no curvature.
    """

    digests: dict[str, str]
    metric: tuple[float, ...]

    def changed(self, now: Fingerprint, parts: Collection[str]) -> list[str]:
        """Which of the parts are others now; one that was not read here counts as another."""
        found = [
            part
            for part in parts
            if part != SCALE
            and (part not in self.digests or self.digests[part] != now.digests.get(part))
        ]
        if SCALE in parts and not _same_metric(now.metric, self.metric):
            found.append(SCALE)
        return found

    def plus(self, part: str, values: np.ndarray | None) -> Fingerprint:
        """With one part more: `SCOPE`, faces (p,) bool, or `ZONE`, vertices (n,) bool."""
        return Fingerprint(self.digests | {part: digest(values)}, self.metric)

    def to_text(self) -> str:
        return json.dumps([self.digests, self.metric])

    @classmethod
    def from_text(cls, text: str) -> Fingerprint:
        """What `to_text` has written; of any other text one that equals none."""
        try:
            digests, metric = json.loads(text)
            metric = tuple(float(value) for value in metric)
            well_formed = isinstance(digests, dict) and len(metric) == 6
        except (ValueError, TypeError, OverflowError, RecursionError):
            well_formed = False
        return cls(digests, metric) if well_formed else cls({}, (np.nan,) * 6)


def digest(*arrays: np.ndarray | None) -> str:
    """Of arrays with their shapes and types; None is another value than an empty array."""
    found = hashlib.blake2b(digest_size=_BYTES)
    for values in arrays:
        if values is None:
            found.update(b"none")
            continue
        values = np.ascontiguousarray(values)
        found.update(f"{values.dtype.str}{values.shape}".encode())
        # A flat view of bytes: hashing takes no other shapes.
        found.update(values.reshape(-1).view(np.uint8).data if values.size else b"")
    return found.hexdigest()


def of_mesh(
    mesh: bpy.types.Mesh,
    matrix: np.ndarray,
    with_uv: bool = False,
    given_names: Sequence[str] = (),
) -> Fingerprint:
    """Of a mesh that is not in Edit Mode, under a transform (4, 4).

    `with_uv` and `given_names`, the names of vertex attributes, say what is read besides places,
    faces and marks.
    """
    seams, sharp = marked_edges(mesh)
    digests = {
        POSITIONS: digest(_attribute(mesh, "position")),
        FACES: digest(*_faces(mesh)),
        SEAMS: digest(seams),
        SHARP: digest(sharp),
    }
    if with_uv:
        layer = mesh.uv_layers.active
        digests[UV] = digest(None if layer is None else fetch(layer.uv, "vector", 2, np.float32))
    if given_names:
        digests[GIVEN] = digest(*(_attribute(mesh, name) for name in given_names))
    return Fingerprint(digests, metric_of(matrix))


def metric_of(matrix: np.ndarray) -> tuple[float, ...]:
    """The six numbers of M^T M of a transform (4, 4)."""
    linear = np.asarray(matrix, float)[:3, :3]
    return tuple((linear.T @ linear)[np.triu_indices(3)].tolist())


def read_by(settings: core.Settings, all_methods: bool = False) -> tuple[str, ...]:
    """The parts that a detection with these settings reads; `all_methods`: or a comparison."""
    parts = [POSITIONS, FACES, SCALE]
    if settings.curvature == "given":
        parts.append(GIVEN)
    elif settings.crease_marks:
        parts.append(SHARP)
    if settings.unfolds or all_methods:
        parts.append(SEAMS if settings.charts in ("automatic", "seams") else UV)
    if settings.method == "S" and settings.parametrization == "uv" and UV not in parts:
        parts.append(UV)
    return tuple(parts)


def mesh_signature(mesh: bpy.types.Mesh) -> str:
    """Digests of the places and, behind a dash, of the faces of a mesh not in Edit Mode."""
    return f"{digest(_attribute(mesh, 'position'))}-{digest(*_faces(mesh))}"


def _faces(mesh: bpy.types.Mesh) -> list[np.ndarray | None]:
    """What tells the faces: the number of vertices, all corners, and how many each face has."""
    corners = _attribute(mesh, ".corner_vert")
    found = [np.array([len(mesh.vertices), len(mesh.polygons)]), corners]
    if corners is not None and len(corners) != 3 * len(mesh.polygons):
        found.append(fetch(mesh.polygons, "loop_total", 1, np.int32))
    return found


def _attribute(mesh: bpy.types.Mesh, name: str) -> np.ndarray | None:
    """An attribute's values, if it is there and of a type that is read."""
    found = mesh.attributes.get(name) if name else None
    if found is None or found.data_type not in LAYOUT:
        return None
    width, dtype, key, _ = LAYOUT[found.data_type]
    return fetch(found.data, key, width, dtype)


def _same_metric(now: Sequence[float], then: Sequence[float]) -> bool:
    size = np.abs(then).max()
    if not np.isfinite(size):
        return False
    return bool(np.allclose(now, then, rtol=_SAME_SCALE, atol=_SAME_SCALE * size))
