"""Planes of symmetry, of a mesh and of its umbilics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize
from scipy.spatial import cKDTree
from surfaces.blobs import random_sphere, star

import core
from core.matching.closest_points import rotation_by
from core.mesh.samples import points_at

from .page import Page, number


@dataclass(frozen=True)
class Mirror:
    """The plane n.x = c; `residual` is the median distance that mirroring leaves."""

    normal: np.ndarray
    offset: float
    residual: float

    def image(self, points: np.ndarray) -> np.ndarray:
        """(k, 3) mirrored points."""
        return points - 2.0 * (points @ self.normal - self.offset)[:, None] * self.normal


def of_mesh(vertices: np.ndarray) -> Mirror:
    """The plane, near one across a coordinate axis, that mirrors the vertices best."""
    sample = vertices[:: max(len(vertices) // 1000, 1)]
    tree = cKDTree(vertices)
    size = np.ptp(vertices, axis=0).max()

    def mirror(parameters: np.ndarray, axis: int) -> tuple[np.ndarray, float]:
        normal = np.eye(3)[axis].copy()
        normal[[(axis + 1) % 3, (axis + 2) % 3]] = parameters[1:]
        return normal / np.linalg.norm(normal), parameters[0] * size

    def residual(parameters: np.ndarray, axis: int) -> float:
        plane = Mirror(*mirror(parameters, axis), 0.0)
        distance, _ = tree.query(plane.image(sample))
        # The mean of what is well mirrored: parts without a counterpart must not pull.
        return float(np.sort(distance)[: int(0.8 * len(distance))].mean())

    best = None
    for axis in range(3):
        middle = 0.5 * (vertices[:, axis].min() + vertices[:, axis].max()) / size
        for shift in (-0.04, 0.0, 0.04):
            start = (middle + shift, 0.0, 0.0)
            found = minimize(residual, start, args=(axis,), method="Nelder-Mead")
            if best is None or found.fun < best[0]:
                best = (found.fun, *mirror(found.x, axis))
    plane = Mirror(best[1], float(best[2]), 0.0)
    distance, _ = tree.query(plane.image(sample))
    return Mirror(plane.normal, plane.offset, float(np.median(distance)))


def mirrored_share(
    umbilics: core.Umbilics, mirror: Mirror, reach: float, vertices: np.ndarray
) -> tuple[float, float]:
    """The share of umbilics with one of their index within `reach` of their mirror image, and
    the same for vertices taken at random."""
    hits, chance = 0, 0.0
    for sign in (-1.0, 1.0):
        rows = np.sign(umbilics.index) == sign
        if not rows.any():
            continue
        points = umbilics.position[rows]
        tree = cKDTree(points)
        hits += np.count_nonzero(tree.query(mirror.image(points))[0] <= reach)
        near = tree.query(mirror.image(vertices))[0] <= reach
        chance += near.mean() * len(points)
    return hits / max(len(umbilics), 1), chance / max(len(umbilics), 1)


def from_umbilics(umbilics: core.Umbilics, reach: float) -> Mirror:
    """The plane between two umbilics that mirrors most of them onto others.

    Every two umbilics of the same index whose curvatures differ by less than a fifth propose
    the plane half way between them; those that are mirrored within `reach` vote.
    """
    position, index, curvature = umbilics.position, umbilics.index, umbilics.curvature
    first, second = np.triu_indices(len(umbilics), 1)
    alike = (index[first] == index[second]) & (
        np.abs(curvature[first] - curvature[second])
        < 0.2 * np.maximum(np.abs(curvature[first]), np.abs(curvature[second]))
    )
    first, second = first[alike], second[alike]
    step = position[second] - position[first]
    length = np.linalg.norm(step, axis=1)
    far = length > 5.0 * reach
    normal = step[far] / length[far, None]
    offset = np.einsum("ij,ij->i", normal, 0.5 * (position[first] + position[second])[far])
    trees = {sign: cKDTree(position[index == sign]) for sign in np.unique(index)}
    best, most = Mirror(np.array([1.0, 0.0, 0.0]), 0.0, np.nan), -1.0
    for n, c in zip(normal, offset, strict=True):
        plane = Mirror(n, float(c), 0.0)
        votes = 0.0
        for sign, tree in trees.items():
            distance, _ = tree.query(plane.image(position[index == sign]))
            # Nearer images count more, so that of the planes around the best one it is taken.
            votes += np.clip(1.0 - distance / reach, 0.0, None).sum()
        if votes > most:
            best, most = plane, votes
    return best


def difference(one: Mirror, other: Mirror, vertices: np.ndarray) -> tuple[float, float]:
    """Angle between two planes in degrees and their distance at the middle of the mesh."""
    cosine = float(np.clip(one.normal @ other.normal, -1.0, 1.0))
    middle = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    sign = np.sign(cosine) or 1.0
    apart = (one.normal @ middle - one.offset) - sign * (other.normal @ middle - other.offset)
    return float(np.degrees(np.arccos(abs(cosine)))), float(abs(apart))


def half_anew(
    vertices: np.ndarray, triangles: np.ndarray, mirror: Mirror, noise: float, seed: int = 0
) -> tuple[np.ndarray, np.ndarray]:
    """The mesh with one half as another scan of it would be: its vertices moved along the surface
    that its triangles stand for, a third of its edges flipped, and noise, in edges."""
    random = np.random.default_rng(seed)
    upper = vertices @ mirror.normal > mirror.offset
    half = np.flatnonzero(upper[triangles].all(axis=1))
    flipped = triangles.copy()
    flipped[half] = flipped_edges(vertices, triangles[half], 0.33, random)
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    area = np.linalg.norm(across, axis=1)
    row, corner = np.zeros(len(vertices), int), np.zeros(len(vertices), int)
    row[triangles.ravel()] = np.repeat(np.arange(len(triangles)), 3)
    corner[triangles.ravel()] = np.tile(np.arange(3), len(triangles))
    weights = 0.7 * np.eye(3)[corner] + 0.3 * random.dirichlet((1.0, 1.0, 1.0), len(vertices))
    moved, _ = points_at(vertices, triangles, (across / area[:, None], 0.5 * area), row, weights)
    edge = np.linalg.norm(a - b, axis=1).mean()
    moved += noise * edge * random.normal(size=vertices.shape)
    return np.where(upper[:, None], moved, vertices), flipped


def flipped_edges(
    vertices: np.ndarray, triangles: np.ndarray, share: float, random: np.random.Generator
) -> np.ndarray:
    """The triangles (m, 3) with about that share of their inner edges turned to the other diagonal
    of their two triangles, where that leaves both facing the same way."""
    triangles = triangles.copy()
    sides = [
        (int(triangle[k]), int(triangle[(k + 1) % 3])) for triangle in triangles for k in range(3)
    ]
    owner = {side: row // 3 for row, side in enumerate(sides)}
    edges = {frozenset(side) for side in sides}
    touched: set[int] = set()
    wanted = int(share * len(edges))
    for row in random.permutation(len(sides)):
        a, b = sides[row]
        one, two = row // 3, owner.get((b, a), -1)
        if two < 0 or one in touched or two in touched:
            continue
        c = int(triangles[one].sum()) - a - b
        d = int(triangles[two].sum()) - a - b
        after = np.array([[c, d, b], [d, c, a]])
        corner = vertices[np.concatenate([triangles[[one, two]], after])]
        normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        side = normal[0] + normal[1]
        if frozenset((c, d)) in edges or (normal[2:] @ side <= 0.1 * (side @ side) / 2).any():
            continue
        triangles[one], triangles[two] = after
        edges.add(frozenset((c, d)))
        touched |= {one, two}
        wanted -= 1
        if wanted <= 0:
            break
    return triangles


def write(page: Page, vertices: np.ndarray, triangles: np.ndarray, mirror: Mirror) -> None:
    """The plane of a mesh whose halves are meshed apart, and rotations of any order."""
    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    rows = []
    for noise in (0.0, 0.02, 0.05):
        places, faces = half_anew(vertices, triangles, mirror, noise)
        plane = core.Guide(places, faces, core.detect(places, faces)).symmetry()
        offset = float(plane.point @ plane.normal)
        found = Mirror(plane.normal, offset, 0.0)
        angle, shift = difference(found, mirror, vertices)
        rows.append(
            [f"{100 * noise:g} %", len(plane.pairs), number(angle), number(plane.angle_error),
             number(100 * shift / size), number(100 * plane.offset_error / size)]
        )  # fmt: skip
    page.text(
        """On a mesh whose vertices are mirrored this is easy. Here one half is another mesh: its
        vertices moved along the surface by up to a third of an edge, a third of its edges flipped,
        and noise added, in edges. *Find Mirror Plane* lets pairs of umbilics propose planes and the
        surface refine them, and states its error."""
    )
    page.table(
        ["noise", "matched", "off, degrees", "stated", "off, % of the size", "stated"], rows
    )
    worst = max(float(row[2]) for row in rows)
    page.differences.append(
        f"""Symmetry of the torso with one half meshed anew and noise of up to 5 % of an edge: the
        plane is within {number(worst, 2)}° of that of the mirrored vertices."""
    )
    _rotations(page)


def _rotations(page: Page) -> None:
    page.heading("Rotation symmetry", 4)
    rows = []
    for order in (2, 3, 4, 5, 8):
        points, triangles = random_sphere(6000, order)
        turn = rotation_by(np.array([0.7, -1.1, 0.4]))
        places = star(points, order) @ turn.T
        shape = core.Shape.of(places, triangles, core.detect(places, triangles))
        found = core.find_rotation(shape)
        tilt = float(np.degrees(np.arccos(min(abs(found.axis @ turn[:, 2]), 1.0))))
        rows.append([order, found.order, number(tilt), number(found.axis_error), len(found.pairs)])
    page.text(
        """*Find Rotation Axis* on shapes that turns by 360° / n, and no others, bring onto
        themselves, 6,000 random points each, so that no sector has the mesh of another."""
    )
    page.table(["n", "found", "axis off, degrees", "stated", "matched"], rows)
