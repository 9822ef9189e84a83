"""Random closed surfaces as people have them: waves on a sphere, metaballs, chains of rings of
genus 1 to 5, out of a grid or decimated, some with noise.

Decimated ones need fast-simplification (tools/benchmark_requirements.txt).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph
from surfaces import ImplicitSurface, icosphere, marching_tetrahedra
from surfaces.implicit import Jet

Mesh = tuple[np.ndarray, np.ndarray]
COUNTS = (400, 1000, 2000, 4000)
# How many have noise, and how much of it, in mean edges.
NOISY, NOISES = 0.3, (0.02, 0.05)


def random_surface(seed: int) -> tuple[str, np.ndarray, np.ndarray, int]:
    """The kind, vertices and triangles of a random closed surface, and a number of quads for it.

    Raises
    ------
    ImportError
        It is decimated, and fast-simplification is not there.
    """
    random = np.random.default_rng(seed)
    kinds: tuple[tuple[str, Callable[[np.random.Generator], Mesh]], ...] = (
        ("waves", waves),
        ("metaballs", metaballs),
        ("rings", rings),
        ("decimated", decimated),
    )
    name, make = kinds[seed % len(kinds)]
    vertices, triangles = make(random)
    if random.random() < NOISY:
        edge = np.linalg.norm(vertices[triangles[:, 0]] - vertices[triangles[:, 1]], axis=1).mean()
        vertices = vertices + edge * random.choice(NOISES) * random.normal(size=vertices.shape)
        name += ", noisy"
    return name, vertices, triangles, int(random.choice(COUNTS))


def waves(random: np.random.Generator) -> Mesh:
    """Waves on a stretched sphere."""
    points, triangles = icosphere(int(random.integers(4, 6)))
    axes = random.normal(size=(14, 3))
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    radius = np.ones(len(points))
    for axis in axes:
        wave = np.cos(random.uniform(1.5, 4.0) * (points @ axis) + random.uniform(0.0, 6.0))
        radius += 0.12 * random.normal() * wave
    return points * np.maximum(radius, 0.25)[:, None] * random.uniform(0.5, 1.5, 3), triangles


def metaballs(random: np.random.Generator) -> Mesh:
    """The largest piece of a level of Gaussians."""
    count = int(random.integers(3, 8))
    centre, spread = random.uniform(-0.9, 0.9, (count, 3)), random.uniform(0.35, 0.7, count)

    def function(x: Jet, y: Jet, z: Jet) -> Jet:
        total = None
        for (a, b, c), s in zip(centre.tolist(), spread.tolist(), strict=True):
            square = (x - a) ** 2 + (y - b) ** 2 + (z - c) ** 2
            ball = (-2.0 / (s * s) * square + 2.0).exp()
            total = ball if total is None else total + ball
        return total * -1.0 + 1.0

    surface = ImplicitSurface("metaballs", function, 2.4)
    return largest(*marching_tetrahedra(surface, int(random.integers(24, 40))))


def rings(random: np.random.Generator) -> Mesh:
    """Tilted rings in a chain, smoothly joined: as many handles as rings."""
    count = int(random.integers(1, 6))
    along = np.cumsum(np.concatenate([[0.0], random.uniform(1.1, 1.5, count - 1)]))
    along -= along.mean()
    tilt, thick = random.uniform(-0.5, 0.5, count), random.uniform(0.18, 0.3, count)

    def function(x: Jet, y: Jet, z: Jet) -> Jet:
        total = None
        for at, turn, radius in zip(along.tolist(), tilt.tolist(), thick.tolist(), strict=True):
            cosine, sine = float(np.cos(turn)), float(np.sin(turn))
            u, v, w = x - at, cosine * y - sine * z, sine * y + cosine * z
            off = (u * u + v * v + 1e-12) ** 0.5 - 0.75
            far = ((off * off + w * w + 1e-12) ** 0.5 - radius) * -14.0
            total = far.exp() if total is None else total + far.exp()
        return total * -1.0 + 1.0

    surface = ImplicitSurface("rings", function, float(along.max()) + 1.3, round=False)
    cells = int(random.integers(28, 40)) + 6 * count
    return largest(*marching_tetrahedra(surface, cells))


def decimated(random: np.random.Generator) -> Mesh:
    """One of the others with edges collapsed by quadrics."""
    import fast_simplification

    vertices, triangles = (waves, metaballs, rings)[int(random.integers(3))](random)
    vertices, triangles = fast_simplification.simplify(
        vertices.astype(np.float32),
        triangles.astype(np.int32),
        target_reduction=float(random.uniform(0.4, 0.85)),
    )
    return vertices.astype(float), triangles.astype(np.int64)


def largest(vertices: np.ndarray, triangles: np.ndarray) -> Mesh:
    """The connected piece with the most triangles."""
    ends = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
    n = len(vertices)
    graph = sparse.coo_array((np.ones(len(ends[0])), ends), shape=(n, n))
    _, label = csgraph.connected_components(graph, directed=False)
    of = label[triangles[:, 0]]
    triangles = triangles[of == np.bincount(of).argmax()]
    rows, corner = np.unique(triangles, return_inverse=True)
    return vertices[rows], corner.reshape(-1, 3)
