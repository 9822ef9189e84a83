"""How the principal curvatures change along their own lines: third derivatives, with their error.

A polynomial of degree 4 or more is fitted to the heights around each vertex, in the frame of its
principal directions. With f the depth below the tangent plane, g its gradient, H its Hessian and
w = sqrt(1 + g.g), the covariant derivative of the second fundamental form is

    C_ijk = f_ijk / w - (H_ij (Hg)_k + H_ki (Hg)_j + H_kj (Hg)_i) / w^3,

symmetric by the Codazzi equations, and e = C(d, d, d) is the derivative of a principal curvature
along its direction d (Porteous 2001, "Geometric Differentiation"; Cazals & Pouget 2005).
"""

from __future__ import annotations

import threading
from dataclasses import dataclass, fields, replace

import numpy as np

from ...base.buffers import Workspace
from ...base.parallel import run
from ...base.progress import Progress
from ...curvature.fits.height_fit import HeightFit, Terms, solve_heights, sum_count, sum_samples
from ...curvature.fits.jets import near_weights, samples_about
from ...curvature.fits.monge import operator_of_heights
from ...mesh.neighbourhoods import Neighbourhood
from ...mesh.surface import Surface

# Vertices whose fits are solved together: their systems take 15 MB in each thread.
CHUNK = 4096
# Samples that are summed together.
SAMPLES_PER_BLOCK = 32768
# Error of e in units of the radius below which it is round-off: heights are known to 1e-16 of it.
ROUND_OFF = 1e-10
# Rings that are added, one at a time, where the samples leave the polynomial undetermined.
RETRIES = 2
# What the error of e depends on: the cubes along both directions, and the twist that turns them.
ENDS: Terms = ((3, 0), (1, 1), (0, 3))


@dataclass(frozen=True)
class Slopes:
    """Principal curvatures k of both families at c vertices, and their change along their lines.

    Row 0 of the first axis is the family of the larger curvature. All in the coordinates of the
    surface the fits were made on.

    Attributes
    ----------
    k, e, bending:
        (2, c) float64 curvature, its first and its second derivative by arc length along its
        own direction; e changes its sign with d.
    mixed:
        (2, c) float64 C(d, d, d') with the direction d' of the other family.
    error:
        (2, c) float64 standard error of e.
    d:
        (2, c, 3) float64 unit directions of the fitted surface.
    normal:
        (c, 3) float64 unit normals of the fitted surface.
    gap_error:
        (c,) float64 standard error of the angle between the families' directions times the gap.
    radius:
        (c,) float64 root mean square distance of the samples.
    determined:
        (c,) bool, False where the samples do not determine the polynomial.
    shown:
        (2, c) bool, True beside ridges that were found before e was corrected.
    """

    k: np.ndarray
    e: np.ndarray
    bending: np.ndarray
    mixed: np.ndarray
    error: np.ndarray
    d: np.ndarray
    normal: np.ndarray
    gap_error: np.ndarray
    radius: np.ndarray
    determined: np.ndarray
    shown: np.ndarray


_OF_FAMILIES = ("k", "e", "bending", "mixed", "error", "d", "shown")


def unknown(count: int) -> Slopes:
    """Slopes of `count` vertices of which nothing is determined."""
    return Slopes(
        k=np.zeros((2, count)),
        e=np.zeros((2, count)),
        bending=np.zeros((2, count)),
        mixed=np.zeros((2, count)),
        error=np.zeros((2, count)),
        d=np.zeros((2, count, 3)),
        normal=np.zeros((count, 3)),
        gap_error=np.zeros(count),
        radius=np.zeros(count),
        determined=np.zeros(count, bool),
        shown=np.zeros((2, count), bool),
    )


def put(made: Slopes, rows: np.ndarray, into: Slopes) -> None:
    """Write the slopes of some vertices into their rows (r,) among those of others."""
    for item in fields(Slopes):
        whole, part = getattr(into, item.name), getattr(made, item.name)
        if item.name in _OF_FAMILIES:
            whole[:, rows] = part
        else:
            whole[rows] = part


