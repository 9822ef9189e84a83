"""Index, kind and separatrices of umbilics from their linear form."""

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st

from core.umbilics import kind as cubic_form

numbers = st.floats(-10, 10).filter(lambda value: abs(value) > 1e-3)


def from_cubic(b0, b1, b2, b3):
    """p, q of the Monge form with cubic (b0 x^3 + 3 b1 x^2 y + 3 b2 x y^2 + b3 y^3) / 6."""
    return (
        np.array([0.5 * ((b0 + b2) + 1j * (b1 + b3))]),
        np.array([0.5 * ((b0 - 3 * b2) + 1j * (3 * b1 - b3))]),
    )


def test_the_three_patterns():
    # For b0 x^3 + 3 b2 x y^2: star if b2 (b0 - b2) < 0, else lemon if b0 > 2 b2, monstar between.
    assert cubic_form.kinds(*from_cubic(1, 0, -1, 0), np.array([-0.5])) == ["star"]
    assert cubic_form.kinds(*from_cubic(5, 0, 2, 0), np.array([0.5])) == ["lemon"]
    assert cubic_form.kinds(*from_cubic(3, 0, 2, 0), np.array([0.5])) == ["monstar"]
    assert cubic_form.kinds(*from_cubic(1, 0, -1, 0), np.array([0.5])) == ["uncertain"]


def test_an_index_that_is_no_generic_one_is_a_compound_whatever_the_form():
    for certified in (-1.0, 0.0, 1.0, 1.5):
        assert cubic_form.kinds(*from_cubic(5, 0, 2, 0), np.array([certified])) == ["compound"]


def test_the_kind_is_open_where_its_error_reaches_the_other():
    lemon, monstar, star = from_cubic(5, 0, 2, 0), from_cubic(3, 0, 2, 0), from_cubic(1, 0, -1, 0)
    # An error larger than the form itself leaves the most open.
    for (p, q), name in ((lemon, "lemon"), (monstar, "monstar")):
        for share, expected in ((0.01, name), (0.6, "uncertain"), (10.0, "uncertain")):
            assert cubic_form.kinds(p, q, np.array([0.5]), share * np.abs(p)) == [expected]
    assert cubic_form.kinds(*star, np.array([-0.5]), np.array([10.0])) == ["star"]


@given(numbers, numbers, numbers, numbers)
def test_index_is_the_sign_of_the_discriminant(b0, b1, b2, b3):
    discriminant = b2 * (b0 - b2) - b1 * (b1 - b3)
    assume(abs(discriminant) > 1e-6)
    p, q = from_cubic(b0, b1, b2, b3)
    np.testing.assert_allclose(
        np.abs(p) ** 2 - np.abs(q) ** 2, 2 * discriminant, rtol=1e-6, atol=1e-9
    )
    assert cubic_form.index(p, q) == 0.5 * np.sign(discriminant)


@given(numbers, numbers, numbers, numbers)
def test_separatrices_solve_their_cubic_and_are_one_or_three(b0, b1, b2, b3):
    p, q = from_cubic(b0, b1, b2, b3)
    angles = cubic_form.separatrix_angles(p, q)[0]
    angles = angles[np.isfinite(angles)]
    assert len(angles) in (1, 3) or np.abs(np.abs(p) - np.abs(q)) < 1e-2
    c, s = np.cos(angles), np.sin(angles)
    cubic = b1 * c**3 + (2 * b2 - b0) * c**2 * s + (b3 - 2 * b1) * c * s**2 - b2 * s**3
    np.testing.assert_allclose(cubic, 0, atol=1e-5)
    # Along a separatrix the direction of the larger curvature is radial.
    along = p * np.exp(1j * angles) + q * np.exp(-1j * angles)
    assert (np.real(along * np.exp(-2j * angles)) >= -1e-6).all()


@given(numbers, numbers, numbers, numbers, st.floats(-3, 3))
def test_turning_the_frame_turns_the_separatrices(b0, b1, b2, b3, turn):
    p, q = from_cubic(b0, b1, b2, b3)
    # Where |p| = |q| the umbilic is not isolated and a separatrix changes sides.
    assume(abs(abs(p[0]) - abs(q[0])) > 0.1)
    angles = cubic_form.separatrix_angles(p, q)[0]
    # z = exp(i turn) z' and D' = exp(-2 i turn) D.
    turned = cubic_form.separatrix_angles(p * np.exp(-1j * turn), q * np.exp(-3j * turn))[0]
    assume(np.isfinite(angles).sum() == np.isfinite(turned).sum())
    first = np.exp(1j * (angles[np.isfinite(angles)] - turn))
    second = np.exp(1j * turned[np.isfinite(turned)])
    gap = np.abs(first[:, None] - second[None])
    assert gap.min(axis=1).max() < 1e-3


def test_cubic_form_of_a_triangle():
    corners = np.array([[[0.0, 0, 0], [2, 0, 0], [0, 1, 0]]])
    p, q = 0.3 - 0.7j, 1.1 + 0.2j
    z = corners[..., 0] + 1j * corners[..., 1]
    values = p * z + q * np.conj(z) + 5.0
    x, y = np.array([[1.0, 0, 0]]), np.array([[0.0, 1, 0]])
    found_p, found_q = cubic_form.in_triangles(corners, values, x, y)
    np.testing.assert_allclose([found_p[0], found_q[0]], [p, q])
