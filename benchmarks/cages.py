"""Control cages of quads, their subdivisions after Catmull and Clark, and the limit surface.

Recursively generated B-spline surfaces on arbitrary topological meshes (1978,
https://doi.org/10.1016/0010-4485(78)90110-0). Beside a vertex where four quads meet the limit
surface is a bicubic spline, whose place, normal and shape operator follow from the eight vertices
around. At the extraordinary ones there is a tangent plane, but the curvature is not continuous
(Peters & Reif 2008, Subdivision Surfaces); umbilics come in small groups around them, and nothing
is asked for there.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from surfaces import UmbilicPoints

import core
from core import CurvatureField
from core.base.unit import unit

from .cases import Case

# Level at which the exact field is searched for its zeros: their distance from those of the limit
# surface is a few thousandths of an edge of level 3.
FINEST = 6
# Levels that are detected on.
LEVELS = (1, 2, 3)
# Edges around extraordinary vertices within which nothing is asked for.
BLIND = 2.0


@dataclass(frozen=True)
class Quads:
    """A closed mesh of quads: vertices (n, 3) float64, corners (m, 4) int64, outward winding."""

    vertices: np.ndarray
    corners: np.ndarray

    @property
    def extraordinary(self) -> np.ndarray:
        """(n,) bool, vertices where not four quads meet."""
        return np.bincount(self.corners.ravel(), minlength=len(self.vertices)) != 4

    @property
    def triangles(self) -> np.ndarray:
        """(2m, 3) int64 halves of the quads."""
        return np.concatenate([self.corners[:, [0, 1, 2]], self.corners[:, [0, 2, 3]]])

    def subdivided(self) -> Quads:
        """One level finer."""
        points, corners, n = self.vertices, self.corners, len(self.vertices)
        start, end = corners, np.roll(corners, -1, axis=1)
        key = np.minimum(start, end) * n + np.maximum(start, end)
        edges, of = np.unique(key.ravel(), return_inverse=True)
        ends = np.stack(np.divmod(edges, n))
        middle = points[corners].mean(axis=1)
        beside, around, along = np.zeros((len(edges), 3)), np.zeros((n, 3)), np.zeros((n, 3))
        np.add.at(beside, of.ravel(), np.repeat(middle, 4, axis=0))
        np.add.at(around, corners.ravel(), np.repeat(middle, 4, axis=0))
        half = points[ends].mean(axis=0)
        for side in ends:
            np.add.at(along, side, half)
        valence = np.bincount(corners.ravel(), minlength=n)[:, None]
        moved = (around / valence + 2.0 * along / valence + (valence - 3.0) * points) / valence
        on_edge = n + of.reshape(-1, 4)
        face = n + len(edges) + np.arange(len(corners))
        finer = [
            np.stack([corners[:, k], on_edge[:, k], face, on_edge[:, k - 1]], axis=1)
            for k in range(4)
        ]
        vertices = np.concatenate([moved, 0.5 * half + 0.25 * beside, middle])
        return Quads(vertices, np.concatenate(finer))

    def limit(self) -> tuple[np.ndarray, CurvatureField]:
        """The vertices' places on the limit surface (n, 3) and its exact shape operators there,
        which are meaningless at extraordinary ones."""
        grid = self._rings()
        points = self.vertices[grid]  # (n, 3, 3, 3)
        value, slope, bend = np.array([[1, 4, 1], [-3, 0, 3], [6, -12, 6]]) / 6.0

        def along(u: np.ndarray, v: np.ndarray) -> np.ndarray:
            return np.asarray(np.einsum("i,j,nijc->nc", u, v, points))

        su, sv = along(slope, value), along(value, slope)
        normal = unit(np.cross(su, sv))
        second = np.stack([along(bend, value), along(slope, slope), along(value, bend)])
        # Positive where convex: against the outward normal.
        b11, b12, b22 = -np.einsum("knc,nc->kn", second, normal)
        # The operator in the orthonormal frame e1 = su / |su|, e2 = normal x e1.
        odd = self.extraordinary
        length = np.where(odd, 1.0, np.linalg.norm(su, axis=1))
        e1 = su / length[:, None]
        e2 = np.cross(normal, e1)
        x, y = np.einsum("nc,nc->n", sv, e1), np.einsum("nc,nc->n", sv, e2)
        y = np.where(odd, 1.0, y)
        s11 = b11 / length**2
        s12 = (b12 / length - x * s11) / y
        s22 = (b22 - 2.0 * x * y * s12 - x * x * s11) / y**2
        mean, deviator = 0.5 * (s11 + s22), (s11 - s22) + 2j * s12
        gap, angle = np.abs(deviator), 0.5 * np.angle(deviator)
        d1 = np.cos(angle)[:, None] * e1 + np.sin(angle)[:, None] * e2
        noise = np.full(len(gap), np.nan)
        field = CurvatureField(
            mean + 0.5 * gap, mean - 0.5 * gap, d1, np.cross(normal, d1), normal, noise
        )
        return self._places(), field

    def _places(self) -> np.ndarray:
        """(n, 3) where the vertices come to (Halstead et al. 1993)."""
        edge, face = np.zeros((2, len(self.vertices), 3))
        for k in range(4):
            np.add.at(edge, self.corners[:, k], self.vertices[self.corners[:, (k + 1) % 4]])
            np.add.at(face, self.corners[:, k], self.vertices[self.corners[:, (k + 2) % 4]])
        count = np.bincount(self.corners.ravel(), minlength=len(edge))[:, None]
        return (count**2 * self.vertices + 4.0 * edge + face) / (count * (count + 5.0))

    def _rings(self) -> np.ndarray:
        """(n, 3, 3) the vertices around each regular one, itself in the middle; of the others
        itself, so that nothing is said of them."""
        n = len(self.vertices)
        grid = np.repeat(np.arange(n), 9).reshape(n, 3, 3)
        start = self.corners.ravel()
        following = np.roll(self.corners, -1, axis=1).ravel()
        across = np.roll(self.corners, -2, axis=1).ravel()
        before = np.roll(self.corners, 1, axis=1).ravel()
        # Quads around a vertex in turn: what is before in one follows in the next.
        keys = start * n + following
        order = np.argsort(keys)
        quad = np.flatnonzero(np.append(True, start[order][1:] != start[order][:-1]))
        quad = order[quad]
        quad = quad[~self.extraordinary[start[quad]]]
        places = ((2, 1), (2, 2)), ((1, 2), (0, 2)), ((0, 1), (0, 0)), ((1, 0), (2, 0))
        vertex = start[quad]
        for edge, corner in places:
            grid[(vertex, *edge)] = following[quad]
            grid[(vertex, *corner)] = across[quad]
            quad = order[np.searchsorted(keys[order], vertex * n + before[quad])]
        return grid


def random_cage(seed: int) -> Quads:
    """A cage of some sixty quads as one begins a figure with: a cube of nine quads a side, two of
    them drawn out, on a sphere that is stretched and dented at random."""
    random = np.random.default_rng(seed)
    lines = np.linspace(-1.0, 1.0, 4)
    sides = []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            u, v = np.meshgrid(lines, lines, indexing="ij")
            points = np.stack([np.full_like(u, sign), u, v], axis=-1)
            # A cyclic change of axes keeps the winding.
            points = np.roll(points, axis, axis=-1).reshape(-1, 3)
            place = np.arange(16).reshape(4, 4)
            quads = np.stack(
                [place[:-1, :-1], place[1:, :-1], place[1:, 1:], place[:-1, 1:]], axis=-1
            ).reshape(-1, 4)
            sides.append((points, quads if sign > 0 else quads[:, ::-1]))
    points = np.concatenate([side for side, _ in sides])
    corners = np.concatenate([16 * k + quads for k, (_, quads) in enumerate(sides)])
    points, of = np.unique(points.round(9), axis=0, return_inverse=True)
    corners = of.ravel()[corners]
    points /= np.linalg.norm(points, axis=1)[:, None]
    points *= 1.0 + 0.08 * random.normal(size=(len(points), 1))
    for quad in random.choice(6, 2, replace=False) * 9 + 4:
        base = corners[quad].copy()
        middle = points[base].mean(axis=0)
        drawn = middle + 0.8 * (points[base] - middle) + 0.6 * middle / np.linalg.norm(middle)
        top = len(points) + np.arange(4)
        points = np.concatenate([points, drawn])
        around = np.stack([base, np.roll(base, -1), np.roll(top, -1), top], axis=1)
        corners[quad] = top
        corners = np.concatenate([corners, around])
    return Quads(points * random.uniform(0.7, 1.3, 3), corners)


def umbilics_of(cage: Quads) -> UmbilicPoints:
    """The umbilics of the limit surface, found in its exact shape operators on a fine mesh. Next to
    extraordinary vertices they mean nothing."""
    for _ in range(FINEST):
        cage = cage.subdivided()
    place, field = cage.limit()
    settings = core.Settings(curvature="given", persistence=0.0, regions=False, merge=False)
    found = core.detect(place, cage.triangles, settings, given=field).candidates
    return UmbilicPoints(found.position, found.index, found.kind)


def cases_of(seed: int) -> Iterator[Case]:
    """A random cage subdivided to several levels, its vertices moved to the limit surface as
    modelling programs do; triangles are halves of quads."""
    quads = random_cage(seed)
    truth = umbilics_of(quads)
    for level in LEVELS:
        quads = quads.subdivided()
        place, _ = quads.limit()
        case = Case(
            f"cage {seed}", f"cage, level {level}", 0.0, place, quads.triangles, truth, euler=2
        )
        odd = place[quads.extraordinary]
        yield replace(case, blind=odd, blind_reach=BLIND * case.edge_at(odd))
