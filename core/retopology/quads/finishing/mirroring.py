"""Exactly symmetric quads: one half is remeshed with the plane for a border, and mirrored.

What lies on one side with nothing alike on the other, such as a sword in one hand, is no half of
anything: it stays as it is, or gets an image where that is asked for.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from ....base.errors import GuidanceError, RemeshError
from ....base.progress import Progress
from ....base.subsets import places_in
from ....matching.mirror import find_mirror_plane
from ....mesh.half_edges import edge_keys
from ....mesh.surface import Surface
from ....umbilics.result import Detection, Umbilics
from ..conformity import conformity
from ..result import QuadMesh
from ..surface.subdivision import Triangles, chosen, pieces, split_edges, taken_apart
from .projection import ClosestPoints

# Vertices nearer to the plane than this part of a typical edge are put on it, and what is mirrored
# is as near to the surface as this part of a quad's edge, or it is said.
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


def on_sides(
    mesh: Triangles, normal: np.ndarray, offset: float, size: float, mirror_single: bool
) -> tuple[list[Triangles], np.ndarray, np.ndarray]:
    """The pieces of a mesh that are to be remeshed, which (p,) bool of them stay as they are, the
    others being mirrored, and which (p,) bool have an image in the mesh.

    Pieces that cross the plane and pairs of images lose what lies where normal . x < offset. A
    piece on one side without an image on the other is single: it stays, if not `mirror_single`,
    unless it is the half of something, open along the plane, or all lie on that side.

    Parameters
    ----------
    size:
        Images are as near to each other, in each extent.

    Raises
    ------
    RemeshError
        Nothing lies where normal . x > offset.
    """
    found = pieces(mesh)
    near = NEAR * float(np.median(mesh.lengths))
    side = np.array([_side(piece, normal, offset, near) for piece in found])
    if not (side >= 0).any():
        raise RemeshError(
            "Nothing of the mesh lies on the positive side of the symmetry plane. Move its "
            "origin, or choose another plane."
        )
    here, beyond = np.flatnonzero(side > 0), np.flatnonzero(side < 0)
    there = _images_of(
        [found[row] for row in here], [found[row] for row in beyond], normal, offset, size
    )
    single = side != 0
    single[here[there >= 0]] = single[beyond[there[there >= 0]]] = False
    keep = single & (len(here) < len(found)) & (not mirror_single)
    cut, stays, imaged = [], [], []
    for row, piece in enumerate(found):
        if side[row] < 0 and not single[row]:
            continue
        flat = side[row] > 0 and _side(piece, -normal, -offset, near) > 0
        if flat or (keep[row] and not _open_along(piece, normal, offset, near)):
            cut.append(piece)
            stays.append(True)
            imaged.append(False)
            continue
        sign = -1.0 if side[row] < 0 else 1.0
        new = pieces(halved(piece, sign * normal, sign * offset, near))
        cut += new
        stays += [False] * len(new)
        imaged += [not single[row]] * len(new)
    return cut, np.array(stays), np.array(imaged)


def _side(piece: Triangles, normal: np.ndarray, offset: float, near: float) -> int:
    """1 or -1 where a piece lies on one side of the plane, 0 where it crosses it."""
    height = piece.vertices @ normal - offset
    return int(height.min() >= -near) or -int(height.max() <= near)


def _open_along(piece: Triangles, normal: np.ndarray, offset: float, near: float) -> bool:
    """Whether an open edge lies on the plane."""
    tail, head = piece.ends
    _, first, uses = np.unique(
        edge_keys(tail, head, len(piece.vertices)), return_index=True, return_counts=True
    )
    edge = first[uses == 1]
    on = np.abs(piece.vertices @ normal - offset) <= near
    return bool((on[tail[edge]] & on[head[edge]]).any())


def _images_of(
    here: list[Triangles],
    beyond: list[Triangles],
    normal: np.ndarray,
    offset: float,
    size: float,
) -> np.ndarray:
    """(h,) int64 the piece beyond the plane that is the image of each one here, as far as their
    extents tell; -1 for none."""
    result = np.full(len(here), -1)
    if not here or not beyond:
        return result
    extents = np.array([_extent(piece.vertices) for piece in here])
    images = np.array(
        [
            _extent(place - 2.0 * (place @ normal - offset)[:, None] * normal)
            for place in (piece.vertices for piece in beyond)
        ]
    )
    near = cKDTree(images).query_ball_point(extents, size, p=np.inf)
    row = np.repeat(np.arange(len(here)), [len(some) for some in near])
    image = np.concatenate([np.zeros(0), *near]).astype(np.int64)
    # Nearest pairs first, each piece once.
    taken = np.zeros(len(beyond), bool)
    off = np.abs(extents[row] - images[image]).max(axis=1)
    for pair in np.argsort(off, kind="stable").tolist():
        if result[row[pair]] < 0 and not taken[image[pair]]:
            result[row[pair]] = image[pair]
            taken[image[pair]] = True
    return result


def _extent(place: np.ndarray) -> np.ndarray:
    """(6,) where points (n, 3) begin and end."""
    return np.concatenate([place.min(axis=0), place.max(axis=0)])


def halved(mesh: Triangles, normal: np.ndarray, offset: float, near_by: float) -> Triangles:
    """What of a mesh lies where normal . x > offset, cut at the plane; new borders lie on it.
    Vertices nearer than `near_by` are put on it."""
    height = mesh.vertices @ normal - offset
    near = np.abs(height) < near_by
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
    # What touches the plane in a vertex only may be two fans there, or two pieces.
    half = taken_apart(chosen(mesh, kept))
    # Where the plane was a crease it is a border now.
    tail, head = half.ends
    inside = np.abs(half.vertices @ normal - offset) < 1e-12
    return replace(half, feature=np.where(inside[tail] & inside[head], np.int8(0), half.feature))


def mirrored(
    half: QuadMesh, single: np.ndarray, plane: Plane, umbilics: Umbilics, size: float
) -> QuadMesh:
    """A half and its image, joined along the plane; without one of the vertices that are `single`
    (n,) bool."""
    vertices, n = half.vertices.copy(), len(half.vertices)
    on = half.border & (np.abs(plane.height(vertices)) <= ON * np.ptp(vertices, axis=0).max())
    on &= ~single
    vertices[on] -= plane.height(vertices[on])[:, None] * plane.normal
    off = np.flatnonzero(~on & ~single)
    image = np.arange(n)
    image[off] = n + np.arange(len(off))
    twin = ~single[half.quads[:, 0]]
    quads = np.concatenate([half.quads, image[half.quads[twin]][:, ::-1]])
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
        patch=np.concatenate([half.patch, half.patch[twin] + int(half.patch.max()) + 1]),
        angle=np.concatenate([half.angle, half.angle[twin]]),
        source_triangle=twice(half.source_triangle),
    )


def words_of_images(images: np.ndarray, whole: Surface, size: float) -> list[str]:
    """What is said of mirrored vertices (n, 3) that are off the input, where they should be on it
    and it is no image of itself."""
    closest = ClosestPoints(whole.vertices, whole.triangles, whole.twin)
    place = (images - whole.origin) / whole.unit
    off = np.linalg.norm(closest(place)[1] - place, axis=1).max(initial=0.0) * whole.unit
    if off <= NEAR * size:
        return []
    return [
        f"The mirrored half is up to {off:.3g} away from the mesh, which is no image of itself. "
        "Choose no symmetry to keep both sides as they are."
    ]


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
