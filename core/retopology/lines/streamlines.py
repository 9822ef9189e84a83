"""Evenly spaced lines of curvature.

After Jobard & Lefer 1997, on the surface itself: a line ends where it comes too near to another
of its family, and new lines start one spacing beside those that are there. Many lines are traced
at once; where two of a round come too near, the longer one goes on.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.spatial import cKDTree

from ...base.errors import GuidanceError
from ...base.options import AUTO
from ...base.progress import Progress
from ...fields.planes import FaceFrames, barycentric_of, places
from ...mesh.surface import Surface
from ..settings import GuidanceSettings
from .polylines import Lines, points_of, spans, sparse_rows
from .tracing import CLOSED, MET, Starts, Traces, trace

# Automatic spacing: this fraction of the root of the area.
AUTO_SPACING = 1 / 35
# Lines of a family keep this many samples to a spacing when their distances are compared, and
# this many points to a spacing when they are handed on.
SAMPLES, DETAIL = 2, 10
# Lines of the first round to one that fits side by side over the size of the surface: many
# fronts grow at once, but few of these lines meet.
FRONTS = 0.5
# With fewer seeds than this a round is not worth its steps: more are taken beside each line.
FEWEST = 60
# A seed is taken if nothing lies nearer than this many spacings.
FREE = 0.9
# Spacings between the places of a line that a seed is set beside.
BESIDE = 2.0
# Normals count as distance, so that the two sides of a thin sheet are not neighbours: opposite
# normals are this many spacings apart.
SIDES = 1.5
MOST_ROUNDS = 400
# A line of which the others of its round leave less than this share waits for a later round.
PATIENCE = 0.8
# A line that goes round and round ends after this many times the size of the surface.
LONGEST = 6.0
# Share of the area with directions below which there is nothing to follow.
LEAST_DIRECTED = 0.02
NO_DIRECTION = (
    "The surface has no preferred direction: it is spherical or flat nearly everywhere, so there "
    "are no lines of curvature to draw. The cross field still has smooth directions."
)


def check_directed(surface: Surface, undirected: np.ndarray) -> None:
    """Raise `GuidanceError` where regions (m,) bool leave no direction to follow."""
    _, area = surface.face_normal_area
    if area[~undirected].sum() < LEAST_DIRECTED * area.sum():
        raise GuidanceError(NO_DIRECTION)


def spacing_of(surface: Surface, settings: GuidanceSettings) -> float:
    """Spacing of the lines in the coordinates of the surface."""
    if settings.spacing == AUTO or settings.spacing == 0.0:
        return AUTO_SPACING * float(np.sqrt(surface.face_normal_area[1].sum()))
    return float(settings.spacing) / surface.unit


@dataclass
class _Family:
    """Accepted lines of one family and the seeds that are left."""

    number: int
    # Random places over the surface, where a line begins once no seeds are left.
    strewn_triangle: np.ndarray
    strewn_z: np.ndarray
    samples: list[np.ndarray] = field(default_factory=list)
    tree: cKDTree | None = None
    seed_triangle: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64))
    seed_z: np.ndarray = field(default_factory=lambda: np.zeros(0, complex))
    # Line and side that a seed lies beside: one of each is tried in a round.
    seed_parent: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64))
    parents: int = 0

    def add_seeds(self, triangle: np.ndarray, z: np.ndarray, parent: np.ndarray) -> None:
        self.seed_triangle = np.concatenate([self.seed_triangle, triangle])
        self.seed_z = np.concatenate([self.seed_z, z])
        self.seed_parent = np.concatenate([self.seed_parent, parent + self.parents])
        self.parents += int(parent.max(initial=-1)) + 1

    def keep_seeds(self, rows: np.ndarray) -> None:
        self.seed_triangle = self.seed_triangle[rows]
        self.seed_z = self.seed_z[rows]
        self.seed_parent = self.seed_parent[rows]


@dataclass(frozen=True)
class _Round:
    """Whole lines of a round: points in order along each, `arc` measured from the seed."""

    line: np.ndarray
    arc: np.ndarray
    triangle: np.ndarray
    z: np.ndarray
    family: np.ndarray
    closed: np.ndarray


class _Drawing:
    def __init__(
        self,
        surface: Surface,
        planes: FaceFrames,
        obstacle: np.ndarray,
        spacing: float,
        settings: GuidanceSettings,
    ) -> None:
        self.surface, self.planes, self.obstacle = surface, planes, obstacle
        self.spacing, self.near = spacing, settings.closest * spacing
        self.shortest = settings.shortest * spacing
        self.normal, self.area = surface.face_normal_area
        self.edge = float(np.sqrt(np.median(self.area[self.area > 0])) * 1.5)
        # Steps between two looks at what is near, and how much nearer the two ends of a line come
        # to each other meanwhile.
        self.every = max(2, int(0.4 * self.near / self.edge))
        self.apart = max(0.25 * self.near, self.every * self.edge)
        self.random = np.random.default_rng(0)
        self.longest = LONGEST * float(np.sqrt(self.area.sum()))
        self.accepted: list[_Round] = []

    def embedded(self, triangle: np.ndarray, z: np.ndarray) -> np.ndarray:
        """(r, 6) points and normals, so that distance tells the sides of a sheet apart."""
        points = points_of(self.surface, self.planes, triangle, z)
        return np.hstack([points, (0.5 * SIDES * self.spacing) * self.normal[triangle]])

    def strewn(self) -> tuple[np.ndarray, np.ndarray]:
        """Random points on the directed part of the surface, two to a square spacing."""
        weight = np.where(self.obstacle < 0, self.area, 0.0)
        count = int(np.clip(2.0 * weight.sum() / self.spacing**2, 64, 200_000))
        triangle = self.random.choice(len(weight), count, p=weight / weight.sum())
        a, b = np.sqrt(self.random.random(count)), self.random.random(count)
        weights = np.stack([1.0 - a, a * (1.0 - b), a * b], axis=1)
        return triangle, places(self.planes, triangle, weights)

    def far_from_lines(self, family: _Family, points: np.ndarray, least: float) -> np.ndarray:
        if family.tree is None:
            return np.ones(len(points), bool)
        distance, _ = family.tree.query(points, distance_upper_bound=least)
        return ~np.isfinite(distance)

    def thinned(self, points: np.ndarray, least: float) -> np.ndarray:
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

    def chosen(self, family: _Family) -> tuple[np.ndarray, np.ndarray]:
        """Seeds for this round: one to each side of a line, else places far from all lines."""
        points = self.embedded(family.seed_triangle, family.seed_z)
        family.keep_seeds(self.far_from_lines(family, points, FREE * self.spacing))
        if len(family.seed_triangle):
            order = self.random.permutation(len(family.seed_triangle))
            _, first = np.unique(family.seed_parent[order], return_index=True)
            rows = np.union1d(order[first], order[: max(0, FEWEST - len(first))])
            points = self.embedded(family.seed_triangle[rows], family.seed_z[rows])
            rows = rows[self.thinned(points, FREE * self.spacing)]
            return family.seed_triangle[rows], family.seed_z[rows]
        points = self.embedded(family.strewn_triangle, family.strewn_z)
        far = np.flatnonzero(self.far_from_lines(family, points, self.spacing))
        # What is near a line stays so.
        points = points[far]
        family.strewn_triangle, family.strewn_z = family.strewn_triangle[far], family.strewn_z[far]
        rows = np.arange(min(len(far), 5000))
        if len(rows):
            rows = rows[self.thinned(points[rows], 2.0 * self.spacing)]
        if family.tree is None:
            rows = rows[: max(4, int(FRONTS * np.sqrt(self.area.sum()) / self.spacing))]
        return family.strewn_triangle[rows], family.strewn_z[rows]

    def traced(
        self, families: list[_Family], seeds: list[tuple], progress: Progress
    ) -> _Round | None:
        triangle = np.concatenate([seed[0] for seed in seeds])
        if not len(triangle):
            return None
        z = np.concatenate([seed[1] for seed in seeds])
        family = np.repeat([f.number for f in families], [len(seed[0]) for seed in seeds])
        value = self.planes.deviator(triangle, z) * np.where(family == 0, 1.0, -1.0)
        direction = np.sqrt(value)
        size = np.abs(direction)
        direction = np.where(size > 0, direction / np.where(size > 0, size, 1.0), 1.0)
        both = np.stack([direction, -direction], axis=1).ravel()
        count = len(both)
        starts = Starts.plain(np.repeat(triangle, 2), np.repeat(z, 2), both, np.repeat(family, 2))
        trees = {f.number: f.tree for f in families}
        head = np.full((count, 6), 1e9)
        far, before = np.zeros(count), np.zeros(count)

        def stop(ids: np.ndarray, triangle: np.ndarray, z: np.ndarray, length: np.ndarray):
            points = self.embedded(triangle, z)
            head[ids], far[ids] = points, length
            code = np.full(len(ids), -1)
            for number, tree in trees.items():
                rows = np.flatnonzero(starts.family[ids] == number)
                if tree is not None and len(rows):
                    distance, _ = tree.query(points[rows], distance_upper_bound=self.near)
                    code[rows[np.isfinite(distance)]] = MET
            partner = ids ^ 1
            gap = np.linalg.norm(points - head[partner], axis=1)
            long = np.minimum(length, far[partner]) > 2.0 * self.spacing + self.apart
            # Ends that have passed beside each other are on their second turn from there.
            passed = (gap < self.near) & (gap > before[ids])
            code[long & passed] = MET
            code[long & (gap < self.apart)] = CLOSED
            before[ids] = gap
            return code

        limit = np.full(count, 0.5 * self.longest)
        result = trace(
            self.surface, self.planes, starts, limit, self.obstacle, progress, stop, self.every
        )
        return self.joined(result, starts.family[::2])

    def joined(self, result: Traces, family: np.ndarray) -> _Round:
        """Both halves of every line as one, thinned to what is handed on."""
        rows = sparse_rows(result, self.spacing / DETAIL)
        half = np.repeat(np.arange(len(result.end)), np.diff(result.start))[rows]
        backward = half % 2 == 1
        # The seed itself begins both halves.
        keep = ~(backward & (result.travelled[rows] == 0.0))
        rows, half, backward = rows[keep], half[keep], backward[keep]
        arc = np.where(backward, -1.0, 1.0) * result.travelled[rows]
        order = np.lexsort((arc, half // 2))
        rows, half, arc = rows[order], half[order], arc[order]
        closed = (result.end[::2] == CLOSED) & (result.end[1::2] == CLOSED)
        return self.closed_cleanly(
            _Round(half // 2, arc, result.triangle[rows], result.z[rows], family, closed)
        )

    def closed_cleanly(self, drawn: _Round) -> _Round:
        """Without what the ends of closed lines have passed of each other; a line whose ends pass
        beside each other is not closed."""
        points = points_of(self.surface, self.planes, drawn.triangle, drawn.z)
        start = np.searchsorted(drawn.line, np.arange(len(drawn.family) + 1))
        keep, closed = np.ones(len(points), bool), drawn.closed.copy()
        for line in np.flatnonzero(closed):
            rows = np.arange(start[line], start[line + 1])
            ahead = points[rows[0]] - points[rows[2]]
            ahead /= max(float(np.linalg.norm(ahead)), 1e-300)
            late = rows[drawn.arc[rows] > drawn.arc[rows[-1]] - 2.0 * self.apart]
            over = points[late] - points[rows[0]]
            along = over @ ahead
            beside = np.linalg.norm(over - along[:, None] * ahead, axis=1)
            # The chord that closes the line goes ahead rather than aside.
            keep[late[along < 2.0 * beside]] = False
            closed[line] = beside[np.abs(along).argmin()] < 0.25 * self.near
        return _Round(
            drawn.line[keep],
            drawn.arc[keep],
            drawn.triangle[keep],
            drawn.z[keep],
            drawn.family,
            closed,
        )

    def accept(self, drawn: _Round, families: list[_Family]) -> None:
        """Keep what does not come too near to other lines of the round, longest lines first."""
        count = len(drawn.family)
        cell = np.floor(drawn.arc * (SAMPLES / self.spacing)).astype(np.int64)
        new = np.ones(len(cell), bool)
        new[1:] = (cell[1:] != cell[:-1]) | (drawn.line[1:] != drawn.line[:-1])
        sample = np.flatnonzero(new)
        points = self.embedded(drawn.triangle[sample], drawn.z[sample])
        # Families do not see each other.
        apart = np.hstack([points, 10.0 * drawn.family[drawn.line[sample], None]])
        tree = cKDTree(apart, balanced_tree=False)
        pairs = tree.query_pairs(self.near, output_type="ndarray")
        line, arc = drawn.line[sample], drawn.arc[sample]
        own = line[pairs[:, 0]] == line[pairs[:, 1]]
        total = np.bincount(drawn.line, minlength=count)
        first = np.concatenate([[0], np.cumsum(total)])
        length = drawn.arc[first[1:] - 1] - drawn.arc[first[:-1]]
        blocked = np.zeros(len(sample), bool)
        selfish = pairs[own]
        gap = np.abs(arc[selfish[:, 0]] - arc[selfish[:, 1]])
        around = np.where(drawn.closed[line[selfish[:, 0]]], length[line[selfish[:, 0]]], np.inf)
        # A line near itself far along is on its second turn: the part farther from the seed goes.
        selfish = selfish[np.minimum(gap, around - gap) > 3.0 * self.near]
        outer = np.abs(arc[selfish[:, 0]]) > np.abs(arc[selfish[:, 1]])
        blocked[np.where(outer, selfish[:, 0], selfish[:, 1])] = True
        other = np.concatenate([pairs[~own], pairs[~own][:, ::-1]])
        other = other[np.argsort(other[:, 0], kind="stable")]
        begin = np.searchsorted(other[:, 0], np.arange(len(sample) + 1))
        taken = np.zeros(len(sample), bool)
        of_line = np.searchsorted(line, np.arange(count + 1))
        pieces = []
        for number in np.argsort(-length, kind="stable"):
            one, two = of_line[number], of_line[number + 1]
            bad = blocked[one:two].copy()
            links = other[begin[one] : begin[two]]
            bad[links[taken[links[:, 1]], 0] - one] = True
            low, high = _run_around_zero(bad, arc[one:two])
            if high - low < max(self.shortest, 1e-12):
                continue
            # Cut short by its neighbours of this round: one that fits better may come later.
            if len(pieces) and high - low < PATIENCE * length[number] and bad.any():
                continue
            whole = not bad.any()
            taken[one:two] = (arc[one:two] >= low) & (arc[one:two] <= high)
            pieces.append((number, -np.inf if whole else low, np.inf if whole else high, whole))
        if pieces:
            self._keep(drawn, pieces, families, first)

    def _keep(
        self, drawn: _Round, pieces: list, families: list[_Family], first: np.ndarray
    ) -> None:
        number = np.array([piece[0] for piece in pieces])
        low, high, whole = (np.array([piece[k] for piece in pieces]) for k in (1, 2, 3))
        count = np.diff(first)[number]
        rows = spans(first[:-1][number], count)
        line = np.repeat(np.arange(len(number)), count)
        inside = (drawn.arc[rows] >= low[line]) & (drawn.arc[rows] <= high[line])
        rows, line = rows[inside], line[inside]
        kept = _Round(
            line,
            drawn.arc[rows],
            drawn.triangle[rows],
            drawn.z[rows],
            drawn.family[number],
            drawn.closed[number] & whole,
        )
        self.accepted.append(kept)
        for family in families:
            mine = np.flatnonzero(kept.family[kept.line] == family.number)
            if not len(mine):
                continue
            cell = np.floor(kept.arc[mine] * (2 * SAMPLES / self.spacing)).astype(np.int64)
            own = kept.line[mine]
            some = np.ones(len(mine), bool)
            some[1:] = (cell[1:] != cell[:-1]) | (own[1:] != own[:-1])
            some = mine[some]
            family.samples.append(self.embedded(kept.triangle[some], kept.z[some]))
            # Built anew in every round: quickly rather than well.
            family.tree = cKDTree(np.concatenate(family.samples), balanced_tree=False)
            self._seed_beside(kept, mine, family)

    def _seed_beside(self, kept: _Round, rows: np.ndarray, family: _Family) -> None:
        """Seeds one spacing to either side of the lines, reached along geodesics."""
        cell = np.floor(kept.arc[rows] / (BESIDE * self.spacing)).astype(np.int64)
        line = kept.line[rows]
        new = np.ones(len(rows), bool)
        new[1:] = (cell[1:] != cell[:-1]) | (line[1:] != line[:-1])
        rows, line = rows[new], line[new]
        triangle, z = kept.triangle[rows], kept.z[rows]
        # Off the edge that the point lies on, so that the walk begins inside the triangle.
        z = z + 1e-4 * (self.planes.corner[triangle].mean(axis=1) - z)
        sign = -1.0 if family.number == 0 else 1.0
        across = np.sqrt(sign * self.planes.deviator(triangle, z))
        size = np.abs(across)
        across = np.where(size > 0, across / np.where(size > 0, size, 1.0), 1j)
        starts = Starts.plain(
            np.repeat(triangle, 2),
            np.repeat(z, 2),
            np.stack([across, -across], axis=1).ravel(),
            np.zeros(2 * len(rows)),
            straight=np.inf,
        )
        walk = trace(
            self.surface,
            self.planes,
            starts,
            np.full(len(starts), self.spacing),
            self.obstacle,
            Progress(),
        )
        last = walk.start[1:] - 1
        # What met a border or an obstacle is too close to it to start from.
        arrived = walk.travelled[last] > 0.999 * self.spacing
        parent = np.stack([2 * line, 2 * line + 1], axis=1).ravel()
        family.add_seeds(walk.triangle[last][arrived], walk.z[last][arrived], parent[arrived])


def _run_around_zero(bad: np.ndarray, arc: np.ndarray) -> tuple[float, float]:
    """The stretch of a line around its seed that holds no bad sample, as arcs."""
    seed = int(np.abs(arc).argmin())
    if bad[seed]:
        return 0.0, 0.0
    before = np.flatnonzero(bad[:seed])
    after = np.flatnonzero(bad[seed:])
    low = arc[before[-1] + 1] if len(before) else arc[0]
    high = arc[seed + after[0] - 1] if len(after) else arc[-1]
    return float(low), float(high)


def evenly_spaced_lines(
    surface: Surface,
    planes: FaceFrames,
    settings: GuidanceSettings,
    obstacle: np.ndarray,
    progress: Progress,
) -> Lines:
    """Lines of curvature at an even spacing.

    Parameters
    ----------
    obstacle:
        (m,) int: lines end at triangles with a number >= 0, umbilics and regions.

    Raises
    ------
    GuidanceError
        Nearly all of the surface has no preferred direction.
    """
    check_directed(surface, obstacle >= 0)
    drawing = _Drawing(surface, planes, obstacle, spacing_of(surface, settings), settings)
    strewn = drawing.strewn()
    wanted = {"both": (0, 1), "first": (0,), "second": (1,)}[settings.families]
    families = [_Family(number, *strewn) for number in wanted]
    barren = 0
    for number in range(MOST_ROUNDS):
        progress.step(1.0 - 0.85**number)
        fresh = [len(family.seed_triangle) == 0 for family in families]
        seeds = [drawing.chosen(family) for family in families]
        drawn = drawing.traced(families, seeds, Progress())
        if drawn is None:
            break
        before = len(drawing.accepted)
        drawing.accept(drawn, families)
        # Places where only lines that are too short would fit stay empty.
        barren = barren + 1 if len(drawing.accepted) == before else 0
        if barren >= 3 and all(fresh):
            break
    progress.step(1.0)
    return _as_lines(surface, planes, drawing.accepted)


def _as_lines(surface: Surface, planes: FaceFrames, rounds: list[_Round]) -> Lines:
    if not rounds:
        return lines_from(
            surface, planes, *(np.zeros(0, kind) for kind in (int, int, complex, int, bool))
        )
    offset = np.cumsum([0] + [len(one.family) for one in rounds])
    line = np.concatenate([one.line + at for one, at in zip(rounds, offset, strict=False)])
    return lines_from(
        surface,
        planes,
        line,
        np.concatenate([one.triangle for one in rounds]),
        np.concatenate([one.z for one in rounds]),
        np.concatenate([one.family for one in rounds]),
        np.concatenate([one.closed for one in rounds]),
    )


def lines_from(
    surface: Surface,
    planes: FaceFrames,
    line: np.ndarray,
    triangle: np.ndarray,
    z: np.ndarray,
    family: np.ndarray,
    closed: np.ndarray,
) -> Lines:
    """Lines in input coordinates from points in the planes, ordered by `line` (p,)."""
    count = len(family)
    start = np.concatenate([[0], np.cumsum(np.bincount(line, minlength=count))]).astype(np.int64)
    weights = barycentric_of(planes, triangle, z)
    points = np.einsum("rk,rkc->rc", weights, surface.vertices[surface.triangles[triangle]])
    points = points * surface.unit + surface.origin
    chord = np.zeros(len(points))
    chord[1:] = np.linalg.norm(np.diff(points, axis=0), axis=1)
    chord[start[:-1][np.diff(start) > 0]] = 0.0
    length = np.bincount(line, weights=chord, minlength=count)
    for number in np.flatnonzero(closed):
        length[number] += np.linalg.norm(points[start[number]] - points[start[number + 1] - 1])
    return Lines(
        start=start,
        position=points,
        normal=surface.face_normal_area[0][triangle],
        triangle=surface.source_triangle[triangle],
        barycentric=weights,
        family=family.astype(np.int8),
        length=length,
        closed=closed.astype(bool),
        source=np.full(count, -1),
        target=np.full(count, -1),
    )
