"""A field smoothed where singularities are to leave: most of them leave by that alone.

Directions that noise swirls say little each, but together what they mean: around dropped umbilics
the field is made as smooth as its sure directions allow, up to a rim and to what must not turn
(after Knoeppel et al. 2013). The few charges that are left after that are then moved one by one.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import sparse

from ...base.progress import Progress
from ...fields.directions import DirectionField
from ...fields.multigrid import solve
from ...mesh.surface import Surface
from .agreement import rotated
from .turns import Patch, turns_at_vertices

# Rings around the triangles whose index is to change in which directions turn.
RINGS = 3
# Weight of a sure direction in that of the edges around it: it is smoothed over about five edges,
# within which the errors of fits are the same.
SURE = 0.01
# Error at which the solver may stop: only which way each direction points is asked.
TOLERANCE = 1e-2
# A trace of the data everywhere keeps the system definite.
LEAST = 1e-6


def filled_in(
    surface: Surface,
    field: DirectionField,
    changing: np.ndarray,
    held: np.ndarray,
    certainty: np.ndarray,
    progress: Progress,
) -> DirectionField:
    """The field, smooth around triangles; elsewhere it stays as it is.

    Parameters
    ----------
    changing:
        (c,) int64 triangles whose index is to change.
    held:
        (n,) bool vertices whose directions must not turn.
    certainty:
        (n,) float64 how sure the directions are, 0 to 1.
    """
    patch = Patch.around(surface, surface.triangles[changing], RINGS)
    turns = turns_at_vertices(surface, patch, field)
    free = ~(held[patch.vertices] | patch.rim(surface))
    rows = np.flatnonzero(free)
    if not len(rows):
        return field
    # The unknowns are factors of the powers of the directions, 1 where nothing turns.
    count = turns.directions
    carried = turns.weight * np.exp(1j * turns.turn)
    off = sparse.coo_array((-carried, (turns.tail, turns.head)), shape=(count, count)).tocsr()
    total = np.bincount(turns.tail, turns.weight, count)
    total += np.bincount(turns.head, turns.weight, count)
    pull = np.maximum(SURE * certainty[patch.vertices], LEAST) * total
    matrix = (off + off.conj().T + sparse.diags_array((total + pull).astype(complex))).tocsr()[rows]
    right = pull[rows] - matrix @ (~free).astype(complex)
    factor = np.ones(count, complex)
    factor[rows] = solve(matrix[:, rows].tocsr(), right, progress, TOLERANCE)
    angle = np.zeros(len(surface.vertices))
    angle[patch.vertices] = np.angle(factor) / field.symmetry
    return replace(field, direction=rotated(field.direction, field.across, angle))
