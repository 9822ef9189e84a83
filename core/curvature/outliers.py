"""Single vertices that stick out of a surface: outliers of photogrammetry, spikes of a scan.

On a clean mesh a single one of them makes umbilics all around it, which no error of the fits tells:
these are averages over many vertices. A vertex is an outlier if it lies much further off a fit to
those around it, without it, than they scatter about that fit (deleted residuals, Cook & Weisberg
1982). A corner or an edge of a surface is none: what is around it fits no better than itself.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy import sparse

from ..base.buffers import Workspace
from ..base.parallel import run
from ..base.progress import Progress
from ..base.unit import unit
from ..fields.frames import frame
from ..mesh.neighbourhoods import Neighbourhood
from ..mesh.normals import vertex_normals
from ..mesh.rings import adjacency
from ..mesh.surface import Surface
from .fits.height_fit import (
    HeightFit,
    heights_at,
    lower_sums,
    solve_heights,
    sum_count,
    sum_samples,
)

# Vertices are asked where the surface is so many times rougher than in the median, at most this
# share of them: where more are, roughness is the surface's own.
ROUGH, MOST = 8.0, 0.02
# What rounding to single precision makes in the unit box, of a vertex and of those around it, is no
# outlier.
ROUNDING = 4.0 * np.finfo(np.float32).eps
# A vertex of more than twice the usual number of edges is the middle of a fan, as of a cap, where a
# subdivided surface bends as no polynomial does (by .12 edges on Blender's cylinder).
FAN = 12
# Degrees and rings of the fits without them.
DEGREES, RINGS = (4, 2), 3
# Weights 1 / (1 + d^2 / FOCUS)^3 of the squared distance (mean 1), as on clean meshes.
FOCUS = 1.0
# Samples so many times further off than the median one are left out, and the fit is made anew, so
# often: another outlier may be among them.
ODD, ROUNDS = 6.0, 3
# Standard deviations of those around it that an outlier is off: of a Student's t of 15 degrees of
# freedom one in a million is as far out.
OFF = 8.0
# Share of that which the two degrees may differ by. At the tip of a cone, which rings around it do
# not tell from a paraboloid, they differ by a half.
AGREE = 0.25
# Passes: of outliers side by side one hides the other.
PASSES = 3
BLOCK = 1 << 15


def without_outliers(
    surface: Surface, normals: np.ndarray, progress: Progress
) -> tuple[Surface, np.ndarray, np.ndarray]:
    """The surface with its outliers laid onto the fit to those around them, its unit normals (n, 3)
    and (k,) which vertices these are."""
    graph = adjacency(surface)
    near_border = surface.near_border(RINGS)
    moved = np.zeros(len(surface.vertices), bool)
    for _ in range(PASSES):
        asked = _roughest(surface, normals, graph, progress.quiet()) & ~near_border
        rows = np.flatnonzero(asked)
        if not 0 < len(rows) <= MOST * len(asked):
            break
        straight = normals.copy()
        straight[graph[rows].indices] = straight[rows] = 0.0
        shift = _shifts(surface, straight, rows, asked, progress)
        out = np.einsum("rc,rc->r", shift, shift) > 0.0
        if not out.any():
            break
        vertices = surface.vertices.copy()
        vertices[rows[out]] += shift[out]
        surface = dataclasses.replace(surface, vertices=vertices)
        normals = vertex_normals(surface)
        moved[rows[out]] = True
    return surface, normals, np.flatnonzero(moved)


def _roughest(
    surface: Surface, normals: np.ndarray, graph: sparse.csr_array, progress: Progress
) -> np.ndarray:
    """(n,) bool, vertices where the surface is much rougher than usual and rougher than at their
    neighbours: how far they lie off the mean of their ring, less what the ring does of its own."""
    start, neighbours, vertices = surface.neighbour_start, surface.neighbours, surface.vertices
    n = len(vertices)
    count = np.diff(start)
    off, rough = np.empty((2, n))
    ones = np.ones(len(neighbours))

    def ring_mean(first: int, values: np.ndarray) -> np.ndarray:
        begin = start[first : first + BLOCK + 1]
        some = slice(begin[0], begin[-1])
        shape = len(begin) - 1, n
        ring = sparse.csr_array((ones[some], neighbours[some], begin - begin[0]), shape=shape)
        return np.asarray((ring @ values).T / np.diff(begin))

    def off_ring(first: int) -> None:
        rows = slice(first, first + BLOCK)
        away = ring_mean(first, vertices) - vertices[rows].T
        np.einsum("cn,nc->n", away, normals[rows], out=off[rows])

    def roughness(first: int) -> None:
        rows = slice(first, first + BLOCK)
        np.abs(off[rows] - ring_mean(first, off), out=rough[rows])

    for work in (off_ring, roughness):
        run(work, range(0, n, BLOCK), progress)
    rows = np.flatnonzero((rough > max(ROUGH * np.median(rough), ROUNDING)) & (count <= FAN))
    asked = np.zeros(n, bool)
    if len(rows):
        ring = graph[rows]
        beside = np.maximum.reduceat(rough[ring.indices], ring.indptr[:-1])
        asked[rows] = rough[rows] >= beside
    return asked


def _shifts(
    surface: Surface,
    normals: np.ndarray,
    centres: np.ndarray,
    asked: np.ndarray,
    progress: Progress,
) -> np.ndarray:
    """(c, 3) from vertices to the fits to what is around them, zero for those that are no outliers.

    Parameters
    ----------
    normals:
        (n, 3) float64 unit normals, zero where outliers may have tilted them.
    asked:
        (n,) bool, vertices that nothing is fitted to.
    """
    shift, workspace = np.zeros((len(centres), 3)), Workspace()
    graph = adjacency(surface)
    ring = graph[centres]
    middle = (ring @ surface.vertices) / np.diff(ring.indptr)[:, None]
    around = Neighbourhood(surface, graph, rings=RINGS, focused=False)
    for rows, members, held in around.blocks(centres, BLOCK, progress):
        there = np.arange(len(members))[:, None] < held
        normal = unit(np.where(there[:, :, None], normals[members], 0.0).sum(axis=0))
        axes = np.stack([*frame(normal.T), normal.T])
        offset = surface.vertices[members] - surface.vertices[centres[rows]]
        x, y, z = np.einsum("sbc,kcb->ksb", offset, axes)
        weights = np.where(asked[members] | ~there, 0.0, 1.0)
        radius = np.sqrt((weights * (x * x + y * y)).sum(axis=0) / np.maximum(weights.sum(0), 1.0))
        radius = np.maximum(radius, np.sqrt(np.finfo(float).tiny))
        x, y, z = x / radius, y / radius, z / radius
        weights *= (1.0 + (x * x + y * y) / FOCUS) ** -3
        for _ in range(ROUNDS):
            one, two = _fits(x, y, z, weights, workspace)
            left = np.abs(z - heights_at(one.coefficients, x, y))
            odd = (left > ODD * _medians(left, weights > 0.0)) & (weights > 0.0)
            if not odd.any():
                break
            weights[odd] = 0.0
        height, other = one.coefficients[0, 0], two.coefficients[0, 0]
        out = one.determined & (np.count_nonzero(weights, axis=0) > len(one.coefficients))
        out &= np.abs(height) > OFF * one.residual
        out &= np.abs(height - other) < AGREE * np.abs(height)
        # Over the middle of its ring: off to the side it would fold the triangles around it.
        aside = middle[rows] - surface.vertices[centres[rows]]
        u, v = np.einsum("bc,kcb->kb", aside, axes[:2]) / radius
        height = heights_at(one.coefficients, u, v)
        laid = np.einsum("kb,kcb->bc", radius * np.stack([u, v, height]), axes)
        shift[rows[out]] = laid[out]
    return shift


def _medians(values: np.ndarray, known: np.ndarray) -> np.ndarray:
    """(b,) medians of the known of values (s, b); infinite where none is."""
    rising = np.sort(np.where(known, values, np.inf).T, axis=1)
    count = np.maximum(np.count_nonzero(known, axis=0), 1)
    row = np.arange(len(rising))
    return 0.5 * (rising[row, (count - 1) // 2] + rising[row, count // 2])


def _fits(
    x: np.ndarray, y: np.ndarray, z: np.ndarray, weights: np.ndarray, workspace: Workspace
) -> list[HeightFit]:
    """Fits of the degrees to columns of samples (s, b)."""
    most = max(DEGREES)
    sums = np.empty((sum_count(most), x.shape[1]))
    sum_samples(x, y, z, weights, most, sums, workspace)
    samples = np.count_nonzero(weights, axis=0)
    return [
        solve_heights(lower_sums(sums, most, degree), samples, degree, workspace)
        for degree in DEGREES
    ]
