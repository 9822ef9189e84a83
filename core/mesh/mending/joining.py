"""Borders that are none: joined, and what that makes of the input's triangles."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ...base.words import counted
from ..half_edges import HalfEdges, following
from ..surface import Surface
from .coincident import border_half_edges, joined_vertices
from .t_junctions import split_at_junctions

# A border edge that is no longer than this, in the unit of the surface, is a few steps of single
# precision; if it is no more than this part of its triangle's longest side, too, it is no detail.
ROUNDED, NEEDLE = 4e-7, 1e-5


def mend_borders(
    vertices: np.ndarray,
    corners: np.ndarray,
    rows: np.ndarray,
    links: HalfEdges | None,
    warnings: list[str],
) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Borders that coincide joined, and vertices on border edges inserted there.

    Returns
    -------
    corners, rows, joined:
        The triangles, what rows they came from, and (j, 2) vertices that are now others. None
        where there is nothing to mend.
    """
    n = len(vertices)
    open_edges = border_half_edges(corners, n) if links is None else np.flatnonzero(links.twin < 0)
    if not len(open_edges):
        return None
    vertices = _in_a_unit_box(vertices, corners)
    same = joined_vertices(vertices, corners, open_edges)
    corners, rows, open_edges = _renamed(corners, rows, same, open_edges)
    if not len(corners):
        return None
    corners, rows, inserted = split_at_junctions(vertices, corners, rows, open_edges)
    if inserted:
        # What was split now has edges like those beyond the junction.
        again = joined_vertices(vertices, corners, border_half_edges(corners, n))
        corners, rows, _ = _renamed(corners, rows, again, open_edges)
        same = again[same]
    copies = np.flatnonzero(same != np.arange(n))
    # What has no area at all is left to those who refuse it in words.
    if not len(corners) or (not len(copies) and not inserted):
        return None
    if len(copies):
        number = counted(len(copies), "vertex", "vertices")
        warnings.append(
            f"Borders lie on each other (an unwelded seam): {number} joined for the analysis. "
            "Merge by Distance joins them in the mesh."
        )
    if inserted:
        warnings.append(
            f"{counted(inserted, 'T-junction')}: a vertex lies on an edge that does not know it; "
            "the triangle beyond was split there for the analysis. Split that edge and merge "
            "by distance to mend it in the mesh."
        )
    return corners, rows, np.stack([copies, same[copies]], axis=1)


