"""Which umbilics the form of a surface has, where it has detail at every size.

No fit of such a surface shows umbilics that another would show again, be it over other triangles
or with a little more noise; those of its form are. Around these, and there alone, the field of the
surface becomes that of the form, so that what is kept turns where it is said to; everything else
that the field turns around cancels.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ...base.progress import Progress
from ...curvature.estimate import Estimate
from ...curvature.field import CurvatureField, field_from_deviators
from ...curvature.form import Form
from ...curvature.tolerances import INDEPENDENT
from ...fields.transport import doubled_angle, tangents
from ...fields.winding import Winding
from ...mesh.surface import Surface
from ..methods.raw import RawUmbilics
from .persistence import lesser_noise, measure_persistence, noise_multiple

# Radius, in radii of the wide fits, within which the field around an umbilic becomes theirs; from
# half of it on it fades into that of the surface.
DISC = 0.5


@dataclass(frozen=True)
class FormUmbilics:
    """The umbilics of a form, k of them, and the field of the surface that has them.

    Attributes
    ----------
    fitted:
        The estimate of the surface, its field around these umbilics that of the form.
    triangle, index:
        (k,) int64 and float64, as in `RawUmbilics`.
    persistence, partner:
        (k,) as `measure_persistence` gives them.
    widest:
        Radius of the form's widest fits.
    """

    fitted: Estimate
    triangle: np.ndarray
    index: np.ndarray
    persistence: np.ndarray
    partner: np.ndarray
    widest: float


def umbilics_of_form(
    surface: Surface, fitted: Estimate, form: Form, progress: Progress
) -> FormUmbilics:
    """The umbilics of a form between which and what they cancel with the gap rises above its
    error: above the change to the next radius, as much larger where residuals are.

    Where fits are no wider than those of the surface itself, the highest that many pairs may reach
    counts, as there. Opposite ones that the same fits show have cancelled before.
    """
    field = form.field
    winding = Winding.of(surface, field.d1, field.d2, progress.quiet())
    triangle = np.flatnonzero(winding.index)
    triangle = triangle[_told_apart(surface, form, triangle, winding.index[triangle])]
    index = winding.index[triangle]
    persistence, partner = measure_persistence(surface, field.gap, triangle, index)
    corners = surface.triangles[triangle]
    share = form.share[corners].mean(axis=1)
    level = share + (1.0 - share) * noise_multiple(len(triangle))
    error = level * field.noise[corners].mean(axis=1)
    kept = np.flatnonzero(~(persistence <= lesser_noise(partner, error)))
    place = np.append(np.full(len(triangle), -1), -1)
    place[kept] = np.arange(len(kept))
    triangle = triangle[kept]
    laid = _laid_over(surface, fitted, form, triangle)
    persistence, partner = persistence[kept], place[partner[kept]]
    return FormUmbilics(laid, triangle, index[kept], persistence, partner, form.widest)


def _told_apart(
    surface: Surface, form: Form, triangle: np.ndarray, index: np.ndarray
) -> np.ndarray:
    """(k,) bool, umbilics in the triangles (k,) that are left once opposite ones nearer to each
    other than independent fits have cancelled, the nearest first: the deviator of one cubic is
    linear and has one zero, so that the two are how fits beside each other were joined."""
    corners = surface.triangles[triangle]
    left = np.ones(len(triangle), bool)
    if not len(triangle):
        return left
    places, reach = surface.vertices[corners].mean(axis=1), form.radius[corners].mean(axis=1)
    reach = INDEPENDENT * np.nan_to_num(reach)
    near = cKDTree(places).query_ball_point(places, reach)
    one = np.repeat(np.arange(len(triangle)), [len(rows) for rows in near])
    two = np.concatenate([np.asarray(rows, np.int64) for rows in near])
    normal = form.field.normal[corners[:, 0]]
    both = (index[one] > 0.0) & (index[two] < 0.0)
    # The other side of a thin sheet is seen by other fits.
    both &= np.einsum("rc,rc->r", normal[one], normal[two]) > 0.0
    both &= surface.component[corners[one, 0]] == surface.component[corners[two, 0]]
    one, two = one[both], two[both]
    apart = np.linalg.norm(places[one] - places[two], axis=1)
    seen = np.flatnonzero(apart <= np.minimum(reach[one], reach[two]))
    for row in seen[np.argsort(apart[seen], kind="stable")]:
        pair = [one[row], two[row]]
        if left[pair].all():
            left[pair] = False
    return left


def paired_by_form(
    surface: Surface, gap: np.ndarray, raw: RawUmbilics, shown: FormUmbilics
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Persistence and partner (k,) of raw umbilics, and which of them the form has: these as it
    pairs them, all others among themselves.

    Where a border leaves the sum open what is left of the others went over it; on closed surfaces
    it stays, and with it the sum.
    """
    place = np.full(len(surface.triangles), -1)
    place[shown.triangle] = np.arange(len(shown.triangle))
    of = place[raw.triangle]
    of[(of >= 0) & (shown.index[of] != raw.index)] = -1
    row = np.full(len(shown.triangle) + 1, -1)
    mine = np.flatnonzero(of >= 0)
    row[of[mine]] = mine
    persistence, partner = np.full(len(raw), np.inf), np.full(len(raw), -1)
    partner[mine] = row[shown.partner[of[mine]]]
    # One of a pair may lie in a region, and be none of its own.
    paired = partner[mine] >= 0
    persistence[mine[paired]] = shown.persistence[of[mine[paired]]]
    rest = np.flatnonzero(of < 0)
    level, other = measure_persistence(surface, gap, raw.triangle[rest], raw.index[rest])
    alone = np.flatnonzero(other < 0)
    open_sum = ~surface.closed[surface.component[surface.triangles[raw.triangle[rest], 0]]]
    persistence[rest] = level
    partner[rest] = np.where(other >= 0, rest[other], -1)
    over = alone[open_sum[alone]]
    persistence[rest[over]] = gap[surface.triangles[raw.triangle[rest[over]]]].max(axis=1)
    return persistence, partner, of >= 0


