"""Rotations that bring a shape onto itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base.blas import one_blas_thread
from ..base.errors import MatchError
from ..base.progress import Progress
from ..fields.transport import tangents
from .align import LONG, REFINED, SHORT, limit
from .closest_points import Fit, polished, refined, rotation_by
from .proposals import REACH, Similarity, matched, proposed
from .shape import Shape
from .symmetry import Symmetry

# The highest order that is looked for: beyond it umbilics of neighbouring sectors are not told
# apart, and a surface of revolution has no umbilics to go by.
MOST_ORDER = 24
# Cosine of axes of a shape that are the same: all pass through its middle.
_SAME_AXIS = float(np.cos(np.radians(5.0)))
# Share of the surface that must come onto itself: a mark on one sector does not hide a symmetry.
_WHOLE = 0.8


@dataclass(frozen=True)
class RotationSymmetry(Symmetry):
    """An axis about which turns by 360 degrees over `order` bring a shape onto itself.

    Attributes
    ----------
    axis:
        (3,) float64 unit direction of the axis.
    order:
        The largest that holds.
    axis_error:
        Standard error of the axis' direction, in degrees.
    """

    axis: np.ndarray
    order: int
    axis_error: float


@one_blas_thread()
def find_rotation(shape: Shape, progress: Progress | None = None) -> RotationSymmetry:
    """The rotation symmetry of highest order, among equals that of the least error.

    Raises
    ------
    MatchError
        There are too few umbilics, or no rotation brings the shape onto itself.

    Examples
    --------
    An ellipsoid of `vertices` and `triangles`, as in `detect`, is the same after half a turn:

    >>> shape = core.Shape.of(vertices, triangles, core.detect(vertices, triangles))
    >>> core.find_rotation(shape).order
    2
    """
    progress = progress or Progress()
    # The best motion is none at all: one more is asked for.
    motions = proposed(shape, shape, False, REFINED + 1)
    turns = [motion for motion in motions if not _rests(motion, shape)]
    if not turns:
        raise MatchError(
            "Too few umbilics match each other to propose an axis. Lower the persistence to keep "
            "more."
        )
    found: list[tuple[int, Fit]] = []
    for done, motion in enumerate(turns):
        progress.step(done / len(turns))
        fit = _finished(motion, shape)
        order = 0 if fit is None or _rests(fit.motion, shape) else _order(fit.motion)
        if fit is not None and order and not _known(fit, found):
            found.append(_raised(order, fit, shape))
    if not found:
        raise MatchError("No rotation brings the shape onto itself.")
    most = max(order for order, _ in found)
    fit = min((fit for order, fit in found if order == most), key=lambda fit: fit.error)
    return _symmetry(most, polished(fit, shape, shape, False, limit(shape, shape)), shape)


def _known(fit: Fit, found: list[tuple[int, Fit]]) -> bool:
    """Whether a turn is about an axis that was found already, all of whose orders were tried."""
    axis, _ = axis_and_angle(fit.motion.rotation)
    others = (axis_and_angle(other.motion.rotation)[0] for _, other in found)
    return any(abs(axis @ other) > _SAME_AXIS for other in others)


def _finished(start: Similarity, shape: Shape) -> Fit | None:
    """The best motion near a start that brings the shape onto itself; None if there is none."""
    far = limit(shape, shape)
    fit = refined(start, shape, shape, False, SHORT, rough=True)
    if fit is None or fit.error > 2.0 * far:
        return None
    fit = refined(fit.motion, shape, shape, False, LONG)
    if fit is None or fit.error > 2.0 * far:
        return None
    fit = polished(fit, shape, shape, False, far, fine=False)
    return fit if fit.overlap >= _WHOLE and fit.error < far else None


def _rests(motion: Similarity, shape: Shape) -> bool:
    """Whether the motion moves nothing."""
    moved = np.linalg.norm(motion(shape.umbilics.position) - shape.umbilics.position, axis=1)
    return bool(moved.max(initial=0.0) < REACH * shape.size)


def axis_and_angle(rotation: np.ndarray) -> tuple[np.ndarray, float]:
    """(3,) unit axis and the angle about it, 0 to pi, of a rotation (3, 3)."""
    angle = float(np.arccos(np.clip(0.5 * (np.trace(rotation) - 1.0), -1.0, 1.0)))
    # The eigenvector of eigenvalue 1, which the skew part loses near half a turn.
    _, _, rows = np.linalg.svd(rotation - np.eye(3))
    axis = rows[-1]
    skew = np.array(
        [
            rotation[2, 1] - rotation[1, 2],
            rotation[0, 2] - rotation[2, 0],
            rotation[1, 0] - rotation[0, 1],
        ]
    )
    return (-axis if skew @ axis < 0 else axis), angle


def _order(motion: Similarity) -> int:
    """The order of which a turn is a multiple, 0 if of none."""
    _, angle = axis_and_angle(motion.rotation)
    orders = np.arange(2, MOST_ORDER + 1)
    parts = orders * angle / (2.0 * np.pi)
    off = np.abs(parts - np.rint(parts)) * 2.0 * np.pi / orders
    # Half of what lies between multiples of the highest order.
    good = (off < np.pi / MOST_ORDER / (MOST_ORDER - 1)) & (np.rint(parts) > 0)
    return int(orders[good][0]) if good.any() else 0


def _raised(order: int, fit: Fit, shape: Shape) -> tuple[int, Fit]:
    """The highest multiple of an order that holds about the same axis, and its fit."""
    axis, _ = axis_and_angle(fit.motion.rotation)
    point = _on_axis(fit.motion, axis, shape)
    best = order, fit
    for multiple in range(1, MOST_ORDER // order + 1):
        turn = rotation_by(axis * 2.0 * np.pi / (order * multiple))
        start = Similarity(turn, 1.0, point - turn @ point)
        tried = _finished(start, shape)
        if tried is not None and _order(tried.motion) == order * multiple:
            best = order * multiple, tried
    return best


def _on_axis(motion: Similarity, axis: np.ndarray, shape: Shape) -> np.ndarray:
    """The point of the axis nearest to the middle of the shape."""
    _, area = shape.face_normal_area
    middle = np.average(shape.vertices[shape.triangles].mean(axis=1), axis=0, weights=area)
    across = motion.shift - (axis @ motion.shift) * axis
    # (1 - R) c = shift across the axis, where 1 - R is regular.
    matrix = np.eye(3) - motion.rotation + np.outer(axis, axis)
    point = np.linalg.solve(matrix, across)
    return np.asarray(point + (axis @ (middle - point)) * axis)


def _in_sector(
    places: np.ndarray, point: np.ndarray, axis: np.ndarray, order: int
) -> np.ndarray:
    """(s, 3) the places turned into one sector: what is wrong at one is wrong at its images."""
    across, along = tangents(axis[None])
    arm = places - point
    x, y = arm @ across[0], arm @ along[0]
    sector = 2.0 * np.pi / order
    angle, radius = np.arctan2(y, x) % sector, np.hypot(x, y)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), arm @ axis], axis=1)


def _symmetry(order: int, fit: Fit, shape: Shape) -> RotationSymmetry:
    axis, angle = axis_and_angle(fit.motion.rotation)
    pairs, _ = matched(shape, shape, fit.motion)
    point = _on_axis(fit.motion, axis, shape)
    if axis[np.abs(axis).argmax()] < 0:
        axis = -axis
    places = _in_sector(fit.equations.image, point, axis, order)
    turned = fit.equations.covariance(places)[:3, :3]
    # A turn about the axis itself leaves its direction as it is.
    tilt = np.sqrt(max(np.trace(turned) - axis @ turned @ axis, 0.0))
    # A turn by an angle shows an error of the axis 2 sin(angle / 2) times.
    seen = max(2.0 * np.sin(0.5 * angle), np.finfo(float).tiny)
    return RotationSymmetry(
        point=point,
        axis=axis,
        order=order,
        error=fit.error,
        axis_error=float(np.degrees(tilt / seen)),
        score=float(1.0 - fit.error / limit(shape, shape)),
        pairs=pairs,
    )
