"""A smooth cross field: four directions at right angles, along the curvature where it has any.

A cross is kept as the fourth power u of any of its directions, written as a complex number in
the tangent frame of a vertex, so that all four give the same u (Palacios & Zhang 2007). The field
minimizes

    sum over edges w_ij |u_i - T_ij u_j|^2  +  sum over vertices (c_i A_i / l^2) |u_i - g_i|^2

with cotangent weights w, transport T by the smallest rotation between the normals, confidence c,
vertex areas A and g the principal directions or those of a feature; l is the length over which
the field is smoothed. One sparse Hermitian solve; after Knoeppel et al. 2013.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from ..base.parallel import run
from ..base.progress import Progress
from ..curvature.field import CurvatureField
from ..curvature.noise import field_noise
from ..fields.directions import DirectionField
from ..fields.frames import frame, principal_directions
from ..fields.multigrid import solve
from ..fields.transport import carried, rotation, tangents
from ..fields.winding import certified_index
from ..mesh.normals import vertex_normals
from ..mesh.surface import Surface
from .dipoles import without_dipoles
from .features import Features, find_features, fourth_power, wanted_directions
from .settings import GuidanceSettings

# The gap over its standard error, and over the median gap, at which a direction counts half.
NOISE_RATIO = 4.0
WEAK_GAP = 0.15
# A trace of the data everywhere keeps the system definite.
LEAST_CONFIDENCE = 1e-6
# Smoothing lengths at the ends of the slider, in radii of the sphere of the same area.
SHORTEST, LONGEST = 0.003, 10.0
# Smoothness whose length is an edge of a mesh of 2,000 quads: singularities are taken together that
# are nearer than that, if the field is as smooth; what is smoother lets go of them by itself.
QUAD_EDGE = 0.4
# Hard features outweigh what pulls at them from around by this much; crests yield to it.
FEATURE_WEIGHT, CREST_WEIGHT = 100.0, 0.3
# Cotangent weights outside these bounds come from slivers and would spoil the solver.
LEAST_WEIGHT, LARGEST_WEIGHT = 0.05, 20.0
# Mean confidence below which a component has no direction of its own: its smoothest field is
# taken then, by this many steps of inverse iteration.
NO_DIRECTION, INVERSE_STEPS = 1e-3, 5
BLOCK = 1 << 16


@dataclass(frozen=True)
class CrossField:
    """Crosses on a `Surface` of n vertices and m triangles.

    Attributes
    ----------
    direction:
        (n, 3) float64 one unit direction of each vertex's cross; the others follow by right
        angles about `normal`.
    normal:
        (n, 3) float64 unit normals.
    confidence:
        (n,) float64 how much the curvature says there, 0 to 1; 1 on features.
    strength:
        (n,) float64 length of u: near 0 around singularities and where directions compete.
    face_direction:
        (m, 3) float64 one unit direction of each triangle's cross, in its plane.
    triangle_index:
        (m,) float64 index of the field in each triangle, a multiple of one quarter. Over a
        closed component they sum to its Euler characteristic.
    smoothing:
        Length over which the field was smoothed, median over the vertices, in the coordinates
        of the surface.
    """

    direction: np.ndarray
    normal: np.ndarray
    confidence: np.ndarray
    strength: np.ndarray
    face_direction: np.ndarray
    triangle_index: np.ndarray
    smoothing: float


def cross_field(
    surface: Surface,
    field: CurvatureField,
    settings: GuidanceSettings,
    progress: Progress,
    *,
    sharp: np.ndarray | None = None,
    undirected: np.ndarray | None = None,
    features: Features | None = None,
) -> CrossField:
    """The cross field of a surface.

    Parameters
    ----------
    surface:
        The surface; n vertices, m triangles.
    field:
        Shape operators at its vertices, in its coordinates.
    settings:
        Smoothness and what to align to.
    sharp:
        (s, 2) pairs of input vertices whose edges are marked sharp.
    undirected:
        (m,) bool triangles of regions where the directions mean nothing.
    features:
        What to run along, if it is known; else hard features by the settings.
    """
    progress.step(0.0)
    if features is None:
        features = find_features(surface, settings, sharp)
    normal = vertex_normals(surface)
    e1, e2 = tangents(normal)
    axis = np.ascontiguousarray((e1 + 1j * e2).T)
    confidence, data = _data(surface, field, normal, axis, undirected, 4)
    weights, area = _weights_and_areas(surface)
    matrix, pull = _laplacian(surface, weights, axis, 4)
    progress.step(0.15)
    feature, wanted = wanted_directions(surface, features, axis)
    smoothing = _length(surface, area, settings.smoothness)
    weight = np.maximum(confidence, LEAST_CONFIDENCE) * area / smoothing**2
    held = np.abs(wanted) * feature
    right = weight * data
    weight = np.where(feature, FEATURE_WEIGHT * pull * held, weight)
    unit = wanted / np.maximum(np.abs(wanted), 1e-12)
    right = np.where(feature, weight * unit, right)
    crest = features.crest_vertex
    extra = CREST_WEIGHT * pull[crest] * features.crest_weight
    weight[crest] += extra
    right[crest] += extra * fourth_power(axis[:, crest], features.crest_direction)
    system = (matrix + sparse.diags_array((weight + 1e-12 * pull).astype(complex))).tocsr()
    u = solve(system, right, progress.part("Solving", 0.15, 0.75))
    u = _smoothest(surface, system, u, confidence, area, feature, progress)
    part = progress.part("Joining singularities", 0.8, 0.9)
    apart = float(np.median(np.minimum(smoothing, _length(surface, area, QUAD_EDGE))))
    u, index = without_dipoles(
        surface, matrix, u, feature, normal, lambda u: _direction(u, e1, e2), apart, part
    )
    direction = _direction(u, e1, e2)
    face_direction = _on_faces(surface, u, axis, progress.part("Carrying to faces", 0.9, 1.0))
    return CrossField(
        direction=direction,
        normal=normal,
        confidence=np.where(feature, held, confidence),
        strength=np.abs(u),
        face_direction=face_direction,
        triangle_index=index,
        smoothing=float(np.median(smoothing)),
    )


def smoothing_length(surface: Surface, smoothness: float) -> float:
    """Length over which a field is smoothed, median over the vertices of the surface."""
    _, area = _weights_and_areas(surface)
    return float(np.median(_length(surface, area, smoothness)))


def smoothness_of(surface: Surface, length: float) -> float:
    """The smoothness, 0 to 1, that smooths over a length: the inverse of `smoothing_length`."""
    shortest = smoothing_length(surface, 0.0)
    if length <= shortest:
        return 0.0
    return min(float(np.log(length / shortest) / np.log(LONGEST / SHORTEST)), 1.0)


def smoothed_lines(
    surface: Surface,
    field: CurvatureField,
    smoothness: float,
    progress: Progress,
    undirected: np.ndarray | None = None,
    held: np.ndarray | None = None,
) -> tuple[DirectionField, np.ndarray]:
    """The principal directions as a smooth line field, and its index (m,) in each triangle.

    As `cross_field`, with second powers: the families stay apart. Features play no part, since
    either family may run along them. The magnitude of the result is the length of u.

    Parameters
    ----------
    held:
        (n,) bool vertices whose directions stay as they are.
    """
    normal = vertex_normals(surface)
    e1, e2 = tangents(normal)
    axis = np.ascontiguousarray((e1 + 1j * e2).T)
    confidence, data = _data(surface, field, normal, axis, undirected, 2)
    weights, area = _weights_and_areas(surface)
    matrix, pull = _laplacian(surface, weights, axis, 2)
    smoothing = _length(surface, area, smoothness)
    weight = np.maximum(confidence, LEAST_CONFIDENCE) * area / smoothing**2
    if held is not None:
        weight = np.where(held, FEATURE_WEIGHT * pull, weight)
    system = (matrix + sparse.diags_array((weight + 1e-12 * pull).astype(complex))).tocsr()
    u = solve(system, weight * data, progress.part("Smoothing the lines", 0.0, 0.8))
    gap = np.abs(u)
    cosine, sine = principal_directions(u.real, u.imag, gap)
    smooth = DirectionField(cosine[:, None] * e1 + sine[:, None] * e2, normal, gap)
    part = progress.part("Counting", 0.8, 1.0)
    return smooth, certified_index(surface, smooth.direction, smooth.across, part)


def _length(surface: Surface, area: np.ndarray, smoothness: float) -> np.ndarray:
    """(n,) length over which a field is smoothed."""
    radius = np.sqrt(_per_component(surface, area) / (4 * np.pi))[surface.component]
    return radius * SHORTEST * (LONGEST / SHORTEST) ** smoothness


def _data(
    surface: Surface,
    field: CurvatureField,
    normal: np.ndarray,
    axis: np.ndarray,
    undirected: np.ndarray | None,
    symmetry: int,
) -> tuple[np.ndarray, np.ndarray]:
    """(n,) confidence in the principal directions, and their powers `symmetry`."""
    gap, noise = field.gap, field.noise
    if not np.isfinite(noise).any():
        noise, _ = field_noise(surface, field.k1, field.k2, field.d1, field.normal)
    d1 = carried(field.d1, field.normal, normal)
    across = np.einsum("cn,nc->n", axis, d1)
    across = across / np.maximum(np.abs(across), 1e-12)
    known = np.isfinite(gap) & np.isfinite(across)
    typical = float(np.median(gap[known])) if known.any() else 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        doubt = (NOISE_RATIO * noise / gap) ** 2 + (WEAK_GAP * typical / gap) ** 2
        confidence = 1.0 / (1.0 + doubt)
    confidence = np.where(known & np.isfinite(confidence), confidence, 0.0)
    if undirected is not None and undirected.any():
        inside = np.ones(len(gap), bool)
        inside[surface.triangles[~undirected]] = False
        confidence[inside] = 0.0
    return confidence, np.where(known, across, 1.0) ** symmetry


def _weights_and_areas(surface: Surface) -> tuple[np.ndarray, np.ndarray]:
    """(3 m,) half the cotangent across from each half-edge; (n,) a third of the areas around."""
    _, area = surface.face_normal_area
    tiny = np.finfo(float).tiny
    weights = np.empty((len(area), 3))

    def block(first: int) -> None:
        rows = slice(first, first + BLOCK)
        a, b, c = (surface.vertices.take(of, axis=0) for of in surface.triangles[rows].T)
        sides = b - a, c - b, a - c
        quarter = 0.25 / np.maximum(area[rows], tiny)
        for k in range(3):
            # The sides that meet across from side k run in opposite senses there.
            product = np.einsum("mc,mc->m", sides[(k + 1) % 3], sides[(k + 2) % 3])
            weights[rows, k] = -quarter * product

    run(block, range(0, len(area), BLOCK), Progress())
    around = np.bincount(
        surface.triangles.ravel(), weights=np.repeat(area / 3.0, 3), minlength=len(surface.vertices)
    )
    return weights.ravel(), np.maximum(around, tiny)


def _laplacian(
    surface: Surface, weights: np.ndarray, axis: np.ndarray, symmetry: int
) -> tuple[sparse.csr_array, np.ndarray]:
    """Connection Laplacian of powers `symmetry`, (n, n), and its diagonal (n,)."""
    n = len(surface.vertices)
    tail = surface.triangles.ravel()
    head = surface.triangles[:, [1, 2, 0]].ravel()
    # One entry for each edge: the first of its half-edges carries both cotangents.
    twin = surface.twin
    first = np.flatnonzero((twin < 0) | (np.arange(len(twin), dtype=np.int32) < twin))
    both = weights[first] + np.where(twin[first] >= 0, weights[twin[first]], 0.0)
    both = np.clip(both, LEAST_WEIGHT, LARGEST_WEIGHT)
    tail, head = tail[first], head[first]
    transport = np.empty(len(first), complex)
    for start in range(0, len(first), BLOCK):
        part = slice(start, start + BLOCK)
        turn = rotation(axis[:, head[part]], axis[:, tail[part]])
        transport[part] = turn**symmetry
    entry = -both * transport
    upper = sparse.coo_array((entry, (tail, head)), shape=(n, n)).tocsr()
    diagonal = np.bincount(tail, weights=both, minlength=n)
    diagonal += np.bincount(head, weights=both, minlength=n)
    matrix = upper + upper.conj().T.tocsr() + sparse.diags_array(diagonal.astype(complex))
    return matrix.tocsr(), diagonal


def _per_component(surface: Surface, values: np.ndarray) -> np.ndarray:
    return np.bincount(surface.component, weights=values)


def _smoothest(
    surface: Surface,
    system: sparse.csr_array,
    u: np.ndarray,
    confidence: np.ndarray,
    area: np.ndarray,
    feature: np.ndarray,
    progress: Progress,
) -> np.ndarray:
    """u, made the smoothest field on components that have no direction of their own."""
    mean = _per_component(surface, confidence * area) / _per_component(surface, area)
    aligned = _per_component(surface, feature.astype(float)) > 0
    free = ((mean < NO_DIRECTION) & ~aligned)[surface.component]
    if not free.any():
        return u
    rows = np.flatnonzero(free)
    part = system[rows][:, rows].tocsr()
    value = u[rows]
    component = surface.component[rows]
    for _ in range(INVERSE_STEPS):
        value = solve(part, area[rows] * value, Progress())
        size = np.sqrt(np.bincount(component, weights=area[rows] * np.abs(value) ** 2))
        value /= np.maximum(size, np.finfo(float).tiny)[component]
    progress.step(0.78)
    u = u.copy()
    scale = np.bincount(component, weights=np.abs(value)) / np.maximum(np.bincount(component), 1)
    u[rows] = value / np.maximum(scale, np.finfo(float).tiny)[component]
    return u


def _direction(u: np.ndarray, e1: np.ndarray, e2: np.ndarray) -> np.ndarray:
    angle = np.angle(u) / 4.0
    return np.cos(angle)[:, None] * e1 + np.sin(angle)[:, None] * e2


def _on_faces(surface: Surface, u: np.ndarray, axis: np.ndarray, progress: Progress) -> np.ndarray:
    """(m, 3) unit direction in each triangle: the mean of its corners' crosses, carried there."""
    normal, _ = surface.face_normal_area
    result = np.empty((len(normal), 3))

    def block(first: int) -> None:
        rows = slice(first, first + BLOCK)
        x, y = frame(normal[rows].T)
        total = np.zeros(x.shape[1], complex)
        own = x + 1j * y
        for corner in surface.triangles[rows].T:
            total += rotation(axis[:, corner], own) ** 4 * u[corner]
        angle = np.angle(total) / 4.0
        result[rows] = (np.cos(angle) * x + np.sin(angle) * y).T

    run(block, range(0, len(normal), BLOCK), progress)
    return result