def _laid_over(surface: Surface, fitted: Estimate, form: Form, triangle: np.ndarray) -> Estimate:
    """The field of the surface, around the triangles (k,) that of the form."""
    corners = surface.triangles[triangle]
    middle = surface.vertices[corners].mean(axis=1)
    share = np.zeros(len(surface.vertices))
    if len(triangle):
        reach = DISC * form.widest
        away, nearest = cKDTree(middle).query(surface.vertices, distance_upper_bound=reach)
        near = np.flatnonzero(np.isfinite(away))
        normal = form.field.normal
        facing = np.einsum("nc,nc->n", normal[near], normal[corners[nearest[near], 0]]) > 0.0
        share[near] = facing * np.clip(2.0 - 2.0 * away[near] / reach, 0.0, 1.0)
        share[corners] = 1.0
    rows = np.flatnonzero(share)
    field, over, part = fitted.field, form.field, share[rows]
    # Both are in the tangent planes of the same normals.
    e1, e2 = tangents(field.normal[rows])
    deviator, mean = np.zeros(len(rows), np.complex128), np.zeros(len(rows))
    noise = np.zeros(len(rows))
    for one, weight in ((field, 1.0 - part), (over, part)):
        deviator += weight * doubled_angle(one.d1[rows], e1, e2, one.gap[rows])
        mean += 0.5 * weight * (one.k1 + one.k2)[rows]
        noise += weight * one.noise[rows]
    laid = field_from_deviators(mean, deviator, field.normal[rows], noise)
    values = {name: value.copy() for name, value in vars(field).items()}
    for name, value in values.items():
        value[rows] = getattr(laid, name)
    changed = CurvatureField(**values)
    winding = fitted.winding
    if winding is not None:
        winding = winding.after(surface, rows, changed.d1, changed.d2)
    return dataclasses.replace(fitted, field=changed, winding=winding)
