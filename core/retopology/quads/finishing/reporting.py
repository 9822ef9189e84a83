"""What is said about the quads of one piece: poles, patches, angle to the curvature."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ....base.subsets import places_in
from ....base.words import counted
from ....fields.frames import side_axes
from ....fields.transport import as_complex
from ...poles import UNATTACHED
from ..conformity import conformity, scaled_jacobian
from ..field.crosses import QUARTER
from ..field.directions import deviators
from ..layout.grids import Grids
from ..layout.laying_out import LaidOut
from ..result import QuadMesh
from ..surface.working_surface import WorkingSurface
from .guides import filled_corner
from .placement import Placement
from .projection import ClosestPoints

# Quads of a scaled Jacobian below this are told.
SKEWED = 0.3


def reported(
    laid: LaidOut,
    grid: Grids,
    placed: Placement,
    position: np.ndarray,
    triangle: np.ndarray,
    closest: ClosestPoints,
) -> QuadMesh:
    """Quads at `position` (n, 3), on the triangles (n,) of the mapped surface, whose closest points
    are looked for in `closest`."""
    surface = laid.working.surface
    topology = conformity(placed.quads, len(position))
    irregular = topology.irregular
    umbilic, confidence = _umbilics(laid, position[irregular], topology.valence[irregular])
    on_feature = laid.map_.crosses.on_feature & ~laid.loose_end
    on_feature = np.where(
        placed.vertex >= 0, on_feature[np.maximum(placed.vertex, 0)], placed.track >= 0
    )
    return QuadMesh(
        vertices=position * surface.unit + surface.origin,
        quads=placed.quads,
        pole=places_in(irregular, len(position)),
        pole_valence=topology.valence[irregular],
        pole_umbilic=umbilic,
        pole_confidence=confidence,
        border=topology.border,
        feature=on_feature & ~topology.border,
        patch=grid.patch,
        angle=angle_to_curvature(laid.working, position, placed.quads, closest),
        source_triangle=surface.source_triangle[triangle],
    )


def words_of_folds(left: int, farthest: float, folded: int) -> list[str]:
    """What is said of so many vertices left off the surface, by so much at most, so that nothing
    folds, and of so many quads that are folded or face against the surface."""
    said = []
    if left:
        said.append(
            f"{counted(left, 'vertex', 'vertices')} moved off the surface, by {farthest:.3g} "
            "at most: quads of this size would fold on its thin parts or sharp corners. Ask for "
            "more quads to have them on it."
        )
    if folded:
        said.append(
            f"{counted(folded, 'quad')} folded: too little room. Ask for more quads, or mend the "
            "mesh there."
        )
    return said


def words_of_shape(pieces: list[tuple[Placement, np.ndarray]]) -> list[str]:
    """What is said of quads of a scaled Jacobian below `SKEWED`, of each piece its placement and
    positions (n, 3): whether the corners of creases and borders that they fill are as sharp."""
    sharp, skewed = [], []
    for placed, position in pieces:
        quads = placed.quads
        quality = scaled_jacobian(position, quads)
        rows = np.flatnonzero((quality < SKEWED) & (quality > 0.0))
        filling = filled_corner(position, quads[rows], placed.beside) >= 0
        sharp += quality[rows[filling]].tolist()
        skewed += quality[rows[~filling]].tolist()
    said = []
    if sharp:
        said.append(
            f"{counted(len(sharp), 'quad')} as sharp as the corners of creases or "
            f"borders there, with a scaled Jacobian of {min(sharp):.2f} at least: quads that "
            "follow them can be no better."
        )
    if skewed:
        said.append(
            f"{counted(len(skewed), 'quad')} skewed, with a scaled Jacobian of "
            f"{min(skewed):.2f} at least: the surface is thinner there than quads of this size, or "
            "creases lie nearer to each other. Ask for more quads."
        )
    return said


def angle_to_curvature(
    working: WorkingSurface, position: np.ndarray, quads: np.ndarray, closest: ClosestPoints
) -> np.ndarray:
    """(q,) degrees from the quads' directions to the principal directions; NaN without any."""
    surface = working.surface
    at = position[quads]
    normal = np.cross(at[:, 2] - at[:, 0], at[:, 3] - at[:, 1])
    triangle, _ = closest(at.mean(axis=1), normal)
    deviator = deviators(working)[triangle]
    x, y = side_axes(surface, triangle)
    first = at[:, 1] - at[:, 0] + at[:, 2] - at[:, 3]
    second = at[:, 3] - at[:, 0] + at[:, 2] - at[:, 1]
    one, two = as_complex(first, x, y), as_complex(second, x, y)
    tiny = np.finfo(float).tiny
    axis = one / np.maximum(np.abs(one), tiny) - 1j * two / np.maximum(np.abs(two), tiny)
    turn = np.angle(axis) - 0.5 * np.angle(deviator)
    off = np.degrees(np.abs(turn - QUARTER * np.rint(turn / QUARTER)))
    return np.where(np.abs(deviator) > 0, off, np.nan)


def _umbilics(
    laid: LaidOut, position: np.ndarray, valence: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The kept umbilic that each pole comes from, -1 for none, and the confidence in it."""
    surface, plan = laid.working.surface, laid.planned.poles
    umbilic = np.full(len(position), -1)
    confidence = np.full(len(position), UNATTACHED)
    there = position * surface.unit + surface.origin
    for kind in np.unique(plan.valence):
        own, planned = np.flatnonzero(valence == kind), np.flatnonzero(plan.valence == kind)
        if not len(own):
            continue
        # Nearest pairs first, each planned pole once.
        reach = min(len(planned), 8)
        distance, near = cKDTree(plan.position[planned]).query(there[own], k=reach)
        distance, near = distance.reshape(len(own), -1), near.reshape(len(own), -1)
        row = np.repeat(np.arange(len(own)), near.shape[1])
        taken = np.zeros(len(planned), bool)
        done = np.zeros(len(own), bool)
        for item in np.argsort(distance.ravel(), kind="stable"):
            pole, choice = row[item], near.ravel()[item]
            if not done[pole] and not taken[choice]:
                done[pole] = taken[choice] = True
                umbilic[own[pole]] = plan.umbilic[planned[choice]]
                confidence[own[pole]] = plan.confidence[planned[choice]]
    known = umbilic >= 0
    umbilic[known] = laid.wishes.umbilic_row[umbilic[known]]
    return umbilic, confidence
