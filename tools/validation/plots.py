"""Plots on doubly logarithmic axes, drawn by Workbench like the other figures."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
from bl_ext.user_default.umbilics.operators.command_line.pictures.stage import (
    Stage,
    View,
    save_pixels,
)
from bl_ext.user_default.umbilics.operators.mesh.build import from_triangles

_SIZE = (900, 760)
_INK = (0.10, 0.11, 0.13, 1.0)
_GRID = (0.78, 0.79, 0.81, 1.0)
# Told apart by lightness too.
COLOURS = (
    (0.03, 0.18, 0.65, 1.0),
    (0.95, 0.48, 0.0, 1.0),
    (0.45, 0.02, 0.25, 1.0),
    (0.15, 0.55, 0.25, 1.0),
)
_LETTER = 0.032


@dataclass(frozen=True)
class Series:
    """Points (x, y) with a name; drawn joined."""

    name: str
    x: np.ndarray
    y: np.ndarray


def fitted_order(x: np.ndarray, y: np.ndarray) -> tuple[float, float]:
    """p and c of y = c x^p, least squares in the logarithms."""
    slope, offset = np.polyfit(np.log(x), np.log(y), 1)
    return float(slope), float(np.exp(offset))


def write(path: Path, plots: list[tuple[str, str, str, list[Series]]]) -> None:
    """Draw plots side by side, each a title, names of the axes, and series.

    The key stands in the upper left, the empty corner of curves that rise.
    """
    save_pixels(path, np.hstack([_drawn(*plot) for plot in plots]))


def _drawn(title: str, x_name: str, y_name: str, series: list[Series]) -> np.ndarray:
    x = np.log10(np.concatenate([one.x for one in series]))
    y = np.log10(np.concatenate([one.y for one in series]))
    low = np.array([np.floor(2 * x.min() - 0.2) / 2, np.floor(2 * y.min() - 0.2) / 2])
    high = np.array([np.ceil(2 * x.max() + 0.2) / 2, np.ceil(2 * y.max() + 0.2) / 2])
    box_low, box_high = np.array([0.15, 0.13]), np.array([1.16, 0.92])

    def place(log_x: np.ndarray, log_y: np.ndarray) -> np.ndarray:
        share = (np.stack([log_x, log_y], axis=-1) - low) / (high - low)
        return box_low + share * (box_high - box_low)

    with Stage(*_SIZE) as stage:
        stage.scene.display.shading.light = "FLAT"
        stage.scene.display.shading.show_cavity = False
        paper = _Paper(stage)
        for axis, other in ((0, 1), (1, 0)):
            for decade in range(int(np.ceil(low[axis])), int(np.floor(high[axis])) + 1):
                ends = np.zeros((2, 2))
                ends[:, axis], ends[:, other] = decade, (low[other], high[other])
                line = place(ends[:, 0], ends[:, 1])
                paper.line(line, 0.0014, _GRID, 0.0)
                label = _power(decade)
                if axis == 0:
                    paper.text(label, (line[0, 0], line[0, 1] - 0.045), "CENTER")
                else:
                    paper.text(label, (line[0, 0] - 0.012, line[0, 1] - 0.01), "RIGHT")
        (left, bottom), (right, top) = box_low, box_high
        corners = [(left, bottom), (right, bottom), (right, top), (left, top), (left, bottom)]
        paper.line(np.array(corners), 0.0022, _INK, 0.01)
        for number, one in enumerate(series):
            colour = COLOURS[number % len(COLOURS)]
            points = place(np.log10(one.x), np.log10(one.y))
            paper.line(points, 0.0030, colour, 0.02)
            for point in points:
                paper.disk(point, 0.009, colour, 0.03 + 0.001 * number)
            x, y = left + 0.03, top - 0.045 * (number + 1)
            paper.disk((x, y + 0.01), 0.009, colour, 0.04)
            paper.text(one.name, (x + 0.022, y), "LEFT")
        paper.text(title, (0.5 * (left + right), 0.955), "CENTER")
        paper.text(x_name, (0.5 * (left + right), 0.03), "CENTER")
        paper.text(y_name, (0.028, 0.5 * (bottom + top)), "CENTER", turned=True)
        frame = np.array([[0.0, 0.0, 0.0], [_SIZE[0] / _SIZE[1], 1.0, 0.0]])
        stage.look(_square_on(frame))
        return stage.pixels()


def _power(decade: int) -> str:
    digits = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
    return {0: "1", 1: "10"}.get(decade, "10" + str(decade).translate(digits))


def _square_on(frame: np.ndarray) -> View:
    """The view along z that shows exactly the frame (2, 3), without the usual margin."""
    middle = frame.mean(axis=0)
    return View(middle + (frame - middle) / 1.16, "Y", -28.0, _SIZE[0] / _SIZE[1], 0.0)


class _Paper:
    """Flat things in the plane z = 0 of a stage; greater depth lies on top."""

    def __init__(self, stage: Stage) -> None:
        self._stage = stage

    def line(self, points: np.ndarray, width: float, colour: tuple, depth: float) -> None:
        """A polyline (p, 2)."""
        start, end = points[:-1], points[1:]
        along = end - start
        along = along / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-30)
        across = width * np.stack([-along[:, 1], along[:, 0]], axis=1)
        corners = np.stack(
            [
                start - across - width * along,
                end - across + width * along,
                end + across + width * along,
                start + across - width * along,
            ],
            axis=1,
        ).reshape(-1, 2)
        quads = 4 * np.arange(len(start))[:, None, None] + np.array([[0, 1, 2], [0, 2, 3]])
        self._add(corners, quads.reshape(-1, 3), colour, depth)

    def disk(self, centre: np.ndarray, radius: float, colour: tuple, depth: float) -> None:
        angle = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
        rim = np.asarray(centre) + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        here = np.arange(40)
        fan = np.stack([np.full(40, 40), here, (here + 1) % 40], axis=1)
        self._add(np.vstack([rim, [centre]]), fan, colour, depth)

    def text(self, text: str, place: tuple, align: str, turned: bool = False) -> None:
        curve = bpy.data.curves.new("umbilics picture", "FONT")
        curve.body, curve.size, curve.align_x = text, _LETTER, align
        obj = self._stage.add(curve, _INK)
        obj.location = (*place, 0.05)
        obj.rotation_euler = (0.0, 0.0, np.pi / 2 if turned else 0.0)

    def _add(self, points: np.ndarray, triangles: np.ndarray, colour: tuple, depth: float) -> None:
        flat = np.column_stack([points, np.full(len(points), depth)])
        self._stage.add(from_triangles(flat, triangles), colour)
