"""Method I: the index of the principal directions around every vertex."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ...base.progress import Progress
from ...curvature.field import CurvatureField
from ...fields.transport import carried, doubled_angle, tangents
from ...mesh.half_edges import ends_of
from ...mesh.surface import Surface
from .raw import RawUmbilics

_BLOCK = 1 << 18


def detect_by_index(
    surface: Surface, curvature: CurvatureField, progress: Progress | None = None
) -> RawUmbilics:
    """Vertices around which the principal directions turn.

    The deviators of the one-ring are carried into the tangent plane at the vertex by the
    smallest rotation; the index is the sum of the jumps of their argument, each taken in
    (-pi, pi], over 4 pi. The operator at the vertex itself does not enter, and one umbilic
    shows up at one to three vertices, because their rings overlap.

    Vertices on a border have no closed ring: they are skipped, and a warning counts them.

    Parameters
    ----------
    surface:
        n vertices, m triangles.
    curvature:
        Shape operators at the surface's vertices.
    """
    progress = progress or Progress()
    n = len(surface.vertices)
    index = 0.5 * np.rint(_total_jump(surface, curvature, progress) / (2.0 * np.pi))
    index[surface.border] = 0.0
    vertex = np.flatnonzero(index)
    triangle, corner = a_corner(surface, vertex)
    warnings = []
    skipped = int(np.count_nonzero(surface.border))
    if skipped:
        vertices = "1 border vertex has" if skipped == 1 else f"{skipped} border vertices have"
        warnings.append(f"Method I: {vertices} no closed ring and were left out.")
    return RawUmbilics(
        triangle=triangle,
        barycentric=np.eye(3)[corner],
        index=index[vertex],
        vertex=vertex,
        conformal_scale=np.full(n, np.nan),
        warnings=warnings,
    )


def merged_clusters(
    surface: Surface, raw: RawUmbilics, triangle_index: np.ndarray
) -> RawUmbilics:
    """Each umbilic once: the vertices that one shows up at, and those of the triangles that the
    directions turn around, are one cluster where triangles join them.

    The index of a cluster is that of its triangles, so that those of a closed surface sum to its
    Euler characteristic; clusters without one are left out. Of each the vertex is reported that
    lies nearest to the middle of these triangles, if possible one that was found.

    Parameters
    ----------
    triangle_index:
        (m,) certified index of each triangle.
    """
    vertices = len(surface.vertices)
    turning = np.flatnonzero(triangle_index)
    near = np.zeros(vertices, bool)
    near[raw.vertex] = True
    near[surface.triangles[turning]] = True
    # Of a border vertex nothing is said: it has no closed ring.
    near &= ~surface.border
    owner = surface.owner
    both = near[owner] & near[surface.neighbours]
    graph = sparse.coo_array(
        (np.ones(int(both.sum()), np.int8), (owner[both], surface.neighbours[both])),
        shape=(vertices, vertices),
    )
    _, label = csgraph.connected_components(graph, directed=False)
    label = np.where(near, label, -1)
    cluster = label[surface.triangles[turning]].max(axis=1)
    turning, cluster = turning[cluster >= 0], cluster[cluster >= 0]
    names, number = np.unique(cluster, return_inverse=True)
    count = len(names)
    index = np.bincount(number, triangle_index[turning], minlength=count)
    size = np.bincount(number, minlength=count)
    centre = surface.vertices[surface.triangles[turning]].mean(axis=1)
    middle = np.stack([np.bincount(number, c, minlength=count) for c in centre.T], axis=1)
    middle = middle / np.maximum(size, 1)[:, None]
    candidate = np.flatnonzero(np.isin(label, names))
    mine = np.searchsorted(names, label[candidate])
    away = np.linalg.norm(surface.vertices[candidate] - middle[mine], axis=1)
    order = np.lexsort((away, ~np.isin(candidate, raw.vertex), mine))
    _, first = np.unique(mine[order], return_index=True)
    vertex = candidate[order[first]][index != 0.0]
    triangle, corner = a_corner(surface, vertex)
    return replace(
        raw,
        triangle=triangle,
        barycentric=np.eye(3)[corner],
        index=index[index != 0.0],
        vertex=vertex,
    )


def _total_jump(surface: Surface, curvature: CurvatureField, progress: Progress) -> np.ndarray:
    """(n,) sum of the jumps of the deviator's argument around the ring of each inner vertex."""
    corner_vertex, neighbour = ends_of(surface.triangles)
    e1, e2 = tangents(curvature.normal)
    argument = np.empty(len(corner_vertex))
    for begin in range(0, len(corner_vertex), _BLOCK):
        centre, ring = (rows[begin : begin + _BLOCK] for rows in (corner_vertex, neighbour))
        direction = carried(curvature.d1[ring], curvature.normal[ring], curvature.normal[centre])
        argument[begin : begin + _BLOCK] = np.angle(
            doubled_angle(direction, e1[centre], e2[centre])
        )
        progress.step(begin / len(corner_vertex))
    # Each triangle at a vertex spans one side of its ring; in a sum their order is no matter.
    # The next corner around the vertex leaves along the side that comes back to this one.
    after = np.roll(surface.twin.reshape(-1, 3), 1, axis=1).ravel()
    jump = argument[after] - argument
    jump -= 2.0 * np.pi * np.ceil(jump / (2.0 * np.pi) - 0.5)  # into (-pi, pi]
    return np.bincount(corner_vertex, jump, minlength=len(surface.vertices))


def a_corner(surface: Surface, vertex: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """For each of (k,) vertices a triangle that holds it and its position there."""
    first = np.full(len(surface.vertices), -1, dtype=np.int64)
    corners = surface.triangles.ravel()
    first[corners[::-1]] = np.arange(len(corners) - 1, -1, -1)
    return first[vertex] // 3, first[vertex] % 3
