"""Surfaces made of surfaces: inversions, similarities, renumbering, noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .analytic import AnalyticSurface


def inverted(
    surface: AnalyticSurface, centre: tuple[float, float, float], radius: float = 1.0
) -> AnalyticSurface:
    """Image under the inversion x -> c + r^2 (x - c) / |x - c|^2, c outside a closed surface.

    Inversion preserves lines of curvature and umbilics. It reverses orientation, so the
    triangles are wound the other way; the outward normal is the reflected one and
    k' = (|x - c|^2 k - 2 (x - c).n) / r^2.
    """
    offset = surface.vertices - np.array(centre)
    square = np.einsum("ij,ij->i", offset, offset)
    direction = offset / np.sqrt(square)[:, None]

    def reflected(vectors: np.ndarray) -> np.ndarray:
        return vectors - 2.0 * np.einsum("ij,ij->i", vectors, direction)[:, None] * direction

    shift = 2.0 * np.einsum("ij,ij->i", offset, surface.normal)
    normal, d1 = reflected(surface.normal), reflected(surface.d1)
    away = surface.umbilics.position - np.array(centre)
    factor = radius**2 / np.einsum("ij,ij->i", away, away)
    return replace(
        surface,
        name=f"inverted {surface.name}",
        vertices=np.array(centre) + offset * (radius**2 / square)[:, None],
        triangles=np.ascontiguousarray(surface.triangles[:, ::-1]),
        k1=(square * surface.k1 - shift) / radius**2,
        k2=(square * surface.k2 - shift) / radius**2,
        d1=d1,
        d2=np.cross(normal, d1),
        normal=normal,
        umbilics=replace(surface.umbilics, position=np.array(centre) + away * factor[:, None]),
    )


def similar(
    surface: AnalyticSurface,
    scale: float = 1.0,
    rotation: np.ndarray | None = None,
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> AnalyticSurface:
    """x -> scale * rotation x + offset; `rotation` is a proper (3, 3) rotation."""
    turn = np.eye(3) if rotation is None else np.asarray(rotation)
    return replace(
        surface,
        vertices=scale * surface.vertices @ turn.T + np.array(offset),
        k1=surface.k1 / scale,
        k2=surface.k2 / scale,
        d1=surface.d1 @ turn.T,
        d2=surface.d2 @ turn.T,
        normal=surface.normal @ turn.T,
        umbilics=replace(
            surface.umbilics,
            position=scale * surface.umbilics.position @ turn.T + np.array(offset),
        ),
    )


def renumbered(surface: AnalyticSurface, seed: int = 0) -> AnalyticSurface:
    """The same surface with vertices, triangles and the corners they start at shuffled."""
    random = np.random.default_rng(seed)
    n, m = len(surface.vertices), len(surface.triangles)
    order = random.permutation(n)
    place = np.empty(n, dtype=np.int64)
    place[order] = np.arange(n)
    triangles = place[surface.triangles[random.permutation(m)]]
    turn = (np.arange(3) + random.integers(0, 3, size=m)[:, None]) % 3
    arrays = {
        name: getattr(surface, name)[order]
        for name in ("vertices", "k1", "k2", "d1", "d2", "normal")
    }
    return replace(surface, triangles=np.take_along_axis(triangles, turn, axis=1), **arrays)


def noisy(
    surface: AnalyticSurface, fraction_of_local_edge: float, seed: int = 0
) -> AnalyticSurface:
    """Vertices moved at random: per coordinate a normal deviation of the given fraction of the
    mean edge length around the vertex. Operators and umbilics stay those of the true surface."""
    random = np.random.default_rng(seed)
    deviation = fraction_of_local_edge * surface.local_edge[:, None]
    vertices = surface.vertices + deviation * random.normal(size=surface.vertices.shape)
    return replace(surface, name=f"noisy {surface.name}", vertices=vertices)
