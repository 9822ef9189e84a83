"""As many quads as asked for, and grids that merge nothing that must stay apart."""

from __future__ import annotations

import numpy as np

from ....base.progress import Progress
from ..conformity import conformity
from .grids import Grids, grids, violations
from .integers import whole_lengths
from .laying_out import LaidOut

# The number of quads may be off by this part; rounds of asking for more or fewer, and the part by
# which scales differ at least.
CLOSE, ROUNDS, CLOSEST = 0.025, 9, 1e-4
# Rounds of forbidding merges before every arc gets a length.
MOST_CUTS = 12


def counted(parts: list[LaidOut], asked: int, progress: Progress) -> tuple[float, list[Grids]]:
    """Grids with about as many quads as asked for, and what lengths were multiplied with."""
    scale = 1.0
    best: tuple[float, float, list[Grids]] = np.inf, scale, []
    cuts: list[set[frozenset[int]]] = [first_cuts(laid) for laid in parts]
    # Scales that are known to make too few and too many.
    low, high = 0.0, np.inf
    for attempt in range(ROUNDS):
        progress.step(attempt / ROUNDS)
        made = [
            whole_grids(laid, scale, cut, progress) for laid, cut in zip(parts, cuts, strict=True)
        ]
        total = sum(len(grid.quads) for grid in made)
        off = float(abs(np.log(max(total, 1) / asked)))
        if off < best[0]:
            best = off, scale, made
        if off <= CLOSE:
            break
        if total < asked:
            low = max(low, scale)
        else:
            high = min(high, scale)
        scale *= float(np.clip(np.sqrt(asked / max(total, 1)), 0.5, 2.0))
        # Whole numbers jump: what was tried is not tried again.
        if not low * (1.0 + CLOSEST) < scale < high * (1.0 - CLOSEST):
            if not low * (1.0 + CLOSEST) ** 2 < high or np.isinf(high) or low == 0.0:
                break
            scale = float(np.sqrt(low * high))
    return best[1:]


def first_cuts(laid: LaidOut) -> set[frozenset[int]]:
    """Arcs between two poles or ends of features always have a length."""
    special = np.array([node.vertex >= 0 for node in laid.layout.nodes])
    both = special[laid.layout.arc_node].all(axis=1)
    return {frozenset([arc]) for arc in np.flatnonzero(both).tolist()}


def whole_grids(
    laid: LaidOut, scale: float, cuts: set[frozenset[int]], progress: Progress
) -> Grids:
    """Grids that merge nothing that must stay apart; `cuts` gathers what was forbidden."""
    layout = laid.layout
    for _ in range(MOST_CUTS):
        grid = grids(layout, whole_lengths(layout, scale, cuts, 0, progress))
        new = violations(layout, grid) - cuts
        if not new and len(grid.quads):
            if _conforms(grid, laid):
                return grid
            break
        cuts |= new
    # Where every arc has a length nothing is merged.
    return grids(layout, whole_lengths(layout, scale, set(), 1, progress))


def _conforms(grid: Grids, laid: LaidOut) -> bool:
    quads = grid.merged[grid.quads]
    found = conformity(quads, int(grid.merged.max()) + 1)
    return found.manifold and found.characteristic == characteristic(laid)


def characteristic(laid: LaidOut) -> int:
    return int(laid.working.surface.euler_characteristic.sum())
