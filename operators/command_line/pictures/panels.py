"""Several views beside each other, each with its own umbilics and title."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .... import core
from ...data.preferences import KIND_COLOURS
from ...jobs.detect import Inputs
from ...mesh.build import from_triangles
from ...mesh.read import MeshArrays
from .picture_parts import caption, glyph_mesh, glyph_size, kinds_below, stroke_mesh
from .stage import Stage, View, save_pixels

_SIDE = 800
_CLAY = (0.86, 0.85, 0.82, 1.0)
_INK = (0.10, 0.11, 0.13, 1.0)
_DROPPED = (0.38, 0.38, 0.38, 1.0)


@dataclass(frozen=True)
class Panel:
    """One view of a mesh.

    Attributes
    ----------
    title:
        Lines above.
    arrays:
        The mesh.
    curvature:
        Whose first directions are drawn as strokes; None for no strokes.
    umbilics:
        Drawn with the glyphs and colours of their kinds, and counted below.
    dropped:
        Drawn smaller and grey.
    tints:
        Pairs of triangles (mask or rows) and colour, drawn in place of clay.
    true_places:
        (p, 3) points that are marked with an open ring.
    view:
        Where from.
    enlarged:
        Factor on the size of the glyphs.
    relief:
        False to leave shading away, for a mesh that lies flat.
    """

    title: list[str]
    arrays: MeshArrays
    curvature: core.CurvatureField | None
    umbilics: core.Umbilics
    view: View
    dropped: core.Umbilics | None = None
    tints: list[tuple[np.ndarray, tuple[float, ...]]] = dataclasses.field(default_factory=list)
    true_places: np.ndarray = dataclasses.field(default_factory=lambda: np.empty((0, 3)))
    enlarged: float = 1.0
    relief: bool = True


def view_of(
    arrays: MeshArrays, up: str = "Z", turn: float = 0.0, lift: float = 0.28, zoom: float = 1.0
) -> View:
    """A square view of the whole mesh; `zoom` above 1 comes closer to its middle."""
    points = arrays.vertices[np.unique(arrays.triangles)]
    points = points[np.isfinite(points).all(axis=1)]
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    return View(middle + (points - middle) / zoom, up, turn, 1.0, lift)


def write(path: Path, panels: list[Panel], columns: int) -> None:
    """Draw the panels in rows of `columns`.

    Raises
    ------
    FileError
        The file cannot be written.
    """
    images = [_drawn(panel) for panel in panels]
    blank = np.ones_like(images[0])
    images += [blank] * (-len(images) % columns)
    rows = [np.hstack(images[i : i + columns]) for i in range(0, len(images), columns)]
    # Pixel rows run upwards.
    save_pixels(path, np.vstack(rows[::-1]))


def write_comparison(
    path: Path, compared: list[tuple[Inputs, tuple[core.MethodResult, ...]]], up: str
) -> None:
    """A row of panels for each mesh, one for each method, from the same side.

    Raises
    ------
    FileError
        The file cannot be written.
    """
    panels = []
    for inputs, results in compared:
        arrays = inputs.arrays
        view = view_of(arrays, up)
        by_shape = results[0].detection
        assert by_shape is not None, "method S refuses nothing"
        for result in results[: len(core.METHODS)]:
            found = result.detection
            umbilics = found.umbilics if found else by_shape.umbilics.select(np.zeros(0, int))
            outcome = f"{len(umbilics)} points" if found else "refused (see the text)"
            title = f"{inputs.object_name}, method {result.method}: {outcome}"
            field = by_shape.curvature if found else None
            panels.append(Panel([title], arrays, field, umbilics, view))
    write(path, panels, len(core.METHODS))


def _drawn(panel: Panel) -> np.ndarray:
    arrays, view = panel.arrays, panel.view
    with Stage(_SIDE, _SIDE) as stage:
        if not panel.relief:
            stage.scene.display.shading.light = "FLAT"
        plain = np.ones(len(arrays.triangles), dtype=bool)
        for rows, colour in panel.tints:
            plain[rows] = False
            stage.add(from_triangles(arrays.vertices, arrays.triangles[rows], smooth=True), colour)
        if plain.any():
            stage.add(from_triangles(arrays.vertices, arrays.triangles[plain], smooth=True), _CLAY)
        if panel.curvature is not None:
            stage.add(stroke_mesh(arrays, panel.curvature), _INK)
        size = panel.enlarged * glyph_size(arrays.vertices, len(panel.umbilics))
        if panel.dropped is not None:
            for kind in core.KINDS:
                rows = panel.dropped.kind == kind
                if rows.any():
                    marks = glyph_mesh(kind, panel.dropped.select(rows), 0.7 * size)
                    stage.add(marks, _DROPPED)
        for kind in core.KINDS:
            rows = panel.umbilics.kind == kind
            if rows.any():
                marks = glyph_mesh(kind, panel.umbilics.select(rows), size)
                stage.add(marks, KIND_COLOURS[kind])
        if len(panel.true_places):
            stage.add(_rings(panel.true_places, view, 1.7 * size), _INK)
        stage.look(view)
        caption(stage, view, panel.title, _INK)
        kinds_below(stage, view, panel.umbilics.counts(), _INK)
        return stage.pixels()


def _rings(places: np.ndarray, view: View, radius: float) -> object:
    """Open rings that face the viewer, in front of everything."""
    steps = 64
    angle = 2.0 * np.pi * np.arange(steps) / steps
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    flat = np.concatenate([radius * circle, 0.9 * radius * circle])
    ahead = 0.5 * (view.depth + view.width)
    offset = flat @ view.frame[:, :2].T
    centre = places + view.frame[:, 2] * ahead
    vertices = (centre[:, None] + offset[None]).reshape(-1, 3)
    here, after = np.arange(steps), (np.arange(steps) + 1) % steps
    band = np.concatenate(
        [
            np.stack([here, after, after + steps], axis=1),
            np.stack([here, after + steps, here + steps], axis=1),
        ]
    )
    triangles = (band[None] + 2 * steps * np.arange(len(places))[:, None, None]).reshape(-1, 3)
    return from_triangles(vertices, triangles)
