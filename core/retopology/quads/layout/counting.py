"""As many quads as asked for, and grids that merge nothing that must stay apart."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ....base.errors import RemeshError
from ....base.progress import Progress
from ..conformity import conformity, torn
from .grids import Grids, grids, violations
from .integer_program import Count, sides_of
from .integers import lengths_of_count, whole_lengths
from .laying_out import LaidOut

# The number of quads may be off by this part; rounds of asking for more or fewer, and the part by
# which scales differ at least.
CLOSE, ROUNDS, CLOSEST = 0.025, 5, 1e-4
# Rounds in which the number of quads is bounded, linear about the last numbers.
LINEAR_ROUNDS = 4
# Fewer quads than this part of those before are fewer.
LESS = 0.98
# Rounds of forbidding merges before every arc gets a length; those in which arcs where quads do not
# join up get longer, before all do, and the most that each gets.
MOST_CUTS, LONGER, MOST_LEAST = 12, 8, 3
# Rectangles of a layout that may be more than its quads. A wireframe of genus 79 has 2,340: at
# 4,000 quads their whole numbers take half a minute, at 2,000 several.
MOST_RECTANGLES = 1000


def countable(parts: list[LaidOut], progress: Progress) -> tuple[list[LaidOut], list[LaidOut]]:
    """The parts that have whole numbers of quads at all, and those that have none, as their lengths
    contradict what must stay apart."""
    having: list[LaidOut] = []
    without: list[LaidOut] = []
    for laid in parts:
        try:
            _affordable(laid)
            whole_grids(laid, 1.0, first_cuts(laid), progress)
        except RemeshError:
            without.append(laid)
        else:
            having.append(laid)
    return having, without


def grids_of_about(parts: list[LaidOut], asked: int, progress: Progress) -> list[Grids]:
    """Grids with about as many quads as asked for.

    Raises
    ------
    RemeshError
        A part has no whole numbers, see `countable`.
    """
    for laid in parts:
        _affordable(laid)
    scale = 1.0
    best: tuple[float, float, list[Grids]] = np.inf, scale, []
    cuts: list[set[frozenset[int]]] = [first_cuts(laid) for laid in parts]
    # Scales that are known to make too few and too many.
    low, high, fewest = 0.0, np.inf, np.inf
    # With more rectangles than quads most have no width as it is, and other scales, each of many
    # seconds then, win little.
    crowded = sum(len(laid.layout.rectangles) for laid in parts) >= asked
    for attempt in range(ROUNDS):
        progress.step(attempt / ROUNDS)
        made = [
            whole_grids(laid, scale, cut, progress) for laid, cut in zip(parts, cuts, strict=True)
        ]
        total = sum(len(grid.quads) for grid in made)
        off = float(abs(np.log(max(total, 1) / asked)))
        if off < best[0]:
            best = off, scale, made
        if off <= CLOSE or (total > asked and (crowded or total >= LESS * fewest)):
            # Smaller lengths no longer make fewer: what must stay apart needs so many.
            break
        fewest = min(fewest, total) if total > asked else fewest
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
    off, scale, made = best
    if off > CLOSE and not crowded:
        made = _bounded(parts, asked, scale, made, cuts, progress)
    return made


def _affordable(laid: LaidOut) -> None:
    """Refuse layouts of very many rectangles that outnumber the quads.

    Raises
    ------
    RemeshError
        It is one.
    """
    if outnumbered(laid):
        raise RemeshError("More rectangles than quads in a piece. Ask for more quads.")


def outnumbered(laid: LaidOut) -> bool:
    """Whether a layout has very many rectangles, and more than quads: most would have no width, and
    what must stay apart is found by hundreds of large linear programs."""
    layout = laid.layout
    if len(layout.rectangles) <= MOST_RECTANGLES:
        return False
    width, height = (sides_of(layout) @ layout.length).reshape(-1, 4)[:, :2].T
    return len(layout.rectangles) > float(width @ height)


def _bounded(
    parts: list[LaidOut],
    asked: int,
    scale: float,
    made: list[Grids],
    cuts: list[set[frozenset[int]]],
    progress: Progress,
) -> list[Grids]:
    """Grids with a number of quads nearer to the one asked for, the largest pieces first."""
    made = list(made)
    sizes = [len(grid.quads) for grid in made]
    for number in np.argsort(sizes)[::-1].tolist():
        wanted = asked - sum(sizes) + sizes[number]
        near, more = made[number].lengths, 0.0
        for _ in range(LINEAR_ROUNDS):
            if abs(sizes[number] - wanted) <= CLOSE * asked:
                return made
            low, high = wanted - CLOSE * asked, wanted + CLOSE * asked
            count = Count(near, low + more, high + more)
            grid = grids_of_count(parts[number], scale, cuts[number], count, progress)
            if grid is None:
                break
            # What the products of changes have taken or added is asked for the next time.
            more += float(np.clip(len(grid.quads), low, high)) - len(grid.quads)
            near = grid.lengths
            if abs(len(grid.quads) - wanted) < abs(sizes[number] - wanted):
                made[number], sizes[number] = grid, len(grid.quads)
    return made


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
    found = _sound(laid, cuts, lambda: whole_lengths(layout, scale, cuts, 0, progress))
    if found is not None:
        return found
    # Where every arc has a length nothing is merged; sides of one quad may still come back to
    # where they began, and those of two quads meet twice.
    least = np.ones(len(layout.arc_track), np.int64)
    found = grids(layout, whole_lengths(layout, scale, set(), least, progress))
    for _ in range(LONGER):
        here = _arcs_at(found, torn(found.merged[found.quads], found.count))
        if _conforms(found, laid) or not here.any():
            break
        least = np.where(here, np.maximum(found.lengths, least) + 1, least)
        found = grids(layout, whole_lengths(layout, scale, set(), least, progress))
    each = 1
    while each < MOST_LEAST and not _conforms(found, laid):
        each += 1
        found = grids(layout, whole_lengths(layout, scale, set(), each, progress))
    return found


def _arcs_at(made: Grids, vertices: np.ndarray) -> np.ndarray:
    """(a,) bool arcs with a vertex in a set (n,) bool of merged ones."""
    return np.array([bool(vertices[made.merged[along]].any()) for along in made.arc_vertices])


def grids_of_count(
    laid: LaidOut, scale: float, cuts: set[frozenset[int]], count: Count, progress: Progress
) -> Grids | None:
    """As `whole_grids`, with about so many quads; None where none were found."""
    return _sound(
        laid,
        cuts,
        lambda: lengths_of_count(laid.layout, scale, cuts, count, progress),
    )


def _sound(
    laid: LaidOut, cuts: set[frozenset[int]], lengths: Callable[[], np.ndarray | None]
) -> Grids | None:
    """Grids of lengths that merge nothing that must stay apart; None where there are none."""
    for _ in range(MOST_CUTS):
        found = lengths()
        if found is None:
            return None
        grid = grids(laid.layout, found)
        new = violations(laid.layout, grid) - cuts
        if not new and len(grid.quads):
            if _conforms(grid, laid):
                return grid
            here = _arcs_at(grid, torn(grid.merged[grid.quads], grid.count)) & (found == 0)
            new = {frozenset([arc]) for arc in np.flatnonzero(here).tolist()} - cuts
        if not new:
            return None
        cuts |= new
    return None


def _conforms(grid: Grids, laid: LaidOut) -> bool:
    quads = grid.merged[grid.quads]
    found = conformity(quads, int(grid.merged.max()) + 1)
    return found.manifold and found.characteristic == characteristic(laid)


def characteristic(laid: LaidOut) -> int:
    """Euler characteristic of the surface that is laid out."""
    return int(laid.working.surface.euler_characteristic.sum())
