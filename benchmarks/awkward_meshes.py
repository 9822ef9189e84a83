"""Meshes that ask more of a detection than an even one of their size, for `benchmarks.speed`."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from surfaces import ellipsoid, icosphere, noisy
from surfaces.parts import plate, turned

from .cases import random_mobius

AXES = (3.0, 2.0, 1.0)
# Length over width of the stretched triangles.
STRETCH = 8.0

Mesh = tuple[np.ndarray, np.ndarray]


def awkward_meshes(level: int) -> Iterator[tuple[str, Mesh]]:
    """Names and meshes of about 20 * 4^level triangles; the first is the even one."""
    even = ellipsoid(AXES, level)
    yield "even", (even.vertices, even.triangles)
    yield "even, single precision", (even.vertices.astype(np.float32), even.triangles)
    for share in (0.02, 0.1):
        shaken = noisy(even, share)
        yield f"noise of {share:.0%} of an edge", (shaken.vertices, shaken.triangles)
    # On the sphere, so that the ellipsoid's own stretch of 3 comes on top.
    points, triangles = icosphere(level)
    points = points * (1.0, 1.0, STRETCH)
    points /= np.linalg.norm(points, axis=1)[:, None]
    yield f"stretched by {STRETCH:.0f} at the sides", (points * AXES, triangles)
    image = random_mobius(seed=0, reach=max(AXES))
    yield "graded", (image(even.vertices), np.ascontiguousarray(triangles[:, ::-1]))
    count = len(triangles)
    profile = np.array([0.0, 2.0, 2.0, 1.0, 1.0, 0.0]), np.array([0.0, 0.0, 2.0, 3.0, 5.0, 5.0])
    yield "part: a turned shaft in long strips", turned(*profile, around=count // 8)
    # A hole takes about four triangles for each of its sides.
    yield "part: a plate with holes", plate(holes=round(np.sqrt(count / (4 * 96))), around=96)
