"""Surfaces given by functions, meshed in several ways, with their exact crest lines."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull
from surfaces import icosphere
from surfaces.analytic import operators
from surfaces.sampling import outward

from core.mesh.mending.repair import clean
from core.retopology.ridges.find import find_ridges
from core.retopology.ridges.slopes import Slopes

MESHES = ("icosphere", "random", "marching cubes", "decimated")
COUNT, LEVEL = 10_000, 5
# Cells of marching cubes along the longest side, and one triangle in so many that is left.
CELLS, DECIMATION = 70, 4
# The truth is drawn on an icosphere of this level with exact derivatives.
TRUTH_LEVEL = 7
# Step of the derivative of exact curvatures along their directions, on surfaces of size 1.
STEP = 1e-4

Values = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Implicit:
    """The surface F = 0 around the origin, with its gradient (n, 3) and Hessian (n, 3, 3).

    `half` is half of a box around it; `round_` says that every ray from the origin meets it once.
    """

    name: str
    value: Values
    gradient: Values
    hessian: Values
    half: np.ndarray
    round_: bool = True

    def on_rays(self, directions: np.ndarray) -> np.ndarray:
        """Where rays (n, 3) from the origin meet the surface, by bisection."""
        rays = directions * self.half
        low, high = np.zeros(len(rays)), np.full(len(rays), 2.0)
        for _ in range(60):
            middle = 0.5 * (low + high)
            outside = self.value(rays * middle[:, None]) > 0
            low, high = np.where(outside, low, middle), np.where(outside, middle, high)
        return rays * low[:, None]

    def nearest(self, points: np.ndarray, steps: int = 5) -> np.ndarray:
        """Points (n, 3) near the surface, moved onto it by Newton's method."""
        for _ in range(steps):
            gradient = self.gradient(points)
            square = np.einsum("nc,nc->n", gradient, gradient)
            points = points - (self.value(points) / square)[:, None] * gradient
        return points

    def curvature(self, points: np.ndarray) -> tuple[np.ndarray, ...]:
        """k1, k2, d1, d2 and normal at points of the surface."""
        return operators(self.gradient(points), self.hessian(points))

    def slopes(self, points: np.ndarray, unit: float) -> Slopes:
        """Exact slopes at points of the surface, in units of `unit`."""
        k1, k2, d1, d2, normal = self.curvature(points)
        k = np.stack([k1, k2]) * unit
        e, bending = np.empty_like(k), np.empty_like(k)
        for family, d in enumerate((d1, d2)):
            e[family], _ = self._slope(points, family)
            beside = []
            for step in (STEP, -STEP):
                slope, along = self._slope(self.nearest(points + step * d), family)
                beside.append(slope * np.sign(np.einsum("nc,nc->n", along, d)))
            bending[family] = (beside[0] - beside[1]) / (2 * STEP)
        nothing, some = np.zeros_like(k), np.full(len(k1), 1e-3)
        return Slopes(
            k, e * unit**2, bending * unit**3, nothing, np.full_like(k, 1e-9),
            np.stack([d1, d2]), normal, some, some, np.ones(len(k1), bool), k < -np.inf,
        )  # fmt: skip

    def _slope(self, points: np.ndarray, family: int) -> tuple[np.ndarray, np.ndarray]:
        """(n,) derivative of a principal curvature along its direction, and that (n, 3)."""
        d = self.curvature(points)[2 + family]
        ahead, behind = (
            self.curvature(self.nearest(points + step * d))[family] for step in (STEP, -STEP)
        )
        return (ahead - behind) / (2 * STEP), d

    def crests(self) -> list[np.ndarray]:
        """Points (q, 3) of each exact crest line, by the exact zeros of e on a fine mesh."""
        if not self.round_:
            return []
        points, triangles = icosphere(TRUTH_LEVEL)
        surface, _ = clean(self.on_rays(points @ _turn()), triangles)
        slopes = self.slopes(surface.vertices * surface.unit + surface.origin, surface.unit)
        chains = find_ridges(surface, slopes).chains
        lines = np.split(chains.position * surface.unit + surface.origin, chains.start[1:-1])
        return [with_end(line, closed) for line, closed in zip(lines, chains.closed, strict=True)]


def with_end(line: np.ndarray, closed: bool) -> np.ndarray:
    """Points of a line; a closed one comes back to its first."""
    return np.concatenate([line, line[:1]]) if closed else line


def surfaces() -> list[Implicit]:
    return [
        _ellipsoid(),
        _skewed(),
        _power("x⁶ + y⁶ + z⁶ = 1", 6),
        _power("x⁴ + y⁴ + z⁴ = 1", 4),
        _torus(),
        _power("(x/2)⁴ + (y/1.5)⁴ + z⁴ = 1", 4, (2.0, 1.5, 1.0)),
    ]


