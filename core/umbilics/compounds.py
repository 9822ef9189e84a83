"""Umbilics that are not told from each other, made one with the sum of their indices, or put
between the places that one of them may have.

A flat point of index +1 is a double zero of the deviator, and no generic one: any error splits it
in two of index +1/2, as far apart as the square root of the error. Where linear interpolation is
what splits it, neither the two nor their distance mean anything; their sum does.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph
from scipy.spatial import cKDTree

from ..base.progress import Progress
from ..curvature.field import CurvatureField
from ..curvature.tolerances import EDGE_BEND, UNRESOLVED
from ..mesh.surface import Surface
from .judged import PRESENT, Evidence, Judged
from .located import Located
from .methods.shape_operators import nearest_inside
from .pairing.persistence import measure_persistence, significant
from .regions.unresolved import unresolved_sets

# Umbilics looked at around each: more than these within an edge are of one group anyway.
NEIGHBOURS = 8
# Distance, in radii of the fits, to the other place that one umbilic may have. Chosen on ellipsoids
# (3, 2, 1) of thin triangles, where it is 1.5 to 2.5. On 58 meshes of thin triangles of four other
# ellipsoids everything from 1.5 to 4 does the same: of 232 umbilics 98.3 % for 96.6 lie within
# three standard errors. On seeds 800, 810 and 820 of benchmarks.people it changes next to nothing.
OTHER_PLACE = 3.0


def unresolved_groups(
    surface: Surface,
    field: CurvatureField,
    noise: np.ndarray,
    radius: np.ndarray,
    found: Located,
    verdict: Judged,
) -> np.ndarray:
    """(k,) int64 number of the group that each candidate is part of, -1 for none.

    Of one group are those of the resolved between which linear interpolation alone decides whether
    the deviator passes zero, and those of one sign that lie within an edge: there are no two zeros
    in one triangle. What noise alone leaves between two zeros is no such reason, since true ones
    come as close: joined by their errors 10 of 138 umbilics were lost under noise and 8 of 228 on
    marching cubes, decimated and coarse meshes of random surfaces. A group that adds up to the
    index of a generic umbilic stays as it is, since one of its members is real, and so does one
    whose members a finer fit all shows, each by itself.

    Parameters
    ----------
    field, noise, radius:
        As for `unresolved_sets`.
    """
    group = np.full(len(found), -1)
    rows = np.flatnonzero(verdict.resolved & ~verdict.at_border)
    if len(rows) < 2:
        return group
    starts = surface.triangles[found.singular[rows]]
    sets = unresolved_sets(surface, field, noise, radius, 0.0, starts, Progress())
    one, two = _within_an_edge(surface, found, rows)
    label = sets.label[found.singular[rows]]
    inside = np.flatnonzero(label >= 0)
    inside = inside[np.argsort(label[inside], kind="stable")]
    same = label[inside[1:]] == label[inside[:-1]]
    one = np.concatenate([one, inside[1:][same]])
    two = np.concatenate([two, inside[:-1][same]])
    graph = sparse.coo_array((np.ones(len(one)), (one, two)), shape=(len(rows), len(rows)))
    count, piece = csgraph.connected_components(graph, directed=False)
    total = np.bincount(piece, weights=found.index[rows], minlength=count)
    more = np.bincount(piece, minlength=count) > 1
    p, q = np.abs(found.p[rows]), np.abs(found.q[rows])
    # Along a line on which the deviator hardly changes a circle around one half of a flat point
    # shows nothing; those of a pair are not halves of anything.
    flat = (total[piece] != 0.0) & ~(np.abs(p - q) > EDGE_BEND * (p + q))
    clear = verdict.present[rows] & ~flat
    unclear = np.bincount(piece, weights=~clear, minlength=count) > 0
    whole = more & (np.abs(total) != 0.5) & unclear
    number = np.where(whole, np.cumsum(whole) - 1, -1)
    group[rows] = number[piece]
    return group


def _within_an_edge(
    surface: Surface, found: Located, rows: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of places in `rows` that have indices of one sign and are nearer than the mean edge
    of either triangle."""
    place = found.position(surface)[rows]
    edge = surface.mean_sides(found.triangle[rows])
    # The nearest few, not all within the longest edge: one long triangle would make all of them.
    away, other = cKDTree(place).query(place, min(NEIGHBOURS + 1, len(rows)))
    one = np.repeat(np.arange(len(rows)), away.shape[1] - 1)
    two = other[:, 1:].ravel()
    near = away[:, 1:].ravel() <= np.maximum(edge[one], edge[two])
    near &= found.index[rows[one]] * found.index[rows[two]] > 0.0
    component = surface.component[surface.triangles[found.triangle[rows], 0]]
    near &= component[one] == component[two]
    return one[near], two[near]


