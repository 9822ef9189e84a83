"""Shape operators from osculating jets: a cubic height function around each vertex.

Cazals & Pouget 2005, "Estimating differential quantities using polynomial fitting of
osculating jets". The height function is fitted in the tangent frame of a first normal; the
shape operator is then expressed at the fitted normal with both fundamental forms.
"""

from __future__ import annotations

import dataclasses
import threading
from dataclasses import dataclass

import numpy as np

from .height_operator import operator_of_heights
from .heights import fit_heights
from .neighbourhoods import Neighbourhood
from .parallel import run
from .progress import Progress
from .surface import Surface
from .tangent import frame, principal_directions
from .workspace import Workspace

DEGREE = 3
# Vertices whose neighbourhoods are found together: their rows stay near the caches.
CHUNK = 32768
# Rings that are added, one at a time, where the samples leave a cubic undetermined.
RETRIES = 2
# Samples per block of fits. Smaller blocks would stay in the second cache, but hand the
# interpreter lock over so often that two threads were slower than one; this is 1.4 times faster.
SAMPLES_PER_BLOCK = 98304
# Weights 1 / (1 + d^2 / FOCUS)^3 of the squared distance d^2 (mean 1) bring the bias of the
# distant samples down; measured on random meshes they beat equal and Gaussian weights.
FOCUS = 0.3


@dataclass(frozen=True)
class Jets:
    """Shape operators at c vertices of a `Surface`, in its own (unit) coordinates.

    Attributes
    ----------
    k1, k2:
        (c,) float64 principal curvatures.
    d1, d2, normal:
        (c, 3) float64 principal directions and unit normal.
    noise:
        (c,) float64 standard error of the gap.
    residual:
        (c,) float64 standard deviation of the heights about the fit, in length.
    radius:
        (c,) float64 root mean square distance of the samples, in length.
    determined:
        (c,) bool, False where the neighbourhood does not determine a cubic.
    """

    k1: np.ndarray
    k2: np.ndarray
    d1: np.ndarray
    d2: np.ndarray
    normal: np.ndarray
    noise: np.ndarray
    residual: np.ndarray
    radius: np.ndarray
    determined: np.ndarray


def fit_jets(
    surface: Surface,
    normals: np.ndarray,
    neighbourhood: Neighbourhood,
    progress: Progress,
    centres: np.ndarray | None = None,
) -> Jets:
    """Fit a jet at vertices of the surface.

    Parameters
    ----------
    surface:
        The surface; n vertices.
    normals:
        (n, 3) float64 unit normals that the fitted height functions start from.
    neighbourhood:
        What each jet is fitted to.
    centres:
        (c,) vertices to fit, or None for all.
    """
    if centres is None:
        centres = np.arange(len(surface.vertices))
    c = len(centres)
    jets = Jets(
        k1=np.zeros(c),
        k2=np.zeros(c),
        d1=np.empty((c, 3)),
        d2=np.empty((c, 3)),
        normal=np.empty((c, 3)),
        noise=np.empty(c),
        residual=np.empty(c),
        radius=np.empty(c),
        determined=np.zeros(c, bool),
    )
    coordinates = np.ascontiguousarray(surface.vertices.T)
    spaces = threading.local()

    def fit(slots: np.ndarray, around: Neighbourhood) -> None:
        if not hasattr(spaces, "workspace"):
            spaces.workspace = Workspace()
        for some, members in around.blocks(centres[slots], SAMPLES_PER_BLOCK):
            _fit_block(
                coordinates,
                normals,
                centres[slots[some]],
                members,
                around.focused,
                slots[some],
                jets,
                spaces.workspace,
            )

    def chunk(first: int) -> None:
        fit(np.arange(first, min(first + CHUNK, c)), neighbourhood)

    run(chunk, range(0, c, CHUNK), progress)
    # On the border of a regular grid two rings are only three rows, and three rows fix no cube.
    for more in range(1, RETRIES + 1):
        undetermined = np.flatnonzero(~jets.determined)
        fit(undetermined, dataclasses.replace(neighbourhood, rings=neighbourhood.rings + more))
    return jets


def _fit_block(
    coordinates: np.ndarray,
    normals: np.ndarray,
    centres: np.ndarray,
    members: np.ndarray,
    focused: bool,
    slots: np.ndarray,
    jets: Jets,
    workspace: Workspace,
) -> None:
    """Fit the jets of b vertices `centres` to their (s, b) samples; into `slots` of `jets`."""
    n0 = normals[centres].T
    axes = np.stack([*frame(n0), n0])
    offset = workspace.array("offset", 3, *members.shape)
    np.take(coordinates, members, axis=1, out=offset, mode="clip")
    offset -= coordinates[:, None, centres]
    radius = np.sqrt(np.einsum("csb,csb->b", offset, offset) / len(members))
    radius = np.maximum(radius, np.finfo(float).tiny)
    inverse = 1.0 / radius
    # One contraction: several times faster than sums of products with their temporaries.
    samples = workspace.array("samples", 3, *members.shape)
    x, y, z = np.einsum("csb,kcb->ksb", offset, axes * inverse, out=samples)
    root = _weight_root(x, y, workspace) if focused else None
    fit = fit_heights(x, y, z, root, DEGREE, workspace)

    c = fit.coefficients
    # Heights in units of the radius bend 1 / radius times as much as in length.
    operator = operator_of_heights(c[1, 0], c[0, 1], 2 * c[2, 0], c[1, 1], 2 * c[0, 2])
    gap = np.hypot(operator.real, operator.imaginary)
    cosine, sine = principal_directions(operator.real, operator.imaginary, gap)
    jets.k1[slots] = (operator.mean + 0.5 * gap) * inverse
    jets.k2[slots] = (operator.mean - 0.5 * gap) * inverse
    jets.d1[slots] = operator.tangent(cosine, sine, axes)
    jets.d2[slots] = operator.tangent(-sine, cosine, axes)
    jets.normal[slots] = operator.normal(axes)
    jets.noise[slots] = fit.gap_error * inverse
    jets.residual[slots] = fit.residual * radius
    jets.radius[slots] = radius
    jets.determined[slots] = fit.determined


def _weight_root(x: np.ndarray, y: np.ndarray, workspace: Workspace) -> np.ndarray:
    """Square root (s, b) of the weights of samples at x, y: 1 / (1 + d^2 / FOCUS)^(3/2)."""
    spread, other = workspace.array("weights", 2, *x.shape)
    np.multiply(x, x, out=spread)
    np.multiply(y, y, out=other)
    spread += other
    spread *= 1.0 / FOCUS
    spread += 1.0
    np.sqrt(spread, out=other)
    spread *= other
    return np.reciprocal(spread, out=spread)
