"""Where a 3D view looks from, in the few numbers that drawing needs."""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np
from mathutils import Matrix, Vector

# Of the points in view this percentile in depth stands for the visible surface.
_FRONT = 25.0


@dataclass(frozen=True)
class Camera:
    """One region of a 3D view.

    Attributes
    ----------
    view_projection:
        From the world to the clip space.
    viewer:
        Place of the viewer and 1 in perspective, direction to it and 0 without.
    pixel:
        Length of a pixel in the world at clip depth w = 1.
    pivot:
        What the view turns around.
    upright:
        (2, 3) what leads right and up on the screen.
    """

    view_projection: Matrix
    viewer: tuple[float, float, float, float]
    pixel: float
    pivot: Vector
    upright: np.ndarray

    @classmethod
    def of(cls, region: bpy.types.Region, view: bpy.types.RegionView3D) -> Camera:
        """The camera of a region as it is being drawn."""
        window = view.window_matrix
        back = view.view_matrix.inverted()
        perspective = abs(window[3][3]) < 0.5
        place = back.translation if perspective else back.col[2].to_3d()
        # In the camera's own view the aspect is the camera's: the larger scale is the pixel's.
        pixel = 2.0 / max(region.height * abs(window[1][1]), 1e-30)
        viewer = (*place, 1.0 if perspective else 0.0)
        matrix = view.perspective_matrix.copy()
        upright = np.array([back.col[0].to_3d(), back.col[1].to_3d()])
        return cls(matrix, viewer, pixel, view.view_location.copy(), upright)

    def pixel_on(self, places: np.ndarray, model: Matrix) -> float:
        """Length of a pixel on the surface that is seen, known by some of its points (n, 3)."""
        matrix = np.array(self.view_projection @ model)
        clip = places @ matrix[:, :3].T + matrix[:, 3]
        depth = clip[:, 3]
        seen = (np.abs(clip[:, :2]) < depth[:, None]).all(axis=1)
        if not seen.any():
            return self.pixel * max((self.view_projection @ self.pivot.to_4d())[3], 1e-9)
        # The nearer part is what is not hidden behind the rest.
        return self.pixel * float(np.percentile(depth[seen], _FRONT))

    def sees(self, spheres: np.ndarray, model: Matrix) -> np.ndarray:
        """(b,) bool, whether spheres (b, 4) of the object's space may be in the picture."""
        matrix = np.array(self.view_projection)
        moved = np.array(model)
        scale = np.linalg.norm(moved[:3, :3], axis=0).max()
        centres = spheres[:, :3] @ moved[:3, :3].T + moved[:3, 3]
        radius = spheres[:, 3] * scale
        inside = np.ones(len(spheres), bool)
        for axis in (0, 1):
            for sign in (1.0, -1.0):
                plane = matrix[3] + sign * matrix[axis]
                length = np.linalg.norm(plane[:3])
                inside &= centres @ plane[:3] + plane[3] > -radius * length
        return inside
