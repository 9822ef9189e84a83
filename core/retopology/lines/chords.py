"""The chord of a line through one triangle: where it leaves, by the midpoint rule.

Points are complex numbers in the planes of their triangles, see `FaceFrames`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...base.unit import phase
from ...fields.planes import FaceFrames

# Cosine of the largest turn from one triangle to the next; a line of curvature that turns more
# has lost its way at a place where the mesh does not resolve the directions.
LEAST_COSINE = 0.5
# A deviator smaller than this share of its change over an edge gives a steady line no direction: it
# goes straight on. Where two families change places, along a circle of umbilics, it comes out at
# right angles to its own and ends, instead of turning into the other's way.
RESOLVED = 1.0
# A steady line ends where it would turn by more than this (37 degrees; beyond 45 the other family
# is nearer) from its mean direction over about so many edges, in a triangle where the families
# change places. Chosen on r = 2 + cos z (none of 1,519 lines on six meshes turns from meridian to
# parallel, 7 did at 53 degrees); confirmed on three other profiles (none of 2,088).
MEMORY, STEADY_COSINE = 1.5, 0.8
# Lines keep this share of an edge away from its ends, where there would be no triangle beyond.
MARGIN = 1e-6
# A direction that leaves by the edge it came in by runs along that edge, this steeply inwards.
INWARD = 1e-3


@dataclass
class Walk:
    """Where r lines are, each in one triangle, and where they want to go.

    Attributes
    ----------
    triangle, corner, z:
        (r,) int64 the triangles, (r, 3) complex128 their corners and (r,) complex128 the places in
        them.
    direction:
        (r,) complex128 of modulus 1: of the two directions of the line field the nearer is taken.
    heading:
        (r,) complex128 of modulus 1, the directions of late.
    entry:
        (r,) int side that the line came in by, -1 for none.
    sign:
        (r,) float64 1 for lines of the larger curvature, -1 for those of the smaller.
    straight:
        (r,) float64 length over which `direction` is kept rather than the field followed.
    steady:
        (r,) bool lines that go straight on where the field is weak, and end where it turns away
        from their directions of late.
    """

    triangle: np.ndarray
    corner: np.ndarray
    z: np.ndarray
    direction: np.ndarray
    heading: np.ndarray
    entry: np.ndarray
    sign: np.ndarray
    straight: np.ndarray
    steady: np.ndarray


@dataclass(frozen=True)
class Chords:
    """The chords of r lines, each in the triangle that the line is in.

    Attributes
    ----------
    triangle:
        (r,) int64 the triangles.
    z:
        (r,) complex128 where the chords end.
    direction:
        (r,) complex128 of modulus 1, their directions.
    length:
        (r,) float64 their lengths.
    side, share:
        (r,) int the sides they run towards, and (r,) float64 how far along the side they meet it.
    inside:
        (r,) bool, True where a chord ends before the side.
    turned:
        (r,) bool, True where the field turns so sharply that there is no chord: its length is 0.
    heading:
        (r,) complex128 of modulus 1, the directions of late, without those of this triangle where
        the field is too weak to tell.
    """

    triangle: np.ndarray
    z: np.ndarray
    direction: np.ndarray
    length: np.ndarray
    side: np.ndarray
    share: np.ndarray
    inside: np.ndarray
    turned: np.ndarray
    heading: np.ndarray


def next_chords(planes: FaceFrames, walk: Walk, longest: np.ndarray, tied: np.ndarray) -> Chords:
    """The next chords of r lines.

    Parameters
    ----------
    longest:
        (r,) float64 the most that a chord may be long.
    tied:
        (r,) bool lines that one sharp turn ends.
    """
    triangle, z, entry = walk.triangle, walk.z, walk.entry
    direction, sign = walk.direction, walk.sign
    rows = np.arange(len(triangle))
    edge, height = _edges(walk.corner, z, entry, rows)
    field = planes.value[triangle], planes.along[triangle], planes.across[triangle]
    steady = walk.steady & planes.swapping[triangle]
    doubt = np.where(steady, RESOLVED * planes.doubt[triangle], 0.0)
    geodesic = walk.straight > 0
    some_geodesic = geodesic.any()
    first, _ = _root(field, doubt, z, sign, direction)
    if some_geodesic:
        first = np.where(geodesic, direction, first)
    half, _ = _exit(edge, height, first, rows)
    middle, strong = _root(field, doubt, z + 0.5 * half * first, sign, first)
    if some_geodesic:
        middle = np.where(geodesic, direction, middle)
    middle = _inwards(edge, entry, middle, rows)
    distance, side = _exit(edge, height, middle, rows)
    turned = (middle * direction.conj()).real < LEAST_COSINE
    turned &= tied
    turned |= steady & ((middle * walk.heading.conj()).real < STEADY_COSINE)
    step = np.minimum(distance, longest)
    if some_geodesic:
        step = np.where(geodesic, np.minimum(step, walk.straight), step)
    step[turned] = 0.0
    step = np.maximum(step, 0.0)
    inside = step < distance
    moved = z + step * middle
    out = edge[rows, side]
    here = walk.corner[rows, side]
    share = ((moved - here) * out).real / np.maximum(np.abs(out) ** 2, np.finfo(float).tiny)
    share = np.minimum(np.maximum(share, MARGIN), 1.0 - MARGIN)
    landed = np.where(inside, moved, here + share * out.conj())
    pull = strong * -np.expm1(-step / (MEMORY * planes.size[triangle]))
    heading = walk.heading + pull * (middle - walk.heading)
    heading = heading / np.abs(heading)
    return Chords(triangle, landed, middle, step, side, share, inside, turned, heading)


def _edges(
    corner: np.ndarray, z: np.ndarray, entry: np.ndarray, rows: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Conjugates (r, 3) of the edges of triangles, and twice the areas (r, 3) from them to z;
    infinite for the edge that a line came in by."""
    edge = (corner[:, (1, 2, 0)] - corner).conj()
    height = np.maximum((edge * (z[:, None] - corner)).imag, 0.0)
    came = entry >= 0
    height[rows[came], entry[came]] = np.inf
    return edge, height


