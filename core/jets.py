"""Shape operators from osculating jets: a cubic height function around each vertex.

Cazals & Pouget 2005, "Estimating differential quantities using polynomial fitting of
osculating jets". The height function is fitted in the tangent frame of a first normal; the
shape operator is then expressed at the fitted normal with both fundamental forms.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .heights import fit_heights
from .neighbourhoods import adjacency, by_size, rings
from .parallel import run
from .progress import Progress
from .surface import Surface
from .tangent import frame, principal_directions

DEGREE = 3
# A cubic has ten coefficients; half as many samples again keep the fit from chasing noise.
FEWEST_SAMPLES = 15
# Vertices whose neighbourhoods are found together: their rows stay near the caches.
CHUNK = 16384
# Samples per block of fits: a (samples, fits) array of float64 then fits the second cache.
SAMPLES_PER_BLOCK = 24576
# Weights 1 / (1 + d^2 / FOCUS)^3 of the squared distance d^2 (mean 1) bring the bias of the
# distant samples down; measured on random meshes they beat equal and Gaussian weights.
FOCUS = 0.3


@dataclass(frozen=True)
class Jets:
    """Shape operators of all vertices of a `Surface`, in its own (unit) coordinates.

    Attributes
    ----------
    k1, k2:
        (n,) float64 principal curvatures.
    d1, normal:
        (n, 3) float64 first principal direction and unit normal.
    noise:
        (n,) float64 standard error of the gap.
    residual:
        (n,) float64 standard deviation of the heights about the fit, in length.
    radius:
        (n,) float64 root mean square distance of the samples, in length.
    determined:
        (n,) bool, False where the neighbourhood does not determine a cubic.
    """

    k1: np.ndarray
    k2: np.ndarray
    d1: np.ndarray
    normal: np.ndarray
    noise: np.ndarray
    residual: np.ndarray
    radius: np.ndarray
    determined: np.ndarray


def fit_jets(
    surface: Surface,
    normals: np.ndarray,
    ring_count: int,
    focused: bool,
    progress: Progress,
) -> Jets:
    """Fit a jet at every vertex over `ring_count` rings, more where these are too few.

    Parameters
    ----------
    surface:
        The surface; n vertices.
    normals:
        (n, 3) float64 unit normals that the fitted height functions start from.
    ring_count:
        Rings of neighbours, at least 2.
    focused:
        Weigh near samples more: least bias, for clean meshes. Equal weights hold noise best.
    """
    n = len(surface.vertices)
    jets = Jets(
        k1=np.zeros(n),
        k2=np.zeros(n),
        d1=np.empty((n, 3)),
        normal=np.empty((n, 3)),
        noise=np.empty(n),
        residual=np.empty(n),
        radius=np.empty(n),
        determined=np.zeros(n, bool),
    )
    graph = adjacency(surface)
    coordinates = np.ascontiguousarray(surface.vertices.T)

    def chunk(first: int) -> None:
        pending = np.arange(first, min(first + CHUNK, n))
        count = ring_count
        # Small neighbourhoods grow ring by ring until they suffice or hold a whole component.
        sizes = np.zeros(len(pending), int)
        while len(pending):
            reach = rings(graph, pending, count)
            grown = np.diff(reach.indptr)
            ready = (grown >= FEWEST_SAMPLES) | (grown == sizes)
            for rows, members in by_size(reach[ready] if not ready.all() else reach, SAMPLES_PER_BLOCK):
                fit_block(coordinates, normals, pending[ready][rows], members, focused, jets)
            pending, sizes = pending[~ready], grown[~ready]
            count += 1

    firsts = range(0, n, CHUNK)
    run(chunk, firsts, progress)
    return jets


def fit_block(
    coordinates: np.ndarray,
    normals: np.ndarray,
    centres: np.ndarray,
    members: np.ndarray,
    focused: bool,
    jets: Jets,
) -> None:
    """Fit the jets of one block and write them into `jets` at `centres`.

    Parameters
    ----------
    coordinates:
        (3, n) float64 vertex positions.
    normals:
        (n, 3) float64 first normals.
    centres:
        (b,) vertices to fit.
    members:
        (s, b) samples of each.
    focused:
        As in `fit_jets`.
    """
    n0 = normals[centres].T
    e1, e2 = frame(n0)
    offset = [np.take(axis, members) for axis in coordinates]
    for axis in range(3):
        offset[axis] -= coordinates[axis, centres]
    x = e1[0] * offset[0] + e1[1] * offset[1] + e1[2] * offset[2]
    y = e2[0] * offset[0] + e2[1] * offset[1] + e2[2] * offset[2]
    z = n0[0] * offset[0] + n0[1] * offset[1] + n0[2] * offset[2]
    radius = np.sqrt(
        (np.einsum("sb,sb->b", x, x) + np.einsum("sb,sb->b", y, y)) / len(members)
    )
    radius = np.maximum(radius, np.finfo(float).tiny)
    inverse = 1.0 / radius
    x *= inverse
    y *= inverse
    z *= inverse
    weights = None
    if focused:
        nearness = 1.0 / (1.0 + (x * x + y * y) / FOCUS)
        weights = nearness * nearness * nearness
    fit = fit_heights(x, y, z, weights, DEGREE)
    write_operator(fit, radius, (e1, e2, n0), centres, jets)


def write_operator(fit, radius, axes, centres, jets):
    """Shape operator at the origin of the fitted heights, by both fundamental forms."""
    e1, e2, n0 = axes
    c = fit.coefficients
    gx, gy = c[1, 0], c[0, 1]
    square = 1.0 + gx * gx + gy * gy
    w = np.sqrt(square)
    # Outward normals: a sphere lies below its tangent plane and has positive curvature.
    lx, ly, lm = -2 * c[2, 0] / (w * radius), -2 * c[0, 2] / (w * radius), -c[1, 1] / (w * radius)
    # I^(-1/2) = 1 - g g^T / (w (1 + w)): the orthonormal frame nearest to (e1, e2).
    q = 1.0 / (w * (1.0 + w))
    a, b, d = 1.0 - q * gx * gx, -q * gx * gy, 1.0 - q * gy * gy
    m11, m12 = a * lx + b * lm, a * lm + b * ly
    m21, m22 = b * lx + d * lm, b * lm + d * ly
    s11, s12, s22 = m11 * a + m12 * b, m11 * b + m12 * d, m21 * b + m22 * d
    mean, real, imaginary = 0.5 * (s11 + s22), s11 - s22, 2 * s12
    gap = np.hypot(real, imaginary)
    cosine, sine = principal_directions(real, imaginary, gap)
    # The tangent frame at the fitted normal, in the coordinates of the first one.
    u, v = a * cosine + b * sine, b * cosine + d * sine
    slope = gx * u + gy * v
    jets.k1[centres] = mean + 0.5 * gap
    jets.k2[centres] = mean - 0.5 * gap
    jets.d1[centres] = (u * e1 + v * e2 + slope * n0).T
    jets.normal[centres] = ((n0 - gx * e1 - gy * e2) / w).T
    jets.noise[centres] = fit.gap_error / radius
    jets.residual[centres] = fit.residual * radius
    jets.radius[centres] = radius
    jets.determined[centres] = fit.determined
