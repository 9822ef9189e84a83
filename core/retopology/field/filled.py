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
from ...fields.winding import certified_index
from ...mesh.surface import Surface
from .agreement import rotated
from .turns import Patch, turns_at_vertices

# Rings around the triangles whose index is to change in which directions turn.
RINGS = 3
# Weight of a sure direction in that of the edges around it: it is smoothed over about five edges,
# within which the errors of fits are the same.
SURE = 0.01
# Around what is left it is done again, so many times as widely, as often as that helps.
WIDER, ROUNDS = 2, 3
# Error at which the solver may stop: only which way each direction points is asked.
TOLERANCE = 1e-2
# A trace of the data everywhere keeps the system definite.
LEAST = 1e-6


def filled_in(
    surface: Surface,
    field: DirectionField,
    index: np.ndarray,
    wanted: np.ndarray,
    held: np.ndarray,
    certainty: np.ndarray,
    progress: Progress,
) -> DirectionField:
    """The field, smooth around triangles that have not the wanted index; elsewhere it stays as it
    is.

    Parameters
    ----------
    index, wanted:
        (m,) float64 index of the field, and that which it should have.
    held:
        (n,) bool vertices whose directions must not turn.
    certainty:
        (n,) float64 how sure the directions are, 0 to 1.
    """
    changing = np.flatnonzero(index != wanted)
    for number in range(ROUNDS):
        if not len(changing):
            break
        part = progress.part("Simplifying the field", number / ROUNDS, (number + 1) / ROUNDS)
        rings = RINGS * WIDER**number
        # Over so many times the length a direction counts by its square less.
        sure = SURE / WIDER ** (2 * number) * certainty
        after = _filled(surface, field, changing, rings, held, sure, part)
        index = certified_index(
            surface, after.direction, after.across, part.quiet(), field.symmetry
        )
        left = np.flatnonzero(index != wanted)
        if len(left) >= len(changing):
            break
        field, changing = after, left
    return field


def _filled(
    surface: Surface,
    field: DirectionField,
    changing: np.ndarray,
    rings: int,
    held: np.ndarray,
    sure: np.ndarray,
    progress: Progress,
) -> DirectionField:
    """The field, smooth in some rings around triangles (c,); the directions count by `sure` (n,)
    in the weight of the edges around."""
    patch = Patch.around(surface, surface.triangles[changing], rings)
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
    pull = np.maximum(sure[patch.vertices], LEAST) * total
    matrix = (off + off.conj().T + sparse.diags_array((total + pull).astype(complex))).tocsr()[rows]
    right = pull[rows] - matrix @ (~free).astype(complex)
    factor = np.ones(count, complex)
    factor[rows] = solve(matrix[:, rows].tocsr(), right, progress, TOLERANCE)
    angle = np.zeros(len(surface.vertices))
    angle[patch.vertices] = np.angle(factor) / field.symmetry
    return replace(field, direction=rotated(field.direction, field.across, angle))