def meshed(surface: Implicit, mesh: str, seed: int = 0) -> tuple[np.ndarray, np.ndarray] | None:
    """Vertices and triangles of about `COUNT` vertices; None where a package is missing."""
    if mesh == "marching cubes":
        return _marching_cubes(surface)
    if not surface.round_:
        return _torus_grid() if mesh == "icosphere" else None
    if mesh == "decimated":
        return _decimated(surface)
    if mesh == "icosphere":
        points, triangles = icosphere(LEVEL)
        return surface.on_rays(points @ _turn()), triangles
    points = np.random.default_rng(seed).normal(size=(COUNT, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    return surface.on_rays(points), outward(points, ConvexHull(points).simplices.astype(np.int64))


def _turn() -> np.ndarray:
    """A turn that leaves no vertex of an icosphere on a plane of symmetry."""
    return np.linalg.qr(np.array([[2.0, 0.3, 0.5], [-0.2, 3.0, 0.7], [0.4, -0.6, 1.5]]))[0]


def _marching_cubes(surface: Implicit) -> tuple[np.ndarray, np.ndarray] | None:
    try:
        from skimage.measure import marching_cubes
    except ImportError:
        return None
    size = 2 * surface.half.max() / CELLS
    # Off centre, so that no plane of symmetry is one of the grid.
    axes = [np.arange(-half - 0.377 * size, half + 2 * size, size) for half in surface.half]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    values = surface.value(grid.reshape(-1, 3)).reshape(grid.shape[:3])
    points, triangles, _, _ = marching_cubes(values, 0.0)
    points = points.astype(float) * size + [axis[0] for axis in axes]
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    upward = np.einsum("tc,tc->", np.cross(b - a, c - a), surface.gradient((a + b + c) / 3))
    return points, (triangles if upward > 0 else triangles[:, ::-1]).astype(np.int64)


def _decimated(surface: Implicit) -> tuple[np.ndarray, np.ndarray] | None:
    try:
        import fast_simplification
    except ImportError:
        return None
    points, triangles = icosphere(LEVEL + 1)
    points, triangles = fast_simplification.simplify(
        surface.on_rays(points @ _turn()).astype(np.float32),
        triangles.astype(np.int32),
        target_reduction=1 - 1 / DECIMATION,
    )
    return points.astype(float), triangles.astype(np.int64)


def _diagonal(values: np.ndarray) -> np.ndarray:
    return values[:, :, None] * np.eye(3)


def _ellipsoid() -> Implicit:
    axes = np.array([3.0, 2.0, 1.0])
    weight = 1.0 / axes**2
    return Implicit(
        "ellipsoid 3 2 1",
        lambda x: (x * x * weight).sum(axis=1) - 1.0,
        lambda x: 2.0 * x * weight,
        lambda x: _diagonal(np.broadcast_to(2.0 * weight, x.shape)),
        1.1 * axes,
    )


def _skewed() -> Implicit:
    """An ellipsoid without a plane of symmetry: a² + b² + c² + abc/4 + a²c/5 + 3ab²/20 = 1."""
    axes = np.array([3.0, 2.0, 1.0])

    def value(x: np.ndarray) -> np.ndarray:
        a, b, c = (x / axes).T
        cubes = 0.25 * a * b * c + 0.2 * a * a * c + 0.15 * a * b * b
        return a * a + b * b + c * c + cubes - 1.0

    def gradient(x: np.ndarray) -> np.ndarray:
        a, b, c = (x / axes).T
        along_a = 2.0 * a + 0.25 * b * c + 0.4 * a * c + 0.15 * b * b
        along_b = 2.0 * b + 0.25 * a * c + 0.3 * a * b
        return np.stack([along_a, along_b, 2.0 * c + 0.25 * a * b + 0.2 * a * a], axis=1) / axes

    def hessian(x: np.ndarray) -> np.ndarray:
        a, b, c = (x / axes).T
        two = np.full(len(x), 2.0)
        ab, ac, bc = 0.25 * c + 0.3 * b, 0.25 * b + 0.4 * a, 0.25 * a
        rows = [[two + 0.4 * c, ab, ac], [ab, two + 0.3 * a, bc], [ac, bc, two]]
        return np.moveaxis(np.array(rows), 2, 0) / axes[:, None] / axes

    return Implicit("skewed ellipsoid", value, gradient, hessian, 1.3 * axes)


def _power(name: str, power: int, axes: tuple[float, float, float] = (1.0, 1.0, 1.0)) -> Implicit:
    size = np.array(axes)
    return Implicit(
        name,
        lambda x: ((x / size) ** power).sum(axis=1) - 1.0,
        lambda x: power * (x / size) ** (power - 1) / size,
        lambda x: _diagonal(power * (power - 1) * (x / size) ** (power - 2) / size**2),
        1.1 * size,
    )


MAJOR, MINOR = 2.0, 0.8


def _torus() -> Implicit:
    def value(x: np.ndarray) -> np.ndarray:
        return (np.hypot(x[:, 0], x[:, 1]) - MAJOR) ** 2 + x[:, 2] ** 2 - MINOR**2

    def gradient(x: np.ndarray) -> np.ndarray:
        away = np.hypot(x[:, 0], x[:, 1])
        share = 2.0 * (1.0 - MAJOR / np.maximum(away, 1e-12))
        return np.stack([share * x[:, 0], share * x[:, 1], 2.0 * x[:, 2]], axis=1)

    def hessian(x: np.ndarray) -> np.ndarray:
        away = np.hypot(x[:, 0], x[:, 1])
        radial = np.column_stack([x[:, :2] / away[:, None], np.zeros(len(x))])
        flat = np.diag([1.0, 1.0, 0.0])
        along = radial[:, :, None] * radial[:, None]
        share = 2.0 * (1.0 - MAJOR / away)
        return 2.0 * along + share[:, None, None] * (flat - along) + np.diag([0.0, 0.0, 2.0])

    half = np.array([MAJOR + MINOR, MAJOR + MINOR, MINOR]) * 1.05
    return Implicit("torus", value, gradient, hessian, half, round_=False)


def _torus_grid() -> tuple[np.ndarray, np.ndarray]:
    from surfaces import torus

    mesh = torus(MAJOR, MINOR, 150, 64)
    return mesh.vertices, mesh.triangles
