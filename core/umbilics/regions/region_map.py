"""Which triangles belong together: regions, and what is done with their numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ...mesh.surface import Surface
from ...mesh.tessellated import Tessellation
from .unresolved import UnresolvedSets


@dataclass(frozen=True)
class RegionMap:
    """Which triangles of a surface lie in which region.

    Attributes
    ----------
    label:
        (m,) int32 number of the region of each triangle of the surface, -1 outside.
    count:
        How many there are.
    faces:
        The exact faces that the first of them are; None without.
    curves:
        How many of those before the last `few` are curves of umbilics.
    few:
        How many of the last of them are whole pieces of too few vertices.
    """

    label: np.ndarray
    count: int
    faces: Tessellation | None = None
    curves: int = 0
    few: int = 0

    @classmethod
    def none(cls, surface: Surface) -> RegionMap:
        """No region at all."""
        return cls(np.full(len(surface.triangles), -1, dtype=np.int32), 0)

    def rows(self) -> list[np.ndarray]:
        """For each region the rows of its triangles, ascending."""
        inside = np.flatnonzero(self.label >= 0)
        inside = inside[np.argsort(self.label[inside], kind="stable")]
        ends = np.cumsum(np.bincount(self.label[inside], minlength=self.count))
        return np.split(inside, ends[:-1]) if self.count else []


def connected(surface: Surface, within: np.ndarray) -> tuple[np.ndarray, int]:
    """Number the edge-connected sets of the chosen triangles; (m,) int32, -1 elsewhere."""
    place = np.cumsum(within, dtype=np.int32) - 1
    chosen = np.flatnonzero(within)
    first, second = [], []
    # Side by side: several times faster than over the last axis of (k, 3).
    for twin in surface.twin.reshape(-1, 3).T:
        other = twin.take(chosen) // 3
        joined = np.flatnonzero((other >= 0) & within.take(other) & (other < chosen))
        first.append(joined)
        second.append(place.take(other.take(joined)))
    ends = np.concatenate(first).astype(np.int32), np.concatenate(second)
    graph = sparse.coo_array((np.ones(len(ends[0])), ends), shape=(len(chosen), len(chosen)))
    count, piece = csgraph.connected_components(graph, directed=False)
    label = np.full(len(within), -1, dtype=np.int32)
    label[chosen] = piece
    return label, int(count)


def largest_disc(
    surface: Surface, radius: np.ndarray, label: np.ndarray, count: int
) -> np.ndarray:
    """(count,) area of the disc that one fit sees, on average over each labelled set."""
    inside = np.flatnonzero(label >= 0)
    known = np.isfinite(radius)
    square = np.where(known, radius, 0.0) ** 2
    own, corners = label[inside], surface.triangles[inside].T
    total, number = (
        np.bincount(own, weights=sum(values.take(corner) for corner in corners), minlength=count)
        for values in (square, known.astype(float))
    )
    return np.pi * total / np.maximum(number, 1)


def without(regions: RegionMap, dropped: Sequence[bool] | np.ndarray) -> RegionMap:
    """The regions but for those that are `dropped`, numbered anew."""
    good = ~np.asarray(dropped, bool)
    renumbered = np.append(np.where(good, np.cumsum(good) - 1, -1), -1).astype(np.int32)
    return RegionMap(renumbered[regions.label], int(good.sum()))


def with_faces(faces: Tessellation, found: RegionMap) -> RegionMap:
    """The exact faces of a tessellated part as regions, and what is left of those `found`
    beside them."""
    outside = np.where(faces.face < 0, found.label, -1)
    kept, label = np.unique(outside[outside >= 0], return_inverse=True)
    labels = faces.face.copy()
    labels[outside >= 0] = len(faces.kinds) + label
    return RegionMap(labels, len(faces.kinds) + len(kept), faces)


def with_curves(
    surface: Surface, regions: RegionMap, sets: UnresolvedSets, triangle_index: np.ndarray
) -> RegionMap:
    """The regions, and beside them the curves of umbilics: unresolved sets that are long and
    narrow, and around which the directions do not turn.

    Where they do, there is an umbilic, whatever the shape of the set. A set that touches a region
    is the rim of that one, where its own fits and others meet.

    Parameters
    ----------
    triangle_index:
        (m,) index in each triangle of the surface.
    """
    label = sets.label
    inside = np.flatnonzero(label >= 0)
    count = len(sets.length)
    index = np.bincount(label[inside], weights=triangle_index[inside], minlength=count)
    held = np.zeros(len(surface.vertices), bool)
    held[surface.triangles[regions.label >= 0]] = True
    beside = np.zeros(count, bool)
    beside[label[inside[held[surface.triangles[inside]].any(axis=1)]]] = True
    curve = sets.curves & (index == 0.0) & ~beside
    if not curve.any():
        return regions
    number = np.append(np.where(curve, regions.count + np.cumsum(curve) - 1, -1), -1)
    labels = np.where(number[label] >= 0, number[label], regions.label).astype(np.int32)
    curves = int(curve.sum())
    return replace(regions, label=labels, count=regions.count + curves, curves=curves)
