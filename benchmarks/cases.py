"""The meshes of the accuracy benchmark: known surfaces, meshed in three ways."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.spatial import ConvexHull, Delaunay, cKDTree
from surfaces import (
    UmbilicPoints,
    ellipsoid,
    grid_points,
    icosphere,
    monkey_saddle,
    paraboloid,
    quartic,
    random_points,
    seed_patch,
)
from surfaces.sampling import outward

MESHES = ("regular", "random", "stretched")
COUNT = 10_000
"""Vertices of a mesh, about."""

STRETCH = 4.0
"""Length over width of the triangles of stretched meshes."""

GRADED = "graded"
"""A mesh of random points that lie the denser, the larger x; of closed surfaces only."""

GRADING = 1.4
"""Their density on the unit sphere is exp(GRADING x)."""


@dataclass(frozen=True)
class Case:
    """A mesh with its true umbilics.

    `everywhere` says that every point is an umbilic. `euler` is the Euler characteristic of a
    closed surface, None of an open one. Nearer to the points `blind` (b, 3) than `blind_reach` (b,)
    nothing is known of umbilics.
    """

    surface: str
    mesh: str
    noise: float
    vertices: np.ndarray
    triangles: np.ndarray
    umbilics: UmbilicPoints
    everywhere: bool = False
    euler: int | None = None
    blind: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    blind_reach: np.ndarray = field(default_factory=lambda: np.zeros(0))

    def asked_at(self, points: np.ndarray) -> np.ndarray:
        """(k,) bool, points (k, 3) at which umbilics are known."""
        away = np.linalg.norm(points[:, None] - self.blind, axis=2)
        return np.asarray((away >= self.blind_reach).all(axis=1))

    def edge_at(self, points: np.ndarray) -> np.ndarray:
        """(k,) mean edge around the vertices nearest to points (k, 3)."""
        if len(points) == 0:
            return np.zeros(0)
        return self._around()[cKDTree(self.vertices).query(points)[1]]

    def _around(self) -> np.ndarray:
        """(n,) mean length of the sides that meet in each vertex."""
        sides = self._sides()
        both = (sides + np.roll(sides, 1, axis=1)).ravel() / 2
        corners = self.triangles.ravel()
        return np.bincount(corners, both) / np.bincount(corners)

    def _sides(self) -> np.ndarray:
        corners = self.vertices[self.triangles]
        return np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)

    def with_noise(self, noise: float, seed: int, share: np.ndarray | float = 1.0) -> Case:
        """Every coordinate moved by normal deviates of `noise` times the edges around it, times
        the `share` (n,) of each vertex."""
        if noise == 0.0:
            return self
        shift = np.random.default_rng(seed).normal(size=self.vertices.shape)
        size = noise * share * self._around()
        return replace(self, noise=noise, vertices=self.vertices + size[:, None] * shift)


def _ball(mesh: str, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Points of the unit sphere and their triangles."""
    if mesh in ("random", GRADED):
        random = np.random.default_rng(seed)
        # As many as needed are left where the grading takes two of three away.
        points = random.normal(size=(COUNT if mesh == "random" else 5 * COUNT, 3))
        points /= np.linalg.norm(points, axis=1)[:, None]
        if mesh == GRADED:
            dense = random.random(len(points)) < np.exp(GRADING * (points[:, 0] - 1.0))
            points = points[dense][:COUNT]
        return points, outward(points, ConvexHull(points).simplices.astype(np.int64))
    points, triangles = icosphere(5)
    # A turn that leaves no vertex on a plane of symmetry.
    turn, _ = np.linalg.qr(np.array([[2.0, 0.3, 0.5], [-0.2, 3.0, 0.7], [0.4, -0.6, 1.5]]))
    points = points @ turn
    if mesh == "stretched":
        points = points * np.array([1.0, 1.0, STRETCH])
        points /= np.linalg.norm(points, axis=1)[:, None]
    return points, triangles


def _rectangle(
    mesh: str, half: float, seed: int, periodic: bool = False
) -> tuple[np.ndarray, np.ndarray]:
    """Points of the square [-half, half]^2 and their triangles, joined at the sides if periodic."""
    low, high = (-half, -half), (half, half)
    if mesh == "random" and not periodic:
        return random_points(COUNT, low, high, seed)
    if mesh == "random":
        points = np.random.default_rng(seed).uniform(low, high, (COUNT, 2))
        tiles = [np.array([i, j]) * 2 * half for i in (0, -1, 1) for j in (0, -1, 1)]
        copies = Delaunay(np.concatenate([points + tile for tile in tiles]))
        # Each triangle has nine copies; the one whose centre lies in the square stays.
        centre = copies.points[copies.simplices].mean(axis=1)
        inside = ((centre >= low) & (centre < high)).all(axis=1)
        corners = copies.points[copies.simplices[inside]]
        u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        triangles = copies.simplices[inside] % COUNT
        clockwise = u[:, 0] * v[:, 1] < u[:, 1] * v[:, 0]
        triangles[clockwise] = triangles[clockwise][:, ::-1]
        return points, triangles.astype(np.int64)
    side = np.sqrt(COUNT)
    ratio = np.sqrt(STRETCH) if mesh == "stretched" else 1.0
    # Odd numbers: no vertex in the middle.
    columns, rows = (2 * round(side * factor / 2) + 1 for factor in (ratio, 1 / ratio))
    points, triangles = grid_points(columns, rows, low, high)
    if periodic:
        number = np.arange(len(points)).reshape(rows + 1, columns + 1)
        number[-1], number[:, -1] = number[0], number[:, 0]
        used, place = np.unique(number, return_inverse=True)
        return points[used], place.ravel()[triangles]
    return points, triangles


