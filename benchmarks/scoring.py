"""How well a set of umbilics matches the true ones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from core.umbilics.result import UNCERTAIN

from .cases import Case

REACH = 5.0
"""Umbilics further than this many edges from every true one are false. Edges are those around
the true umbilic: on a Möbius image they differ by a factor of ten."""


SPLIT_REACH = 16.0
"""The same around a true umbilic of larger index. It is not generic: any error splits it into
ones of index +-1/2, as far apart as the square root of the error."""


@dataclass(frozen=True)
class Score:
    """Counts and errors of one program on one mesh.

    Attributes
    ----------
    found, missed:
        True umbilics whose index is matched by the sum of those found within `REACH`, and the
        others.
    false:
        Umbilics that no true one needs.
    mean_error, worst_error:
        Distance in edges from the found true umbilics of index +-1/2 to the nearest match; NaN
        without any.
    matched, kinds:
        How many these are, and how many of them have the right kind.
    """

    found: int
    missed: int
    false: int
    mean_error: float
    worst_error: float
    matched: int
    kinds: int


def score(
    case: Case,
    positions: np.ndarray,
    index: np.ndarray,
    kinds: np.ndarray | None,
    region_centres: list[np.ndarray] | tuple = (),
    region_index: list[float] | tuple = (),
) -> Score:
    """Compare umbilics (k, 3) with indices (k,) and kinds (k,) with the truth of a case.

    Regions count by their index and centre, but are never false.
    """
    truth = case.umbilics
    if len(truth) == 0:
        return Score(0, 0, len(index), np.nan, np.nan, 0, 0)
    reach = np.where(np.abs(truth.index) > 0.5, SPLIT_REACH, REACH)
    nearest, away = _nearest(positions, truth.position, case.edge_at(truth.position))
    region_nearest, region_away = _nearest(
        np.array(region_centres).reshape(-1, 3), truth.position, case.edge_at(truth.position)
    )
    total = np.array(region_index, dtype=float)
    found, right, needed, errors = 0, 0, 0, []
    for number in range(len(truth)):
        rows = np.flatnonzero((nearest == number) & (away <= reach[number]))
        regions = (region_nearest == number) & (region_away <= reach[number])
        by_regions = total[regions].sum()
        if index[rows].sum() + by_regions != truth.index[number]:
            continue
        found += 1
        # One of index +1 stands for two of +1/2, and the other way round.
        sign = np.sign(truth.index[number])
        whole = len(rows) and (index[rows] * sign > 0).all()
        needed += len(rows) if whole else round(2 * abs(truth.index[number] - by_regions))
        same = rows[index[rows] == truth.index[number]]
        if abs(truth.index[number]) == 0.5 and len(same):
            best = same[away[same].argmin()]
            errors.append(away[best])
            right += kinds is not None and kinds[best] == truth.kind[number]
    return Score(
        found=found,
        missed=len(truth) - found,
        false=len(index) - needed,
        mean_error=float(np.mean(errors)) if errors else np.nan,
        worst_error=float(np.max(errors)) if errors else np.nan,
        matched=len(errors),
        kinds=int(right),
    )


def _nearest(
    positions: np.ndarray, truth: np.ndarray, edge: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """For each position (k, 3) the nearest true one and its distance in edges (t,) of that one."""
    if len(positions) == 0:
        return np.zeros(0, dtype=int), np.zeros(0)
    distance = np.linalg.norm(positions[:, None] - truth[None], axis=2) / edge
    nearest = distance.argmin(axis=1)
    return nearest, distance[np.arange(len(positions)), nearest]


RESOLVED = 3.0
"""Edges between umbilics from which a mesh can tell them apart."""

WITHIN = 2.0
"""Edges within which a resolved umbilic counts as found."""


@dataclass(frozen=True)
class Tally:
    """Counts of one program on meshes, of the umbilics that these can resolve.

    Attributes
    ----------
    true, found, near:
        Resolved true umbilics, those found within `WITHIN` edges and within `REACH`.
    determined, determined_found:
        Of the first two those whose place the mesh determines, see `ceiling.determined`.
    false, certain_false:
        Umbilics that are no true one, resolved or not, and those of them marked certain.
    kinds_right, kinds_uncertain, kinds_wrong:
        Of all true ones near which one of the right index was found.
    """

    true: int = 0
    found: int = 0
    near: int = 0
    determined: int = 0
    determined_found: int = 0
    false: int = 0
    certain_false: int = 0
    kinds_right: int = 0
    kinds_uncertain: int = 0
    kinds_wrong: int = 0

    @classmethod
    def sum(cls, tallies: list[Tally]) -> Tally:
        """All added up."""
        return cls(**{name: sum(getattr(t, name) for t in tallies) for name in vars(cls())})


def tally(
    case: Case,
    positions: np.ndarray,
    index: np.ndarray,
    kinds: np.ndarray | None = None,
    certain: np.ndarray | None = None,
    determined: np.ndarray | None = None,
) -> Tally:
    """Match umbilics (k, 3) of indices (k,) with the true ones one to one, the nearest first.

    A true one of index +1 takes one of +1 or two of +1/2, within `SPLIT_REACH`. One of a larger
    index is not false where true ones of its sign that are left over, within the same reach, make
    it up; these count as missed. Where a case knows of no umbilics nothing is true or false.
    """
    truth = case.umbilics
    edge = case.edge_at(truth.position)
    asked = case.asked_at(truth.position)
    between = np.linalg.norm(truth.position[:, None] - truth.position[None], axis=2)
    np.fill_diagonal(between, np.inf)
    resolved = asked & (between.min(axis=1, initial=np.inf) >= RESOLVED * edge)
    away = np.linalg.norm(positions[:, None] - truth.position[None], axis=2) / edge
    taken = np.zeros(len(positions), bool)
    distance = np.full(len(truth), np.inf)
    match = np.full(len(truth), -1)
    whole = np.abs(truth.index) != 0.5
    close = np.argwhere((away <= REACH) & (index[:, None] == truth.index) & ~whole)
    for row, number in close[np.argsort(away[tuple(close.T)])]:
        if not taken[row] and match[number] < 0:
            taken[row], match[number], distance[number] = True, row, away[row, number]
    for number in np.flatnonzero(whole):
        left = truth.index[number]
        for row in np.argsort(away[:, number]):
            share = index[row] / truth.index[number]
            if not taken[row] and away[row, number] <= SPLIT_REACH and share > 0 and left:
                taken[row] = abs(index[row]) <= abs(left)
                left -= index[row] * taken[row]
        distance[number] = np.inf if left else 0.0
    for row in np.flatnonzero(~taken & (np.abs(index) > 0.5)):
        left = (match < 0) & ~whole & (truth.index * index[row] > 0) & (away[row] <= SPLIT_REACH)
        taken[row] = abs(truth.index[left].sum()) >= abs(index[row])
    taken |= ~case.asked_at(positions)
    paired = np.flatnonzero((match >= 0) & asked)
    named = kinds[match[paired]] if kinds is not None else np.zeros(0, "<U9")
    right = int((named == truth.kind[paired]).sum()) if len(named) else 0
    unsure = int((named == UNCERTAIN).sum())
    clear = resolved & (determined if determined is not None else False)
    return Tally(
        true=int(resolved.sum()),
        found=int((resolved & (distance <= WITHIN)).sum()),
        near=int((resolved & (distance <= SPLIT_REACH)).sum()),
        determined=int(clear.sum()),
        determined_found=int((clear & (distance <= WITHIN)).sum()),
        false=int((~taken).sum()),
        certain_false=int((~taken & certain).sum()) if certain is not None else 0,
        kinds_right=right,
        kinds_uncertain=unsure,
        kinds_wrong=len(named) - right - unsure,
    )
