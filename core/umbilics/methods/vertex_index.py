"""Method I: the index of the principal directions around every vertex."""

from __future__ import annotations

import numpy as np

from ...base.progress import Progress
from ...curvature.field import CurvatureField
from ...fields.transport import carried, doubled_angle, tangents
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


def _total_jump(surface: Surface, curvature: CurvatureField, progress: Progress) -> np.ndarray:
    """(n,) sum of the jumps of the deviator's argument around the ring of each inner vertex."""
    corner_vertex = surface.triangles.ravel()
    neighbour = np.roll(surface.triangles, -1, axis=1).ravel()
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