def in_one_place(surface: Surface, count: int) -> np.ndarray | None:
    """(count,) int64 for each vertex of the input the first of those that edges of no length join
    it to; None where there is no such edge.

    Poles of lofts and lathes come as rows of vertices in one place, around a hole that is none,
    and bevels that ran into each other as triangles without area. Around such a hole edges have no
    length that single precision would not have either.
    """
    squares = surface.side_squares
    none = (squares == 0.0).T.ravel()
    if surface.border.any():
        none |= _holes_of_no_size(surface)
    half = np.flatnonzero(none)
    if not len(half):
        return None
    piece = surface.component[surface.triangles[:, 0]]
    left = proper(_taken_together(surface, half, count)[surface.source_vertex[surface.triangles]])
    # A piece of which nothing would be left stays as it is.
    half = half[np.bincount(piece, weights=left)[piece[half // 3]] > 0]
    return _taken_together(surface, half, count) if len(half) else None


def _taken_together(surface: Surface, half: np.ndarray, count: int) -> np.ndarray:
    """(count,) int64 for each vertex of the input the first of those that half-edges join it to."""
    corners = surface.source_vertex[surface.triangles.ravel()]
    ends = corners[half], corners[following(half)]
    graph = sparse.coo_array((np.ones(len(half), np.int8), ends), shape=(count, count))
    _, label = csgraph.connected_components(graph, directed=False)
    _, first = np.unique(label, return_index=True)
    return np.asarray(first[label])


def _holes_of_no_size(surface: Surface) -> np.ndarray:
    """(3 m,) bool the edges around holes none of whose edges has a length of its own."""
    found = np.zeros(len(surface.twin), bool)
    squares = surface.side_squares
    half = np.flatnonzero(surface.twin < 0)
    least = np.minimum(ROUNDED, NEEDLE * np.sqrt(squares[:, half // 3].max(axis=0)))
    long = squares[half % 3, half // 3] > least**2
    if long.all():
        return found
    corners, n = surface.triangles.ravel(), len(surface.vertices)
    ends = corners[half], corners[following(half)]
    graph = sparse.coo_array((np.ones(len(half), np.int8), ends), shape=(n, n))
    _, label = csgraph.connected_components(graph, directed=False)
    loop = label[ends[0]]
    found[half] = np.bincount(loop, weights=long)[loop] == 0
    return found


def joined_with(vertices: np.ndarray, joined: np.ndarray) -> np.ndarray:
    """Vertices, those in the first column of `joined` (j, 2) as what the second says."""
    if not len(joined) or not len(vertices):
        return vertices
    same = np.arange(1 + max(int(vertices.max()), int(joined.max())))
    same[joined[:, 0]] = joined[:, 1]
    return same[vertices]


def _in_a_unit_box(vertices: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Vertices moved and scaled so that those of the triangles lie in a box of two units, where
    no square overflows; what lies in one place stays there."""
    used = np.zeros(len(vertices), bool)
    used[corners] = True
    low, high = vertices[used].min(axis=0), vertices[used].max(axis=0)
    unit = float((0.5 * high - 0.5 * low).max())
    scaled = np.zeros_like(vertices)
    scaled[used] = (vertices[used] - (0.5 * low + 0.5 * high)) / (unit if unit > 0 else 1.0)
    return scaled


def _renamed(
    corners: np.ndarray, rows: np.ndarray, same: np.ndarray, open_edges: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Triangles whose corners are called by `same`, without those that this leaves no area, and
    their open edges."""
    if (same == np.arange(len(same))).all():
        return corners, rows, open_edges
    corners = same[corners].astype(np.int32)
    sound = proper(corners)
    corners, rows = corners[sound], rows[sound]
    return corners, rows, border_half_edges(corners, len(same))


def proper(triangles: np.ndarray) -> np.ndarray:
    """(m,) bool, triangles (m, 3) with three different corners."""
    a, b, c = triangles.T
    return np.asarray((a != b) & (b != c) & (c != a))


def corners_in_input(
    vertices: np.ndarray,
    triangles: np.ndarray,
    corners: np.ndarray,
    rows: np.ndarray,
    joined: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """(r,) triangles whose corners are not those of their input triangle in its order, and
    (r, 3, 3) their corners as weights of its corners.

    Parameters
    ----------
    corners, rows:
        (m, 3) input vertices at the corners of the surface's triangles, (m,) input triangles.
    """
    given = joined_with(triangles[rows], joined)
    recut = np.flatnonzero((given != corners).any(axis=1))
    given, corners = given[recut], corners[recut]
    weights = (corners[:, :, None] == given[:, None, :]).astype(float)
    # What is none of the corners lies on an edge between two of them.
    row, corner = np.nonzero(weights.sum(axis=2) == 0)
    point, ends = vertices[corners[row, corner]], vertices[given[row]]
    along = ends[:, [1, 2, 0]] - ends
    square = np.einsum("rkc,rkc->rk", along, along)
    share = np.einsum("rkc,rkc->rk", point[:, None] - ends, along)
    share = np.clip(share / np.where(square > 0, square, 1.0), 0.0, 1.0)
    away = np.linalg.norm(point[:, None] - ends - share[..., None] * along, axis=2)
    edge = away.argmin(axis=1)
    share = share[np.arange(len(row)), edge]
    weights[row, corner, edge] = 1.0 - share
    weights[row, corner, (edge + 1) % 3] = share
    return recut, weights
