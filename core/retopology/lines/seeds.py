"""Where evenly spaced lines begin: beside those that are there, else anywhere far from all."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.spatial import cKDTree

from ...base.progress import Progress
from ...fields.planes import places
from .canvas import Canvas
from .rounds import Round
from .tracing import Obstacles, Starts, trace

# Lines of the first round to one that fits side by side over the size of the surface: many
# fronts grow at once, but few of these lines meet.
FRONTS = 0.5
# With fewer seeds than this a round is not worth its steps: more are taken beside each line.
FEWEST = 60
# Seeds anywhere that are looked at in one round.
MOST_STREWN = 5000
# A seed is taken if nothing lies nearer than this many spacings.
FREE = 0.9
# Spacings between the places of a line that a seed is set beside.
BESIDE = 2.0


@dataclass
class Family:
    """The lines of one family that are there, as samples, and the seeds that are left.

    Seeds are (s,) triangles and places; `strewn_…` are places all over the surface, where a line
    begins once no others are left.
    """

    number: int
    strewn_triangle: np.ndarray
    strewn_z: np.ndarray
    samples: list[np.ndarray] = field(default_factory=list)
    tree: cKDTree | None = None
    seed_triangle: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64))
    seed_z: np.ndarray = field(default_factory=lambda: np.zeros(0, complex))
    # Line and side that a seed lies beside: one of each is tried in a round.
    seed_parent: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64))
    parents: int = 0

    def add_lines(self, points: np.ndarray) -> None:
        """Take note of lines by their samples (p, 6), see `Canvas.embedded`."""
        self.samples.append(points)
        # Built anew in every round: quickly rather than well.
        self.tree = cKDTree(np.concatenate(self.samples), balanced_tree=False)

    def add_seeds(self, triangle: np.ndarray, z: np.ndarray, parent: np.ndarray) -> None:
        """Places (s,) at which lines may begin, and which of the new lines they lie beside."""
        self.seed_triangle = np.concatenate([self.seed_triangle, triangle])
        self.seed_z = np.concatenate([self.seed_z, z])
        self.seed_parent = np.concatenate([self.seed_parent, parent + self.parents])
        self.parents += int(parent.max(initial=-1)) + 1

    def keep_seeds(self, rows: np.ndarray) -> None:
        """Forget the other seeds; a mask or rows."""
        self.seed_triangle = self.seed_triangle[rows]
        self.seed_z = self.seed_z[rows]
        self.seed_parent = self.seed_parent[rows]

    def is_far(self, points: np.ndarray, least: float) -> np.ndarray:
        """(r,) bool, True for points (r, 6) with no line nearer than `least`."""
        if self.tree is None:
            return np.ones(len(points), bool)
        distance, _ = self.tree.query(points, distance_upper_bound=least)
        return ~np.isfinite(distance)


def random_seeds(canvas: Canvas, random: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Random places on the directed part of the surface, two to a square spacing."""
    weight = np.where(canvas.obstacle < 0, canvas.surface.face_normal_area[1], 0.0)
    count = int(np.clip(2.0 * weight.sum() / canvas.spacing**2, 64, 200_000))
    triangle = random.choice(len(weight), count, p=weight / weight.sum())
    a, b = np.sqrt(random.random(count)), random.random(count)
    weights = np.stack([1.0 - a, a * (1.0 - b), a * b], axis=1)
    return triangle, places(canvas.planes, triangle, weights)


def choose_seeds(
    canvas: Canvas, family: Family, random: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Seeds for this round: one to each side of a line, else places far from all lines."""
    spacing = canvas.spacing
    points = canvas.embedded(family.seed_triangle, family.seed_z)
    family.keep_seeds(family.is_far(points, FREE * spacing))
    if len(family.seed_triangle):
        order = random.permutation(len(family.seed_triangle))
        _, first = np.unique(family.seed_parent[order], return_index=True)
        rows = np.union1d(order[first], order[: max(0, FEWEST - len(first))])
        points = canvas.embedded(family.seed_triangle[rows], family.seed_z[rows])
        rows = rows[_thinned(points, FREE * spacing)]
        return family.seed_triangle[rows], family.seed_z[rows]
    points = canvas.embedded(family.strewn_triangle, family.strewn_z)
    far = np.flatnonzero(family.is_far(points, spacing))
    # What is near a line stays so.
    points = points[far]
    family.strewn_triangle, family.strewn_z = family.strewn_triangle[far], family.strewn_z[far]
    rows = np.arange(min(len(far), MOST_STREWN))
    if len(rows):
        rows = rows[_thinned(points[rows], 2.0 * spacing)]
    if family.tree is None:
        area = float(canvas.surface.face_normal_area[1].sum())
        rows = rows[: max(4, int(FRONTS * np.sqrt(area) / spacing))]
    return family.strewn_triangle[rows], family.strewn_z[rows]


def _thinned(points: np.ndarray, least: float) -> np.ndarray:
    """Rows of points of which no two are nearer than `least`, in order of preference."""
    pairs = cKDTree(points).query_pairs(least, output_type="ndarray")
    kept = np.ones(len(points), bool)
    # In each round those without an earlier neighbour stay and their neighbours go.
    while len(pairs):
        second = np.zeros(len(points), bool)
        second[pairs[:, 1]] = True
        kept[pairs[~second[pairs[:, 0]], 1]] = False
        pairs = pairs[kept[pairs].all(axis=1)]
    return np.flatnonzero(kept)


def seed_beside(
    canvas: Canvas, lines: Round, rows: np.ndarray, family: Family, progress: Progress
) -> None:
    """Give `family` seeds one spacing to either side of the points `rows` of its new lines,
    reached along geodesics."""
    cell = np.floor(lines.arc[rows] / (BESIDE * canvas.spacing)).astype(np.int64)
    line = lines.line[rows]
    new = np.ones(len(rows), bool)
    new[1:] = (cell[1:] != cell[:-1]) | (line[1:] != line[:-1])
    rows, line = rows[new], line[new]
    triangle, z = lines.triangle[rows], lines.z[rows]
    # Off the edge that the point lies on, so that the walk begins inside the triangle.
    z = z + 1e-4 * (canvas.planes.corner[triangle].mean(axis=1) - z)
    across = canvas.direction(triangle, z, np.full(len(rows), 1 - family.number))
    starts = Starts.plain(
        np.repeat(triangle, 2),
        np.repeat(z, 2),
        np.stack([across, -across], axis=1).ravel(),
        np.zeros(2 * len(rows)),
        np.full(2 * len(rows), canvas.spacing),
        straight=np.inf,
    )
    walk = trace(canvas.surface, canvas.planes, starts, Obstacles(canvas.obstacle), progress)
    last = walk.start[1:] - 1
    # What met a border or an obstacle is too close to it to start from.
    arrived = walk.travelled[last] > 0.999 * canvas.spacing
    parent = np.stack([2 * line, 2 * line + 1], axis=1).ravel()
    family.add_seeds(walk.triangle[last][arrived], walk.z[last][arrived], parent[arrived])
