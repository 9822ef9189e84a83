"""Meshes as files in the wild have them: damaged, degenerate, one-sided, of every size.

Each takes a random generator and gives (n, 3) vertices and (m, 3) triangles, a few hundred at
most.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .sampling import grid_points, icosphere

Mesh = tuple[np.ndarray, np.ndarray]
Random = np.random.Generator


def joined(parts: list[Mesh]) -> Mesh:
    """Several meshes as one."""
    first = np.cumsum([0] + [len(points) for points, _ in parts])
    triangles = [faces + at for (_, faces), at in zip(parts, first, strict=False)]
    return np.concatenate([points for points, _ in parts]), np.concatenate(triangles)


def soup(random: Random) -> Mesh:
    """Triangles that join any vertices at all."""
    count = int(random.integers(3, 40))
    triangles = random.integers(0, count, (int(random.integers(1, 80)), 3))
    return random.normal(size=(count, 3)), triangles


def soup_on_a_grid(random: Random) -> Mesh:
    """As `soup`, with coincident vertices and corners in a line."""
    points, triangles = soup(random)
    return np.rint(points), triangles


def blob(random: Random) -> Mesh:
    """A bumpy ball."""
    points, triangles = icosphere(2)
    height = sum(
        0.1 * random.normal() * np.cos(3.0 * points @ random.normal(size=3)) for _ in range(5)
    )
    return points * np.maximum(1.0 + height, 0.3)[:, None], triangles


def graph(random: Random) -> Mesh:
    """A sheet over a square: waves, a monkey saddle, a bowl, noise or a plane."""
    cells = random.integers(2, 14, 2)
    points, triangles = grid_points(*map(int, cells), (-1.0, -1.0), (1.0, 1.0))
    x, y = points.T
    heights = (0.3 * np.sin(5 * x) * np.cos(4 * y), x**3 - 3 * x * y * y, x * x + y * y)
    heights += (0.1 * random.normal(size=len(x)), 0.0 * x)
    return np.column_stack([x, y, heights[random.integers(len(heights))]]), triangles


def moebius(random: Random) -> Mesh:
    """A one-sided strip."""
    around, across = int(random.integers(8, 40)), int(random.integers(1, 5))
    u, v = np.meshgrid(
        2 * np.pi * np.arange(around) / around, np.linspace(-0.4, 0.4, across + 1), indexing="ij"
    )
    radius = 1.0 + v * np.cos(u / 2)
    points = np.stack([radius * np.cos(u), radius * np.sin(u), v * np.sin(u / 2)], axis=-1)
    row = np.arange(around * (across + 1)).reshape(around, across + 1)
    after = np.vstack([row[1:], row[:1, ::-1]])
    a, b, c, d = (some.ravel() for some in (row[:, :-1], after[:, :-1], after[:, 1:], row[:, 1:]))
    return points.reshape(-1, 3), np.concatenate([np.c_[a, b, c], np.c_[a, c, d]])


def fan(random: Random) -> Mesh:
    """A cone with one vertex of many edges, open below, sometimes flat."""
    count = int(random.choice([3, 7, 60]))
    angle = np.sort(random.uniform(0, 2 * np.pi, count))
    rim = random.uniform(0.5, 1.5, (count, 1)) * np.column_stack([np.cos(angle), np.sin(angle)])
    points = np.vstack([[0.0, 0.0, random.choice([0.0, 1.0])], np.c_[rim, np.zeros(count)]])
    row = 1 + np.arange(count)
    return points, np.c_[0 * row, row, np.roll(row, -1)]


def spiked(random: Random) -> Mesh:
    """A ball with vertices far out."""
    points, triangles = icosphere(2)
    out = random.integers(0, len(points), 8)
    points = points.copy()
    points[out] *= random.uniform(1.5, 6.0, (8, 1))
    return points, triangles


def shells(random: Random) -> Mesh:
    """One ball in another, wound either way."""
    points, triangles = blob(random)
    inner = triangles[:, ::-1] if random.random() < 0.5 else triangles
    return joined([(points, triangles), (0.6 * points, inner)])


def sheets(random: Random) -> Mesh:
    """Two sides of a thin sheet."""
    points, triangles = graph(random)
    away = np.array([0.0, 0.0, 10.0 ** random.uniform(-9, -2)])
    return joined([(points, triangles), (points + away, triangles[:, ::-1])])


def slit(random: Random) -> Mesh:
    """Every triangle with vertices of its own, as STL has them."""
    points, triangles = blob(random)
    return points[triangles].reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3)


def fins(random: Random) -> Mesh:
    """A ball with triangles that stand on its edges, and two of its vertices made one."""
    points, triangles = blob(random)
    foot = triangles[random.integers(0, len(triangles), 6)][:, :2]
    fin = np.column_stack([foot, len(points) + np.arange(6)])
    points = np.concatenate([points, 1.5 * points[foot[:, 0]]])
    one, other = random.integers(0, len(points), 2)
    triangles = np.concatenate([triangles, fin])
    return points, np.where(triangles == one, other, triangles)


def stretched(random: Random) -> Mesh:
    """Needles: one axis is much longer or shorter than the others."""
    points, triangles = blob(random)
    factor = np.ones(3)
    factor[random.integers(3)] = 10.0 ** random.uniform(-6, 3)
    return points * factor, triangles


def pinched(random: Random) -> Mesh:
    """Edges that hardly have a length, or none."""
    points, triangles = blob(random)
    one, other = triangles[random.integers(0, len(triangles), 8)][:, :2].T
    size = random.choice([0.0, 1e-18, 1e-9, 1e-4])
    points = points.copy()
    points[one] = points[other] + size * random.normal(size=(8, 3))
    return points, triangles


def stray(random: Random) -> Mesh:
    """A vertex or two so far away that nothing else has a size beside them."""
    points, triangles = (blob, graph)[random.integers(2)](random)
    points = points.copy()
    rows = random.integers(0, len(points), int(random.integers(1, 3)))
    points[rows] *= 10.0 ** random.uniform(2, 200)
    return points, triangles


def far(random: Random) -> Mesh:
    """So far from the origin that coordinates lose digits, up to all of them."""
    points, triangles = blob(random)
    return points + 10.0 ** random.uniform(1, 17) * random.normal(size=3), triangles


def broken(random: Random) -> Mesh:
    """Holes, turned and doubled triangles, coordinates that are no numbers, loose vertices."""
    points, triangles = blob(random)
    points = np.concatenate([points, 50.0 * random.normal(size=(5, 3))])
    triangles = triangles[random.random(len(triangles)) > random.choice([0.02, 0.5])]
    turned = random.random(len(triangles)) < 0.1
    triangles[turned] = triangles[turned][:, ::-1]
    points[random.integers(0, len(points), 2), random.integers(0, 3, 2)] = random.choice(
        [np.nan, np.inf, -np.inf], 2
    )
    return points, np.concatenate([triangles, triangles[:5]])


def boxes(random: Random) -> Mesh:
    """Faces of random cells of a grid, as voxels are exported: flat, with edges of four faces."""
    size = int(random.integers(2, 5))
    full = np.pad(random.random((size, size, size)) < 0.5, 1)
    full[1, 1, 1] = True
    points, triangles = [], []
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    for axis in range(3):
        for side in (0, 1):
            open_ = full & ~np.roll(full, 1 - 2 * side, axis)
            for cell in np.argwhere(open_):
                corner = np.zeros((4, 3))
                corner[:, axis], corner[:, axis - 2], corner[:, axis - 1] = side, *square.T
                first = 4 * len(points)
                wound = [0, 1, 2, 0, 2, 3] if side else [2, 1, 0, 3, 2, 0]
                triangles.append(first + np.array(wound).reshape(2, 3))
                points.append(corner + cell)
    found, row = np.unique(np.concatenate(points), axis=0, return_inverse=True)
    return found, row.ravel()[np.concatenate(triangles)]


KINDS: tuple[Callable[[Random], Mesh], ...] = (
    soup, soup_on_a_grid, blob, graph, moebius, fan, spiked, shells, sheets, slit, fins, stretched,
    pinched, stray, far, broken, boxes,
)  # fmt: skip
