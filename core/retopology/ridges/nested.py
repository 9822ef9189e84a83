"""Fits of third derivatives that reach one ring farther each: what they sum grows ring by ring."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from ...base.buffers import Workspace
from ...curvature.fits.height_fit import solve_heights, sum_count, sum_degrees, sum_samples
from ...curvature.fits.jets import samples_about
from ...mesh.rings import adjacency, by_size
from ...mesh.surface import Surface
from .slopes import ENDS, SAMPLES_PER_BLOCK, Slopes, slopes_of


class NestedFits:
    """Polynomials with equal weights at vertices (c,), over more and more rings.

    All the reaches together take no longer than the widest alone, since a wider fit adds the sums
    of its last ring to those of the fit before.

    Parameters
    ----------
    axes:
        (3, 3, n) float64 as for `fit_slopes`.
    centres:
        (c,) the vertices.
    degree, rings:
        Degree of the polynomials, and the rings of the first fit, two or more.
    """

    def __init__(
        self, surface: Surface, axes: np.ndarray, centres: np.ndarray, degree: int, rings: int
    ) -> None:
        self._coordinates = surface.coordinates
        self._origin = self._coordinates[:, centres]
        self._axes = np.ascontiguousarray(axes[:, :, centres])
        self._degree, self._workspace = degree, Workspace()
        self._unit = surface.mean_side
        self._sums = np.zeros((sum_count(degree), len(centres)))
        self._count, self._squares = np.zeros((2, len(centres)))
        self._graph = adjacency(surface)
        self._reach = self._graph[centres]
        for _ in range(rings - 1):
            self._grow()
        self._add(self._reach)

    def slopes(self) -> Slopes:
        """Those of the fits as far as they reach now."""
        radius = np.sqrt(self._squares / self._count)
        radius = np.maximum(radius, np.finfo(float).tiny)
        sums = self._sums * (self._unit / radius) ** sum_degrees(self._degree)[:, None]
        fit = solve_heights(sums, self._count, self._degree, self._workspace, ENDS)
        return slopes_of(fit, radius, self._axes)

    def widen(self) -> None:
        """Reach one ring farther."""
        before = self._reach
        self._grow()
        ring = self._reach - before
        ring.eliminate_zeros()
        self._add(ring)

    def _grow(self) -> None:
        # A walk of exactly so many edges, two or more, reaches the nearer vertices too.
        self._reach = self._reach @ self._graph
        self._reach.data[:] = 1

    def _add(self, members: sparse.csr_array) -> None:
        """Sum the samples that the rows of a matrix name."""
        degrees = sum_degrees(self._degree)[:, None]
        sums = self._workspace.array("sums", *self._sums.shape)
        for rows, some in by_size(members, SAMPLES_PER_BLOCK):
            origin = self._origin.take(rows, axis=1)
            axes = self._axes.take(rows, axis=2)
            (x, y, height), radius = samples_about(
                self._coordinates, some, len(some), origin, axes, self._workspace
            )
            part = sums[:, : len(rows)]
            sum_samples(x, y, height, None, self._degree, part, self._workspace)
            self._sums[:, rows] += part * (radius / self._unit) ** degrees
            self._count[rows] += len(some)
            self._squares[rows] += len(some) * radius**2
