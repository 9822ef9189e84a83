"""How well a set of umbilics matches the true ones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

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
        needed += round(2 * abs(truth.index[number] - by_regions))
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