@dataclass(frozen=True)
class Fitting:
    """What is fitted around each vertex.

    Attributes
    ----------
    neighbourhood:
        Which vertices are the samples.
    degree:
        Degree of the polynomial, at least 4.
    focus:
        Near samples count more by 1 / (1 + d^2 / focus)^3 of their squared distance (mean 1);
        None for equal weights.
    """

    neighbourhood: Neighbourhood
    degree: int
    focus: float | None

    def wider(self, rings: int) -> Fitting:
        """The same with so many rings more."""
        around = replace(self.neighbourhood, rings=self.neighbourhood.rings + rings)
        return replace(self, neighbourhood=around)


def fit_slopes(
    surface: Surface,
    axes: np.ndarray,
    fitting: Fitting,
    progress: Progress,
    centres: np.ndarray | None = None,
) -> Slopes:
    """Fit polynomials at vertices (c,) of the surface, or at all.

    Parameters
    ----------
    axes:
        (3, 3, n) float64: coordinates of the principal directions d1, d2 and the normal at each
        vertex, as [axis, coordinate, vertex]; rough ones will do.
    """
    if centres is None:
        centres = np.arange(len(surface.vertices))
    c = len(centres)
    slopes = unknown(c)
    coordinates = surface.coordinates
    spaces = threading.local()

    def fit(slots: np.ndarray, wanted: Fitting) -> None:
        if not hasattr(spaces, "workspace"):
            spaces.workspace = Workspace()
        _fit_some(coordinates, axes, centres, slots, wanted, slopes, spaces.workspace)

    def chunk(first: int) -> None:
        fit(np.arange(first, min(first + CHUNK, c)), fitting)

    run(chunk, range(0, c, CHUNK), progress)
    for more in range(1, RETRIES + 1):
        undetermined = np.flatnonzero(~slopes.determined)
        for first in range(0, len(undetermined), CHUNK):
            fit(undetermined[first : first + CHUNK], fitting.wider(more))
    return slopes


def _fit_some(
    coordinates: np.ndarray,
    axes: np.ndarray,
    centres: np.ndarray,
    slots: np.ndarray,
    fitting: Fitting,
    slopes: Slopes,
    workspace: Workspace,
) -> None:
    """Fit at the vertices `centres[slots]` into `slots` of `slopes`."""
    degree, rows = fitting.degree, centres[slots]
    sums = workspace.array("sums", sum_count(degree), len(rows))
    radius, count = np.empty((2, len(rows)))
    blocks, end = [np.zeros(0, int)], 0
    for some, members, held in fitting.neighbourhood.blocks(rows, SAMPLES_PER_BLOCK):
        block = slice(end, end := end + len(some))
        blocks.append(some)
        count[block] = held
        origin = coordinates.take(rows[some], axis=1)
        along = axes.take(rows[some], axis=2)
        samples, radius[block] = samples_about(coordinates, members, held, origin, along, workspace)
        focus = fitting.focus
        weights = None if focus is None else near_weights(samples[:2], held, focus, workspace)
        x, y, height = samples
        sum_samples(x, y, height, weights, degree, sums[:, block], workspace, held)
    order = np.concatenate(blocks)
    fit = solve_heights(sums[:, :end], count[:end], degree, workspace, ENDS)
    made = slopes_of(fit, radius[:end], axes.take(rows[order], axis=2))
    put(made, slots[order], slopes)


