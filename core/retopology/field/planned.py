"""A cross field that has the planned poles, and no others, at its vertices and in its faces."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ...base.progress import Progress
from ...base.subsets import places_in
from ...fields.directions import DirectionField
from ...fields.face_index import face_field_singularities
from ...fields.planes import FaceFrames
from ...fields.winding import certified_index
from ...mesh.rings import adjacency, selection
from ...mesh.surface import Surface
from ..crosses.cross_field import CrossField
from ..crosses.in_triangles import index_around
from ..features import Features
from .agreement import rotated, with_index
from .settling import settle
from .simplified import STIFF
from .turns import Cutout, turns_in_triangles

# Rings around the singular vertices that differ, within which triangles turn.
NEARBY = 12
# Rings around poles that have no vertex yet within which triangles may turn from features: chosen
# on a torso (one ring and three leave some), held on a tray, a chair, a goblet and its foot's edge.
ROOM = 2
# Rings beside its triangle in which a pole looks for a vertex where its corners have none left.
BESIDE = 2


def with_poles(
    surface: Surface,
    planes: FaceFrames,
    cross: CrossField,
    features: Features,
    triangle: np.ndarray,
    sign: np.ndarray,
    progress: Progress,
    exact: bool = True,
) -> CrossField:
    """Turn a cross field so that its singularities are the poles.

    In the faces each pole is at a vertex of its own, a corner of its triangle or near it, and
    triangles beside hard features keep to them unless poles need their room. What the sum over the
    surface forbids stays as it is; so does what the curvature is sure of, as far as it can.

    Parameters
    ----------
    features:
        What the field runs along.
    triangle, sign:
        (k,) triangles of the poles and (k,) 4 - valence of each.
    exact:
        Whether the faces take great pains for their poles: triangles leave features, and turns
        that stay too large are made certain. Quads had better keep to the features, and go around
        poles that are not met.
    """
    part = progress.part("Moving poles", 0.0, 0.5)
    held = _beside(surface, features)
    faces, astray = _faces(surface, planes, cross, held, triangle, sign, part, exact)
    cross = replace(cross, face_direction=faces, astray=astray)
    part = progress.part("Moving poles", 0.5, 1.0)
    return _with_vertices(surface, planes, cross, triangle, sign, part)


def with_poles_of_faces(
    surface: Surface,
    planes: FaceFrames,
    cross: CrossField,
    triangle: np.ndarray,
    sign: np.ndarray,
    progress: Progress,
) -> tuple[CrossField, np.ndarray, np.ndarray, np.ndarray]:
    """The cross field with the poles that its faces have, each in a triangle with the vertex that
    they turn around for a corner.

    Where they cannot have the planned ones, as around a vertex of three triangles that stands out
    far, where a field turns whatever is planned, there are others.

    Returns
    -------
    cross, row, triangle, sign:
        The field, its vertices with these poles, too; (p,) the planned pole that each is, -1 for
        none, its triangle and 4 - valence.
    """
    found, vertex, quarters = _met(surface, planes, cross.face_direction, triangle, sign)
    kept, planned = np.flatnonzero(found >= 0), triangle
    triangle = _with_their_vertices(surface, triangle[kept], vertex[found[kept]])
    np.subtract.at(quarters, found[kept], sign[kept])
    index = index_around(surface, vertex, quarters)
    more = np.flatnonzero(index)
    each = np.rint(4.0 * np.abs(index[more])).astype(np.int64)
    row = np.append(kept, np.full(each.sum(), -1))
    triangle = np.append(triangle, np.repeat(more, each))
    sign = np.append(sign[kept], np.repeat(np.sign(index[more]).astype(np.int64), each))
    if np.array_equal(triangle, planned):
        return cross, row, triangle, sign
    cross = _with_vertices(surface, planes, cross, triangle, sign, progress)
    found, _, quarters = _met(surface, planes, cross.face_direction, triangle, sign)
    return replace(cross, astray=_astray(found, quarters)), row, triangle, sign


def _with_their_vertices(
    surface: Surface, triangle: np.ndarray, vertex: np.ndarray
) -> np.ndarray:
    """(k,) the triangles of poles whose faces turn around vertices (k,): those without it for a
    corner go to the one with it whose middle is nearest."""
    triangle = triangle.copy()
    aside = np.flatnonzero((surface.triangles[triangle] != vertex[:, None]).all(axis=1))
    wanted = np.zeros(len(surface.vertices), bool)
    wanted[vertex[aside]] = True
    beside = surface.touching(wanted)
    corner = surface.triangles[beside]
    middle = surface.vertices[corner].mean(axis=1)
    for row in aside:
        around = np.flatnonzero((corner == vertex[row]).any(axis=1))
        here = surface.vertices[surface.triangles[triangle[row]]].mean(axis=0)
        away = np.linalg.norm(middle[around] - here, axis=1)
        triangle[row] = beside[around[away.argmin()]]
    return triangle


def _with_vertices(
    surface: Surface,
    planes: FaceFrames,
    cross: CrossField,
    triangle: np.ndarray,
    sign: np.ndarray,
    progress: Progress,
) -> CrossField:
    """The cross field with the poles in the directions of its vertices."""
    quarters = np.zeros(len(surface.triangles), np.int64)
    np.add.at(quarters, triangle, sign)
    lines = DirectionField(cross.direction, cross.normal, cross.strength, symmetry=4)
    wanted = quarters / 4.0
    if cross.in_triangles is not None:
        # What the vertices hold there is for nobody to follow: it stays.
        part = progress.part("Counting", 0.0, 0.1)
        own = certified_index(surface, lines.direction, lines.across, part, lines.symmetry)
        wanted = np.where(cross.in_triangles, own, wanted)
    part = progress.part("Moving poles", 0.1, 1.0)
    none = np.zeros(len(quarters))
    found = with_index(surface, lines, wanted, none, STIFF * cross.confidence, part)
    index = found.index
    if cross.in_triangles is not None:
        named = _named(surface, planes, cross.face_direction, triangle, sign)
        index = np.where(cross.in_triangles, named, index)
    return replace(cross, direction=found.field.direction, triangle_index=index)


def _faces(
    surface: Surface,
    planes: FaceFrames,
    cross: CrossField,
    beside: np.ndarray,
    triangle: np.ndarray,
    sign: np.ndarray,
    progress: Progress,
    exact: bool,
) -> tuple[np.ndarray, int]:
    """(m, 3) directions in the triangles, with the poles for their singular vertices, and how many
    of these are others than the poles; directions `beside` (m,) bool features stay if they can."""
    direction, upright = cross.face_direction, surface.face_normal_area[0]
    vertex, quarters = face_field_singularities(surface, planes, direction)
    charge = np.zeros(len(surface.vertices), np.int64)
    charge[vertex] = quarters
    corner, value = _corners(surface, charge, triangle, sign)
    np.subtract.at(charge, corner, value)
    sure = STIFF * cross.confidence[surface.triangles].mean(axis=1)
    none = np.zeros(len(charge))
    for yielding, near in itertools.product((False, True)[: 1 + exact], (True, False)):
        changing = np.flatnonzero(charge)
        if not len(changing):
            break
        cutout = Cutout.around(surface, changing, NEARBY) if near else Cutout.whole(surface)
        turns = turns_in_triangles(surface, cutout, planes, direction)
        _, twin, inner = cutout.sides(surface)
        held = np.any(((twin >= 0) & ~inner).reshape(-1, 3), axis=1)
        keeps = beside
        if yielding:
            keeps = beside.copy()
            keeps[Cutout.around(surface, changing, ROOM).triangles] = False
        held |= keeps[cutout.triangles]
        stiffness = np.where(beside, STIFF, sure)[cutout.triangles]
        mine = cutout.vertices
        settled = settle(
            turns, charge[mine], none[mine], held, stiffness, progress, exact, again=True
        )
        if np.count_nonzero(settled.left) < len(changing):
            angle = np.zeros(len(direction))
            angle[cutout.triangles] = settled.angle / 4.0
            direction = rotated(direction, np.cross(upright, direction), angle)
            charge[mine] = settled.left
    found, _, quarters = _met(surface, planes, direction, triangle, sign)
    return direction, _astray(found, quarters)


def _met(
    surface: Surface,
    planes: FaceFrames,
    direction: np.ndarray,
    triangle: np.ndarray,
    sign: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(k,) for each pole the row of a singular vertex of its own in its triangle or beside it, -1
    for none; the singular vertices (s,) and four times their index."""
    vertex, quarters = face_field_singularities(surface, planes, direction)
    own = selection(surface.triangles[triangle], len(surface.vertices))
    near = own @ adjacency(surface)
    place = places_in(vertex, len(surface.vertices))
    found = np.full(len(triangle), -1)
    for one in (1, -1):
        others = np.ones(len(surface.vertices), bool)
        others[vertex[one * quarters > 0]] = False
        mine = np.flatnonzero(sign == one)
        # Those with one in their own triangle keep it, if that leaves one to all.
        taken = others.copy()
        match = _matched(own[mine], taken)
        rest = np.flatnonzero(match < 0)
        match[rest] = _matched(near[mine[rest]], taken)
        if (match < 0).any():
            match = _matched(near[mine], others)
        found[mine] = np.where(match >= 0, place[match], -1)
    return found, vertex, quarters


