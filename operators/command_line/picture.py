"""A picture of a mesh and its umbilics, from two sides, drawn by Workbench."""

from __future__ import annotations

import tempfile
from pathlib import Path

import bpy
import numpy as np

from ... import core
from ..engine import Inputs
from ..errors import FileError
from ..mesh_data import from_triangles
from ..preferences import KIND_COLOURS
from .importers import quiet
from .picture_parts import glyph_mesh, glyph_size, legend, stroke_mesh
from .stage import Stage, View

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
    with Stage(_WIDTH, _HEIGHT) as stage, tempfile.TemporaryDirectory() as folder:
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
            images.append(_render(stage, Path(folder) / f"{number}.png"))
            stage.drop(notes)
        _save(path, np.hstack(images))


def _render(stage: Stage, path: Path) -> np.ndarray:
    """(height, width, 4) float32 pixels, bottom row first."""
    with quiet():
        stage.render(path)
    image = bpy.data.images.load(str(path))
    try:
        pixels = np.empty(_HEIGHT * _WIDTH * 4, dtype=np.float32)
        image.pixels.foreach_get(pixels)
    finally:
        bpy.data.images.remove(image)
    return pixels.reshape(_HEIGHT, _WIDTH, 4)


def _save(path: Path, pixels: np.ndarray) -> None:
    height, width = pixels.shape[:2]
    image = bpy.data.images.new("umbilics picture", width, height)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        image.pixels.foreach_set(np.ascontiguousarray(pixels).ravel())
        image.filepath_raw = str(path.resolve())
        image.file_format = "PNG"
        with quiet():
            image.save()
    except (OSError, RuntimeError) as error:
        raise FileError(f"{path}: cannot be written ({str(error).strip()}).") from error
    finally:
        bpy.data.images.remove(image)