def slopes_of(fit: HeightFit, radius: np.ndarray, axes: np.ndarray) -> Slopes:
    """Slopes of fits (b,) in units of `radius` (b,), over `axes` (3, 3, b)."""
    c = fit.coefficients
    operator = operator_of_heights(c[1, 0], c[0, 1], 2 * c[2, 0], c[1, 1], 2 * c[0, 2])
    gap = np.hypot(operator.real, operator.imaginary)
    half = 0.5 * np.arctan2(operator.imaginary, operator.real)
    cosine, sine = np.cos(half), np.sin(half)
    # Directions over the plane's axes, of length one on the surface.
    r11, r12, r22 = operator.root
    ends = np.array(
        [
            [r11 * cosine + r12 * sine, r12 * cosine + r22 * sine],
            [-r11 * sine + r12 * cosine, -r12 * sine + r22 * cosine],
        ]
    )
    safe = np.maximum(gap, np.finfo(float).tiny)
    along, across = _third(fit, ends[0], ends[1]), _third(fit, ends[1], ends[0])
    e, mixed = np.stack([along[0], across[0]]), np.stack([along[1], across[1]])
    k = np.stack([operator.mean + 0.5 * gap, operator.mean - 0.5 * gap])
    sign = np.array([[1.0], [-1.0]])
    w = np.sqrt(1.0 + operator.gx**2 + operator.gy**2)
    fourth = np.stack([_fourth(fit, one) for one in ends]) / w
    bending = fourth - 3.0 * k**3 + 3.0 * sign * mixed**2 / safe
    # e sees the error of its cube and, where the direction turns by its error, 3 C(d, d, d').
    turned = 3.0 * sign * mixed / safe
    v = fit.covariance
    variance = np.stack(
        [
            36.0 * v[0, 0] + turned[0] * (12.0 * v[0, 1] + turned[0] * v[1, 1]),
            36.0 * v[2, 2] + turned[1] * (12.0 * v[1, 2] + turned[1] * v[1, 1]),
        ]
    )
    return Slopes(
        k=k / radius,
        e=e / radius**2,
        bending=bending / radius**3,
        mixed=mixed / radius**2,
        error=np.maximum(np.sqrt(np.maximum(variance, 0.0)), ROUND_OFF) / radius**2,
        d=np.stack([operator.tangent(cosine, sine, axes), operator.tangent(-sine, cosine, axes)]),
        normal=operator.normal(axes),
        gap_error=2.0 * np.sqrt(np.maximum(v[1, 1], 0.0)) / radius,
        radius=radius,
        determined=fit.determined,
        shown=np.zeros(k.shape, bool),
    )


def _third(fit: HeightFit, a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """C(a, a, a) and C(a, a, b) for directions (2, n) over the plane's axes."""
    c = fit.coefficients
    gx, gy = c[1, 0], c[0, 1]
    hxx, hxy, hyy = 2 * c[2, 0], c[1, 1], 2 * c[0, 2]
    w = np.sqrt(1.0 + gx * gx + gy * gy)
    hgx, hgy = hxx * gx + hxy * gy, hxy * gx + hyy * gy
    x, y = a
    haa = hxx * x * x + 2 * hxy * x * y + hyy * y * y
    hab = hxx * x * b[0] + hxy * (x * b[1] + y * b[0]) + hyy * y * b[1]
    ga, gb = hgx * x + hgy * y, hgx * b[0] + hgy * b[1]
    # Gradient of the cubic form at a, divided by 3: its products with a and b are the values.
    tx = 6 * c[3, 0] * x * x + 4 * c[2, 1] * x * y + 2 * c[1, 2] * y * y
    ty = 2 * c[2, 1] * x * x + 4 * c[1, 2] * x * y + 6 * c[0, 3] * y * y
    # The heights are minus the depths; the cubes of H and g keep that one sign.
    aaa = -(tx * x + ty * y) / w + 3 * haa * ga / w**3
    aab = -(tx * b[0] + ty * b[1]) / w + (haa * gb + 2 * hab * ga) / w**3
    return aaa, aab


def _fourth(fit: HeightFit, a: np.ndarray) -> np.ndarray:
    """Fourth derivative of the depth along directions (2, n)."""
    c = fit.coefficients
    x, y = a
    total = np.zeros(len(x))
    for power in range(5):
        total += c[4 - power, power] * x ** (4 - power) * y**power
    return -24.0 * total
