"""Shape operators from osculating jets: a cubic height function around each vertex.

Cazals & Pouget 2005, "Estimating differential quantities using polynomial fitting of
osculating jets". The height function is fitted in the tangent frame of a first normal; the
shape operator is then expressed at the fitted normal with both fundamental forms.
"""

from __future__ import annotations

import dataclasses
import threading
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...base.buffers import Workspace
from ...base.parallel import run
from ...base.progress import Progress
from ...fields.frames import frame, principal_directions
from ...mesh.neighbourhoods import Neighbourhood
from ...mesh.rings import side_by_side
from ...mesh.surface import Surface
from .height_fit import HeightFit, solve_heights, sum_count, sum_samples
from .monge import operator_of_heights

DEGREE = 3
# Vertices whose fits are solved together: their systems take 14 MB in each thread. Fewer are dealt
# out in so many parts, of not fewer than that, as threads with less to do wait for the interpreter
# lock more than they work; round-off depends on the parts, and so they depend on the surface alone,
# not on the machine.
CHUNK, PARTS, FEWEST = 16384, 4, 512
# Rings that are added, one at a time, where the samples leave a cubic undetermined.
RETRIES = 2
# Samples that are summed together. Smaller blocks would stay in the second cache, but in short
# calls the threads wait for the interpreter lock longer than the cache saves.
SAMPLES_PER_BLOCK = 65536
# By degree: weights 1 / (1 + d^2 / focus)^3 of the squared distance d^2 (mean 1) bring the bias of
# the distant samples down; measured on random meshes they beat equal and Gaussian weights.
FOCUS = {3: 0.3, 4: 1.0, 5: 1.0}

# Samples in one point are taken as if they lay so far apart: its fourth power is a number still.
_SHORTEST = float(np.finfo(float).tiny) ** 0.25

# Takes fits (b,), their radii (b,), their axes (3, 3, b) and which of the centres they are of (b,).
Store = Callable[[HeightFit, np.ndarray, np.ndarray, np.ndarray], None]


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

    @classmethod
    def none(cls, count: int) -> Jets:
        """Zeros, to be filled: none of so many is determined."""
        return cls(
            k1=np.zeros(count),
            k2=np.zeros(count),
            d1=np.zeros((count, 3)),
            d2=np.zeros((count, 3)),
            normal=np.zeros((count, 3)),
            noise=np.zeros(count),
            residual=np.zeros(count),
            radius=np.zeros(count),
            determined=np.zeros(count, bool),
        )


