"""Coarser triangles for surfaces finer than a map needs, by collapsing edges many at once.

In each round vertices go of which no two are neighbours, chosen by lot (Luby 1986,
10.1137/0215074): the triangles around each are laid anew from one vertex of their rim, and no two
of these places overlap. Vertices on features and borders stay, unless borders may become coarser
too: theirs then go along them. The topology stays (link condition: Dey et al. 1999).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse

from ....base.errors import RemeshError
from ....base.progress import Progress
from ....base.subsets import places_in, spans
from ....mesh.half_edges import edge_keys, ends_of, following, link, previous
from .subdivision import Triangles

# An equilateral triangle of side s has the area 0.433 s^2.
SHARE = 0.433
# Edges up to this many aimed-at lengths may go, new ones may be so long.
SHORT, LONG = 1.1, 2.0
# Lengths are aimed at that are so many times the present ones at most: triangles stay alike.
GROWTH = 1.1
# Where little has gone longer ones are aimed at: triangles without area make the mean too small.
LONGER = 1.5
# Cosine by which a triangle may turn, and the least shape (1 is equilateral) it may have then.
TURN, SHAPE = 0.7, 0.25
# Triangles of less shape have no normal.
FLAT = 1e-6
# Drawings of lots in a round: each adds vertices away from those that were chosen before.
DRAWINGS = 3
# A border may come so far from where it was, by the aimed-at length, each time a vertex of it goes.
DENTED = 0.35
# Rounds at most, and how many may take away less than this share of the triangles.
ROUNDS, LITTLE, PATIENCE = 300, 0.002, 5


def coarsened(
    mesh: Triangles, most: int, progress: Progress, borders: bool = False
) -> Triangles:
    """The mesh with about `most` triangles where it has more, its borders coarser too or not."""
    area = mesh.area
    work = _Coarsening(mesh, borders)
    before = len(mesh.triangles)
    idle = 0
    for _ in range(ROUNDS):
        count = len(work.triangles)
        if count <= most or idle >= PATIENCE:
            break
        progress.step((before - count) / max(before - most, 1))
        aimed = min(area / most, GROWTH**2 * area / count) * LONGER ** (2 * idle) / SHARE
        work.round(float(np.sqrt(aimed)), (count - most + 1) // 2)
        idle = idle + 1 if len(work.triangles) > (1.0 - LITTLE) * count else 0
    return work.result()


@dataclass(frozen=True)
class _Stars:
    """The triangles around k vertices that are to go, one vertex after the other.

    Attributes
    ----------
    gone, kept:
        (k,) the vertices, and for each the neighbour that takes its place.
    whose, corner:
        (s,) row of the vertex and half-edge that leaves it.
    one, two:
        (s,) the other corners.
    """

    gone: np.ndarray
    kept: np.ndarray
    whose: np.ndarray
    corner: np.ndarray
    one: np.ndarray
    two: np.ndarray

    @property
    def dead(self) -> np.ndarray:
        """(s,) bool triangles that shrink to an edge."""
        kept = self.kept[self.whose]
        return (self.one == kept) | (self.two == kept)


class _Coarsening:
    """A mesh while vertices go; those that are left keep their places."""

    def __init__(self, mesh: Triangles, borders: bool) -> None:
        links = link(mesh.triangles.astype(np.int32), len(mesh.vertices))
        if links is None:
            raise RemeshError(
                "A piece of the mesh crosses itself where it was coarsened. Repair it."
            )
        self._mesh = mesh
        self.triangles = mesh.triangles.astype(np.int32)
        # Rows of the mesh that vertices and triangles were.
        self._vertex, self._triangle = np.arange(len(mesh.vertices)), np.arange(len(self.triangles))
        tail, head = mesh.ends
        opened = links.twin < 0
        self._kind = mesh.feature | np.where(opened, np.int8(0), mesh.feature[links.twin])
        fixed = (opened & (not borders)) | (self._kind > 0)
        self._held = np.zeros(len(mesh.vertices), bool)
        self._held[tail[fixed]] = self._held[head[fixed]] = True
        # Ends of half-edges that stay: their vertices are held.
        self._border = np.stack([tail[opened], head[opened]])
        self._feature = np.stack([tail[self._kind > 0], head[self._kind > 0]])
        self._lots = np.random.default_rng(0)

    def result(self) -> Triangles:
        """What is left, with the features on the edges that they lay on."""
        mesh, n = self._mesh, len(self._vertex)
        made = replace(
            mesh,
            vertices=mesh.vertices[self._vertex],
            triangles=self.triangles.astype(np.int64),
            values=mesh.values[self._vertex],
            source=mesh.source[self._triangle],
            feature=np.zeros(3 * len(self.triangles), np.int8),
        )
        if not self._feature.shape[1]:
            return made
        row = places_in(self._vertex, len(mesh.vertices))
        low, high = np.sort(row[self._feature], axis=0)
        key, first = np.unique(low * n + high, return_index=True)
        kind = self._kind[self._kind > 0][first]
        one, two = np.sort(np.stack(made.ends), axis=0)
        place = np.minimum(np.searchsorted(key, one * n + two), len(key) - 1)
        return replace(
            made, feature=np.where(key[place] == one * n + two, kind[place], np.int8(0))
        )

    def round(self, aim: float, most: int) -> None:
        """Take at most so many vertices away, edges being aimed at that are `aim` long."""
        stars = self._drawn(aim, most)
        if not len(stars.gone):
            return
        refused = self._dented(stars, aim)
        refused[stars.whose[_spoiled(self._place, stars, aim) & ~stars.dead]] = True
        refused |= ~self._linked(stars)
        refused |= _repeated(stars, refused, self._on_border)
        going = ~refused[stars.whose]
        self.triangles.reshape(-1)[stars.corner[going]] = stars.kept[stars.whose[going]]
        alive = np.ones(len(self.triangles), bool)
        alive[stars.corner[going & stars.dead] // 3] = False
        self.triangles, self._triangle = self.triangles[alive], self._triangle[alive]
        staying = np.ones(len(self._vertex), bool)
        staying[stars.gone[~refused]] = False
        row = (np.cumsum(staying) - 1).astype(np.int32)
        row[stars.gone[~refused]] = row[stars.kept[~refused]]
        self.triangles = row[self.triangles]
        self._vertex = self._vertex[staying]
        border = row[self._border]
        self._held, self._border = self._held[staying], border[:, border[0] != border[1]]

    @property
    def _place(self) -> np.ndarray:
        return self._mesh.vertices[self._vertex]

    def _drawn(self, aim: float, most: int) -> _Stars:
        """Vertices by lot, no two of them neighbours, each with a short edge to give way along."""
        n = len(self._vertex)
        tail, head = ends_of(self.triangles)
        # Around vertices that may go every neighbour is met once by the half-edges that leave, but
        # for those on borders, which the border comes back to.
        name = np.arange(1, len(tail) + 1, dtype=np.int32)
        ahead = np.unique(self._border[0].astype(np.int64) * n + self._border[1])
        name = np.concatenate([name, -np.ones(len(ahead), np.int32)])
        tail, head = np.concatenate([tail, ahead % n]), np.concatenate([head, ahead // n])
        leaving = sparse.coo_array((name, (tail, head)), shape=(n, n)).tocsr()
        start, other = leaving.indptr, leaving.indices
        count = np.diff(start)
        place = self._place
        along = place[other]
        along -= np.repeat(place, count, axis=0)
        square = np.einsum("hc,hc->h", along, along)
        short = square < (SHORT * aim) ** 2
        short &= self._along_borders(np.repeat(np.arange(n), count), other, ahead)
        free = ~self._held & np.logical_or.reduceat(short, start[:-1])
        lot = self._lots.permutation(n).astype(np.int32)
        chosen = np.zeros(n, bool)
        for _ in range(DRAWINGS):
            drawn = np.where(free, lot, np.int32(n))
            first = free & (drawn < np.minimum.reduceat(drawn[other], start[:-1]))
            chosen |= first
            free &= ~first & ~np.logical_or.reduceat(first[other], start[:-1])
        gone = np.flatnonzero(chosen)
        if len(gone) > most:
            gone = np.sort(gone[np.argpartition(lot[gone], most)[:most]])
        count = count[gone]
        rows = spans(start[gone], count)
        whose = np.repeat(np.arange(len(gone)), count)
        wish = np.where(short[rows], square[rows] * self._lots.uniform(0.5, 1.5, len(rows)), np.inf)
        first = np.cumsum(count) - count
        hit = np.flatnonzero(wish == np.minimum.reduceat(wish, first)[whose]) if len(gone) else rows
        kept = np.empty(len(gone), np.int32)
        kept[whose[hit]] = other[rows[hit]]
        corner = leaving.data[rows] - 1
        whose, corner = whose[corner >= 0], corner[corner >= 0]
        flat = self.triangles.ravel()
        return _Stars(gone, kept, whose, corner, flat[following(corner)], flat[previous(corner)])

    @property
    def _on_border(self) -> np.ndarray:
        """(n,) bool vertices on borders."""
        found = np.zeros(len(self._vertex), bool)
        found[self._border[0]] = True
        return found

    def _along_borders(self, tail: np.ndarray, head: np.ndarray, ahead: np.ndarray) -> np.ndarray:
        """(h,) bool half-edges that vertices may go along: those on borders to the next."""
        if not len(ahead):
            return np.ones(len(tail), bool)
        key = tail.astype(np.int64) * len(self._vertex) + head
        place = np.minimum(np.searchsorted(ahead, key), len(ahead) - 1)
        return ~self._on_border[tail] | (ahead[place] == key)

    def _dented(self, stars: _Stars, aim: float) -> np.ndarray:
        """(k,) bool vertices of borders that are far from where the border would go without them,
        or lie in one triangle only."""
        n = len(self._vertex)
        before = np.full(n, -1)
        before[self._border[1]] = self._border[0]
        before = before[stars.gone]
        place = self._place
        start, end = place[before], place[stars.kept]
        along = end - start
        square = np.maximum(np.einsum("kc,kc->k", along, along), np.finfo(float).tiny)
        out = place[stars.gone] - start
        share = np.clip(np.einsum("kc,kc->k", out, along) / square, 0.0, 1.0)
        off = np.linalg.norm(out - share[:, None] * along, axis=1)
        alone = np.bincount(stars.whose, minlength=len(before)) < 2
        return (before >= 0) & (alone | (off > DENTED * aim))

    def _linked(self, stars: _Stars) -> np.ndarray:
        """(k,) bool whether the two ends of an edge have only the neighbours in common that its
        triangles show."""
        n = len(self._vertex)
        # Along a border the half-edge that comes back is missing.
        tail, head = (
            np.concatenate([inner, open_])
            for inner, open_ in zip(ends_of(self.triangles), self._border[::-1], strict=True)
        )
        ones = np.ones(len(tail), np.int8)
        adjacency = sparse.coo_array((ones, (tail, head)), shape=(n, n)).tocsr()
        both = adjacency[stars.gone].multiply(adjacency[stars.kept])
        return np.asarray(both.sum(axis=1)).ravel() == np.where(self._on_border[stars.gone], 1, 2)


def _repeated(stars: _Stars, refused: np.ndarray, on_border: np.ndarray) -> np.ndarray:
    """(k,) bool vertices whose going makes an edge that another's makes as well."""
    n = len(on_border)
    dead, kept = stars.dead, stars.kept[stars.whose]
    # Where the fan of new triangles begins lies an edge that was there before.
    begin = np.full(len(stars.gone), -1)
    starting = dead & (stars.one == kept)
    begin[stars.whose[starting]] = stars.two[starting]
    rows = np.flatnonzero(~dead & (stars.one != begin[stars.whose]) & ~refused[stars.whose])
    one, two = stars.one[rows], kept[rows]
    # Where the fan of a vertex on a border ends lies another new one; other fans end where they
    # begin.
    open_ = np.flatnonzero(on_border[stars.gone][stars.whose])
    fan = stars.whose[open_] * np.int64(n)
    ending = ~np.isin(fan + stars.two[open_], fan + stars.one[open_])
    ending &= ~dead[open_] & ~refused[stars.whose[open_]]
    last = open_[ending]
    rows = np.concatenate([rows, last])
    one, two = np.concatenate([one, stars.two[last]]), np.concatenate([two, kept[last]])
    key = edge_keys(one, two, n)
    order = np.argsort(key, kind="stable")
    again = np.flatnonzero(np.diff(key[order]) == 0) + 1
    found = np.zeros(len(stars.gone), bool)
    found[stars.whose[rows[order[again]]]] = True
    return found


