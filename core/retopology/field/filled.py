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
from ...fields.multigrid import solve_diagonal
from ...fields.winding import Winding
from ...mesh.half_edges import ends_of
from ...mesh.surface import Surface
from .agreement import rotated
from .turns import Cutout

# Rings around the triangles whose index is to change in which directions turn.
RINGS = 3
# Weight of a sure direction in that of the edges around it: it is smoothed over about five edges,
# within which the errors of fits are the same.
SURE = 0.01
# Error at which the solver may stop: only which way each direction points is asked. Where nothing
# is sure what lies far apart matters too; what it does not see of that is left to be moved.
TOLERANCE = 3e-4
# A trace of the data everywhere keeps the system definite.
LEAST = 1e-6


def filled_in(
    surface: Surface,
    field: DirectionField,
    winding: Winding,
    changing: np.ndarray,
    held: np.ndarray,
    certainty: np.ndarray,
    progress: Progress,
) -> tuple[DirectionField, Winding]:
    """The field, smooth around triangles, with its winding; elsewhere it stays as it is.

    Parameters
    ----------
    winding:
        That of the field.
    changing:
        (c,) int64 triangles whose index is to change.
    held:
        (n,) bool vertices whose directions must not turn.
    certainty:
        (n,) float64 how sure the directions are, 0 to 1.
    """
    cutout = Cutout.around(surface, surface.triangles[changing], RINGS)
    free = ~(held[cutout.vertices] | cutout.rim(surface))
    rows = np.flatnonzero(free)
    if not len(rows):
        return field, winding
    half, twin = cutout.edges(surface)
    weight = cutout.weights(surface, half, twin)
    turn = winding.turns(surface, half, field.direction, field.across)
    row = places_in(cutout.vertices, len(surface.vertices))
    tail, head = (row[end] for end in ends_of(surface.triangles, half))
    count = len(cutout.vertices)
    total = np.bincount(tail, weight, count) + np.bincount(head, weight, count)
    pull = np.maximum(SURE * certainty[cutout.vertices], LEAST) * total
    # The unknowns are factors of the powers of the directions, 1 where nothing turns.
    carried = weight * np.exp(1j * turn)
    right = pull[rows].astype(complex)
    place = places_in(rows, count)
    one, two = place[tail], place[head]
    for here, there, value in ((one, two, carried), (two, one, carried.conj())):
        rim = np.flatnonzero((here >= 0) & (there < 0))
        np.add.at(right, here[rim], value[rim])
    some = np.flatnonzero((one >= 0) & (two >= 0))
    one, two, own = one[some], two[some], np.arange(len(rows))
    entries = np.concatenate([(total + pull)[rows], -carried[some], -carried[some].conj()])
    at = np.concatenate([own, one, two]), np.concatenate([own, two, one])
    matrix = sparse.coo_array((entries, at), shape=(len(rows), len(rows)))
    # The solver needs no sorted rows.
    matrix.has_canonical_format = True
    factor = np.ones(count, complex)
    factor[rows] = solve_diagonal(matrix.tocsr(), right, progress, TOLERANCE)
    angle = np.zeros(len(surface.vertices))
    angle[cutout.vertices] = np.angle(factor) / field.symmetry
    found = replace(field, direction=rotated(field.direction, field.across, angle))
    return found, winding.after(surface, cutout.vertices, found.direction, found.across)
