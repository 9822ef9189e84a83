"""A picture of a mesh and its umbilics, from two sides, drawn by Workbench."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .... import core
from ...data.preferences import KIND_COLOURS
from ...jobs.detect import Inputs
from ...mesh.build import from_triangles
from .picture_parts import glyph_mesh, glyph_size, legend, stroke_mesh
from .stage import Stage, View, save_pixels

# Pixels of one of the two views.
_WIDTH, _HEIGHT = 960, 960
_CLAY = (0.80, 0.78, 0.74, 1.0)
_INK = (0.10, 0.11, 0.13, 1.0)


def write(path: Path, found: list[tuple[Inputs, core.Detection]], up: str) -> None:
    """Draw the objects with their umbilics; `up` is the world axis that points up, Y or Z.

    Raises
    ------
    FileError
        The file cannot be written.
    """
    points = np.vstack([inputs.arrays.vertices for inputs, _ in found])
    points = points[np.isfinite(points).all(axis=1)]
    with Stage(_WIDTH, _HEIGHT) as stage:
        size = glyph_size(points, sum(len(detection.umbilics) for _, detection in found))
        for inputs, detection in found:
            arrays = inputs.arrays
            stage.add(from_triangles(arrays.vertices, arrays.triangles, smooth=True), _CLAY)
            stage.add(stroke_mesh(arrays, detection.curvature), _INK)
            for kind in core.KINDS:
                marks = detection.umbilics.select(detection.umbilics.kind == kind)
                if len(marks):
                    stage.add(glyph_mesh(kind, marks, size), KIND_COLOURS[kind])
        views = [View(points, up, turn, _WIDTH / _HEIGHT) for turn in (0.0, 180.0)]
        images = []
        for number, view in enumerate(views):
            stage.look(view)
            notes = legend(stage, view, found, _INK) if number == 0 else []
            images.append(stage.pixels())
            stage.drop(notes)
        save_pixels(path, np.hstack(images))
