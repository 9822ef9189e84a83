"""Height functions added as functions of space."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from core.curvature.fits.implicit import (
    derivatives,
    expanded,
    moved,
    offset_powers,
    shape_operator,
)
from core.curvature.fits.monge import operator_at

TERMS = [(total - b, b) for total in range(4) for b in range(total + 1)]


def heights(seed, count=6):
    """Random cubics over random planes: coefficients, radii and axes."""
    random = np.random.default_rng(seed)
    coefficients = {term: random.normal(size=count) for term in TERMS}
    axes, _ = np.linalg.qr(random.normal(size=(count, 3, 3)))
    axes *= np.sign(np.linalg.det(axes))[:, None, None]
    return coefficients, random.uniform(0.3, 3.0, count), np.moveaxis(axes, 0, 2)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10_000))
def test_the_operator_is_that_of_the_heights(seed):
    coefficients, radius, axes = heights(seed)
    x, y, z = np.random.default_rng(seed + 1).normal(size=(3, len(radius)))
    low, third = derivatives(coefficients, radius, axes)
    # However far from the plane: F is linear in z.
    offset = np.einsum("kb,kcb->cb", np.stack([x, y, z]) * radius, axes)
    k1, k2, d1, d2, normal = shape_operator(*moved(low.T, third.T, offset))
    expected = operator_at(coefficients, x, y)
    gap = np.hypot(expected.real, expected.imaginary)
    np.testing.assert_allclose(k1 * radius, expected.mean + 0.5 * gap, rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose(k2 * radius, expected.mean - 0.5 * gap, rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose(normal.T, expected.normal(axes), atol=1e-9)
    half = 0.5 * np.arctan2(expected.imaginary, expected.real)
    along = expected.tangent(np.cos(half), np.sin(half), axes)
    np.testing.assert_allclose(np.abs(np.einsum("cb,bc->b", d1, along)), 1.0, atol=1e-7)
    np.testing.assert_allclose(np.cross(normal.T, d1.T), d2.T, atol=1e-9)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10_000))
def test_what_is_added_up_is_the_sum_of_what_is_moved(seed):
    low, third = derivatives(*heights(seed))
    random = np.random.default_rng(seed + 2)
    offset, weight = random.normal(size=(3, len(low))), random.uniform(size=len(low))
    gradient, hessian = moved(low.T, third.T, offset)
    first, second = (weight * powers for powers in offset_powers(offset))
    by_first, by_second = expanded(low, third)
    total = np.einsum("kb,bkm->m", first, by_first)
    np.testing.assert_allclose(total[3:], hessian @ weight, atol=1e-9)
    total = total[:3] + np.einsum("kb,bkm->m", second, by_second)
    np.testing.assert_allclose(total, gradient @ weight, atol=1e-9)
