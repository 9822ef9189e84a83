"""A field made to have exactly the index that is wanted in every triangle."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...base.progress import Progress
from ...fields.directions import DirectionField
from ...fields.winding import Winding
from ...mesh.surface import Surface
from .settling import balances, settle
from .turns import Cutout, turns_at_vertices

# Rings around charges that are to move, within which they are looked for to cancel first; where
# that is most of the surface, or not enough, it is all of it.
NEARBY, MOST = 12, 0.5


@dataclass(frozen=True)
class Agreement:
    """A field that agrees with what is wanted as far as it can.

    Attributes
    ----------
    field:
        The field; its directions have changed around the triangles whose index had to.
    index:
        (m,) float64 its certified index.
    stayed:
        (s,) int64 triangles whose index is not the one wanted: the sum over the surface does not
        allow it, there is no way to what would balance it, or the normals turn too wildly there.
    """

    field: DirectionField
    index: np.ndarray
    stayed: np.ndarray


def with_index(
    surface: Surface,
    field: DirectionField,
    wanted: np.ndarray,
    priority: np.ndarray,
    stiffness: np.ndarray,
    progress: Progress,
    held: np.ndarray | None = None,
    winding: Winding | None = None,
) -> Agreement:
    """Turn the directions of a field so that its index is the wanted one.

    Parameters
    ----------
    wanted:
        (m,) float64 multiples of 1 / symmetry.
    priority:
        (m,) float64: where the sums do not agree, what differs stays as it is where this is
        highest.
    stiffness:
        (n,) float64 by which directions resist to turning, in the resistance of an edge.
    held:
        (n,) bool vertices whose directions must not turn.
    winding:
        That of the field, where it is known.
    """
    if winding is None:
        part = progress.part("Counting", 0.0, 0.1)
        winding = Winding.of(surface, field.direction, field.across, part, field.symmetry)
    index = winding.index
    charge = np.rint(field.symmetry * (index - wanted)).astype(np.int64)
    changing = np.flatnonzero(charge)
    before = Agreement(field, index, changing)
    if not len(changing):
        return before
    angle = np.zeros(len(surface.vertices))
    nearby = Cutout.around(surface, surface.triangles[changing], NEARBY)
    cutouts = [Cutout.whole(surface)]
    if len(nearby.triangles) < MOST * len(index):
        cutouts.insert(0, nearby)
    for number, cutout in enumerate(cutouts):
        turns = turns_at_vertices(surface, cutout, field, winding)
        mine, rim = charge[cutout.triangles], cutout.rim(surface)
        if held is not None:
            rim |= held[cutout.vertices]
        last = number == len(cutouts) - 1
        if not last and not balances(turns, mine, rim):
            continue
        part = progress.part("Simplifying the field", 0.1, 0.9)
        settled = settle(
            turns, mine, priority[cutout.triangles], rim, stiffness[cutout.vertices], part
        )
        if last or not settled.left.any():
            angle[cutout.vertices] = settled.angle
            break
    turned = replace(
        field, direction=rotated(field.direction, field.across, angle / field.symmetry)
    )
    changed = np.flatnonzero(angle)
    after = winding.after(surface, changed, turned.direction, turned.across).index
    stayed = np.flatnonzero(after != wanted)
    # Where normals turn wildly, rather as it was than worse.
    return Agreement(turned, after, stayed) if len(stayed) <= len(changing) else before


def rotated(direction: np.ndarray, across: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """(n, 3) unit directions turned by angles (n,) towards those at right angles to them; the very
    same where the angle is 0."""
    cosine, sine = np.cos(angle)[:, None], np.sin(angle)[:, None]
    return np.where(angle[:, None] != 0.0, cosine * direction + sine * across, direction)
