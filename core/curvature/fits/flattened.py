"""Surfaces seen in the Möbius map that makes a plane of the sphere nearest to them.

Over its tangent plane a sphere has heights of every even degree, which a polynomial cuts off. Once
the sphere is made a plane, nothing but the surface's deviation from it is left to fit, and around
an umbilic that starts with the cubic terms: the same degree holds over wider windows. Möbius maps
keep angles, principal directions and umbilics, and scale the deviator as they scale curvature
(e.g. Blaschke 1929), and errors of points that are alike in all directions stay so.

A sphere of curvature k that touches the plane z = 0 at the origin from the side of z is made that
plane by X' = (X - b |X|^2) / (1 - 2 b X + |b|^2 |X|^2) with b = k n / 2, n the axis of z. The same
map with -b leads back.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...base.buffers import Workspace
from .height_fit import HeightFit, heights_at, lower_sums, solve_heights, sum_count, sum_samples
from .monge import HeightOperator, operator_at

# Samples further around their sphere than a half of it are left out: the map scales lengths by
# 1 / cos^2 of half the angle, which far around grows beyond bounds.
HALF = 0.5
# Samples nearer to each other than this are one point.
_SHORTEST = float(np.finfo(float).tiny) ** 0.25


@dataclass(frozen=True)
class FlatFit:
    """Heights over spheres, b fits.

    Attributes
    ----------
    bend:
        (b,) float64 curvature k of the spheres, in 1 / unit of the samples.
    radius:
        (b,) float64 root mean square distance of the flattened samples from the origin.
    heights:
        The fits to the flattened samples, in units of the radius.
    """

    bend: np.ndarray
    radius: np.ndarray
    heights: HeightFit

    @classmethod
    def joined(cls, fits: Sequence[FlatFit]) -> FlatFit:
        """All fits, of the same terms, beside each other."""
        heights = [fit.heights for fit in fits]
        return cls(
            np.concatenate([fit.bend for fit in fits]),
            np.concatenate([fit.radius for fit in fits]),
            HeightFit(
                {
                    term: np.concatenate([height.coefficients[term] for height in heights])
                    for term in heights[0].coefficients
                },
                np.concatenate([height.residual for height in heights]),
                np.concatenate([height.covariance for height in heights], axis=-1),
                np.concatenate([height.determined for height in heights]),
            ),
        )

    @property
    def residual(self) -> np.ndarray:
        """(b,) standard deviation of the samples about the fit, in the unit of the samples."""
        return np.asarray(self.heights.residual * self.radius)


@dataclass(frozen=True)
class RoundOperator:
    """Shape operators of surfaces that were fitted flattened.

    Attributes
    ----------
    place:
        (3, b) float64 point of the surface.
    mean, deviator:
        (b,) float64 mean curvature and (b,) complex128 deviator in the frame of `tangent`.
    scale:
        (b,) float64 length in the flattened picture over length on the surface.
    """

    place: np.ndarray
    mean: np.ndarray
    deviator: np.ndarray
    scale: np.ndarray
    _flat: HeightOperator
    _seen: np.ndarray
    _bend: np.ndarray

    @property
    def root(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """As in `HeightOperator`, of the flattened picture."""
        return self._flat.root

    def tangent(
        self, cosine: np.ndarray | float, sine: np.ndarray | float, axes: np.ndarray
    ) -> np.ndarray:
        """(b, 3) unit tangent at an angle to the frame's first axis; axes (3, 3, b): e1, e2, n."""
        return self._turned(self._flat.tangent(cosine, sine, _UNIT), axes)

    def normal(self, axes: np.ndarray) -> np.ndarray:
        """(b, 3) unit normal; axes (3, 3, b): e1, e2, n."""
        return self._turned(self._flat.normal(_UNIT), axes)

    def _turned(self, vector: np.ndarray, axes: np.ndarray) -> np.ndarray:
        """Vectors (b, 3) of the flattened picture as the map back turns them."""
        half = 0.5 * self._bend
        along = np.einsum("kb,bk->b", self._seen, vector)
        turned = vector.T - 2.0 * self.place * (half * vector[:, 2] + half * half * along)
        turned[2] += 2.0 * half * along
        return np.asarray(np.einsum("kb,kcb->bc", turned, axes))


