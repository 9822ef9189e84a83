"""Opposite singularities of a cross field that no quad could part, taken out of it for certain.

Filling the field in around them (`dipoles`) lets go of most of them and leaves it smooth. What is
left then, as on fingers, toes and ears smaller than a quad, cancels here, the nearest first.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ...base.progress import Progress
from ...fields.directions import DirectionField
from ...mesh.half_edges import ends_of, inner_edges
from ...mesh.surface import Surface
from .agreement import with_index
from .simplified import STIFF

# Once a pair is gone others are next to each other; after so many rounds the rest stays.
ROUNDS = 4
# Over the middles of triangles a way is up to so many times as long as it is straight.
DETOUR = 1.5


def without_near_pairs(
    surface: Surface,
    field: DirectionField,
    index: np.ndarray,
    confidence: np.ndarray,
    held: np.ndarray,
    apart: float,
    progress: Progress,
) -> tuple[np.ndarray, np.ndarray]:
    """The directions (n, 3) of a cross field without opposite singularities that are nearer along
    the surface than a length, and its index (m,).

    Parameters
    ----------
    index:
        (m,) float64 of the field.
    confidence:
        (n,) float64 how sure the directions are, 0 to 1.
    held:
        (n,) bool vertices whose directions stay, as on features.
    apart:
        Length that opposite singularities must be apart.
    """
    wanted = _uncancelled(surface, index, held, apart)
    if np.array_equal(wanted, index):
        return field.direction, index
    none = np.zeros(len(index))
    found = with_index(surface, field, wanted, none, STIFF * confidence, progress, held)
    return found.field.direction, found.index


def _uncancelled(
    surface: Surface, index: np.ndarray, held: np.ndarray, apart: float
) -> np.ndarray:
    """(m,) the index without pairs, the nearest cancelled first; those on what is held stay, and
    ways do not cross it."""
    quarters = np.rint(4.0 * index).astype(np.int64)
    touching = held[surface.triangles].any(axis=1)
    middle = surface.vertices[surface.triangles].mean(axis=1)
    side = inner_edges(surface.twin)
    here, there = side // 3, surface.twin[side] // 3
    tail, head = ends_of(surface.triangles, side)
    way = ~(held[tail] & held[head])
    here, there = here[way], there[way]
    length = np.linalg.norm(middle[here] - middle[there], axis=1)
    graph = sparse.coo_array((length, (here, there)), shape=(len(index),) * 2).tocsr()
    for _ in range(ROUNDS):
        source = np.flatnonzero((quarters != 0) & ~touching)
        if not (quarters[source] > 0).any() or not (quarters[source] < 0).any():
            break
        distance, _, owner = csgraph.dijkstra(
            graph,
            directed=False,
            indices=source,
            min_only=True,
            return_predecessors=True,
            limit=DETOUR * apart,
        )
        # -9999 stands for none.
        one, two = owner[here], owner[there]
        bridge = np.flatnonzero((one >= 0) & (two >= 0))
        bridge = bridge[quarters[one[bridge]] * quarters[two[bridge]] < 0]
        total = distance[here[bridge]] + length[bridge] + distance[there[bridge]]
        straight = np.linalg.norm(middle[one[bridge]] - middle[two[bridge]], axis=1)
        near = (straight < apart) & (total < DETOUR * apart)
        order = np.argsort(total, kind="stable")
        order = order[near[order]]
        changed = False
        for row in bridge[order].tolist():
            first, second = int(one[row]), int(two[row])
            if quarters[first] * quarters[second] < 0:
                gone = int(np.sign(quarters[first]))
                quarters[first] -= gone
                quarters[second] += gone
                changed = True
        if not changed:
            break
    return quarters / 4.0