def fit_jets(
    surface: Surface,
    normals: np.ndarray,
    neighbourhood: Neighbourhood,
    progress: Progress,
    centres: np.ndarray | None = None,
    degree: int = DEGREE,
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
    degree:
        Degree of the height functions, 3 to 5.
    """
    if centres is None:
        centres = np.arange(len(surface.vertices))
    jets = Jets.none(len(centres))

    def store(fit: HeightFit, radius: np.ndarray, axes: np.ndarray, slots: np.ndarray) -> None:
        _store(fit, radius, axes, slots, jets)

    fit_each(surface, normals, neighbourhood, progress, centres, degree, store)
    return jets


def fit_each(
    surface: Surface,
    normals: np.ndarray,
    neighbourhood: Neighbourhood,
    progress: Progress,
    centres: np.ndarray,
    degree: int,
    store: Store,
) -> None:
    """Fit height functions at the vertices `centres` (c,), and hand them to `store` in parts.

    The other parameters are those of `fit_jets`.
    """
    c = len(centres)
    spaces = threading.local()
    ask = progress.quiet()
    determined = np.zeros(c, bool)
    # Made once, before threads ask for them.
    neighbourhood.patches  # noqa: B018

    def fit(slots: np.ndarray, around: Neighbourhood) -> None:
        if not hasattr(spaces, "workspace"):
            spaces.workspace = Workspace()
        some = centres[slots]
        fits, radius, axes, order = _fit_some(
            surface.coordinates, normals, some, around, degree, spaces.workspace, ask
        )
        determined[slots[order]] = fits.determined
        store(fits, radius, axes, slots[order])

    size = CHUNK if c > CHUNK else max(-(-c // PARTS), FEWEST)

    order = np.arange(c)
    if neighbourhood.side_by_side(size):
        order = side_by_side(surface.vertices[centres])

    def chunk(first: int) -> None:
        fit(order[first : first + size], neighbourhood)

    run(chunk, range(0, c, size), progress)
    # On the border of a regular grid two rings are only three rows, and three rows fix no cube.
    for more in range(1, RETRIES + 1):
        undetermined = np.flatnonzero(~determined)
        wider = dataclasses.replace(neighbourhood, rings=neighbourhood.rings + more, patching=None)
        for first in range(0, len(undetermined), CHUNK):
            fit(undetermined[first : first + CHUNK], wider)


def _fit_some(
    coordinates: np.ndarray,
    normals: np.ndarray,
    centres: np.ndarray,
    around: Neighbourhood,
    degree: int,
    workspace: Workspace,
    progress: Progress,
) -> tuple[HeightFit, np.ndarray, np.ndarray, np.ndarray]:
    """Fits at vertices `centres` (c,) in the order of their samples: the fits, (c,) radii,
    (3, 3, c) axes and (c,) their rows of `centres`.

    The samples are summed in blocks, the fits solved all together: in many short calls two
    threads would wait for the interpreter lock more than they work.
    """
    n0 = normals[centres].T
    axes = np.stack([*frame(n0), n0])
    sums = workspace.array("sums", sum_count(degree), len(centres))
    radius, count = np.empty((2, len(centres)))
    patches = around.patches
    seen = coordinates if patches is None else patches.coordinates
    blocks, end = [np.zeros(0, int)], 0
    for some, members, held in around.blocks(centres, SAMPLES_PER_BLOCK, progress):
        block = slice(end, end := end + len(some))
        blocks.append(some)
        count[block] = held
        # `take` gives arrays that run along b; indexed with [..., some] they would not.
        origin = coordinates.take(centres[some], axis=1)
        along = axes.take(some, axis=2)
        samples, radius[block] = samples_about(seen, members, held, origin, along, workspace)
        weights = None
        if around.focused:
            weights = near_weights(samples[:2], held, FOCUS[degree], workspace)
        if patches is not None:
            weights = patches.size.take(members)
            count[block] = weights.sum(axis=0)
        x, y, height = samples
        sum_samples(x, y, height, weights, degree, sums[:, block], workspace, held)
        if patches is not None:
            # Squares of all heights, not of their means alone.
            sums[-1, block] += patches.scatter.take(members).sum(axis=0) / radius[block] ** 2
    order = np.concatenate(blocks)
    fit = solve_heights(sums[:, :end], count[:end], degree, workspace)
    return fit, radius[:end], axes.take(order, axis=2), order


def samples_about(
    coordinates: np.ndarray,
    members: np.ndarray,
    held: np.ndarray | int,
    origin: np.ndarray,
    axes: np.ndarray,
    workspace: Workspace,
) -> tuple[np.ndarray, np.ndarray]:
    """(3, s, b) coordinates of the vertices `members` (s, b) about `origin` (3, b) along three
    `axes` (3, 3, b), in units of their root mean square distance, and (b,) that radius. All but
    the `held` (b,) first lie at the origin."""
    offset = workspace.array("offset", 3, *members.shape)
    for here, centre, away in zip(coordinates, origin, offset, strict=True):
        np.subtract(here[members], centre, out=away)
    radius = np.sqrt(np.einsum("csb,csb->b", offset, offset) / held)
    radius = np.maximum(radius, _SHORTEST)
    samples = workspace.array("samples", 3, *members.shape)
    # Axis by axis: NumPy takes three times as long for one contraction with all of them.
    for axis, along in zip(axes / radius, samples, strict=True):
        np.einsum("csb,cb->sb", offset, axis, out=along)
    return samples, radius


def near_weights(
    plane: np.ndarray, held: np.ndarray, focus: float, workspace: Workspace
) -> np.ndarray:
    """Weights (s, b) of samples at `plane` (2, s, b), up to a factor: 1 / (1 + d^2 / focus)^3; zero
    but for the `held` (b,) first."""
    spread, other = workspace.array("weights", *plane.shape)
    np.einsum("csb,csb->sb", plane, plane, out=spread)
    spread += focus
    np.multiply(spread, spread, out=other)
    spread *= other
    np.reciprocal(spread, out=spread)
    if held.min() < len(spread):
        spread *= np.arange(len(spread))[:, None] < held
    return np.asarray(spread)


def _store(
    fit: HeightFit, radius: np.ndarray, axes: np.ndarray, slots: np.ndarray, jets: Jets
) -> None:
    """Write the shape operators of fits (b,) over `axes` (3, 3, b) to `slots` (b,) of `jets`."""
    c = fit.coefficients
    # Heights in units of the radius bend 1 / radius times as much as in length.
    operator = operator_of_heights(c[1, 0], c[0, 1], 2 * c[2, 0], c[1, 1], 2 * c[0, 2])
    gap = np.hypot(operator.real, operator.imaginary)
    cosine, sine = principal_directions(operator.real, operator.imaginary, gap)
    inverse = 1.0 / radius
    jets.k1[slots] = (operator.mean + 0.5 * gap) * inverse
    jets.k2[slots] = (operator.mean - 0.5 * gap) * inverse
    jets.d1[slots] = operator.tangent(cosine, sine, axes)
    jets.d2[slots] = operator.tangent(-sine, cosine, axes)
    jets.normal[slots] = operator.normal(axes)
    jets.noise[slots] = fit.gap_error * inverse
    jets.residual[slots] = fit.residual * radius
    jets.radius[slots] = radius
    jets.determined[slots] = fit.determined
