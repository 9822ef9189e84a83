"""A scanned model, what is detected on it, and how methods are set side by side."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

import core

from . import pictures
from .page import Page, number
from .surfaces_found import RAW

# Models that stand along another axis than files of their kind usually do.
_UPRIGHT = {"torso_vtk.obj": "Z"}

TRIVIAL = replace(RAW, curvature="normals")
"""As in the paper: operators from normals, no filter."""


class Model:
    """A mesh from a file and what is detected on it."""

    def __init__(self, path: Path) -> None:
        self.name = path.stem
        self.arrays, self.up = pictures.read(path)
        self.up = _UPRIGHT.get(path.name, self.up)
        self.size = float(np.linalg.norm(np.ptp(self.arrays.vertices, axis=0)))

    def detect(self, settings: core.Settings, **extra: object) -> core.Detection:
        return core.detect(self.arrays.vertices, self.arrays.triangles, settings, **extra)

    def panel(
        self, found: core.Detection, title: str, turn: float = 0.0, **changes: object
    ) -> pictures.Panel:
        """The umbilics of a detection from one side; the number of points goes to the title."""
        view = pictures.view_of(self.arrays, self.up, turn)
        panel = pictures.Panel(
            [f"{title}: {len(found.umbilics)} points"],
            self.arrays,
            found.curvature,
            found.umbilics,
            view,
            enlarged=1.2,
        )
        return replace(panel, **changes)

    def dropped(self, found: core.Detection) -> core.Umbilics:
        """The candidates outside the opened elliptic part."""
        return found.candidates.select(~found.candidates.elliptic)


def comparison(results: tuple[core.MethodResult, ...]) -> tuple[list, list]:
    heading = ["method", "points", "index sum", "umbilics of S found", "missed", "elsewhere",
               "edges away"]  # fmt: skip
    rows = [
        [
            result.method,
            len(result.detection.umbilics),
            f"{result.detection.index_sum:+g}" if result.method in core.METHODS else "–",
            result.confirmed,
            result.missed,
            result.unmatched,
            number(result.error, 2),
        ]
        for result in results
        if result.detection is not None
    ]
    return heading, rows


def clusters(page: Page, model: Model, by_index: core.Detection, name: str) -> None:
    """How many neighbouring vertices of the same index method I reports together."""
    sizes = _cluster_sizes(model, by_index)
    few = np.count_nonzero(sizes <= 3) / max(len(sizes), 1)
    page.text(
        f"""I reports {len(by_index.umbilics)} vertices in {len(sizes)} clusters of neighbours of
        one sign: {np.count_nonzero(sizes == 1)} of one vertex, {np.count_nonzero(sizes == 2)} of
        two, {np.count_nonzero(sizes == 3)} of three, {np.count_nonzero(sizes > 3)} larger."""
    )
    page.differences.append(
        f"""Clusters of I on the {name}: {few:.0%} have one to three vertices, the paper's
        “typically either 1, 2, or 3”; larger ones are several umbilics side by side."""
    )


def _cluster_sizes(model: Model, by_index: core.Detection) -> np.ndarray:
    triangles = model.arrays.triangles
    index = np.zeros(len(model.arrays.vertices))
    index[by_index.umbilics.vertex] = np.sign(by_index.umbilics.index)
    start, end = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    same = (index[start] != 0) & (index[start] == index[end])
    size = len(index)
    graph = sparse.coo_array(
        (np.ones(np.count_nonzero(same)), (start[same], end[same])), shape=(size, size)
    )
    label = csgraph.connected_components(graph, directed=False)[1]
    _, count = np.unique(label[index != 0], return_counts=True)
    return count


