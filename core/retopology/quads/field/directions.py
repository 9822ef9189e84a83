"""The directions that maps and finished quads turn to: of the curvature where that is certain, else
of the cross field."""

from __future__ import annotations

import numpy as np

from ....base.progress import Progress
from ....fields.frames import side_axes
from ....fields.planes import FaceFrames, lay_out
from ....fields.transport import as_complex
from ..surface.working_surface import WorkingSurface
from .crosses import Crosses
from .planned import PlannedField
from .wishes import Wishes

# Gaps between the curvatures beyond this share of the triangles count like those at it.
MOST_GAP = 0.95
# Degrees up to which crosses turn to the directions wholly, and from which on not at all: between a
# pole and the umbilic that it stands for now one axis is the nearer, now another: they would jump.
# With 10 or 30 for the first, angles of wave 3 of the benchmark are the same to 0.1 degrees.
TURNED, LEFT = 20.0, 40.0


def deviators(working: WorkingSurface) -> np.ndarray:
    """(m,) complex deviator of the curvature in the middle of each triangle."""
    frames: FaceFrames = lay_out(working.surface, working.field.lines, Progress())
    row = np.arange(len(frames.corner))
    return frames.deviator(row, frames.corner.mean(axis=1))


def guiding_directions(
    working: WorkingSurface, wishes: Wishes, planned: PlannedField, crosses: Crosses
) -> np.ndarray:
    """(m, 3) float64 one unit direction for each triangle.

    Fourth powers of both are added, that of the curvature weighed with the confidence in it.
    """
    x, y = side_axes(working.surface)
    of_cross = as_complex(crosses.direction, x, y)
    deviator = deviators(working)
    size = np.abs(deviator)
    of_curvature = np.divide(deviator, size, out=np.zeros_like(deviator), where=size > 0) ** 2
    sure = _sure(wishes, planned, working)
    # What a user has drawn is surer.
    sure *= planned.pulled[working.surface.triangles].max(axis=1) == 0.0
    angle = np.angle((1.0 - sure) * of_cross**4 + sure * of_curvature) / 4.0
    # Quads along features stay along them.
    held = crosses.on_feature[crosses.triangles].any(axis=1)
    angle = np.where(held, np.angle(of_cross), angle)
    return np.cos(angle)[:, None] * x + np.sin(angle)[:, None] * y


def turned_to(crosses: Crosses, direction: np.ndarray) -> Crosses:
    """The crosses turned to directions (m, 3) that are nearly theirs, with the poles that they
    have: where others are nearer by a whole axis they stay."""
    other = np.cross(crosses.normal, crosses.direction)
    off = as_complex(direction, crosses.direction, other)
    angle = np.angle(off**4) / 4.0
    share = (np.radians(LEFT) - np.abs(angle)) / np.radians(LEFT - TURNED)
    return crosses.turned(angle * np.clip(share, 0.0, 1.0))


def _sure(wishes: Wishes, planned: PlannedField, working: WorkingSurface) -> np.ndarray:
    """(m,) 0 to 1 confidence in the directions of the curvature."""
    sure = planned.cross.confidence[working.surface.triangles].min(axis=1)
    return np.where(wishes.undirected, 0.0, sure)


def direction_weights(
    working: WorkingSurface, wishes: Wishes, planned: PlannedField, crosses: Crosses
) -> np.ndarray:
    """(m,) float64 how much it matters that quads follow the directions in each triangle: the
    confidence in them, half of it times what the curvatures differ beside the mean over the area,
    the largest twentieth like the next. Along features and strokes it is 1 at least."""
    surface = working.surface
    gap = np.abs(deviators(working))
    gap = np.minimum(gap, np.quantile(gap, MOST_GAP))
    area = surface.face_normal_area[1]
    mean = float((gap * area).sum() / area.sum())
    share = gap / mean if mean > 0.0 else np.zeros(len(gap))
    weight = 0.5 * (1.0 + share) * _sure(wishes, planned, working)
    asked = crosses.on_feature[crosses.triangles].any(axis=1)
    asked |= planned.pulled[surface.triangles].max(axis=1) > 0.0
    return np.where(asked, np.maximum(weight, 1.0), weight)
