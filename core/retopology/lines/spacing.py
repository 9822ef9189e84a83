"""Which lines of a round stay, so that no two of a family come too near; longest lines first."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ...base.progress import Progress
from ...base.subsets import spans
from .canvas import Canvas
from .rounds import Round
from .seeds import Family, seed_beside

# Lines of a family keep this many samples to a spacing when their distances are compared.
SAMPLES = 2
# A line of which the others of its round leave less than this share waits for a later round.
PATIENCE = 0.8


def accepted(
    canvas: Canvas, drawn: Round, families: list[Family], progress: Progress
) -> Round | None:
    """The lines of a round that stay, cut where they come too near to others; None for none.

    The families take note of them and get new seeds beside them.
    """
    count = len(drawn.family)
    sample = _samples(drawn, SAMPLES / canvas.spacing)
    line, arc = drawn.line[sample], drawn.arc[sample]
    points = canvas.embedded(drawn.triangle[sample], drawn.z[sample])
    # Families do not see each other.
    apart = np.hstack([points, 10.0 * drawn.family[line, None]])
    tree = cKDTree(apart, balanced_tree=False)
    pairs = tree.query_pairs(canvas.near, output_type="ndarray")
    own = line[pairs[:, 0]] == line[pairs[:, 1]]
    begin = np.concatenate([[0], np.cumsum(np.bincount(drawn.line, minlength=count))])
    length = drawn.arc[begin[1:] - 1] - drawn.arc[begin[:-1]]
    blocked = np.zeros(len(sample), bool)
    blocked[_second_turns(canvas, drawn, line, arc, length, pairs[own])] = True
    other = np.concatenate([pairs[~own], pairs[~own][:, ::-1]])
    other = other[np.argsort(other[:, 0], kind="stable")]
    begin_other = np.searchsorted(other[:, 0], np.arange(len(sample) + 1))
    taken = np.zeros(len(sample), bool)
    of_line = np.searchsorted(line, np.arange(count + 1))
    pieces: list[tuple[int, float, float, bool]] = []
    for number in np.argsort(-length, kind="stable"):
        one, two = of_line[number], of_line[number + 1]
        bad = blocked[one:two].copy()
        links = other[begin_other[one] : begin_other[two]]
        bad[links[taken[links[:, 1]], 0] - one] = True
        low, high = _run_around_zero(bad, arc[one:two])
        if high - low < max(canvas.shortest, 1e-12):
            continue
        # Cut short by its neighbours of this round: one that fits better may come later.
        if pieces and high - low < PATIENCE * length[number] and bad.any():
            continue
        whole = not bad.any()
        taken[one:two] = (arc[one:two] >= low) & (arc[one:two] <= high)
        pieces.append((number, -np.inf if whole else low, np.inf if whole else high, whole))
    if not pieces:
        return None
    kept = _cut(drawn, pieces, begin)
    for family in families:
        mine = np.flatnonzero(kept.family[kept.line] == family.number)
        if len(mine):
            some = mine[_samples(kept, 2 * SAMPLES / canvas.spacing, mine)]
            family.add_lines(canvas.embedded(kept.triangle[some], kept.z[some]))
            seed_beside(canvas, kept, mine, family, progress)
    return kept


def _samples(lines: Round, density: float, rows: np.ndarray | None = None) -> np.ndarray:
    """Of the points `rows` of lines (all for None), the places in it of `density` to a length."""
    line, arc = (lines.line, lines.arc) if rows is None else (lines.line[rows], lines.arc[rows])
    cell = np.floor(arc * density).astype(np.int64)
    new = np.ones(len(cell), bool)
    new[1:] = (cell[1:] != cell[:-1]) | (line[1:] != line[:-1])
    return np.flatnonzero(new)


def _second_turns(
    canvas: Canvas,
    drawn: Round,
    line: np.ndarray,
    arc: np.ndarray,
    length: np.ndarray,
    pairs: np.ndarray,
) -> np.ndarray:
    """Samples of lines that come near to themselves far along: of both the one farther from the
    seed, which is on its second turn."""
    one, two = pairs.T
    gap = np.abs(arc[one] - arc[two])
    around = np.where(drawn.closed[line[one]], length[line[one]], np.inf)
    far = np.minimum(gap, around - gap) > 3.0 * canvas.near
    one, two = one[far], two[far]
    return np.where(np.abs(arc[one]) > np.abs(arc[two]), one, two)


def _cut(drawn: Round, pieces: list[tuple[int, float, float, bool]], begin: np.ndarray) -> Round:
    """The stretches (line, from, to, whether whole) of a round's lines."""
    number = np.array([piece[0] for piece in pieces])
    low, high, whole = (np.array([piece[k] for piece in pieces]) for k in (1, 2, 3))
    count = np.diff(begin)[number]
    rows = spans(begin[:-1][number], count)
    line = np.repeat(np.arange(len(number)), count)
    inside = (drawn.arc[rows] >= low[line]) & (drawn.arc[rows] <= high[line])
    rows, line = rows[inside], line[inside]
    return Round(
        line,
        drawn.arc[rows],
        drawn.triangle[rows],
        drawn.z[rows],
        drawn.family[number],
        drawn.closed[number] & whole,
    )


def _run_around_zero(bad: np.ndarray, arc: np.ndarray) -> tuple[float, float]:
    """The stretch of a line around its seed that holds no bad sample, as arcs."""
    seed = int(np.abs(arc).argmin())
    if bad[seed]:
        return 0.0, 0.0
    before = np.flatnonzero(bad[:seed])
    after = np.flatnonzero(bad[seed:])
    low = arc[before[-1] + 1] if len(before) else arc[0]
    high = arc[seed + after[0] - 1] if len(after) else arc[-1]
    return float(low), float(high)
