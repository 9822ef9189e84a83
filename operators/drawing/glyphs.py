"""Small meshes that stand for the kinds of umbilics, told apart by shape as well as by colour.

Each outline is a polygon around the origin of the tangent plane, about one long, whose x axis
points along a separatrix.
"""

from __future__ import annotations

import numpy as np

# Above and below the surface, in lengths of the outline: high enough to be seen from the side,
# deep enough that no gap shows where the surface curves away.
_TOP, _BOTTOM = 0.25, -0.6


def _drop(tips: tuple[float, ...], steps: int = 48) -> np.ndarray:
    """(p, 2) a disk drawn out into tips at the given angles, in degrees."""
    angle = np.linspace(-np.pi, np.pi, steps, endpoint=False)
    radius = np.full(steps, 0.62)
    for tip in np.radians(tips):
        away = np.abs((angle - tip + np.pi) % (2.0 * np.pi) - np.pi)
        radius = np.maximum(radius, 1.25 - 1.35 * away)
    return radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])


def _star() -> np.ndarray:
    """(6, 2) three points at 120°."""
    angle = np.radians(60.0 * np.arange(6))
    radius = np.where(np.arange(6) % 2 == 0, 1.35, 0.36)
    return radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])


def _disk() -> np.ndarray:
    """(p, 2) a disk as wide as the others are long: nothing is known of lines that run into it."""
    angle = np.linspace(-np.pi, np.pi, 48, endpoint=False)
    return 0.9 * np.column_stack([np.cos(angle), np.sin(angle)])


def _square() -> np.ndarray:
    return 0.62 * np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])


OUTLINES = {
    "star": _star(),
    "lemon": _drop((0.0,)),
    "monstar": _drop((-75.0, 0.0, 75.0)),
    "compound": _disk(),
    "uncertain": _square(),
}


def prisms(outline: np.ndarray, frames: np.ndarray, size: float) -> tuple[np.ndarray, np.ndarray]:
    """One prism over the outline for each frame.

    Parameters
    ----------
    outline:
        (p, 2) polygon, counter-clockwise, star-shaped about the origin.
    frames:
        (k, 4, 4) from the glyph's space to the world.
    size:
        Length of the outline's unit in the world.

    Returns
    -------
    vertices (k * (2 p + 1), 3) and triangles (k * 3 p, 3): top and walls, no floor.
    """
    count = len(outline)
    top = np.column_stack([outline, np.full(count, _TOP)])
    bottom = np.column_stack([outline, np.full(count, _BOTTOM)])
    shape = np.vstack([top, bottom, [[0.0, 0.0, _TOP]]]) * size
    here = np.arange(count)
    after = (here + 1) % count
    centre = np.full(count, 2 * count)
    triangles = np.vstack(
        [
            np.column_stack([centre, here, after]),
            np.column_stack([here, here + count, after + count]),
            np.column_stack([here, after + count, after]),
        ]
    )
    vertices = np.einsum("kij,pj->kpi", frames[:, :3, :3], shape) + frames[:, None, :3, 3]
    first = (np.arange(len(frames)) * len(shape))[:, None, None]
    return vertices.reshape(-1, 3), (triangles[None] + first).reshape(-1, 3)
