"""The form of a surface that has detail at every size, as scans have: what wide fits see of it.

Where the shape has a size of its own, the change of the deviator from one radius of the fits to
the next rises with the radius (see `scale`). On a scan it does not: there is detail at every size,
no scale is better than another, and a little more noise or other triangles choose another one,
which shows other umbilics. What the form of such a surface has are the umbilics at a scale that
the surface itself gives, whatever its triangles: as wide as so many fits side by side cover it,
and where the surface turns too far for these as wide as twice as many do, and so on.

Fits as wide as that need few samples: the mean places of small connected patches of the surface,
each weighed by its area as the plane of the fit sees it, less and less towards the rim of the
window, so that how the surface is cut into triangles hardly matters. What one tells varies slowly
over its window: they are made at cells of some four patches, and blended at the vertices.
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
from ..base.subsets import spans
from ..base.unit import unit
from ..fields.frames import frame
from ..fields.transport import carried, doubled_angle, tangents
from ..mesh.rings import adjacency, grow, selection
from ..mesh.surface import Surface
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
# Edges of the graph of cells that reach over one cell at most: they meet at corners.
DETOUR = 1.3
# Vertices for each fit, at least: a window holds twice as many.
LEAST = 40
# Share of the gap that the change is, at least: where it is less any scale shows the same umbilics.
# Of six scans and their copies it is .20 and more at the widest, of a boat, a plane with holes and
# 24 rough and noisy meshes with a size (`benchmarks/accuracy`, seed 800) .13 at most.
UNSETTLED = 0.15
# Share of the change that errors of single patches may be: where they are all of it, 1.1.
NOISY = 0.65
# Turn, in radians over the radius, up to which a place is seen by fits; from twice that on by the
# narrower ones alone, in the end those of the surface itself.
WIDEST = 0.7
# Cosine between the normals of the wide fits and of the surface below which they are not of it.
ALIKE = 0.5
# Cells that are fitted at by one thread at once, at most: whatever number of threads there is, the
# same are summed together. And what is nothing beside one.
CHUNK, TINY = 512, 1e-6
# Windows that are summed together: many calls for few take longer, and more leave the cache.
TOGETHER = 64
# Cells that are fitted at to see whether the surface has a size of its own.
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
class _Pieces:
    """Small connected pieces of a surface, p of them, that a grid of cubes cuts it into.

    Attributes
    ----------
    piece:
        (n,) that of each vertex, or of each smaller piece.
    cube:
        (p, 3) int64 which cube of the grid each is of.
    middle, normal:
        (p, 3) mean places, and normals times their areas.
    area:
        (p,) their areas.
    graph:
        (p, p) bool, whether an edge joins two, each with itself as well.
    side:
        That of the cubes.
    """

    piece: np.ndarray
    cube: np.ndarray
    middle: np.ndarray
    normal: np.ndarray
    area: np.ndarray
    graph: sparse.csr_array
    side: float

    @classmethod
    def of(cls, surface: Surface, normals: np.ndarray, side: float) -> _Pieces:
        """The pieces for cubes of this side."""
        cube = np.floor(surface.vertices / side).astype(np.int64)
        area = surface.vertex_area / 3.0
        graph = adjacency(surface)
        places = surface.coordinates
        return cls._joined(cube, graph, area, places, normals.T * area, side)

    def joined(self) -> _Pieces:
        """Those for cubes of twice the side, each of some of these."""
        cube = self.cube >> 1
        return self._joined(
            cube, self.graph, self.area, self.middle.T, self.normal.T, 2.0 * self.side
        )

    @classmethod
    def _joined(
        cls,
        cube: np.ndarray,
        graph: sparse.csr_array,
        area: np.ndarray,
        places: np.ndarray,
        normals: np.ndarray,
        side: float,
    ) -> _Pieces:
        n = len(cube)
        key = np.zeros(n, np.int64)
        for along in cube.T:
            along = along - along.min()
            key *= int(along.max()) + 1
            key += along
        tail = np.repeat(np.arange(n, dtype=np.int32), np.diff(graph.indptr))
        head = graph.indices
        same = (key.take(tail) == key.take(head)) & (tail < head)
        start = np.append(0, np.cumsum(same, dtype=np.int32))[graph.indptr]
        columns = head[same]
        inside = sparse.csr_array((np.ones(len(columns)), columns, start), (n, n))
        count, piece = csgraph.connected_components(inside, directed=False)
        total = np.bincount(piece, area)
        middle = np.stack([np.bincount(piece, area * axis) for axis in places], axis=1)
        middle = middle / np.maximum(total, np.finfo(float).tiny)[:, None]
        normal = np.stack([np.bincount(piece, axis) for axis in normals], axis=1)
        first = np.empty(count, np.int64)
        first[piece] = np.arange(n)
        tail, head = piece.take(tail), piece.take(head)
        apart = tail != head
        own = np.arange(count, dtype=tail.dtype)
        rows, columns = np.append(tail[apart], own), np.append(head[apart], own)
        joins = sparse.coo_array((np.ones(len(rows), bool), (rows, columns)), (count, count))
        return cls(piece, cube[first], middle, normal, total, joins.tocsr(), side)


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
    patches, cells, radius:
        The samples, what is fitted at, and the root mean square distance of the samples.
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

    patches: _Pieces
    cells: _Pieces
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
        patches = _Pieces.of(surface, normals, 2.0 * radius / PATCHES)
        cells = patches.joined()
        step = max(len(cells.area) // SAMPLED, 1)
        # Every so many along an axis: whatever number they have.
        some = np.argsort(cells.middle[:, 0], kind="stable")[::step]
        deviators, known = [], np.ones(len(some), bool)
        scales = (1.0 / STEP, 1.0, STEP)
        fits, _ = _fits(patches, cells, [scale * radius for scale in scales], some, progress)
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
            return cls(patches, cells, radius, True, False, False, 0.0)
        one, two = (float(np.median(np.abs(b - a)[known])) for a, b in pairwise(deviators))
        gap = float(np.median(np.abs(deviators[1])[known]))
        independent = float(np.median(noise[known]))
        falls = two < STEP * one
        detail = falls and two > UNSETTLED * gap and 0.0 < independent < NOISY * two
        factor = two / max(independent, np.finfo(float).tiny)
        return cls(patches, cells, radius, False, falls, detail, factor)


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
        wanted = np.flatnonzero(rest)
        jets = _jets(surface, level, wanted, progress)
        turn = level.radius * np.maximum(np.abs(jets.k1), np.abs(jets.k2))
        share = rest[wanted] * np.clip(2.0 - turn / WIDEST, 0.0, 1.0)
        share[~jets.determined | (np.einsum("nc,nc->n", under[wanted], jets.normal) < ALIKE)] = 0.0
        some = np.flatnonzero(share)
        rows, share = wanted[some], share[some]
        first = carried(jets.d1[some], jets.normal[some], under[rows])
        wide = doubled_angle(first, e1[rows], e2[rows], (jets.k1 - jets.k2)[some])
        deviator[rows] += share * wide
        mean[rows] += 0.5 * share * (jets.k1 + jets.k2)[some]
        noise[rows] += share * level.factor * jets.noise[some]
        size[rows] += share * level.radius
        rest[rows] -= share
    deviator += rest * doubled_angle(field.d1, e1, e2, field.gap)
    mean += 0.5 * rest * (field.k1 + field.k2)
    noise += rest * field.noise
    size += rest * radius
    shape = field_from_deviators(mean, deviator, under, noise)
    return Form(shape, 1.0 - rest, size, levels[0].radius)


def _jets(surface: Surface, level: Level, wanted: np.ndarray, progress: Progress) -> Jets:
    """Jets at the vertices `wanted` (w,)."""
    patches, cells = level.patches, level.cells
    cell = cells.piece[patches.piece[wanted]]
    held = np.zeros(len(cells.area), bool)
    held[cell] = True
    near = cells.graph[np.flatnonzero(held)]
    asked = np.unique(near.indices)
    [(fit, size)], axes = _fits(patches, cells, [level.radius], asked, progress)
    there, values = rows_of(fit, size, axes, cells.middle[asked])
    # Fits count in the mean by the area of their cells.
    there[:, 6] /= np.sqrt(np.maximum(cells.area[asked], np.finfo(float).tiny))
    place = np.zeros(len(held), near.indices.dtype)
    place[asked] = np.arange(len(asked), dtype=place.dtype)
    shape = near.shape[0], len(asked)
    near = sparse.csr_array((near.data, place[near.indices], near.indptr), shape)
    near = near[(np.cumsum(held) - 1)[cell]]
    fits = Fits(there, (values[:, None],))
    normals = unit(cells.normal)
    return blended(surface.vertices[wanted], normals[cell], fits, near, progress)


def _fits(
    patches: _Pieces,
    cells: _Pieces,
    radii: list[float],
    centres: np.ndarray,
    progress: Progress,
) -> tuple[list[tuple[HeightFit, np.ndarray]], np.ndarray]:
    """Cubics at cells (c,) over windows of ascending radii, each with the radii (c,) of its
    samples, and the axes (3, 3, c) of them all."""
    c = len(centres)
    along = unit(cells.normal[centres]).T
    middles = np.ascontiguousarray(cells.middle[centres].T)
    axes = np.stack([*frame(along), along])
    sums = np.empty((len(radii), sum_count(DEGREE), c))
    size, count = np.empty((2, len(radii), c))
    order = np.argsort(cells.piece, kind="stable")
    begin = np.append(0, np.cumsum(np.bincount(cells.piece, minlength=len(cells.area))))
    coordinates = np.ascontiguousarray(patches.middle[order].T)
    normals = np.ascontiguousarray(patches.normal[order].T)
    parts = -(-c // CHUNK)
    cuts = c * np.arange(parts + 1) // max(parts, 1)
    rings = int(np.ceil(DETOUR * 2.0 * radii[-1] / cells.side))

    def fit(part: int) -> None:
        workspace = Workspace()
        rows = np.arange(cuts[part], cuts[part + 1])
        around = selection(centres[rows, None], len(cells.area))
        for some, reached in grow(around, cells.graph, rings, progress):
            own = rows[some]
            for scale, radius in enumerate(radii):
                reach = 2.0 * radius
                blocks = _windows(coordinates, middles[:, own], reached, begin, reach)
                for block, members, there in blocks:
                    at = own[block]
                    offset, lines, facing = np.empty((3, 3, *members.shape))
                    for k, middle in enumerate(middles[:, at]):
                        np.subtract(coordinates[k].take(members), middle, out=offset[k])
                        np.multiply(normals[k].take(members), along[k, at], out=facing[k])
                    square = np.einsum("csb,csb->sb", offset, offset)
                    weight = np.maximum(1.0 - square / reach**2, TINY) ** 2
                    # Area as the plane sees it: the other side of a thin sheet is none of it.
                    weight *= np.maximum(facing.sum(axis=0), TINY * cells.side**2)
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
    middles: np.ndarray,
    around: sparse.csr_array,
    begin: np.ndarray,
    reach: float,
) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Blocks of windows of about one size.

    Parameters
    ----------
    coordinates:
        (3, p) places of the patches, cell by cell, those of each from `begin` (cells + 1,) on.
    middles:
        (3, r) places in the middle of windows.
    around:
        (r, cells) which cells may be of each.
    reach:
        How far members lie from it, less than.

    Yields
    ------
    rows:
        (b,) of the windows.
    members, there:
        (s, b) patches, and whether they are of the window: the smaller are filled up.
    """
    held = np.diff(begin)[around.indices]
    candidates = spans(begin[around.indices], held)
    ends = np.append(0, np.cumsum(held))[around.indptr]
    every = np.diff(ends)
    square = np.zeros(len(candidates))
    for axis, middle in zip(coordinates, middles, strict=True):
        away = axis.take(candidates)
        away -= np.repeat(middle, every)
        away *= away
        square += away
    inside = square < reach * reach
    start = np.append(0, np.cumsum(inside))[ends]
    members = candidates[inside]
    sizes = np.diff(start)
    order = np.argsort(sizes, kind="stable")
    for low in range(0, len(order), TOGETHER):
        rows = order[low : low + TOGETHER]
        slots = np.arange(sizes[rows[-1]])[:, None]
        there = slots < sizes[rows]
        yield rows, members[np.where(there, start[rows] + slots, start[rows])], there