def merged(
    surface: Surface,
    field: CurvatureField,
    found: Located,
    verdict: Judged,
    group: np.ndarray,
    evidence: Evidence,
) -> tuple[Located, Judged]:
    """The candidates and what was judged of them, with each group (k,) that has an index in one
    row, where its first part was. The others hold nothing that is resolved.

    A compound lies in the middle of its parts of its own sign, on the nearest triangle around
    them; its uncertainty is how far they lie from there. What is not resolved stays paired as it
    was; the others, the compounds among them, are paired anew.
    """
    parts = np.flatnonzero(group >= 0)
    parts = parts[np.argsort(group[parts], kind="stable")]
    groups = np.split(parts, np.flatnonzero(np.diff(group[parts])) + 1)
    empty = [own for own in groups if found.index[own].sum() == 0.0]
    groups = [own for own in groups if found.index[own].sum() != 0.0]
    keep = np.ones(len(group), bool)
    for own in groups:
        keep[own[1:]] = False
    values = {item.name: getattr(found, item.name).copy() for item in dataclasses.fields(found)}
    places = found.position(surface)
    for own in groups:
        row = own[0]
        total = float(found.index[own].sum())
        same = own[found.index[own] * total > 0.0]
        centre = places[same].mean(axis=0)
        start = found.triangle[same], found.barycentric[same]
        triangle, weights = _nearest_place(surface, *start, centre)
        corners = surface.triangles[triangle]
        spread = np.square(places[same] - centre).sum(axis=1) + np.square(found.uncertainty[same])
        values["singular"][row] = values["triangle"][row] = triangle
        values["barycentric"][row] = weights
        values["index"][row] = total
        values["normal"][row] = weights @ field.normal[corners]
        values["curvature"][row] = weights @ (0.5 * (field.k1 + field.k2)[corners])
        values["noise"][row] = np.max(found.noise[own])
        values["uncertainty"][row] = np.sqrt(spread.mean())
        values["clarity"][row] = np.min(found.clarity[same])
        # Nothing is known of lines that run into it.
        values["p"][row] = values["q"][row] = np.nan
        values["elliptic"][row] = found.elliptic[own].all()
        values["asked"][row] = values["seen"][row] = True
    left = Located(**{name: value[keep] for name, value in values.items()})
    return left, _judged_again(surface, found, left, verdict, groups, empty, keep, evidence)


def _judged_again(
    surface: Surface,
    before: Located,
    left: Located,
    verdict: Judged,
    groups: list[np.ndarray],
    empty: list[np.ndarray],
    keep: np.ndarray,
    evidence: Evidence,
) -> Judged:
    certain = verdict.certain.copy()
    for own in groups:
        certain[own[0]] = verdict.certain[own].all()
    persistence, partner = verdict.persistence.copy(), verdict.partner.copy()
    resolved = verdict.resolved.copy()
    for own in empty:
        # Opposite ones in pairs that come and go at the error that they do not rise above.
        resolved[own] = False
        up, down = own[before.index[own] > 0.0], own[before.index[own] < 0.0]
        # One of a whole index has two of a half to go with.
        partner[up], partner[down] = np.resize(down, len(up)), np.resize(up, len(down))
        persistence[own] = UNRESOLVED * np.max(before.noise[own])
    place = np.where(keep, np.cumsum(keep) - 1, -1)
    persistence, resolved = persistence[keep], resolved[keep]
    partner = np.where(partner >= 0, place[partner], -1)[keep]
    rows = np.flatnonzero(resolved)
    persistence[rows], other = measure_persistence(
        surface, evidence.gap, left.singular[rows], left.index[rows], evidence.regions
    )
    partner[rows] = np.where(other >= 0, rows[other], -1)
    present = verdict.present[keep]
    return Judged(persistence, partner, verdict.at_border[keep], resolved, certain[keep], present)


def settled(surface: Surface, found: Located, verdict: Judged, radius: np.ndarray) -> Located:
    """The candidates, those that are kept moved to the mean of both places where a pair that is
    not kept has one of the same index within a fit of them and within the errors of both.

    Of three umbilics of which two cancel either of the outer ones may be the surface's. Both are
    estimates of one place, averaged by their inverse variances. On decimated meshes and marching
    cubes of seeds 200, 201, 300, 301, 400 and 401 of benchmarks.people this takes the mean error
    of 37 such places from 1.11 edges to 0.98, of 30 of 500 and 501 from 1.28 to 1.20, and 25
    instead of 21 of these are then within two edges.

    Parameters
    ----------
    radius:
        (n,) root mean square distance of the samples of the fits.
    """
    partner = verdict.partner
    mutual = (partner >= 0) & (partner[partner] == np.arange(len(found)))
    inner = ~verdict.at_border & ~np.isnan(found.p) & (np.abs(found.index) == 0.5)
    kept = np.flatnonzero(verdict.resolved & inner)
    others = np.flatnonzero(~verdict.resolved & inner & mutual)
    if not len(kept) or not len(others):
        return found
    places = found.position(surface)
    component = surface.component[surface.triangles[found.triangle, 0]]
    reach = radius[surface.triangles[found.triangle[kept]]].mean(axis=1)
    near = cKDTree(places[others]).query_ball_point(places[kept], reach)
    one = np.repeat(kept, [len(rows) for rows in near])
    two = others[np.concatenate([np.zeros(0, np.int64), *near]).astype(np.int64)]
    apart = np.linalg.norm(places[one] - places[two], axis=1)
    errors = significant(1.0, PRESENT) * np.hypot(found.uncertainty[one], found.uncertainty[two])
    same = (found.index[one] == found.index[two]) & (component[one] == component[two])
    same &= apart <= errors
    one, two, apart = one[same], two[same], apart[same]
    order = np.lexsort((apart, one))
    _, first = np.unique(one[order], return_index=True)
    triangle, barycentric = found.triangle.copy(), found.barycentric.copy()
    for both in np.stack([one, two], axis=1)[order[first]]:
        weight = np.maximum(found.uncertainty[both], np.finfo(float).eps) ** -2.0
        place = weight @ places[both] / weight.sum()
        start = found.triangle[both], found.barycentric[both]
        triangle[both[0]], barycentric[both[0]] = _nearest_place(surface, *start, place)
    return dataclasses.replace(found, triangle=triangle, barycentric=barycentric)


