"""Smoothed principal directions with the singularities of the curvature's own."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...base.progress import Progress
from ...mesh.surface import Surface
from ..cross_field import smoothed_lines
from .agreement import Agreement, with_index
from .simplified import STIFF, SimplifiedField


def smoothed_field(
    surface: Surface,
    simple: SimplifiedField,
    smoothness: float,
    regions: Sequence[np.ndarray],
    progress: Progress,
    held: np.ndarray | None = None,
) -> Agreement:
    """The directions of a simplified field, smoothed, with its own index in every triangle outside
    the regions. Smoothing alone moves singularities about, makes some and loses others.

    Parameters
    ----------
    smoothness:
        `GuidanceSettings.line_smoothness`.
    regions:
        For each region the rows of its triangles.
    held:
        (n,) bool vertices whose directions are not smoothed.
    """
    undirected = np.zeros(len(surface.triangles), bool)
    for rows in regions:
        undirected[rows] = True
    part = progress.part("Smoothing the lines", 0.0, 0.5)
    smooth, index = smoothed_lines(surface, simple.curvature, smoothness, part, undirected, held)
    wanted = np.where(undirected, index, simple.index)
    for rows in regions:
        # Within a region the sum alone counts; what it lacks may turn up anywhere in it.
        lacking = int(np.rint(2.0 * (simple.index[rows].sum() - index[rows].sum())))
        at = rows[np.linspace(0, len(rows) - 1, abs(lacking)).astype(np.int64)]
        np.add.at(wanted, at, 0.5 * np.sign(lacking))
    stiffness = np.zeros(len(surface.vertices))
    stiffness[surface.triangles[simple.index != 0.0]] = STIFF
    if held is not None:
        stiffness[held] = STIFF
    part = progress.part("Simplifying the field", 0.5, 1.0)
    return with_index(surface, smooth, wanted, np.zeros(len(wanted)), stiffness, part)
