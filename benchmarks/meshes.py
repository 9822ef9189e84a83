"""The kinds of mesh that people have, of closed implicit surfaces: on the surface, coarse,
marching cubes, decimated by quadrics.

Needs scikit-image and fast-simplification, which `tools/run_in_benchmark_python.py` brings.
"""

from __future__ import annotations

from collections.abc import Callable

import fast_simplification
import numpy as np
from scipy.spatial import ConvexHull
from skimage.measure import marching_cubes
from surfaces import ImplicitSurface, icosphere
from surfaces.sampling import outward

Mesh = tuple[np.ndarray, np.ndarray]

# A turn that leaves no vertex on a plane of symmetry.
TURN, _ = np.linalg.qr(np.array([[2.0, 0.3, 0.5], [-0.2, 3.0, 0.7], [0.4, -0.6, 1.5]]))
# Cells along a side of the grid from whose surface meshes of any topology are thinned out.
DENSE = 140


def voxels(surface: ImplicitSurface, cells: int) -> Mesh:
    """Marching cubes on a grid of so many cells along each side of the surface's cube."""
    axis = np.linspace(-surface.half, surface.half, cells + 1)
    points = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
    # Turned: people's surfaces do not lie along the grid.
    volume = surface.values(points @ TURN).reshape([cells + 1] * 3)
    vertices, triangles, _, _ = marching_cubes(volume, 0.0, allow_degenerate=False)
    vertices = (vertices * (axis[1] - axis[0]) - surface.half) @ TURN
    return vertices.astype(float), _outward(vertices, triangles.astype(np.int64))


def _outward(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    a, b, c = vertices[triangles].transpose(1, 0, 2)
    inside_out = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() < 0
    return np.ascontiguousarray(triangles[:, ::-1]) if inside_out else triangles


def decimated(surface: ImplicitSurface, triangles: int, dense: Mesh | None = None) -> Mesh:
    """A dense mesh of the surface with its edges collapsed by quadrics."""
    vertices, faces = dense or projected_voxels(surface, DENSE)
    share = 1.0 - triangles / len(faces)
    vertices, faces = fast_simplification.simplify(
        vertices.astype(np.float32), faces.astype(np.int32), max(share, 0.0)
    )
    return vertices.astype(float), faces.astype(np.int64)


def projected_voxels(surface: ImplicitSurface, cells: int) -> Mesh:
    """Marching cubes with every vertex moved onto the surface."""
    vertices, triangles = voxels(surface, cells)
    return surface.projected(vertices), triangles


def regular(surface: ImplicitSurface, count: int) -> Mesh:
    """About `count` vertices on the surface: an icosphere or, where rays meet the surface more
    than once, a decimated mesh whose vertices are moved onto it."""
    if not surface.round:
        vertices, triangles = decimated(surface, 2 * count)
        return surface.projected(vertices), triangles
    points, triangles = icosphere(max(round(np.log(count / 10.0) / np.log(4.0)), 1))
    return surface.on_rays(points @ TURN), triangles


def random(surface: ImplicitSurface, count: int, seed: int) -> Mesh:
    """Random directions from the origin; as `regular` where rays will not do."""
    if not surface.round:
        return regular(surface, count)
    points = np.random.default_rng(seed).normal(size=(count, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    triangles = outward(points, ConvexHull(points).simplices.astype(np.int64))
    return surface.on_rays(points), triangles


KINDS: dict[str, Callable[[ImplicitSurface, int], Mesh]] = {
    "regular": lambda surface, seed: regular(surface, 10_000),
    "random": lambda surface, seed: random(surface, 10_000, seed),
    "coarse regular": lambda surface, seed: regular(surface, 640),
    "coarse random": lambda surface, seed: random(surface, 1_500, seed),
    "marching cubes 64": lambda surface, seed: voxels(surface, 64),
    "marching cubes 36": lambda surface, seed: voxels(surface, 36),
    "decimated 10000": lambda surface, seed: decimated(surface, 10_000),
    "decimated 4000": lambda surface, seed: decimated(surface, 4_000),
}
"""Maker of each kind of mesh from a surface and a seed, about so many vertices, triangles of the
decimated ones, or cells along a side of the grid."""
