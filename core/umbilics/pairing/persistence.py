"""Which umbilics are really there: persistence by cancelling charges in the merge tree.

After Wang & Hotz, Robustness for 2D symmetric tensor field topology (2017). Every umbilic
is a node of value 0 joined to the corners of its triangle; sublevel sets of the gap k1 - k2
grow over the edges of the mesh. Where two of them merge whose umbilics left over have indices
of opposite sign, the closest opposite pairs cancel at that gap until one sign is left. The sum
of the indices is therefore the same at every level.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ...curvature.tolerances import PAIR_CROWD, PAIR_NOISE
from ...mesh.surface import Surface
from .cancelling import cancel
from .merge_tree import merge_tree

# Gives what `merge_tree` gives.
Tree = Callable[[], tuple[np.ndarray, np.ndarray, np.ndarray]]


def measure_persistence(
    surface: Surface,
    gap: np.ndarray,
    triangle: np.ndarray,
    index: np.ndarray,
    regions: Sequence[np.ndarray] = (),
    firm: np.ndarray | None = None,
    tree: Tree | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """The gap at which each umbilic cancels, and with which other one.

    Parameters
    ----------
    surface:
        The mesh; separate components never cancel each other's umbilics.
    gap:
        (n,) k1 - k2 at the vertices, >= 0. What is not finite counts as the largest finite gap.
    triangle:
        (k,) rows of `surface.triangles` that hold the umbilics.
    index:
        (k,) their indices, multiples of one half.
    regions:
        For each spherical or flat region the rows of its triangles. The gap is zero all over a
        region, so that umbilics at its border meet through it; its own index is not offered
        for cancelling, because a region is never removed.
    firm:
        (k,) bool, umbilics that stay where others could cancel in their place: those that a
        finer fit shows. None for no difference.
    tree:
        Where these umbilics meet, as from `meeting`; None to find out.

    Returns
    -------
    persistence:
        (k,) float64 gap, in the unit of `gap`; infinite where nothing is left to cancel with.
        Umbilics of a larger index may cancel with several others: these then share the
        persistence at which the last of them goes.
    partner:
        (k,) int64 row of the umbilic that it cancels with, -1 where the persistence is infinite.
    """
    count = len(index)
    persistence = np.full(count, np.inf)
    partner = np.full(count, -1, dtype=np.int64)
    units = np.rint(2.0 * np.asarray(index, dtype=float)).astype(np.int64)
    if not (units > 0).any() or not (units < 0).any():
        return persistence, partner

    low, high, saddle = (tree or meeting(surface, gap, triangle, index, regions))()
    centres = sum(surface.vertices[corner] for corner in surface.triangles[triangle].T) / 3.0
    first, second, level = cancel(units, centres, low, high, saddle, firm)
    if len(first) == 0:
        return persistence, partner
    if np.abs(units).max() == 1:
        persistence[first] = persistence[second] = level
        partner[first], partner[second] = second, first
        return persistence, partner
    return _group(units, first, second, level)


def meeting(
    surface: Surface,
    gap: np.ndarray,
    triangle: np.ndarray,
    index: np.ndarray,
    regions: Sequence[np.ndarray] = (),
) -> Tree:
    """Where umbilics meet, found when it is first asked for; parameters as those of
    `measure_persistence`."""
    charged = np.rint(2.0 * np.asarray(index, dtype=float)) != 0.0
    return cache(
        lambda: merge_tree(surface, _finite(gap), np.asarray(triangle), charged, regions)
    )


def survivors(persistence: np.ndarray, level: float) -> np.ndarray:
    """(k,) bool, True where an umbilic is kept at a persistence level; 0 keeps all."""
    return persistence >= level


def made_by_noise(persistence: np.ndarray, partner: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """(k,) bool, True for the umbilics that come in pairs made by noise: the automatic choice.

    A pair is noise where it cancels below `noise_multiple` times the gap's standard error, the
    lesser one of its places: a pair of one clear umbilic and one at a ragged border is the
    clear one's. Noise differs over a mesh, so that each pair is judged by itself.

    Parameters
    ----------
    persistence, partner:
        (k,) as `measure_persistence` gives them. Umbilics that cancel together go together;
        those with a persistence of NaN or infinity stay.
    noise:
        (k,) standard error of the gap at each umbilic, in the unit of `persistence`; NaN where
        it is not known.
    """
    lesser = lesser_noise(partner, noise)
    # Nothing known of any of them: keep them.
    lesser = np.where(np.isfinite(lesser), lesser, -np.inf)
    with np.errstate(invalid="ignore"):
        below = persistence <= noise_multiple(len(persistence)) * lesser
    return np.isfinite(persistence) & below


def lesser_noise(partner: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """(k,) the least noise among those that cancel together; infinite where none is known."""
    count = len(noise)
    paired = np.flatnonzero(partner >= 0)
    links = sparse.coo_matrix((np.ones(len(paired)), (paired, partner[paired])), (count, count))
    groups, group = csgraph.connected_components(links, directed=False)
    lesser = np.full(groups, np.inf)
    np.fmin.at(lesser, group, noise)
    return lesser[group]


def importance(
    persistence: np.ndarray, partner: np.ndarray, noise: np.ndarray, gap: np.ndarray
) -> np.ndarray:
    """(k,) how important umbilics are: see `Umbilics.importance`.

    Parameters
    ----------
    persistence, partner, noise:
        (k,) as for `made_by_noise`.
    gap:
        (n,) k1 - k2 at the vertices.
    """
    known = gap[np.isfinite(gap)]
    largest = float(known.max(initial=0.0))
    usual = float(np.median(known)) if len(known) else 0.0
    level = np.where(np.isfinite(persistence), persistence, largest)
    error = lesser_noise(partner, noise)
    error = np.where(np.isfinite(error), error, usual)
    with np.errstate(over="ignore"):
        return np.asarray(level / np.maximum(error, np.finfo(float).tiny))


def significant(fits: float, chance: float) -> float:
    """How many standard errors a deviator must be long, so that by a given chance at most one
    of so many independent fits of an umbilic surface has a longer one.

    The error of a deviator is a complex Gaussian, its length follows Rayleigh's law:
    P(longer than t standard errors) = exp(-t^2).
    """
    return float(np.sqrt(np.log(max(fits, 1.0) / chance)))


def noise_multiple(count: int) -> float:
    """How many standard errors a pair must rise above to be told from noise, among `count`
    umbilics: the more there are, the higher the highest that noise makes.

    The largest of n normal deviates grows as sqrt(log n) (Donoho & Johnstone 1994).

    Examples
    --------
    >>> core.noise_multiple(10) < core.noise_multiple(1000)
    True
    """
    crowd = np.log(max(count, PAIR_CROWD)) / np.log(PAIR_CROWD)
    return PAIR_NOISE * float(np.sqrt(crowd))


def trust_ratio(noise: np.ndarray, gap: np.ndarray) -> float:
    """How strong the noise is: the gap at which it makes pairs cancel over the median gap.

    Up to about 0.5 the umbilics left sit where the surface has them; above 0.7 the noise that
    was cancelled is as large as the signal and they may not. The medians keep a few damaged
    places from speaking for the whole mesh.

    Parameters
    ----------
    noise, gap:
        (n,) standard error of the gap k1 - k2 at the vertices, and the gap. 0 is returned where
        the noise is not known.
    """
    known = np.isfinite(noise) & np.isfinite(gap)
    if not known.any():
        return 0.0
    if not known.all():
        noise, gap = noise[known], gap[known]
    cancels, median = PAIR_NOISE * float(np.median(noise)), float(np.median(gap))
    return cancels / median if cancels < 1e6 * median else 0.0


def _finite(gap: np.ndarray) -> np.ndarray:
    gap = np.asarray(gap, dtype=float)
    finite = np.isfinite(gap)
    if finite.all():
        return gap
    return np.where(finite, gap, gap[finite].max() if finite.any() else 0.0)


def _group(
    units: np.ndarray, first: np.ndarray, second: np.ndarray, level: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Persistence where larger indices cancel with several others.

    Those that are linked go together, at their highest level, or stay together if their sum
    is not zero; anything else would change the sum of what is left.
    """
    count = len(units)
    links = sparse.coo_matrix((np.ones(len(first)), (first, second)), shape=(count, count))
    groups, group = csgraph.connected_components(links, directed=False)
    highest = np.zeros(groups)
    np.maximum.at(highest, group[first], level)
    total = np.bincount(group, weights=units, minlength=groups)
    # An umbilic without a link is a group of its own, with a sum of its own index.
    linked = np.bincount(group[first], minlength=groups) > 0
    highest[(total != 0) | ~linked] = np.inf
    persistence = highest[group]
    partner = np.full(count, -1, dtype=np.int64)
    # Each link uses one of its ends up, whose last link it is: kept there, it holds the group
    # together.
    partner[np.stack([first, second], axis=1)] = np.stack([second, first], axis=1)
    partner[~np.isfinite(persistence)] = -1
    return persistence, partner