_UNIT = np.eye(3)[:, :, None]


def flattened(
    x: np.ndarray, y: np.ndarray, z: np.ndarray, bend: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Points (..., b) as the map with the spheres of curvature `bend` (b,) shows them, and the
    length on the surface over that in the picture."""
    square = x * x + y * y + z * z
    shrink = 1.0 - bend * z + 0.25 * bend * bend * square
    shrink = np.maximum(shrink, np.finfo(float).eps)
    return x / shrink, y / shrink, (z - 0.5 * bend * square) / shrink, shrink


def fit_flattened(
    x: np.ndarray,
    y: np.ndarray,
    z: np.ndarray,
    degrees: Sequence[int],
    focus: float | None = None,
    planar: np.ndarray | None = None,
    held: np.ndarray | None = None,
) -> list[FlatFit]:
    """Fit heights of each of some degrees to columns of samples (s, b) over the spheres nearest to
    them or over planes.

    Parameters
    ----------
    planar:
        (b,) bool, those over planes; None for whichever leaves smaller residuals.
    focus:
        Weights are 1 / (1 + d^2 / focus)^3 of the squared distance d^2 (mean 1) from the origin;
        None for equal ones. Either are divided by the squared scale of the map, by which it makes
        the errors of the points larger.
    held:
        (b,) how many samples, the first ones, are meant; None for all.
    """
    there = None
    if held is not None and held.min() < len(x):
        there = np.arange(len(x))[:, None] < held
        x, y, z = (np.where(there, value, 0.0) for value in (x, y, z))
    bend = nearest_spheres(x, y, z, there)
    if planar is not None:
        return _fits_over(x, y, z, np.where(planar, 0.0, bend), degrees, focus, there)
    spheres = _fits_over(x, y, z, bend, degrees, focus, there)
    planes = _fits_over(x, y, z, np.zeros(x.shape[1]), degrees, focus, there)
    return [_of_less_left(*pair) for pair in zip(spheres, planes, strict=True)]


def _fits_over(
    x: np.ndarray,
    y: np.ndarray,
    z: np.ndarray,
    bend: np.ndarray,
    degrees: Sequence[int],
    focus: float | None,
    there: np.ndarray | None,
) -> list[FlatFit]:
    """The fits over spheres of curvature `bend` (b,), to the samples that are `there` (s, b)."""
    x, y, z, shrink = flattened(x, y, z, bend)
    weights = np.where(shrink > HALF, shrink * shrink, 0.0)
    if there is not None:
        weights *= there
    if not weights.all():
        # In units of what counts, what does not may lie as far away as no number says.
        x, y, z = (np.where(weights > 0.0, value, 0.0) for value in (x, y, z))
    square, total = x * x + y * y, weights.sum(axis=0)
    tiny = np.finfo(float).tiny
    radius = np.sqrt((weights * square).sum(axis=0) / np.maximum(total, tiny))
    radius = np.maximum(radius, np.sqrt(tiny))
    if focus is not None:
        weights = weights * (1.0 + square / (focus * radius * radius)) ** -3
    most = max(degrees)
    sums, workspace = np.empty((sum_count(most), x.shape[1])), Workspace()
    even = weights if focus is not None or there is not None or bend.any() else None
    sum_samples(x / radius, y / radius, z / radius, even, most, sums, workspace)
    samples = np.count_nonzero(weights, axis=0)
    return [
        FlatFit(
            bend,
            radius,
            solve_heights(lower_sums(sums, most, degree), samples, degree, workspace),
        )
        for degree in degrees
    ]


def _of_less_left(one: FlatFit, two: FlatFit) -> FlatFit:
    """Of each pair of fits to the same samples the one that leaves smaller residuals."""
    left = [np.where(fit.heights.determined, fit.residual, np.inf) for fit in (one, two)]
    first = left[0] <= left[1]
    return FlatFit(
        np.where(first, one.bend, two.bend),
        np.where(first, one.radius, two.radius),
        HeightFit(
            {
                term: np.where(first, value, two.heights.coefficients[term])
                for term, value in one.heights.coefficients.items()
            },
            np.where(first, one.heights.residual, two.heights.residual),
            np.where(first, one.heights.covariance, two.heights.covariance),
            one.heights.determined | two.heights.determined,
        ),
    )


def nearest_spheres(
    x: np.ndarray, y: np.ndarray, z: np.ndarray, there: np.ndarray | None = None
) -> np.ndarray:
    """(b,) curvature, positive towards z, of the spheres nearest to samples (s, b), by linear least
    squares of z = c0 + c1 x + c2 y + c3 (x^2 + y^2 + z^2) / 2 (Coope 1993). Samples that are not
    `there` (s, b) lie at the origin."""
    size = np.maximum.reduce([np.abs(value).max(axis=0) for value in (x, y, z)])
    size = np.maximum(size, _SHORTEST)
    x, y, z = x / size, y / size, z / size
    square = 0.5 * (x * x + y * y + z * z)
    if there is None:
        x, y, square, z = (value - value.mean(axis=0) for value in (x, y, square, z))
    else:
        count = np.count_nonzero(there, axis=0)
        means = (value.sum(axis=0) / count for value in (x, y, square, z))
        values = zip((x, y, square, z), means, strict=True)
        x, y, square, z = (np.where(there, value - mean, 0.0) for value, mean in values)
    xx, xy, yy = (x * x).sum(axis=0), (x * y).sum(axis=0), (y * y).sum(axis=0)
    # Less is round-off of samples along a line.
    area = np.maximum(xx * yy - xy * xy, np.finfo(float).eps * xx * yy)
    area = np.maximum(area, np.finfo(float).tiny)

    def level(value: np.ndarray) -> np.ndarray:
        """What no plane over x and y explains of values (s, b)."""
        along, across = (x * value).sum(axis=0), (y * value).sum(axis=0)
        tilt = (yy * along - xy * across) / area, (xx * across - xy * along) / area
        return np.asarray(value - tilt[0] * x - tilt[1] * y)

    square, z = level(square), level(z)
    spread = np.maximum((square * square).sum(axis=0), np.finfo(float).tiny)
    return np.asarray((square * z).sum(axis=0) / spread / size)


def round_operator(
    coefficients: Mapping[tuple[int, int], np.ndarray],
    radius: np.ndarray,
    bend: np.ndarray,
    u: np.ndarray,
    v: np.ndarray,
) -> RoundOperator:
    """Shape operators at (u, v) of the flattened pictures, in units of the `radius` as the
    coefficients are; places and curvatures in units of the samples."""
    flat = operator_at(coefficients, u, v)
    height = heights_at(coefficients, u, v)
    seen = radius * np.stack([u, v, np.broadcast_to(height, np.shape(u))])
    half, square = 0.5 * bend, (seen * seen).sum(axis=0)
    scale = 1.0 + 2.0 * half * seen[2] + half * half * square
    place = seen.copy()
    place[2] += half * square
    place /= scale
    normal = flat.normal(_UNIT).T
    # A map that scales lengths by 1 / s turns the mean curvature H into s H minus the derivative
    # of s along the normal.
    along = 2.0 * half * normal[2] + 2.0 * half * half * (normal * seen).sum(axis=0)
    return RoundOperator(
        place=place,
        mean=scale * flat.mean / radius - along,
        deviator=scale * (flat.real + 1j * flat.imaginary) / radius,
        scale=scale,
        _flat=flat,
        _seen=seen,
        _bend=bend,
    )
