"""The form of a surface that has detail at every size, as scans have: what wide fits see of it.

Where the shape has a size of its own, the change of the deviator from one radius of the fits to
the next rises with the radius (see `scale`). On a scan it does not: there is detail at every size,
no scale is better than another, and a little more noise or other triangles choose another one,
which shows other umbilics. What the form of such a surface has are the umbilics at a scale that
the surface itself gives, whatever its triangles: as wide as so many fits side by side cover it,
and where the surface turns too far for these as wide as twice as many do, and so on.

Fits as wide as that need few samples: the mean places of small connected patches of the surface,
each weighed by its area as the plane of the fit sees it, less and less towards the rim of the
window, so that how the surface is cut into triangles hardly matters.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ..base.buffers import Workspace
from ..base.parallel import run
from ..base.progress import Progress
from ..base.unit import unit
from ..fields.frames import frame
from ..fields.transport import carried, doubled_angle, tangents
from ..mesh.rings import Begun
from ..mesh.surface import BLOCK, Surface
from .field import CurvatureField, field_from_deviators
from .fits.height_fit import HeightFit, solve_heights, sum_count, sum_samples
from .fits.jets import DEGREE, Jets
from .fits.monge import operator_of_heights
from .spread_fits import Fits, blended, rows_of
from .wider import MOST_TURN

# Fits side by side that cover the surface, at least, and how often twice as many are tried.
FITS = 64
MOST_DOUBLED = 6
# Patches across half a window: a window holds about a hundred.
PATCHES = 6.0
# Edges of the graph of patches that reach over one patch at most: they meet at corners.
DETOUR = 1.3
# Vertices for each fit, at least: a window holds twice as many.
LEAST = 40
# Share of the gap that the change is, at least: where it is less any scale shows the same umbilics.
UNSETTLED = 0.2
# Share of the change that errors of single patches may be: where they are all of it, 1.1.
NOISY = 0.65
# Turn, in radians over the radius, up to which a place is seen by fits; from twice that on by the
# narrower ones alone, in the end those of the surface itself.
WIDEST = 0.7
# Cosine between the normals of the wide fits and of the surface below which they are not of it.
ALIKE = 0.5
# Patches that are fitted by one thread at once, at most: whatever number of threads there is, the
# same are summed together. And what is nothing beside one.
CHUNK, TINY = 512, 1e-6
# Windows that are summed together: many calls for few take longer, and more leave the cache.
TOGETHER = 64
# Patches that are fitted to see whether the surface has a size of its own.
SAMPLED = 300
# From a radius to one so much larger cubics miss twice as much of a smooth surface. Where the
# change rises less than half as much at every radius, down to the least that vertices allow, there
# is detail at every size: on six scans, and on copies of three, noisy, halved and with other
# triangles, it rises at most 1.29 times; of a car and a boat, whose change rises as little at the
# widest, up to 1.80 and 1.65 times at narrower ones.
STEP = float(np.sqrt(2.0))


@dataclass(frozen=True)
class Form:
    """What wide fits see.

    Attributes
    ----------
    field:
        Shape operators at the n vertices, by the widest fits that the surface turns little within,
        else those of the surface itself; `noise` its standard errors.
    share:
        (n,) how much of each is wide fits', 0 to 1.
    radius:
        (n,) root mean square distance of the samples of each.
    widest:
        That of the widest fits.
    """

    field: CurvatureField
    share: np.ndarray
    radius: np.ndarray
    widest: float


@dataclass(frozen=True)
class _Patches:
    """Small connected pieces of a surface, p of them.

    Attributes
    ----------
    patch:
        (n,) that of each vertex.
    middle, normal:
        (p, 3) mean places and unit normals.
    area:
        (p,) their areas.
    graph:
        (p, p) bool, whether an edge joins two, each with itself as well.
    side:
        The length that they are cut to.
    """

    patch: np.ndarray
    middle: np.ndarray
    normal: np.ndarray
    area: np.ndarray
    graph: sparse.csr_array
    side: float

    @classmethod
    def of(cls, surface: Surface, normals: np.ndarray, side: float) -> _Patches:
        """The parts that a grid of cubes of this side cuts the surface into."""
        key = np.zeros(len(surface.vertices), np.int64)
        for along in surface.coordinates:
            cube = np.floor(along / side).astype(np.int64)
            cube -= cube.min()
            key *= int(cube.max()) + 1
            key += cube
        n = len(key)
        tail, head = surface.owner, surface.neighbours
        same = np.empty(len(tail), bool)

        def compare(first: int) -> None:
            some = slice(first, first + BLOCK)
            one, two = tail[some], head[some]
            same[some] = (key.take(one) == key.take(two)) & (one < two)

        run(compare, range(0, len(tail), BLOCK), Progress())
        start = np.append(0, np.cumsum(same, dtype=np.int32))[surface.neighbour_start]
        columns = head[same].astype(np.int32)
        inside = sparse.csr_array((np.ones(len(columns)), columns, start), (n, n))
        count, patch = csgraph.connected_components(inside, directed=False)
        weight = surface.vertex_area / 3.0
        area = np.bincount(patch, weight)
        middle, normal = (
            np.stack([np.bincount(patch, weight * axis) for axis in vectors], axis=1)
            for vectors in (surface.coordinates, normals.T)
        )
        middle = middle / np.maximum(area, np.finfo(float).tiny)[:, None]
        tail, head = patch[tail], patch[head]
        apart = np.flatnonzero(tail < head)
        keys = np.unique(tail[apart].astype(np.int64) * count + head[apart])
        one, two = np.divmod(keys, count)
        own = np.arange(count)
        rows, columns = np.concatenate([one, two, own]), np.concatenate([two, one, own])
        ones = np.ones(len(rows), bool)
        graph = sparse.coo_array((ones, (rows, columns)), (count, count)).tocsr()
        return cls(patch, middle, unit(normal), area, graph, side)


def levels_of(surface: Surface, normals: np.ndarray, progress: Progress) -> list[Level]:
    """The radii at which a surface that has detail at every size has a form, the widest first;
    none of one that has a size of its own.

    Parameters
    ----------
    normals:
        (n, 3) unit vertex normals.
    """
    levels: list[Level] = []
    for doubled in range(MOST_DOUBLED):
        level = Level.of(surface, normals, doubled, progress)
        if level is None:
            break
        if not levels and level.turned:
            continue
        if not (level.falls if levels else level.sees_detail):
            return []
        levels.append(level)
    return levels


@dataclass(frozen=True)
class Level:
    """Fits of one radius, and how they differ from those a step narrower and wider.

    Attributes
    ----------
    patches, radius:
        What is fitted, and the root mean square distance of the samples.
    turned:
        Whether the surface turns too far within the radius to tell.
    falls:
        Whether the change to the next radius rises less than half as much as that of a smooth
        surface does.
    sees_detail:
        Whether besides the change is neither small nor what independent errors make.
    factor:
        The change over the error that residuals tell.
    """

    patches: _Patches
    radius: float
    turned: bool
    falls: bool
    sees_detail: bool
    factor: float

    @classmethod
    def of(
        cls, surface: Surface, normals: np.ndarray, doubled: int, progress: Progress
    ) -> Level | None:
        """Of `FITS` side by side, so many times doubled; None where too few vertices are left."""
        count = FITS * 2**doubled
        if LEAST * count > len(surface.vertices):
            return None
        area = float(surface.face_normal_area[1].sum())
        # Weights (1 - d^2 / reach^2)^2 have a root mean square distance of half the reach; points
        # of a disc are 1 / sqrt(2) of its radius from its middle.
        radius = float(np.sqrt(area / (2.0 * np.pi * count)))
        patches = _Patches.of(surface, normals, 2.0 * radius / PATCHES)
        step = max(len(patches.area) // SAMPLED, 1)
        # Every so many along an axis: whatever number they have.
        some = np.argsort(patches.middle[:, 0], kind="stable")[::step]
        deviators, known = [], np.ones(len(some), bool)
        scales = (1.0 / STEP, 1.0, STEP)
        fits, _ = _fits(patches, [scale * radius for scale in scales], some, progress)
        for scale, (fit, size) in zip(scales, fits, strict=True):
            c = fit.coefficients
            operator = operator_of_heights(c[1, 0], c[0, 1], 2 * c[2, 0], c[1, 1], 2 * c[0, 2])
            found = (operator.real + 1j * operator.imaginary) / size
            known &= fit.determined
            deviators.append(found)
            if scale == 1.0:
                noise = fit.gap_error / size
                turn = np.abs(operator.mean) + 0.5 * np.abs(found) * size
        if not known.any() or np.median(turn[known]) > MOST_TURN:
            return cls(patches, radius, True, False, False, 0.0)
        one, two = (float(np.median(np.abs(b - a)[known])) for a, b in pairwise(deviators))
        gap = float(np.median(np.abs(deviators[1])[known]))
        independent = float(np.median(noise[known]))
        falls = two < STEP * one
        detail = falls and two > UNSETTLED * gap and 0.0 < independent < NOISY * two
        factor = two / max(independent, np.finfo(float).tiny)
        return cls(patches, radius, False, falls, detail, factor)


def form_of(
    surface: Surface,
    levels: list[Level],
    field: CurvatureField,
    radius: np.ndarray,
    progress: Progress,
) -> Form:
    """The form at levels of `levels_of`, one at least, of a surface with the shape operators of
    `field` of its own, whose samples have the root mean square distances `radius` (n,)."""
    under = field.normal
    e1, e2 = tangents(under)
    rest = np.ones(len(under))
    deviator = np.zeros(len(under), np.complex128)
    mean, noise, size = np.zeros((3, len(under)))
    for level in levels:
        jets = _jets(surface, level, rest > 0.0, progress)
        turn = level.radius * np.maximum(np.abs(jets.k1), np.abs(jets.k2))
        share = rest * np.clip(2.0 - turn / WIDEST, 0.0, 1.0)
        share[~jets.determined | (np.einsum("nc,nc->n", under, jets.normal) < ALIKE)] = 0.0
        rows = np.flatnonzero(share)
        first = carried(jets.d1[rows], jets.normal[rows], under[rows])
        wide = doubled_angle(first, e1[rows], e2[rows], (jets.k1 - jets.k2)[rows])
        deviator[rows] += share[rows] * wide
        mean[rows] += 0.5 * share[rows] * (jets.k1 + jets.k2)[rows]
        noise += share * level.factor * jets.noise
        size += share * level.radius
        rest = rest - share
    deviator += rest * doubled_angle(field.d1, e1, e2, field.gap)
    mean += 0.5 * rest * (field.k1 + field.k2)
    noise += rest * field.noise
    size += rest * radius
    shape = field_from_deviators(mean, deviator, under, noise)
    return Form(shape, 1.0 - rest, size, levels[0].radius)


def _jets(surface: Surface, level: Level, wanted: np.ndarray, progress: Progress) -> Jets:
    """Jets at the vertices `wanted` (n,), the others not determined."""
    patches = level.patches
    near = patches.graph[patches.patch]
    if not wanted.all():
        near = (sparse.diags_array(wanted.astype(float)) @ near).astype(bool).tocsr()
        near.eliminate_zeros()
    asked = np.unique(near.indices)
    [(fit, size)], axes = _fits(patches, [level.radius], asked, progress)
    there, values = rows_of(fit, size, axes, patches.middle[asked])
    # Fits count in the mean by the area of their patches.
    there[:, 6] /= np.sqrt(np.maximum(patches.area[asked], np.finfo(float).tiny))
    place = np.zeros(len(patches.area), near.indices.dtype)
    place[asked] = np.arange(len(asked))
    shape = near.shape[0], len(asked)
    near = sparse.csr_array((near.data, place[near.indices], near.indptr), shape)
    fits = Fits(there, (values[:, None],))
    return blended(surface.vertices, patches.normal[patches.patch], fits, near, progress)


def _fits(
    patches: _Patches, radii: list[float], centres: np.ndarray, progress: Progress
) -> tuple[list[tuple[HeightFit, np.ndarray]], np.ndarray]:
    """Cubics at patches (c,) over windows of ascending radii, each with the radii (c,) of its
    samples, and the axes (3, 3, c) of them all."""
    c = len(centres)
    along = patches.normal[centres].T
    axes = np.stack([*frame(along), along])
    sums = np.empty((len(radii), sum_count(DEGREE), c))
    size, count = np.empty((2, len(radii), c))
    coordinates, normals = (np.ascontiguousarray(a.T) for a in (patches.middle, patches.normal))
    parts = -(-c // CHUNK)
    cuts = c * np.arange(parts + 1) // max(parts, 1)

    def fit(part: int) -> None:
        workspace, begun = Workspace(), Begun()
        rows = np.arange(cuts[part], cuts[part + 1])
        for scale, radius in enumerate(radii):
            reach = 2.0 * radius
            rings = int(np.ceil(DETOUR * reach / patches.side))
            for some, around in begun.grow(centres[rows], patches.graph, rings, progress):
                own = rows[some]
                for at, members, there in _windows(coordinates, centres, own, around, reach):
                    offset, lines, facing = np.empty((3, 3, *members.shape))
                    for k, middle in enumerate(coordinates[:, centres[at]]):
                        np.subtract(coordinates[k].take(members), middle, out=offset[k])
                        np.multiply(normals[k].take(members), along[k, at], out=facing[k])
                    square = np.einsum("csb,csb->sb", offset, offset)
                    weight = np.maximum(1.0 - square / reach**2, TINY) ** 2
                    weight *= patches.area.take(members)
                    # Area as the plane sees it: the other side of a thin sheet is none of it.
                    weight *= np.maximum(facing.sum(axis=0), TINY)
                    weight *= there
                    total = weight.sum(axis=0)
                    mean = np.einsum("sb,sb->b", weight, square) / total
                    mean = np.maximum(np.sqrt(mean), TINY * reach)
                    size[scale, at] = mean
                    count[scale, at] = total**2 / np.einsum("sb,sb->b", weight, weight)
                    # Axis by axis: NumPy takes three times as long for one contraction with all.
                    for axis, line in zip(axes[:, :, at] / mean, lines, strict=True):
                        np.einsum("csb,cb->sb", offset, axis, out=line)
                    x, y, z = lines
                    some_sums = np.empty((sums.shape[1], len(at)))
                    sum_samples(x, y, z, weight, DEGREE, some_sums, workspace)
                    sums[scale][:, at] = some_sums

    run(fit, range(parts), progress)
    fits = [solve_heights(s, n, DEGREE, Workspace()) for s, n in zip(sums, count, strict=True)]
    return list(zip(fits, size, strict=True)), axes


def _windows(
    coordinates: np.ndarray,
    centres: np.ndarray,
    own: np.ndarray,
    around: sparse.csr_array,
    reach: float,
) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Blocks of windows of about one size.

    Parameters
    ----------
    coordinates:
        (3, p) places of the patches.
    centres, own:
        (c,) patches in the middle of windows, and (r,) which of these the rows (r, p) `around`
        belong to.
    reach:
        How far members lie from it, less than.

    Yields
    ------
    at:
        (b,) of `own`.
    members, there:
        (s, b) patches, and whether they are of the window: the smaller are filled up.
    """
    of = np.repeat(centres[own], np.diff(around.indptr))
    square = np.zeros(len(of))
    for axis in coordinates:
        away = axis.take(around.indices)
        away -= axis.take(of)
        away *= away
        square += away
    inside = square < reach * reach
    start = np.append(0, np.cumsum(inside))[around.indptr]
    members = around.indices[inside].astype(np.intp)
    sizes = np.diff(start)
    order = np.argsort(sizes, kind="stable")
    for low in range(0, len(order), TOGETHER):
        rows = order[low : low + TOGETHER]
        slots = np.arange(sizes[rows[-1]])[:, None]
        there = slots < sizes[rows]
        yield own[rows], members[np.where(there, start[rows] + slots, start[rows])], there
