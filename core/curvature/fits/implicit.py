"""Height functions as functions of space whose zero level is the surface.

The heights h over a plane make F(p) = z - h(x, y) with zero level z = h. Values of several such
functions at a place can be added as they are, whatever their planes, and the shape operator of the
sum follows from its gradient and its Hessian (Ohtake et al. 2003, "Multi-level partition of unity
implicits", https://doi.org/10.1145/882262.882293; Goldman 2005, "Curvature formulas for implicit
curves and surfaces", https://doi.org/10.1016/j.cagd.2005.06.005).
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import permutations

import numpy as np

from ...fields.frames import frame, principal_directions

# The gradient and the Hessian (xx, xy, xz, yy, yz, zz) among the first and second derivatives.
GRADIENT, HESSIAN = slice(0, 3), slice(3, 9)
_PAIRS = [(a, b) for a in range(3) for b in range(a, 3)]
_TRIPLES = [(a, b, c) for a in range(3) for b in range(a, 3) for c in range(b, 3)]
_PAIR = {pair: k for k, pair in enumerate(_PAIRS)} | {(b, a): k for k, (a, b) in enumerate(_PAIRS)}
_TRIPLE = {(a, b, c): k for k, t in enumerate(_TRIPLES) for a, b, c in permutations(t)}
# (3, 3) places of the Hessian's rows, and (3, 6) of the Hessian that one axis takes of the third
# derivatives.
ROWS = np.array([[_PAIR[a, b] for b in range(3)] for a in range(3)])
SLICES = np.array([[_TRIPLE[a, b, c] for b, c in _PAIRS] for a in range(3)])
# Where `expanded` takes its values from, among the 19 derivatives.
_FIRST = np.array(
    [[*range(9)]] + [[*(3 + ROWS[axis]), *(9 + SLICES[axis])] for axis in range(3)], np.intp
)
_SECOND = np.array([9 + SLICES[a, ROWS[b]] for a, b in _PAIRS], np.intp)


def derivatives(
    coefficients: Mapping[tuple[int, int], np.ndarray], radius: np.ndarray, axes: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(b, 9) first and second and (b, 10) third derivatives of F at the origin of cubic heights.

    Parameters
    ----------
    coefficients:
        {(a, b): (b,)} of the heights, in units of the radius.
    radius:
        (b,) that unit.
    axes:
        (3, 3, b) the plane's axes and its normal.
    """
    c, (x, y, normal) = coefficients, axes
    low, high = np.empty((len(radius), 9)), np.empty((len(radius), 10))
    low[:, GRADIENT] = (normal - c[1, 0] * x - c[0, 1] * y).T
    # The Hessian is x (second x + mixed y) + y (mixed x + third y), and so on one degree up.
    unit = 1.0 / radius
    first = -unit * (2.0 * c[2, 0] * x + c[1, 1] * y)
    second = -unit * (c[1, 1] * x + 2.0 * c[0, 2] * y)
    for column, (a, b) in zip(low[:, HESSIAN].T, _PAIRS, strict=True):
        np.add(x[a] * first[b], y[a] * second[b], out=column)
    square = 2.0 * unit * unit
    xx = -square * (3.0 * c[3, 0] * x + c[2, 1] * y)
    xy = -square * (c[2, 1] * x + c[1, 2] * y)
    yy = -square * (c[1, 2] * x + 3.0 * c[0, 3] * y)
    for column, (a, b, d) in zip(high.T, _TRIPLES, strict=True):
        mixed = x[a] * y[b] + y[a] * x[b]
        column[:] = x[a] * x[b] * xx[d] + mixed * xy[d] + y[a] * y[b] * yy[d]
    return low, high


def moved(
    low: np.ndarray, third: np.ndarray, offset: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Gradient (3, b) and Hessian (6, b) of cubics at an offset (3, b) from where their
    derivatives are (9, b) and (10, b)."""
    change = np.zeros((6, low.shape[1]))
    for along, places in zip(offset, SLICES, strict=True):
        change += along * third[places]
    hessian = low[HESSIAN]
    middle = hessian + 0.5 * change
    gradient = low[GRADIENT].copy()
    for along, places in zip(offset, ROWS, strict=True):
        gradient += along * middle[places]
    return gradient, hessian + change


def expanded(low: np.ndarray, third: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What `offset_powers` is multiplied with: (b, 4, 9) gradients and Hessians and how they change
    along the axes, and (b, 6, 3) second changes of the gradients, of derivatives (b, 9) and
    (b, 10)."""
    both = np.concatenate([low, third], axis=1)
    return both.take(_FIRST, axis=1), both.take(_SECOND, axis=1)


def offset_powers(offset: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(4, p) and (6, p): the terms of degrees 0 to 1 and of degree 2 of Taylor's series at offsets
    (3, p)."""
    first = np.concatenate([np.ones((1, offset.shape[1])), offset])
    second = [offset[a] * offset[b] * (0.5 if a == b else 1.0) for a, b in _PAIRS]
    return first, np.stack(second)


def shape_operator(
    gradient: np.ndarray, hessian: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """k1, k2 (b,), d1, d2 and normal (3, b) of the level of a function, from its gradient (3, b),
    which must not vanish, and its Hessian (6, b)."""
    scale = 1.0 / np.sqrt(np.einsum("cb,cb->b", gradient, gradient))
    normal = gradient * scale
    e1, e2 = frame(normal)
    bent = np.stack([np.einsum("cb,cb->b", hessian[places], e1) for places in ROWS])
    s11, s12 = np.einsum("cb,cb->b", bent, e1), np.einsum("cb,cb->b", bent, e2)
    trace = hessian[_PAIR[0, 0]] + hessian[_PAIR[1, 1]] + hessian[_PAIR[2, 2]]
    across = np.stack([np.einsum("cb,cb->b", hessian[places], normal) for places in ROWS])
    s22 = trace - s11 - np.einsum("cb,cb->b", across, normal)
    real, imaginary = scale * (s11 - s22), 2.0 * scale * s12
    gap = np.hypot(real, imaginary)
    mean = 0.5 * scale * (s11 + s22)
    cosine, sine = principal_directions(real, imaginary, gap)
    d1, d2 = cosine * e1 + sine * e2, cosine * e2 - sine * e1
    return mean + 0.5 * gap, mean - 0.5 * gap, d1, d2, normal
