"""Opposite singularities of a cross field that stand closer than it resolves, taken together.

Between two that are an edge or a smoothing length apart no quad fits, and beside an umbilic the
fourth powers of directions that turn fast from vertex to vertex make such pairs out of nothing. The
field forgets its data around them and is filled in harmonically; opposite ones then meet and are
gone, as the discrete index says.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy import sparse
from scipy.spatial import cKDTree

from ...base.progress import Progress
from ...fields.multigrid import solve_part
from ...fields.winding import certified_index
from ...mesh.surface import Surface

# No quad fits between two that are nearer than so many edges of the triangles: these do not tell
# where between them the field turns. Pairs that sampling makes beside umbilics of ellipsoids, clean
# and with noise, are .4 to 1.4 edges apart.
CLOSEST = 1.5
# The field is filled in over a disc that reaches so many of their distances beyond a pair in the
# first round, twice as many in the second and so on: a tighter disc may keep them apart, a wider
# one forgets more than it must.
MARGIN, ROUNDS = 1.0, 3
# A singularity is joined with this many of the nearest opposite ones: where a large triangle brings
# all of them within reach, pairs of all with all would be too many to look at.
PARTNERS = 4
DISCS_PER_BLOCK = 64


def without_dipoles(
    surface: Surface,
    laplacian: sparse.csr_array,
    u: np.ndarray,
    fixed: np.ndarray,
    normal: np.ndarray,
    direction: Callable[[np.ndarray], np.ndarray],
    apart: float,
    progress: Progress,
) -> tuple[np.ndarray, np.ndarray]:
    """The field u (n,) with fewer pairs, and its index (m,) in each triangle.

    Parameters
    ----------
    laplacian:
        (n, n) complex connection Laplacian of the field's powers.
    fixed:
        (n,) bool vertices whose values stay.
    normal:
        (n, 3) float64 unit normals.
    direction:
        Gives one direction (n, 3) of the crosses u.
    apart:
        Length that opposite singularities must be apart.
    """

    def indices(field: np.ndarray) -> np.ndarray:
        d1 = direction(field)
        return certified_index(surface, d1, np.cross(normal, d1), progress.quiet(), symmetry=4)

    index = indices(u)
    for number in range(1, ROUNDS + 1):
        progress.ask()
        margin = MARGIN * number
        free = np.flatnonzero(_around_pairs(surface, index, normal, apart, margin) & ~fixed)
        if not len(free):
            break
        filled = _filled(laplacian, u, free, progress.quiet())
        after = indices(filled)
        if np.count_nonzero(after) < np.count_nonzero(index):
            u, index = filled, after
    return u, index


def _around_pairs(
    surface: Surface, index: np.ndarray, normal: np.ndarray, apart: float, margin: float
) -> np.ndarray:
    """(n,) bool, True at vertices in the discs around opposite singularities."""
    chosen = np.zeros(len(surface.vertices), bool)
    single = np.flatnonzero(index)
    corner = surface.vertices[surface.triangles[single]]
    place, upright = corner.mean(axis=1), surface.face_normal_area[0][single]
    edge = surface.mean_sides(single)
    reach = np.maximum(apart, CLOSEST * edge)
    one, two = _nearest_opposite(place, index[single])
    distance = np.linalg.norm(place[one] - place[two], axis=1)
    close = distance <= np.minimum(reach[one], reach[two])
    close &= np.einsum("pc,pc->p", upright[one], upright[two]) > 0
    one, two, distance = one[close], two[close], distance[close]
    middle = 0.5 * (place[one] + place[two])
    radius = 0.5 * distance + margin * np.maximum(distance, np.maximum(edge[one], edge[two]))
    tree = cKDTree(surface.vertices)
    # The largest discs first; a pair with all its corners inside these needs none of its own.
    order = np.argsort(-radius, kind="stable")
    for first in range(0, len(order), DISCS_PER_BLOCK):
        some = order[first : first + DISCS_PER_BLOCK]
        corners = surface.triangles[single[np.stack([one[some], two[some]], axis=1)]]
        some = some[~chosen[corners].all(axis=(1, 2))]
        near = tree.query_ball_point(middle[some], radius[some])
        for pair, found in zip(some, near, strict=True):
            vertex = np.asarray(found, np.int64)
            # Not the other side of a thin sheet.
            chosen[vertex[normal[vertex] @ upright[one[pair]] > 0]] = True
    return chosen


def _nearest_opposite(place: np.ndarray, index: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pairs (p,) and (p,) of singularities: each with the `PARTNERS` nearest of the other sign."""
    positive, negative = np.flatnonzero(index > 0), np.flatnonzero(index < 0)
    if not len(positive) or not len(negative):
        return positive[:0], negative[:0]
    pairs = []
    for mine, theirs in ((positive, negative), (negative, positive)):
        count = min(PARTNERS, len(theirs))
        near = cKDTree(place[theirs]).query(place[mine], k=np.arange(1, count + 1))[1]
        pair = np.stack([np.repeat(mine, count), theirs[near.ravel()]])
        pairs.append(pair if mine is positive else pair[::-1])
    one, two = np.unique(np.concatenate(pairs, axis=1), axis=1)
    return one, two


def _filled(
    laplacian: sparse.csr_array, u: np.ndarray, free: np.ndarray, progress: Progress
) -> np.ndarray:
    """u with the harmonic field between the others at the vertices `free`."""
    inside = np.zeros(len(u), bool)
    inside[free] = True
    known = np.where(inside, 0.0, u)
    rows = laplacian[free]
    system = rows[:, free]
    # A disc without a rim, a small component all in it, has no harmonic field but zero.
    system = (system + sparse.diags_array(1e-9 * system.diagonal())).tocsr()
    result = u.copy()
    result[free] = solve_part(system, -(rows @ known), progress)
    return result