def _astray(found: np.ndarray, quarters: np.ndarray) -> int:
    """How many poles have no singular vertex of their own, and how many singularities are of no
    pole."""
    return len(found) + int(np.abs(quarters).sum()) - 2 * int(np.count_nonzero(found >= 0))


def _named(
    surface: Surface,
    planes: FaceFrames,
    direction: np.ndarray,
    triangle: np.ndarray,
    sign: np.ndarray,
) -> np.ndarray:
    """(m,) the index of directions (m, 3) of triangles: of singular vertices in the triangles of
    the poles that have them for a corner, of others beside them."""
    vertex, quarters = face_field_singularities(surface, planes, direction)
    reach = selection(surface.triangles[triangle], len(surface.vertices))
    left = np.zeros(len(surface.vertices), np.int64)
    left[vertex] = quarters
    index = np.zeros(len(surface.triangles))
    for one in (1, -1):
        rows = np.flatnonzero(sign == one)
        found = _matched(reach[rows], one * left <= 0)
        known = found >= 0
        np.add.at(index, triangle[rows[known]], 0.25 * one)
        left[found[known]] -= one
    others = np.flatnonzero(left)
    return index + index_around(surface, others, left[others])


def _beside(surface: Surface, features: Features) -> np.ndarray:
    """(m,) bool triangles with an edge on a hard feature."""
    twin = surface.twin[features.half_edge]
    found = np.zeros(len(surface.triangles), bool)
    found[np.concatenate([features.half_edge, twin[twin >= 0]]) // 3] = True
    return found


def _corners(
    surface: Surface, quarters: np.ndarray, triangle: np.ndarray, sign: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Vertices that stand for the poles, each for one, and the signs of the poles: of the corners
    of its triangle one where the faces are singular already if it can be, where none is left one
    beside these. Border vertices cannot."""
    vertex = np.full(len(triangle), -1)
    taken = surface.border.copy()
    corners = surface.triangles[triangle].T
    # First those that are singular already, then others.
    for wanted in (quarters, None):
        for corner in corners:
            fits = (vertex < 0) & ~taken[corner]
            if wanted is not None:
                fits &= wanted[corner] * sign > 0
            rows = np.flatnonzero(fits)
            _, first = np.unique(corner[rows], return_index=True)
            vertex[rows[first]] = corner[rows[first]]
            taken[corner[rows[first]]] = True
    reach = selection(surface.triangles[triangle], len(surface.vertices))
    if (vertex < 0).any():
        # All that share vertices with one that has none choose anew.
        group = csgraph.connected_components(reach @ reach.T, directed=False)[1]
        again = np.flatnonzero(np.isin(group, group[vertex < 0]))
        taken[vertex[again]] = False
        taken |= surface.border
        vertex[again] = _matched(reach[again], taken)
    for _ in range(BESIDE):
        again = np.flatnonzero(vertex < 0)
        if not len(again):
            break
        reach = reach @ adjacency(surface)
        vertex[again] = _matched(reach[again], taken)
    known = vertex >= 0
    return vertex[known], sign[known]


def _matched(reach: sparse.csr_array, taken: np.ndarray) -> np.ndarray:
    """(r,) a vertex for each row of those it reaches, for as many rows as can be, -1 for none; none
    twice and none that is `taken` (n,) bool, as they are then."""
    free = np.flatnonzero(~taken)
    found = csgraph.maximum_bipartite_matching(reach.tocsc()[:, free].tocsr(), perm_type="column")
    vertex, some = np.full(len(found), -1), found >= 0
    vertex[some] = free[found[some]]
    taken[vertex[some]] = True
    return vertex
