"""The mirror plane of a shape, from pairs of umbilics that are images of each other.

Pairs of the same kind and curvature propose planes; those that map many umbilics onto umbilics
are refined on the whole surface.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base.errors import GuidanceError
from ..base.progress import Progress
from ..base.words import WITHOUT_AREA
from ..umbilics.result import Umbilics
from .mirror_planes import MATCHED, mirrored_pairs, proposed_planes
from .mirror_refinement import (
    DEVIATIONS,
    polished_plane,
    refined_plane,
    spread_samples,
    standard_errors,
    tilt_of,
    vertex_samples,
)
from .symmetry import Symmetry

# Steps that refine a plane at first, and to the end.
SHORT, STEPS = 4, 40
# Of the planes as many are refined to the end.
FINALISTS = 3
# Below this error, in sizes, the vertices are each other's images, and samples would only blur it.
EXACT = 1e-7
# Root mean square distance, in sizes, beyond which the shape is not symmetric.
ASYMMETRIC = 0.004


@dataclass(frozen=True)
class MirrorPlane(Symmetry):
    """A plane of symmetry; its error is over the best 85 % of the shape, and umbilics on it are
    pairs of one row.

    Attributes
    ----------
    normal:
        (3,) float64 unit normal of the plane.
    angle_error, offset_error:
        Standard errors of the plane's direction, in degrees, and of its distance from the middle
        of the shape, in length.
    """

    normal: np.ndarray
    angle_error: float
    offset_error: float


def find_mirror_plane(
    vertices: np.ndarray,
    face_normal_area: tuple[np.ndarray, np.ndarray],
    triangles: np.ndarray,
    umbilics: Umbilics,
    progress: Progress,
) -> MirrorPlane:
    """The best mirror plane of a surface.

    Parameters
    ----------
    vertices, triangles:
        (n, 3) and (m, 3) of the surface.
    face_normal_area:
        (m, 3) unit normals and (m,) areas.
    umbilics:
        k umbilics in the same coordinates.

    Raises
    ------
    GuidanceError
        There are too few umbilics, or no plane maps the surface onto itself.
    """
    if not face_normal_area[1].any():
        raise GuidanceError(WITHOUT_AREA)
    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    middle, samples, target = spread_samples(vertices, triangles, face_normal_area)
    planes = proposed_planes(umbilics, size)
    if not len(planes) and not len(umbilics):
        raise GuidanceError(
            "Too few umbilics match in kind and curvature to propose a mirror plane. Lower the "
            "persistence to keep more."
        )
    # Where noise has moved the umbilics: the plane of a mirrored shape lies across an axis of
    # inertia, through its middle.
    axes = _axes_of_inertia(vertices[triangles] - middle, face_normal_area[1])
    planes += [(axis, float(axis @ middle)) for axis in axes]
    rough = []
    for done, plane in enumerate(planes):
        progress.step(0.8 * done / len(planes))
        rough.append(refined_plane(plane, samples, target, SHORT))
    rough.sort(key=lambda item: item[1])
    finals = [refined_plane(plane, samples, target, STEPS) for plane, _ in rough[:FINALISTS]]
    best, least = min(finals, key=lambda item: item[1])
    # On meshes that are symmetric vertex by vertex this finds the plane to the last digits.
    corners, tree = vertex_samples(vertices, triangles, face_normal_area)
    exact, remaining = refined_plane(best, corners, tree, STEPS)
    if remaining < least:
        best, least = exact, remaining
    # Of the nearest share of normal deviates the root mean square falls short; a little more is
    # no matter, as what counts is chosen anew.
    reach = 1.5 * DEVIATIONS * max(least, EXACT * size)
    if least > EXACT * size:
        best, reach = polished_plane(best, middle, samples, target, reach)
    else:
        samples, target = corners, tree
    angle_error, offset_error = standard_errors(tilt_of(best, middle, samples, target, reach))
    normal, offset = best
    score = 1.0 - least / (ASYMMETRIC * size)
    if score <= 0.0:
        raise GuidanceError(
            "No mirror plane: the best one leaves the shape "
            f"{100.0 * least / size:.1f} % of its size away from its image."
        )
    if normal[np.abs(normal).argmax()] < 0:
        normal, offset = -normal, -offset
    return MirrorPlane(
        point=middle - (middle @ normal - offset) * normal,
        normal=normal,
        error=float(least),
        score=float(score),
        pairs=mirrored_pairs(umbilics, normal, offset, MATCHED * size),
        angle_error=angle_error,
        offset_error=offset_error,
    )


def _axes_of_inertia(corner: np.ndarray, area: np.ndarray) -> np.ndarray:
    """(3, 3) unit axes, a row each, of triangles with corners (m, 3, 3) about the origin and areas
    (m,)."""
    sums = corner.sum(axis=1)
    # Of a triangle's second moments: its corners' and that of their sum, over 12 and its area.
    spread = np.einsum("t,tki,tkj->ij", area, corner, corner) + (area * sums.T) @ sums
    return np.linalg.eigh(spread)[1].T
