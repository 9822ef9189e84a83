"""Which of the located candidates are real, which may be a border's, and which are beyond doubt."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..curvature.tolerances import INDEPENDENT
from ..mesh.borders import distance_to_border
from ..mesh.surface import Surface
from .located import Located
from .pairing.persistence import Tree, made_by_noise, measure_persistence, significant

# Standard error of a place, in radii of the fit, above which a border may have made it: the
# spurious ones along the border of the test patch have 0.1 and more, most true ones 0.05.
VAGUE = 0.1
# Standard errors that an umbilic must be clear of to be believed where a pair may have lost its
# other half over the border.
BORDER_CLEAR = 2.0
# Chance that noise alone makes a pair that passes for present, or one that passes for certain.
PRESENT = 1e-2
CERTAIN = 1e-8
# Pairs of two places of their own that noise is expected to make on a mesh, and the chance that
# the errors of two such places reach as far as they stand apart. Chosen on seeds 200, 201, 300,
# 301, 400 and 401 of benchmarks.people, where 0.2 to 1 and 0.06 to 0.3 keep the same but for one
# pair; of fields and metaballs of 500 and 501 this keeps 253 for 237, none false.
SEPARATE = 0.3
TOGETHER = 0.15
# Distance of a pair, in radii of the jets, that the finer fit at one of the two spans.
PAIR_REACH = 2.0
# Rings from a border within which a place must be better than that: what three rings of samples
# and one more for the place reach, and the triangle itself.
BORDER_RINGS = 5


@dataclass(frozen=True)
class Evidence:
    """What speaks for and against umbilics, beside what is located of them.

    Attributes
    ----------
    gap, noise, radius:
        (n,) k1 - k2, its standard error and the radius of the fits, at the vertices.
    determined:
        (n,) bool, vertices whose fit is.
    regions:
        Rows of the triangles of each region.
    jets, certified, exact:
        Whether shape operators were fitted, whether the indices balance, and whether the shape
        operators have no error.
    form_radius:
        That of the widest fits of a surface with detail at every size; 0 of others.
    tree:
        Where the umbilics meet; None to find out.
    """

    gap: np.ndarray
    noise: np.ndarray
    radius: np.ndarray
    determined: np.ndarray
    regions: list[np.ndarray]
    jets: bool
    certified: bool
    exact: bool
    form_radius: float = 0.0
    tree: Tree | None = None


@dataclass(frozen=True)
class Judged:
    """The verdicts (k,) on candidates; see `Umbilics`. Persistence in the surface's coordinates.

    `present` are those that a finer fit shows on a circle around them, clear of its error.
    """

    persistence: np.ndarray
    partner: np.ndarray
    at_border: np.ndarray
    resolved: np.ndarray
    certain: np.ndarray
    present: np.ndarray


def judge(
    surface: Surface,
    found: Located,
    evidence: Evidence,
    persistence: np.ndarray,
    partner: np.ndarray,
    of_form: np.ndarray | None = None,
) -> Judged:
    """Judge candidates with the persistence and partner (k,) that were found for them; where the
    surface has detail at every size, those `of_form` (k,) bool are the real ones, and none is
    certain."""
    corners = surface.triangles[found.triangle]
    radius = evidence.radius[corners]
    # A fit whose place is this vague within its own radius would not show a one-sided error.
    vague = ~found.seen | (found.uncertainty > VAGUE * radius.mean(axis=1))
    if of_form is None and evidence.certified and evidence.jets and vague[found.asked].any():
        # Of two that could cancel a third, the one that the finer fit shows stays.
        persistence, partner = measure_persistence(
            surface,
            evidence.gap,
            found.singular,
            found.index,
            evidence.regions,
            ~vague,
            evidence.tree,
        )
    fits = _independent_fits(surface, evidence.radius)
    present = found.clarity >= significant(fits, PRESENT)
    unclear = found.clarity < BORDER_CLEAR
    if of_form is not None:
        at_border = _within_fit_of_border(surface, found, evidence.form_radius)
        none = np.zeros(len(found), bool)
        return Judged(persistence, partner, at_border, of_form, none, present)
    at_border = _at_border(surface, found, partner, vague, unclear, evidence.exact)
    position = found.position(surface)
    other_noise = np.where(partner >= 0, found.noise[partner], 0.0)
    unseen = _unseen_pairs(position, partner, found.seen | at_border, radius)
    if not evidence.exact:
        # A border has errors of its own: it makes places vague without making pairs.
        inner = ~at_border & ~(at_border[partner] & (partner >= 0))
        within = _within_errors(position, partner, found.uncertainty, PRESENT)
        # Errors of places tell by the slopes of a fit, and these only as far as it reaches: those
        # of halves of a flat point are many radii. What parts two further apart is the gap between.
        sure = persistence > significant(fits, CERTAIN) * np.fmax(found.noise, other_noise)
        unseen |= inner & within & ~(sure & ~_close(position, partner, radius))
    # What a finer fit does not show is noise up to where it cancels, what it shows clearly none.
    above = np.where(unseen, np.fmax(found.noise, persistence), found.noise)
    above = np.where(_both(present, partner), 0.0, above)
    firm = ~made_by_noise(persistence, partner, above)
    resolved = firm | _separate(found, position, persistence, partner, at_border, radius)
    certain = found.seen & evidence.determined[corners].all(axis=1) & ~at_border
    certain &= firm
    if not evidence.exact:
        # Without a finer fit there is no clarity, and nothing that noise could not have made.
        certain &= found.clarity >= significant(fits, CERTAIN)
        # What a border cuts off from a fit its error does not tell.
        certain &= ~surface.near_border(BORDER_RINGS)[corners].any(axis=1)
    return Judged(persistence, partner, at_border, resolved, certain, present)


def _at_border(
    surface: Surface,
    found: Located,
    partner: np.ndarray,
    vague: np.ndarray,
    unclear: np.ndarray,
    exact: bool,
) -> np.ndarray:
    """(k,) bool, umbilics that a border may have made by its slivers and one-sided fits.

    Those that lie within one ring of it, or were found there and moved inwards since; unless the
    operators are `exact`, as far in as fits reach, those whose place is `vague`, twice as far in
    if they are `unclear` too; and within two or three rings those that cancel with one of these:
    the two come and go together.
    """
    if surface.closed.all():
        return np.zeros(len(found), bool)
    corners = surface.triangles[found.triangle]
    # Rings alone are blind where the border has few vertices, as the hull of scattered points.
    edge = float(np.sqrt(np.median(surface.side_squares)))
    points = surface.vertices[corners.ravel()]
    distance = distance_to_border(surface, points, edge, BORDER_RINGS * edge)
    distance = distance.reshape(-1, 3).min(axis=1)

    def within(rings: int) -> np.ndarray:
        return surface.near_border(rings)[corners].any(axis=1) | (distance <= rings * edge)

    doubtful = within(1) | surface.near_border(1)[surface.triangles[found.singular]].any(axis=1)
    if not exact:
        doubtful |= within(BORDER_RINGS) & vague
        doubtful |= within(2 * BORDER_RINGS) & vague & unclear
    return doubtful | (within(2 if exact else 3) & (partner >= 0) & doubtful[partner])


def _within_fit_of_border(surface: Surface, found: Located, radius: float) -> np.ndarray:
    """(k,) bool, umbilics within one ring of a border or so near to it that it cuts fits of a
    radius in half: a length, whatever the triangles."""
    if surface.closed.all():
        return np.zeros(len(found), bool)
    edge = float(np.sqrt(np.median(surface.side_squares)))
    near = surface.near_border(1)[surface.triangles[found.triangle]].any(axis=1)
    away = distance_to_border(surface, found.position(surface), min(edge, radius), radius)
    return near | (away <= radius)


def _unseen_pairs(
    position: np.ndarray, partner: np.ndarray, located: np.ndarray, radius: np.ndarray
) -> np.ndarray:
    """(k,) bool, umbilics of pairs that the finer fit does not show: neither of them or, of a
    close pair, not both.

    A fit that reaches over both would have two zeros or none: the error of the gap is then at
    least what parts them. `radius` (k, 3) are those of the fits at the corners.
    """
    paired, close = partner >= 0, _close(position, partner, radius)
    both, either = located & located[partner], located | located[partner]
    return paired & ~(both | (either & ~close))


def _close(position: np.ndarray, partner: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """(k,) bool, umbilics that a finer fit, of `radius` (k, 3) at the corners, reaches over
    together with the one they cancel with."""
    apart = np.linalg.norm(position - position[partner], axis=1)
    return np.asarray(apart <= PAIR_REACH * radius.mean(axis=1))


def _within_errors(
    position: np.ndarray, partner: np.ndarray, uncertainty: np.ndarray, chance: float
) -> np.ndarray:
    """(k,) bool, umbilics that stand no further from the one they cancel with than the errors
    of both places reach by a given chance: the same errors could bring them together."""
    apart = np.linalg.norm(position - position[partner], axis=1)
    reach = significant(1.0, chance) * np.hypot(uncertainty, uncertainty[partner])
    return (partner >= 0) & (apart < reach)


def _separate(
    found: Located,
    position: np.ndarray,
    persistence: np.ndarray,
    partner: np.ndarray,
    at_border: np.ndarray,
    radius: np.ndarray,
) -> np.ndarray:
    """(k,) bool, umbilics of pairs that are two places of their own: so far apart that the errors
    of their fits are independent, further than the errors of both places, with a gap between them
    that of as many pairs of noise hardly one has, and at least one of them shown by a finer fit.
    `radius` (k, 3) are those of the fits at the corners."""
    mutual = (partner >= 0) & (partner[partner] == np.arange(len(partner)))
    reach = np.fmin(radius.mean(axis=1), radius.mean(axis=1)[partner])
    apart = np.linalg.norm(position - position[partner], axis=1) > INDEPENDENT * reach
    inner = ~at_border & ~at_border[partner]
    shown = found.seen | found.seen[partner]
    pairs = np.count_nonzero(mutual) / 2.0
    with np.errstate(invalid="ignore"):
        above = persistence > significant(pairs, SEPARATE) * np.fmin(
            found.noise, found.noise[partner]
        )
    within = _within_errors(position, partner, found.uncertainty, TOGETHER)
    return mutual & apart & inner & shown & above & ~within


def _both(there: np.ndarray, partner: np.ndarray) -> np.ndarray:
    """(k,) bool, umbilics that are there together with the one they cancel with."""
    return there & (partner >= 0) & there[partner]


def _independent_fits(surface: Surface, radius: np.ndarray) -> float:
    """How many fits of a surface share no samples: its area over that of their discs."""
    _, area = surface.face_normal_area
    known = radius[np.isfinite(radius) & (radius > 0)]
    if len(known) == 0:
        return 1.0
    # Points spread over a disc are 1 / sqrt(2) of its radius away from its middle.
    return max(float(area.sum() / (2.0 * np.pi * np.median(known) ** 2)), 1.0)
