"""Creases: edges across which a surface bends sharply, by angle or by the user's mark."""

from __future__ import annotations

import numpy as np

from .half_edges import all_edges, edge_keys, ends_of, inner_edges, previous
from .input_map import kept_vertices
from .surface import Surface

# Importers mark every edge sharp where a file has a normal for each corner. More marks than this
# share of the edges are not creases, unless the mesh is so small that they may well be.
MOST_MARKED, SMALL = 0.2, 600


def bent_half_edges(surface: Surface, angle: float) -> np.ndarray:
    """(h,) int64 half-edges, one of each edge, ascending, across which the normal turns further
    than `angle` in degrees."""
    inner, bend = edge_bends(surface)
    return inner[bend > angle]


def edge_bends(surface: Surface) -> tuple[np.ndarray, np.ndarray]:
    """(h,) int64 half-edges, one of each inner edge, ascending, and the degrees (h,) that the
    normal turns across each."""
    inner = inner_edges(surface.twin)
    normal, _ = surface.face_normal_area
    one, two = normal[inner // 3], normal[surface.twin[inner] // 3]
    sine = np.linalg.norm(np.cross(one, two), axis=1)
    return inner, np.degrees(np.arctan2(sine, np.einsum("ec,ec->e", one, two)))


def is_convex(surface: Surface, half_edges: np.ndarray) -> np.ndarray:
    """(e,) bool, True where the surface bends outwards at an edge, and on borders."""
    twin = surface.twin[half_edges]
    normal, _ = surface.face_normal_area
    inner = twin >= 0
    opposite = surface.triangles.ravel()[previous(twin)]
    tail = surface.triangles.ravel()[half_edges]
    height = np.einsum(
        "ec,ec->e",
        normal[half_edges // 3],
        surface.vertices[opposite] - surface.vertices[tail],
    )
    return ~inner | (height <= 0)


def marked_half_edges(surface: Surface, sharp: np.ndarray | None) -> np.ndarray:
    """(h,) int64 half-edges, one of each edge, ascending, that are marked; none where more than a
    fifth of the edges are.

    Parameters
    ----------
    sharp:
        (s, 2) pairs of input vertices whose edges are marked sharp, or None.
    """
    if sharp is None or not len(sharp):
        return np.zeros(0, np.int64)
    source = surface.source_vertex
    edges = all_edges(surface.twin)
    tail, head = ends_of(surface.triangles, edges)
    count = int(source.max()) + 1
    marked = kept_vertices(surface, np.asarray(sharp, np.int64))
    one, other = marked[(marked < count).all(axis=1)].T
    keys = edge_keys(source[tail], source[head], count)
    chosen = edges[np.isin(keys, edge_keys(one, other, count))]
    return chosen if are_few(len(chosen), len(surface.twin)) else np.zeros(0, np.int64)


def are_few(marked: int, half_edges: int) -> bool:
    """Whether so many marked edges, of a mesh with so many half-edges, may be creases."""
    return marked <= MOST_MARKED * 0.5 * half_edges or half_edges <= SMALL
