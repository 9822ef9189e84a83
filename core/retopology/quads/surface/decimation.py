"""Coarser triangles for surfaces finer than a map needs, by collapsing edges many at once.

In each round short edges go whose neighbourhoods do not touch, chosen by lot, so that all of
them can go together. Vertices on features and borders stay, and so does the topology (link
condition: Dey et al. 1999).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import sparse

from ....base.errors import RemeshError
from ....base.progress import Progress
from ....mesh.half_edges import HalfEdges, link
from .subdivision import Triangles, chosen

# An equilateral triangle of side s has the area 0.433 s^2.
SHARE = 0.433
# Edges up to this many aimed-at lengths may go, new ones may be so long.
SHORT, LONG = 1.1, 2.0
# Cosine by which a triangle may turn, and the least shape (1 is equilateral) it may have then.
TURN, SHAPE = 0.7, 0.25
# Rounds at most, and how many may take away less than this share of the triangles.
ROUNDS, LITTLE, PATIENCE = 300, 0.002, 5


def coarsened(mesh: Triangles, most: int, progress: Progress) -> Triangles:
    """The mesh with about `most` triangles where it has more."""
    a, b, c = (mesh.vertices[mesh.triangles[:, k]] for k in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    aim = float(np.sqrt(area / most / SHARE))
    before = len(mesh.triangles)
    lots = np.random.default_rng(0)
    idle = 0
    for _ in range(ROUNDS):
        count = len(mesh.triangles)
        if count <= most or idle >= PATIENCE:
            break
        progress.step((before - count) / max(before - most, 1))
        mesh = _round(mesh, aim, lots)
        idle = idle + 1 if len(mesh.triangles) > (1.0 - LITTLE) * count else 0
    # Where an edge has come to lie on a feature only one of its sides knows.
    twin = _linked(mesh).twin
    return replace(mesh, feature=mesh.feature | np.where(twin >= 0, mesh.feature[twin], np.int8(0)))


def _linked(mesh: Triangles) -> HalfEdges:
    links = link(mesh.triangles.astype(np.int32), len(mesh.vertices))
    if links is None:
        raise RemeshError("A piece of the mesh crosses itself where it was coarsened. Repair it.")
    return links


def _round(mesh: Triangles, aim: float, lots: np.random.Generator) -> Triangles:
    """The mesh after one round of collapses."""
    n = len(mesh.vertices)
    links = _linked(mesh)
    twin = links.twin
    mesh = replace(mesh, feature=mesh.feature | np.where(twin >= 0, mesh.feature[twin], np.int8(0)))
    tail, head = mesh.ends
    held = np.zeros(n, bool)
    fixed = (mesh.feature > 0) | (twin < 0)
    held[tail[fixed]] = held[head[fixed]] = True
    edge = np.flatnonzero((np.arange(len(twin)) < twin) & (mesh.lengths < SHORT * aim))
    edge = edge[~(held[tail[edge]] & held[head[edge]])]
    if not len(edge):
        return mesh
    gone, kept = _apart(edge, lots.permutation(len(edge)), tail, head, held)
    adjacency = sparse.csr_array(
        (np.ones(len(links.neighbours)), links.neighbours, links.neighbour_start), shape=(n, n)
    )
    common = np.asarray(adjacency[gone].multiply(adjacency[kept]).sum(axis=1)).ravel()
    gone, kept = gone[common == 2], kept[common == 2]
    if not len(gone):
        return mesh
    owner = np.full(n, -1)
    owner[gone] = np.arange(len(gone))
    touched = np.flatnonzero((owner[mesh.triangles] >= 0).any(axis=1))
    corners = mesh.triangles[touched]
    whose = owner[corners].max(axis=1)
    moved = np.where(corners == gone[whose][:, None], kept[whose][:, None], corners)
    dead = (corners == kept[whose][:, None]).any(axis=1)
    bad = _spoiled(mesh.vertices, corners, moved, aim) & ~dead
    refused = np.zeros(len(gone), bool)
    refused[whose[bad]] = True
    apply = ~refused[whose]
    triangles = mesh.triangles.copy()
    triangles[touched[apply]] = moved[apply]
    alive = np.ones(len(triangles), bool)
    alive[touched[apply & dead]] = False
    return chosen(replace(mesh, triangles=triangles), np.flatnonzero(alive))


def _apart(
    edge: np.ndarray, lot: np.ndarray, tail: np.ndarray, head: np.ndarray, held: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Edges (e,) with the least lot of all that touch their neighbours: the vertices that go,
    and those that they go to."""
    one, two = tail[edge], head[edge]
    least = np.full(len(held), len(edge))
    np.minimum.at(least, one, lot)
    np.minimum.at(least, two, lot)
    around = least.copy()
    np.minimum.at(around, tail, least[head])
    np.minimum.at(around, head, least[tail])
    first = lot <= np.minimum(around[one], around[two])
    one, two = one[first], two[first]
    swap = held[one]
    return np.where(swap, two, one), np.where(swap, one, two)


def _spoiled(vertices: np.ndarray, before: np.ndarray, after: np.ndarray, aim: float) -> np.ndarray:
    """(t,) bool triangles that a collapse would turn, flatten or stretch too much."""
    old, new = vertices[before], vertices[after]
    normal = [np.cross(at[:, 1] - at[:, 0], at[:, 2] - at[:, 0]) for at in (old, new)]
    size = [np.linalg.norm(one, axis=1) for one in normal]
    cosine = np.einsum("tc,tc->t", *normal)
    square = [((np.roll(at, -1, axis=1) - at) ** 2).sum(axis=2) for at in (old, new)]
    shape = [
        2.0 * np.sqrt(3.0) * a / np.maximum(s.sum(axis=1), 1e-300)
        for a, s in zip(size, square, strict=True)
    ]
    turned = cosine < TURN * size[0] * size[1]
    return (
        turned
        | (shape[1] < np.minimum(SHAPE, 0.5 * shape[0]))
        | (square[1].max(axis=1) > (LONG * aim) ** 2)
    )