def other_places(
    surface: Surface, found: Located, verdict: Judged, radius: np.ndarray
) -> np.ndarray:
    """(k,) how far off, per axis, what is kept may be for standing at the wrong one of two places:
    0 where there is one.

    Of three umbilics in a row, of which two cancel, either of the outer ones may be the surface's:
    beyond the errors of both, where they are not `settled`, one of these errors is too small. Of
    two places that are as likely half the square of their distance is the variance, a quarter of
    it along each axis.

    Parameters
    ----------
    radius:
        (n,) root mean square distance of the samples of the fits.
    """
    off = np.zeros(len(found))
    partner = verdict.partner
    mutual = (partner >= 0) & (partner[partner] == np.arange(len(found)))
    half = np.abs(found.index) == 0.5
    kept = np.flatnonzero(verdict.resolved & half)
    others = np.flatnonzero(~verdict.resolved & half & mutual)
    if not len(kept) or not len(others):
        return off
    places = found.position(surface)
    reach = OTHER_PLACE * radius[surface.triangles[found.triangle[kept]]].mean(axis=1)
    near = cKDTree(places[others]).query_ball_point(places[kept], np.nan_to_num(reach))
    one = np.repeat(kept, [len(rows) for rows in near])
    two = others[np.concatenate([np.zeros(0, np.int64), *near]).astype(np.int64)]
    component = surface.component[surface.triangles[found.triangle, 0]]
    same = (found.index[one] == found.index[two]) & (component[one] == component[two])
    one, two = one[same], two[same]
    between = places[partner[two]]
    apart = np.linalg.norm(places[one] - places[two], axis=1)
    row = np.linalg.norm(places[one] - between, axis=1) < apart
    row &= np.linalg.norm(places[two] - between, axis=1) < apart
    least = np.full(len(found), np.inf)
    np.minimum.at(least, one[row], apart[row])
    return np.where(np.isfinite(least), 0.5 * least, off)


def _nearest_place(
    surface: Surface, triangles: np.ndarray, barycentric: np.ndarray, point: np.ndarray
) -> tuple[int, np.ndarray]:
    """The place on the surface nearest to a point in the middle of some places: triangle and
    weights. Looked for from the nearest of their triangles, from neighbour to neighbour while it
    gets nearer. Where all are so degenerate that nothing is near, the first place stays."""
    rows = triangles
    best, triangle, weights = np.inf, int(triangles[0]), barycentric[0]
    while True:
        corners = surface.vertices[surface.triangles[rows]]
        inside = nearest_inside(corners, _over(corners, point))
        away = np.linalg.norm(np.einsum("rk,rkc->rc", inside, corners) - point, axis=1)
        # A triangle without area has no foot of the point.
        there = np.isfinite(away) & (np.abs(inside.sum(axis=1) - 1.0) < 1e-9)
        away = np.where(there, away, np.inf)
        nearest = int(away.argmin())
        if not away[nearest] < best:
            return triangle, weights
        best, triangle, weights = float(away[nearest]), int(rows[nearest]), inside[nearest]
        beside = surface.twin[3 * triangle : 3 * triangle + 3]
        rows = beside[beside >= 0] // 3
        if not len(rows):
            return triangle, weights


def _over(corners: np.ndarray, point: np.ndarray) -> np.ndarray:
    """(r, 3) weights of the corners (r, 3, 3) at the foot of a point in the planes of the
    triangles; of those without area on the longer of two sides."""
    ab, ac, ap = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], point - corners[:, 0]
    bb, bc, cc = ((u * v).sum(axis=1) for u, v in ((ab, ab), (ab, ac), (ac, ac)))
    pb, pc = (ap * ab).sum(axis=1), (ap * ac).sum(axis=1)
    area, tiny = bb * cc - bc * bc, np.finfo(float).tiny
    flat = area <= np.maximum(np.finfo(float).eps * bb * cc, tiny)
    first = flat & (bb >= cc)
    area = np.where(flat, 1.0, area)
    b, c = (cc * pb - bc * pc) / area, (bb * pc - bc * pb) / area
    b = np.where(flat, np.where(first, pb / np.maximum(bb, tiny), 0.0), b)
    c = np.where(flat, np.where(first, 0.0, pc / np.maximum(cc, tiny)), c)
    return np.column_stack([1.0 - b - c, b, c])