def _spoiled(place: np.ndarray, stars: _Stars, aim: float) -> np.ndarray:
    """(s,) bool triangles that would be turned, flattened or stretched too much."""
    gone, kept = (place[rows[stars.whose]] for rows in (stars.gone, stars.kept))
    one, two = place[stars.one], place[stars.two]
    far = one - two
    rim = np.einsum("sc,sc->s", far, far)
    normals, sizes, shapes, longest = [], [], [], rim
    for corner in (gone, kept):
        a, b = one - corner, two - corner
        normal = np.cross(a, b)
        size = np.sqrt(np.einsum("sc,sc->s", normal, normal))
        sides = np.einsum("sc,sc->s", a, a), np.einsum("sc,sc->s", b, b)
        total = np.maximum(rim + sides[0] + sides[1], np.finfo(float).tiny)
        normals.append(normal)
        sizes.append(size)
        shapes.append(2.0 * np.sqrt(3.0) * size / total)
        longest = np.maximum(rim, np.maximum(*sides))
    turned = np.einsum("sc,sc->s", *normals) < TURN * sizes[0] * sizes[1]
    # A triangle without area has no normal to keep.
    turned &= shapes[0] > FLAT
    worse = shapes[1] < np.minimum(SHAPE, 0.5 * shapes[0])
    return turned | worse | (longest > (LONG * aim) ** 2)
