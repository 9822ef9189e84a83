"""How large quads shall be: of one size, or smaller where the surface bends."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from ....base.factors import definite_factors
from ....mesh.half_edges import ends_of
from .working_surface import WorkingSurface

# Quads are at most so much smaller and larger than the mean one.
SMALLEST, LARGEST = 0.25, 2.0
# Sizes change over this many lengths of quads, but over no more than so many times the surface's
# own: then they are one size to five digits, and a system that is stiffer still has no factors.
SMOOTHED, WIDEST = 3.0, 100.0


def sizes(working: WorkingSurface, size: float, adaptivity: float) -> np.ndarray:
    """(m,) float64 length of a quad's edge in each triangle, as many quads in all as with `size`.

    The distance from an edge of length s to a surface of curvature k grows with k s^2: with
    adaptivity 1 it is the same everywhere, within bounds.
    """
    surface = working.surface
    triangles = surface.triangles
    if adaptivity <= 0.0:
        return np.full(len(triangles), size)
    _, area = surface.face_normal_area
    bend = np.sqrt(0.5 * (working.field.k1**2 + working.field.k2**2))
    bend = np.nan_to_num(bend)
    typical = float(np.median(bend[bend > 0])) if (bend > 0).any() else 1.0
    wanted = -0.5 * adaptivity * np.log(np.maximum(bend / typical, 1e-6))
    wanted = np.clip(wanted, np.log(SMALLEST), np.log(LARGEST))
    n = len(surface.vertices)
    around = np.bincount(triangles.ravel(), np.repeat(area / 3.0, 3), minlength=n)
    tail, head = ends_of(triangles)
    graph = sparse.coo_array((np.full(len(tail), 0.5), (tail, head)), shape=(n, n)).tocsr()
    graph = graph + graph.T
    length = min(SMOOTHED * size, WIDEST * float(np.sqrt(area.sum())))
    stiff = length**2 * (sparse.diags_array(graph.sum(axis=1)) - graph)
    smooth = definite_factors(stiff + sparse.diags_array(around)).solve(around * wanted)
    result = np.exp(smooth[triangles].mean(axis=1))
    return size * result * np.sqrt((area / result**2).sum() / area.sum())
