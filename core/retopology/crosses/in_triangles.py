"""A cross field of triangles, for parts on which vertices cannot tell one.

Programs that make parts of planes and round faces put most vertices on the outlines of these. What
a vertex there says holds for none of the faces that meet in it, and between vertices that are all
held no field has any freedom: it turns as chance will have it. The triangles know: those beside
features run along them, those of cylinders and cones along the axis, and between them, over flat
and spherical faces, which have no direction of their own, the field is as smooth as it can be.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from ...base.parallel import run
from ...base.progress import Progress
from ...base.subsets import places_in, spans
from ...curvature.field import CurvatureField
from ...fields.connection import LARGEST_WEIGHT, LEAST_WEIGHT
from ...fields.face_index import face_field_singularities
from ...fields.frames import frame, side_axes
from ...fields.multigrid import solve_part
from ...fields.planes import FaceFrames, in_plane, lay_out
from ...fields.transport import rotation
from ...mesh.half_edges import ends_of
from ...mesh.surface import Surface
from ...mesh.tessellated import Tessellation, tessellation
from ..features import Features, between_features, fourth_power
from .smoothing import CREST_WEIGHT

# Share of a part's area in such triangles from which they tell its field rather than vertices do.
MOST = 0.5
# Directions of a triangle's features whose mean is shorter agree on none.
AGREEING = 1e-6
# A trace of stiffness keeps triangles without any that is held from floating.
FLOATING = 1e-9
SIDES = 3
BLOCK = 1 << 16


@dataclass(frozen=True)
class Told:
    """The field of the components that triangles tell.

    Attributes
    ----------
    there:
        (m,) bool, True on these components.
    direction:
        (m, 3) float64 one unit direction of the cross in each triangle.
    index:
        (m,) float64 there of triangles beside the vertices around which these directions turn,
        elsewhere as it was.
    """

    there: np.ndarray
    direction: np.ndarray
    index: np.ndarray

    def over(self, direction: np.ndarray) -> np.ndarray:
        """(m, 3) the directions of others, and these where they are told."""
        return np.where(self.there[:, None], self.direction, direction)


def told_by_triangles(
    surface: Surface,
    features: Features,
    field: CurvatureField,
    axis: np.ndarray,
    data: np.ndarray,
    index: np.ndarray,
) -> Told | None:
    """The field of components whose vertices cannot tell one, where triangles have fewer poles;
    None where nothing is told so.

    Parameters
    ----------
    axis:
        (3, n) complex tangent frames of the vertices.
    data:
        (n,) complex128 fourth powers of the measured directions in these, by their weights for an
        area of one.
    index:
        (m,) float64 of the field that the vertices tell.
    """
    parts, exact = parts_of_faces(surface, features)
    if not parts.any():
        return None
    quiet = Progress()
    rows = np.arange(len(index))
    direction, size = on_faces(surface, data, axis, quiet)
    pull = size * surface.face_normal_area[1] * in_plane(surface, rows, direction) ** 4
    if exact is not None:
        # These know their directions, or have none.
        pull[exact.face >= 0] = 0.0
    crest = features.crest_vertex
    if len(crest):
        value = np.zeros(len(data), complex)
        across = fourth_power(axis[:, crest], features.crest_direction)
        value[crest] = SIDES * CREST_WEIGHT * features.crest_weight * across
        direction, size = on_faces(surface, value, axis, quiet)
        pull += size * in_plane(surface, rows, direction) ** 4
    planes = lay_out(surface, field.lines, quiet)
    direction = field_in_triangles(surface, planes, features, exact, pull, quiet)
    turning = index_around(surface, *face_field_singularities(surface, planes, direction))
    before, after = (
        surface.by_component(slice(None), np.abs(some)) for some in (index, turning)
    )
    there = (parts & (after < before))[surface.component[surface.triangles[:, 0]]]
    return Told(there, direction, np.where(there, turning, index)) if there.any() else None


def parts_of_faces(
    surface: Surface, features: Features
) -> tuple[np.ndarray, Tessellation | None]:
    """(components,) bool, those of whose area most is in exact faces or in triangles with all
    corners on features; and these faces."""
    told = between_features(surface, features)
    faces = tessellation(surface)
    if faces is not None:
        told |= faces.face >= 0
    area = surface.face_normal_area[1]
    rows = np.flatnonzero(told)
    share = surface.by_component(rows, area[rows])
    return share > MOST * surface.by_component(slice(None), area), faces


def field_in_triangles(
    surface: Surface,
    planes: FaceFrames,
    features: Features,
    faces: Tessellation | None,
    pull: np.ndarray,
    progress: Progress,
) -> np.ndarray:
    """(m, 3) unit direction of a cross in each triangle.

    Parameters
    ----------
    pull:
        (m,) complex128 fourth powers of the directions that triangles are drawn to, in the plane
        of each, by how much in the weight of an edge.
    """
    held = _held(surface, features, faces)
    m = len(held)
    side = np.flatnonzero(surface.twin > np.arange(len(surface.twin)))
    # Across a crease nothing is smooth but along it, and what is beside it is held.
    crease = np.zeros(len(surface.twin), bool)
    crease[features.half_edge] = True
    side = side[~(crease[side] | crease[surface.twin[side]])]
    here, there = side // 3, surface.twin[side] // 3
    area = surface.face_normal_area[1]
    both = np.maximum(area[here] + area[there], np.finfo(float).tiny)
    # Length of the edge over that of the way from middle to middle, a third of both heights.
    weight = 1.5 * surface.side_squares[side % 3, here] / both
    weight = np.clip(weight, LEAST_WEIGHT, LARGEST_WEIGHT)
    across = sparse.coo_array(
        (-weight * planes.turn[side].conj() ** 4, (here, there)), shape=(m, m)
    ).tocsr()
    drawn = np.abs(pull)
    total = np.bincount(here, weights=weight, minlength=m)
    total += np.bincount(there, weights=weight, minlength=m)
    diagonal = (total + drawn) * (1.0 + FLOATING) + FLOATING
    matrix = (across + across.conj().T + sparse.diags_array(diagonal.astype(complex))).tocsr()
    u = held.copy()
    free = np.flatnonzero(held == 0.0)
    if len(free):
        rows = matrix[free]
        u[free] = solve_part(rows[:, free].tocsr(), pull[free] - rows @ held, progress)
    x, y = side_axes(surface, np.arange(m))
    angle = np.angle(u) / 4.0
    return np.asarray(np.cos(angle)[:, None] * x + np.sin(angle)[:, None] * y)


def index_around(surface: Surface, vertex: np.ndarray, quarters: np.ndarray) -> np.ndarray:
    """(m,) the index of singular vertices (s,) as that of triangles around them: a quarter in each
    while there are any, first in those with no other of them for a corner, and last in those with
    all corners on a border."""
    place = places_in(vertex, len(surface.vertices))
    corner = np.flatnonzero(place[surface.triangles.ravel()] >= 0)
    triangle, row = corner // 3, place[surface.triangles.ravel()[corner]]
    others = (place[surface.triangles[triangle]] >= 0).sum(axis=1)
    outside = surface.border[surface.triangles[triangle]].all(axis=1)
    triangle = triangle[np.lexsort((triangle, others, outside, row))]
    count = np.bincount(row, minlength=len(vertex))
    size = np.abs(quarters)
    which = np.repeat(np.arange(len(vertex)), size)
    turn = spans(0, size)
    index = np.zeros(len(surface.triangles))
    first = np.cumsum(count) - count
    at = triangle[first[which] + turn % count[which]]
    np.add.at(index, at, 0.25 * np.sign(quarters[which]))
    return index


def _held(surface: Surface, features: Features, faces: Tessellation | None) -> np.ndarray:
    """(m,) complex128 fourth power of the direction that a triangle has for certain, in its plane;
    0 for none."""
    total = np.zeros(len(surface.triangles), complex)
    twin = surface.twin[features.half_edge]
    half = np.concatenate([features.half_edge, twin[twin >= 0]])
    tail, head = ends_of(surface.triangles, half)
    along = in_plane(surface, half // 3, surface.vertices[head] - surface.vertices[tail])
    np.add.at(total, half // 3, along**4)
    if faces is not None:
        directed = np.linalg.norm(faces.axis, axis=1) > 0.5
        rows = np.flatnonzero((faces.face >= 0) & (total == 0.0))
        rows = rows[directed[faces.face[rows]]]
        total[rows] = in_plane(surface, rows, faces.axis[faces.face[rows]]) ** 4
    size = np.abs(total)
    return np.where(size > AGREEING, total / np.maximum(size, AGREEING), 0.0)


def on_faces(
    surface: Surface, u: np.ndarray, axis: np.ndarray, progress: Progress
) -> tuple[np.ndarray, np.ndarray]:
    """(m, 3) unit direction in each triangle: the mean of its corners' crosses, carried there; and
    the length (m,) of this mean."""
    normal, _ = surface.face_normal_area
    result, size = np.empty((len(normal), 3)), np.empty(len(normal))

    def block(first: int) -> None:
        rows = slice(first, first + BLOCK)
        x, y = frame(normal[rows].T)
        total = np.zeros(x.shape[1], complex)
        own = x + 1j * y
        for corner in surface.triangles[rows].T:
            total += rotation(axis[:, corner], own) ** 4 * u[corner]
        angle = np.angle(total) / 4.0
        result[rows] = (np.cos(angle) * x + np.sin(angle) * y).T
        size[rows] = np.abs(total) / SIDES

    run(block, range(0, len(normal), BLOCK), progress)
    return result, size
