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
from ...base.subsets import places_in
from ...fields.directions import DirectionField
from ...fields.multigrid import solve, solve_diagonal
from ...fields.winding import Winding
from ...mesh.surface import Surface
from .agreement import rotated
from .turns import Patch, ends_of

# Rings around the triangles whose index is to change in which directions turn.
RINGS = 3
# Weight of a sure direction in that of the edges around it: it is smoothed over about five edges,
# within which the errors of fits are the same.
SURE = 0.01
# Around what is left it is done again, so many times as widely, as often as less is left by that.
WIDER, ROUNDS = 2, 4
# Error at which the solver may stop: only which way each direction points is asked.
TOLERANCE = 1e-2
# Of a solver that sees less far.
NEAR_TOLERANCE = 1e-3
# A trace of the data everywhere keeps the system definite.
LEAST = 1e-6


def filled_in(
    surface: Surface,
    field: DirectionField,
    winding: Winding,
    wanted: np.ndarray,
    held: np.ndarray,
    certainty: np.ndarray,
    progress: Progress,
) -> tuple[DirectionField, Winding]:
    """The field, smooth around triangles whose index is not the wanted one, with its winding;
    elsewhere it stays as it is.

    Parameters
    ----------
    winding:
        That of the field.
    wanted:
        (m,) float64 index that the triangles should have.
    held:
        (n,) bool vertices whose directions must not turn.
    certainty:
        (n,) float64 how sure the directions are, 0 to 1.
    """
    changing = np.flatnonzero(winding.index != wanted)
    for number in range(ROUNDS):
        if not len(changing):
            break
        part = progress.part("Simplifying the field", number / ROUNDS, (number + 1) / ROUNDS)
        patch = Patch.around(surface, surface.triangles[changing], RINGS * WIDER**number)
        # Over so many times the length a direction counts by its square less.
        sure = SURE / WIDER ** (2 * number) * certainty
        after = _filled(surface, field, winding, patch, held, sure, part, number == 0)
        counted = winding.after(surface, patch.vertices, after.direction, after.across)
        left = np.flatnonzero(counted.index != wanted)
        if len(left) >= len(changing):
            break
        field, winding, changing = after, counted, left
    return field, winding


def _filled(
    surface: Surface,
    field: DirectionField,
    winding: Winding,
    patch: Patch,
    held: np.ndarray,
    sure: np.ndarray,
    progress: Progress,
    first: bool,
) -> DirectionField:
    """The field, smooth in a patch; its directions count by `sure` (n,) in the weight of the edges
    around."""
    free = ~(held[patch.vertices] | patch.rim(surface))
    rows = np.flatnonzero(free)
    if not len(rows):
        return field
    half, twin = patch.edges(surface)
    weight = patch.weights(surface, half, twin)
    turn = winding.turns(surface, half, field.direction, field.across)
    row = places_in(patch.vertices, len(surface.vertices))
    tail, head = (row[end] for end in ends_of(surface, half))
    # The unknowns are factors of the powers of the directions, 1 where nothing turns.
    count = len(patch.vertices)
    carried = weight * np.exp(1j * turn)
    off = sparse.coo_array((-carried, (tail, head)), shape=(count, count)).tocsr()
    total = np.bincount(tail, weight, count) + np.bincount(head, weight, count)
    pull = np.maximum(sure[patch.vertices], LEAST) * total
    matrix = (off + off.conj().T + sparse.diags_array((total + pull).astype(complex))).tocsr()
    right = pull.astype(complex)
    if len(rows) < count:
        matrix = matrix[rows]
        right = pull[rows] - matrix @ (~free).astype(complex)
        matrix = matrix[:, rows].tocsr()
    factor = np.ones(count, complex)
    factor[rows] = (
        solve_diagonal(matrix, right, progress, NEAR_TOLERANCE)
        if first
        else solve(matrix, right, progress, TOLERANCE)
    )
    angle = np.zeros(len(surface.vertices))
    angle[patch.vertices] = np.angle(factor) / field.symmetry
    return replace(field, direction=rotated(field.direction, field.across, angle))
