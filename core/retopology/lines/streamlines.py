"""Evenly spaced lines of curvature.

After Jobard & Lefer 1997, on the surface itself: a line ends where it comes too near to another
of its family, and new lines start one spacing beside those that are there. Many lines are traced
at once; where two of a round come too near, the longer one goes on.
"""

from __future__ import annotations

import numpy as np

from ...base.errors import GuidanceError
from ...base.options import AUTO
from ...base.progress import Progress
from ...base.words import WITHOUT_AREA
from ...fields.planes import FaceFrames
from ...mesh.surface import Surface
from ..settings import GuidanceSettings
from .canvas import Canvas
from .polylines import Lines, lines_from
from .rounds import Round, draw_round
from .seeds import Family, choose_seeds, random_seeds
from .spacing import accepted

# Automatic spacing: this fraction of the root of the area.
AUTO_SPACING = 1 / 35
MOST_ROUNDS = 400
# Squares of the spacing that the surface holds, at most: so many for each triangle (lines half an
# edge apart, between which directions are interpolated alone), or as many as lines four times as
# close as the automatic ones.
MOST_SQUARES, USUAL_SQUARES = 2.0, (4.0 / AUTO_SPACING) ** 2
# A spacing of more than this many times the size of the surface is as good as that.
WIDEST = 100.0
# Share of the area with directions below which there is nothing to follow.
LEAST_DIRECTED = 0.02
NO_DIRECTION = (
    "The surface has no preferred direction: it is spherical or flat nearly everywhere, so there "
    "are no lines of curvature to draw. The cross field still has smooth directions."
)


def check_directed(surface: Surface, undirected: np.ndarray) -> None:
    """Raise `GuidanceError` where regions (m,) bool leave no direction to follow."""
    _, area = surface.face_normal_area
    if not area.any():
        raise GuidanceError(WITHOUT_AREA)
    if area[~undirected].sum() < LEAST_DIRECTED * area.sum():
        raise GuidanceError(NO_DIRECTION)


def spacing_of(surface: Surface, settings: GuidanceSettings) -> float:
    """Spacing of the lines in the coordinates of the surface."""
    if settings.spacing == AUTO or settings.spacing == 0.0:
        return AUTO_SPACING * float(np.sqrt(surface.face_normal_area[1].sum()))
    size = float(np.sqrt(surface.face_normal_area[1].sum()))
    return min(float(settings.spacing) / surface.unit, WIDEST * size)


def check_spacing(surface: Surface, spacing: float) -> None:
    """Raise `GuidanceError` where lines would be far closer to each other than the mesh has
    directions."""
    size = float(np.sqrt(surface.face_normal_area[1].sum()))
    across = float(np.sqrt(max(MOST_SQUARES * len(surface.triangles), USUAL_SQUARES)))
    if across * spacing < size:
        least = 1.005 * size / across * surface.unit
        raise GuidanceError(
            f"Lines {spacing * surface.unit:g} apart are too many for this mesh: its directions "
            f"tell lines {least:.3g} apart and more. Choose a larger spacing or subdivide the mesh."
        )


def evenly_spaced_lines(
    surface: Surface,
    planes: FaceFrames,
    settings: GuidanceSettings,
    obstacle: np.ndarray,
    progress: Progress,
) -> Lines:
    """Lines of curvature at an even spacing.

    Parameters
    ----------
    obstacle:
        (m,) int: lines end at triangles with a number >= 0, umbilics and regions.

    Raises
    ------
    GuidanceError
        Nearly all of the surface has no preferred direction, or the spacing is far below what the
        mesh tells.
    """
    check_directed(surface, obstacle >= 0)
    spacing = spacing_of(surface, settings)
    check_spacing(surface, spacing)
    canvas = Canvas.of(
        surface,
        planes,
        obstacle,
        spacing,
        settings.closest,
        settings.shortest,
    )
    random = np.random.default_rng(0)
    places = random_seeds(canvas, random)
    wanted = {"both": (0, 1), "first": (0,), "second": (1,)}[settings.families]
    families = [Family(number, *places) for number in wanted]
    kept: list[Round] = []
    barren = 0
    for number in range(MOST_ROUNDS):
        part = progress.part("Tracing lines", 1.0 - 0.85**number, 1.0 - 0.85 ** (number + 1))
        fresh = [len(family.seed_triangle) == 0 for family in families]
        seeds = [choose_seeds(canvas, family, random) for family in families]
        triangle = np.concatenate([seed[0] for seed in seeds])
        if not len(triangle):
            break
        z = np.concatenate([seed[1] for seed in seeds])
        family = np.repeat(wanted, [len(seed[0]) for seed in seeds])
        trees = {family.number: family.tree for family in families}
        drawn = draw_round(canvas, triangle, z, family, trees, part)
        fitting = accepted(canvas, drawn, families, part)
        if fitting is not None:
            kept.append(fitting)
        # Places where only lines that are too short would fit stay empty.
        barren = barren + 1 if fitting is None else 0
        if barren >= 3 and all(fresh):
            break
    progress.step(1.0)
    return _as_lines(surface, planes, kept)


def _as_lines(surface: Surface, planes: FaceFrames, rounds: list[Round]) -> Lines:
    if not rounds:
        return lines_from(
            surface, planes, *(np.zeros(0, kind) for kind in (int, int, complex, int, bool))
        )
    offset = np.cumsum([0] + [len(one.family) for one in rounds])
    line = np.concatenate([one.line + at for one, at in zip(rounds, offset, strict=False)])
    return lines_from(
        surface,
        planes,
        line,
        np.concatenate([one.triangle for one in rounds]),
        np.concatenate([one.z for one in rounds]),
        np.concatenate([one.family for one in rounds]),
        np.concatenate([one.closed for one in rounds]),
    )
