"""Which umbilics a mesh determines: the least error that fits of one scale leave at their places.

A program that knew where the umbilics are could choose for a mesh the window and the degree whose
deviator is least wrong there. That error over the slope of the exact deviator is the error of the
place. Fits are made at the true places, but not asked for their own zeros: where the slope is
small beside the error a fit has a zero wherever it is made.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree
from surfaces import ImplicitSurface

from core.base.buffers import Workspace
from core.curvature.fits.height_fit import solve_heights, sum_count, sum_samples
from core.curvature.fits.monge import deviator_at
from core.fields.frames import frame

from .cases import Case

# Radii of the windows, in edges around the umbilic, and degrees.
WINDOWS = (3.0, 4.0, 5.5, 7.5, 10.0, 14.0, 19.0)
DEGREES = (3, 4, 5, 6, 8)
SAMPLES_PER_TERM = 1.5
# Samples further than this share of the window from the tangent plane are of other sheets.
SAME_SHEET = 0.8
# Median length of a complex Gaussian of unit standard deviation.
MEDIAN = np.sqrt(np.log(2.0))

DETERMINED = 1.0
"""Edges that the error of a place may come to: 98 % are then within twice as many."""


def determined(case: Case, surface: ImplicitSurface) -> np.ndarray:
    """(t,) bool, true umbilics of index +-1/2 whose place the mesh determines to `DETERMINED`."""
    truth = case.umbilics.position
    edge = case.edge_at(truth)
    slope = surface.slopes(truth)
    error = np.full(len(truth), np.inf)
    if not len(truth):
        return np.zeros(0, bool)
    for wrong in _deviators(case, surface.normals(truth), edge):
        typical = np.median(wrong[np.isfinite(wrong)]) / MEDIAN if np.isfinite(wrong).any() else 1
        known = np.where(np.isfinite(wrong), typical, np.inf)
        error = np.minimum(error, known / np.maximum(slope, np.finfo(float).tiny))
    generic = np.abs(case.umbilics.index) == 0.5
    return np.asarray(generic & (error <= DETERMINED * edge))


def _deviators(case: Case, normal: np.ndarray, edge: np.ndarray) -> list[np.ndarray]:
    """Of each window and degree the (t,) lengths of the fitted deviator at the true umbilics, where
    it should be 0; infinite where nothing is determined."""
    truth, tree, workspace = case.umbilics.position, cKDTree(case.vertices), Workspace()
    axes = np.stack([*frame(normal.T), normal.T])
    found = []
    for window in WINDOWS:
        balls = tree.query_ball_point(truth, window * edge)
        most = max(*map(len, balls), 1)
        place, inside = np.zeros((3, most, len(truth))), np.zeros((most, len(truth)))
        for row, ball in enumerate(balls):
            offset = (case.vertices[ball] - truth[row]) @ axes[:, :, row].T
            offset = offset[np.abs(offset[:, 2]) < SAME_SHEET * window * edge[row]]
            place[:, : len(offset), row] = offset.T
            inside[: len(offset), row] = 1.0
        count = np.maximum(inside.sum(axis=0), 1.0)
        radius = np.sqrt((place[0] ** 2 + place[1] ** 2).sum(axis=0) / count)
        radius = np.maximum(radius, np.finfo(float).tiny)
        x, y, z = place / radius
        for degree in DEGREES:
            enough = count >= SAMPLES_PER_TERM * (degree + 1) * (degree + 2) / 2
            sums = np.empty((sum_count(degree), len(truth)))
            sum_samples(x, y, z, inside, degree, sums, workspace)
            fit = solve_heights(sums, count, degree, workspace)
            middle = np.zeros(len(truth))
            length = np.abs(deviator_at(fit.coefficients, middle, middle)) / radius
            found.append(np.where(fit.determined & enough, length, np.inf))
    return found
