"""What the drawing of evenly spaced lines measures with: the surface, the spacing, the reaches."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...fields.planes import FaceFrames
from ...mesh.surface import Surface
from .polylines import points_of

# Normals count as distance, so that the two sides of a thin sheet are not neighbours: opposite
# normals are this many spacings apart.
SIDES = 1.5
# A line that goes round and round ends after this many times the size of the surface.
LONGEST = 6.0


@dataclass(frozen=True)
class Canvas:
    """The surface that lines are drawn on, and the lengths that decide about them.

    Attributes
    ----------
    surface, planes:
        The surface and its triangles in their planes.
    obstacle:
        (m,) int: lines end at triangles with a number >= 0.
    spacing, near, shortest, longest:
        Between neighbouring lines, where a line has come too near to another, and the bounds of
        a line's length, in the coordinates of the surface.
    every, apart:
        Steps between two looks at what is near, and how much nearer the two ends of a line come
        to each other meanwhile.
    """

    surface: Surface
    planes: FaceFrames
    obstacle: np.ndarray
    spacing: float
    near: float
    shortest: float
    longest: float
    every: int
    apart: float

    @classmethod
    def of(
        cls,
        surface: Surface,
        planes: FaceFrames,
        obstacle: np.ndarray,
        spacing: float,
        closest: float,
        shortest: float,
    ) -> Canvas:
        """With `closest` and `shortest` in spacings."""
        area = surface.face_normal_area[1]
        edge = surface.usual_side
        near = closest * spacing
        every = max(2, int(0.4 * near / edge))
        return cls(
            surface,
            planes,
            obstacle,
            spacing,
            near,
            shortest * spacing,
            LONGEST * float(np.sqrt(area.sum())),
            every,
            max(0.25 * near, every * edge),
        )

    def embedded(self, triangle: np.ndarray, z: np.ndarray) -> np.ndarray:
        """(r, 6) points and normals, so that distance tells the sides of a sheet apart."""
        points = points_of(self.surface, self.planes, triangle, z)
        normal = self.surface.face_normal_area[0][triangle]
        return np.hstack([points, (0.5 * SIDES * self.spacing) * normal])

    def direction(self, triangle: np.ndarray, z: np.ndarray, family: np.ndarray) -> np.ndarray:
        """(r,) complex128 of modulus 1: the way of the lines of a family, one of its two."""
        value = self.planes.deviator(triangle, z)
        root = np.sqrt(np.where(family == 0, value, -value))
        size = np.abs(root)
        return np.divide(root, size, out=np.ones_like(root), where=size > 0)
