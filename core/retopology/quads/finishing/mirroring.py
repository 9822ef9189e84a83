"""Exactly symmetric quads: one half is remeshed with the plane for a border, and mirrored."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from ....base.errors import GuidanceError, RemeshError
from ....base.progress import Progress
from ....base.subsets import places_in
from ....matching.mirror import find_mirror_plane
from ....mesh.surface import Surface
from ....umbilics.result import Detection, Umbilics
from ..conformity import conformity
from ..result import QuadMesh
from ..surface.subdivision import Triangles, chosen, pieces, split_edges, taken_apart

# Vertices nearer to the plane than this part of a typical edge are put on it.
NEAR = 0.02
# A vertex of the result lies on the plane within this part of the size of the surface.
ON = 1e-7
# A mirrored pole belongs to an umbilic within so many lengths of quads of the image of its own.
CLAIM = 4.0


@dataclass(frozen=True)
class Plane:
    """Points x with normal . x = offset, in the coordinates of the input; the half on the side
    that the unit normal (3,) points to is kept."""

    normal: np.ndarray
    offset: float

    def height(self, points: np.ndarray) -> np.ndarray:
        """(p,) signed distances of points (p, 3)."""
        return points @ self.normal - self.offset

    def reflected(self, points: np.ndarray) -> np.ndarray:
        """(p, 3) mirror images of points (p, 3)."""
        return points - 2.0 * self.height(points)[:, None] * self.normal


def wanted_plane(
    symmetry: str, whole: Surface, detection: Detection, warnings: list[str]
) -> Plane | None:
    """The plane that is asked for; None, with a warning, where the surface has none."""
    if symmetry == "none":
        return None
    if symmetry != "auto":
        return Plane(np.eye(3)["xyz".index(symmetry)], 0.0)
    try:
        found = find_mirror_plane(
            whole.vertices * whole.unit + whole.origin,
            whole.face_normal_area,
            whole.triangles,
            detection.umbilics,
            Progress(),
        )
    except GuidanceError as error:
        warnings.append(f"Not mirrored: {error}")
        return None
    normal = found.normal / np.linalg.norm(found.normal)
    return Plane(normal, float(found.point @ normal))


def halved(mesh: Triangles, normal: np.ndarray, offset: float) -> Triangles:
    """What of a mesh lies where normal . x > offset, cut at the plane; new borders lie on it.

    Raises
    ------
    RemeshError
        Nothing does.
    """
    height = mesh.vertices @ normal - offset
    near = np.abs(height) < NEAR * float(np.median(mesh.lengths))
    height[near] = 0.0
    vertices = mesh.vertices.copy()
    vertices[near] -= (vertices[near] @ normal - offset)[:, None] * normal
    mesh = replace(mesh, vertices=vertices)
    tail, head = mesh.ends
    crossing = height[tail] * height[head] < 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(crossing, height[tail] / (height[tail] - height[head]), 0.5)
    mesh = split_edges(mesh, crossing, share)
    height = np.concatenate([height, np.zeros(len(mesh.vertices) - len(height))])
    vertices = mesh.vertices.copy()
    flat = height == 0.0
    vertices[flat] -= (vertices[flat] @ normal - offset)[:, None] * normal
    mesh = replace(mesh, vertices=vertices)
    high = height[mesh.triangles]
    kept = np.flatnonzero((high >= 0.0).all(axis=1) & (high > 0.0).any(axis=1))
    if not len(kept):
        raise RemeshError(
            "Nothing of the mesh lies on the positive side of the symmetry plane. Move its "
            "origin, or choose another plane."
        )
    # What touches the plane in a vertex only may be two fans there, or two pieces.
    half = taken_apart(chosen(mesh, kept))
    # Where the plane was a crease it is a border now.
    tail, head = half.ends
    inside = np.abs(half.vertices @ normal - offset) < 1e-12
    return replace(half, feature=np.where(inside[tail] & inside[head], np.int8(0), half.feature))


def lost(mesh: Triangles, normal: np.ndarray, offset: float, size: float) -> int:
    """How many pieces of a mesh lie beyond the plane, where normal . x <= offset, and have no image
    on the side that is kept: none that reaches as far everywhere, but for the length of a quad."""
    here, beyond = [], []
    for piece in pieces(mesh):
        place = piece.vertices[np.unique(piece.triangles)]
        height = place @ normal - offset
        # What crosses the plane is no image of a piece that does not.
        if height.max() <= 0.0:
            image = place - 2.0 * height[:, None] * normal
            beyond.append([image.min(axis=0), image.max(axis=0)])
        elif height.min() >= 0.0:
            here.append([place.min(axis=0), place.max(axis=0)])
    if not here or not beyond:
        return len(beyond)
    off, _ = cKDTree(np.reshape(here, (-1, 6))).query(np.reshape(beyond, (-1, 6)), p=np.inf)
    return int(np.count_nonzero(off > size))


def mirrored(half: QuadMesh, plane: Plane, umbilics: Umbilics, size: float) -> QuadMesh:
    """A half and its image, joined along the plane."""
    vertices, n = half.vertices.copy(), len(half.vertices)
    on = half.border & (np.abs(plane.height(vertices)) <= ON * np.ptp(vertices, axis=0).max())
    vertices[on] -= plane.height(vertices[on])[:, None] * plane.normal
    off = np.flatnonzero(~on)
    image = np.arange(n)
    image[off] = n + np.arange(len(off))
    quads = np.concatenate([half.quads, image[half.quads][:, ::-1]])
    vertices = np.concatenate([vertices, plane.reflected(vertices[off])])
    topology = conformity(quads, len(vertices))
    irregular = topology.irregular
    # Where each pole comes from: from the half, from its image, or from the plane.
    origin = np.where(irregular < n, irregular, off[np.maximum(irregular - n, 0)])
    of = half.pole[origin]
    known = of >= 0
    umbilic = np.full(len(irregular), -1)
    umbilic[known] = half.pole_umbilic[of[known]]
    confidence = np.full(len(irregular), 0.5)
    confidence[known] = half.pole_confidence[of[known]]
    there = irregular >= n
    umbilic[there] = _images(umbilic[there], plane, umbilics, size)

    def twice(values: np.ndarray) -> np.ndarray:
        return np.concatenate([values, values[off]])

    return replace(
        half,
        vertices=vertices,
        quads=quads,
        pole=places_in(irregular, len(vertices)),
        pole_valence=topology.valence[irregular],
        pole_umbilic=umbilic,
        pole_confidence=confidence,
        border=topology.border,
        feature=twice(half.feature) & ~topology.border,
        patch=np.concatenate([half.patch, half.patch + int(half.patch.max()) + 1]),
        angle=np.concatenate([half.angle, half.angle]),
        source_triangle=twice(half.source_triangle),
    )


def _images(rows: np.ndarray, plane: Plane, umbilics: Umbilics, size: float) -> np.ndarray:
    """The umbilics nearest to the images of those in `rows`, -1 where none is near."""
    result = np.full(len(rows), -1)
    known = np.flatnonzero(rows >= 0)
    if len(known) and len(umbilics):
        images = plane.reflected(umbilics.position[rows[known]])
        distance, near = cKDTree(umbilics.position).query(images)
        same = umbilics.index[near] == umbilics.index[rows[known]]
        fits = (distance < CLAIM * size) & same
        result[known[fits]] = near[fits]
    return result