def _ellipsoid(axes: tuple[float, float, float]) -> Callable[[str, int], Case]:
    def make(mesh: str, seed: int) -> Case:
        points, triangles = _ball(mesh, seed)
        truth = ellipsoid(axes, 0).umbilics
        return Case("", mesh, 0.0, points * axes, triangles, truth, euler=2)

    return make


def _mobius(axes: tuple[float, float, float], seed: int) -> Callable[[str, int], Case]:
    """An ellipsoid inverted in a random sphere, then turned, scaled and moved at random."""

    def make(mesh: str, mesh_seed: int) -> Case:
        case = _ellipsoid(axes)(mesh, mesh_seed)
        image = random_mobius(seed, reach=max(axes))
        umbilics = replace(case.umbilics, position=image(case.umbilics.position))
        # An inversion turns the surface inside out.
        return replace(
            case,
            vertices=image(case.vertices),
            triangles=np.ascontiguousarray(case.triangles[:, ::-1]),
            umbilics=umbilics,
        )

    return make


def random_mobius(seed: int, reach: float) -> Callable[[np.ndarray], np.ndarray]:
    """A random inversion with its centre 1.4 to 3 times `reach` away, and a similarity."""
    random = np.random.default_rng(seed)
    away = random.normal(size=3)
    centre = reach * random.uniform(1.4, 3.0) * away / np.linalg.norm(away)
    turn, triangle = np.linalg.qr(random.normal(size=(3, 3)))
    turn = turn * np.sign(np.diag(triangle))
    turn = turn * np.sign(np.linalg.det(turn))
    scale, shift = 10.0 ** random.uniform(-2, 2), random.normal(size=3)

    def image(points: np.ndarray) -> np.ndarray:
        offset = points - centre
        square = np.einsum("ij,ij->i", offset, offset)[:, None]
        return scale * (reach**2 * offset / square @ turn.T + shift)

    return image


def _quartic(mesh: str, seed: int) -> Case:
    points, triangles = _ball(mesh, seed)
    vertices = points / (points**4).sum(axis=1)[:, None] ** 0.25
    return Case("", mesh, 0.0, vertices, triangles, quartic(0).umbilics, euler=2)


def _sphere(mesh: str, seed: int) -> Case:
    points, triangles = _ball(mesh, seed)
    return Case("", mesh, 0.0, points, triangles, UmbilicPoints.none(), True, 2)


def _torus(mesh: str, seed: int) -> Case:
    angles, triangles = _rectangle(mesh, np.pi, seed, periodic=True)
    u, v = angles.T
    radial = 2.0 + 0.8 * np.cos(v)
    vertices = np.column_stack([radial * np.cos(u), radial * np.sin(u), 0.8 * np.sin(v)])
    return Case("", mesh, 0.0, vertices, triangles, UmbilicPoints.none(), euler=0)


def _graph(
    height: Callable[[np.ndarray, np.ndarray], np.ndarray], half: float, truth: UmbilicPoints
) -> Callable[[str, int], Case]:
    def make(mesh: str, seed: int) -> Case:
        points, triangles = _rectangle(mesh, half, seed)
        vertices = np.column_stack([points, height(*points.T)])
        return Case("", mesh, 0.0, vertices, triangles, truth)

    return make


def _patch_height(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return 0.5 * (x * x + y * y) + 1.2 * x**3 - 0.5 * x * x * y + 0.2 * x * y * y + 1.6 * y**3


def _makers() -> dict[str, Callable[[str, int], Case]]:
    return {
        "ellipsoid 3 2 1": _ellipsoid((3.0, 2.0, 1.0)),
        "ellipsoid 1.3 1 0.8": _ellipsoid((1.3, 1.0, 0.8)),
        "Möbius image 1": _mobius((1.5, 1.0, 0.7), 1),
        "Möbius image 2": _mobius((1.3, 1.1, 0.8), 2),
        "x⁴ + y⁴ + z⁴ = 1": _quartic,
        "paraboloid": _graph(
            lambda x, y: x * x / 4.0 + y * y / 2.0, 2.0, paraboloid(cells=4).umbilics
        ),
        "monkey saddle": _graph(
            lambda x, y: x**3 - 3.0 * x * y * y, 1.0, monkey_saddle(cells=3).umbilics
        ),
        "patch": _graph(_patch_height, 1.2, seed_patch(10).umbilics),
        "torus": _torus,
        "sphere": _sphere,
    }


def make(surface: str, mesh: str, seed: int) -> Case:
    """A surface of the benchmark on one of its kinds of mesh, without noise."""
    return replace(_makers()[surface](mesh, seed), surface=surface)


def cases(noises: tuple[float, ...], seed: int = 0) -> Iterator[Case]:
    """Every surface on every mesh with every noise (fractions of the edges)."""
    for surface in _makers():
        for mesh in MESHES:
            clean = make(surface, mesh, seed)
            for noise in noises:
                yield clean.with_noise(noise, seed + 1)