def _root(
    field: tuple[np.ndarray, np.ndarray, np.ndarray],
    doubt: np.ndarray,
    z: np.ndarray,
    sign: np.ndarray,
    near: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """The direction of the line field at z that is nearer to `near`, `near` itself where the
    field is too weak to tell, and where it is strong enough."""
    value, along, across = field
    value = value + along * z + across * z.conj()
    root = np.sqrt(sign * value)
    size = np.abs(root)
    root /= np.copysign(size, (root * near.conj()).real)
    strong = size * size > doubt
    if not strong.all():
        root = np.where(strong, root, near)
    return root, strong


def _inwards(
    edge: np.ndarray, entry: np.ndarray, direction: np.ndarray, rows: np.ndarray
) -> np.ndarray:
    """The directions, but along the edge that a line came in by where it would leave by it."""
    inner = phase(edge[rows, entry])
    along = direction * inner
    back = np.flatnonzero((along.imag < INWARD) & (entry >= 0))
    if len(back):
        steep = np.where(along[back].real >= 0, np.exp(1j * INWARD), -np.exp(-1j * INWARD))
        direction[back] = steep * inner[back].conj()
    return direction


def _exit(
    edge: np.ndarray, height: np.ndarray, direction: np.ndarray, rows: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Distance (r,) to the edge by which a ray leaves its triangle, and that edge."""
    rate = (edge * direction[:, None]).imag
    distance = np.where(rate < 0, height / -rate, np.inf)
    side = distance.argmin(axis=1)
    distance = distance[rows, side]
    return np.where(distance < np.inf, distance, 0.0), side
