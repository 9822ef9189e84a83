"""How little a cross field need be smoothed: what saves no pole only turns it from the curvature.

Smoothed over the usual length a field has the poles that quads have room for. Less is better where
that brings no more of them, as on a machine part; where it does, as on a scan, it is not.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ...base.progress import Progress
from ...fields.connection import weights_and_areas
from ...mesh.surface import Surface
from ..field_settings import USUAL_SMOOTHNESS
from .smoothing import per_component, smoothing_lengths

# Smoothness whose length is an edge of a mesh of 2,000 quads: singularities are taken together that
# are nearer than that, if the field is as smooth; what is smoother lets go of them by itself.
QUAD_EDGE = 0.4
# Lengths tried, in such edges: from half of one, since what turns within less no quad can show, to
# where the usual ones begin.
EDGES = (0.5, 0.7, 1.0)
# So many times the poles are no more of them, and so many degrees nearer to the measured directions
# can be seen. Chosen on the shapes of benchmarks.features.
AS_MANY, SEEN = 1.1, 0.5


@dataclass(frozen=True)
class Smoothed:
    """Crosses smoothed over a length.

    Attributes
    ----------
    direction:
        (n, 3) float64 one unit direction at each vertex.
    strength:
        (n,) float64 near 0 around singularities and where directions compete.
    index:
        (m,) float64 index in each triangle.
    length:
        (n,) float64 that they are smoothed over.
    angle:
        (n,) float64 degrees between the directions and the measured ones.
    """

    direction: np.ndarray
    strength: np.ndarray
    index: np.ndarray
    length: np.ndarray
    angle: np.ndarray


def least_smoothed(
    surface: Surface,
    smoothed: Callable[[np.ndarray, Progress], Smoothed],
    weight: np.ndarray,
    progress: Progress,
) -> Smoothed:
    """Of each component the field that is smoothed least of those that have as few poles as the
    usual one and are nearer to the measured directions; else the usual one.

    Parameters
    ----------
    smoothed:
        Gives the field that is smoothed over lengths (n,).
    weight:
        (n,) float64 how much the measured directions count, by their area and certainty.
    """
    _, area = weights_and_areas(surface)
    edge = smoothing_lengths(surface, area, QUAD_EDGE)
    count = len(EDGES) + 1
    usual = smoothing_lengths(surface, area, USUAL_SMOOTHNESS)
    found = smoothed(usual, progress.part("Solving", 0.0, 1.0 / count))
    total = np.maximum(per_component(surface, weight), np.finfo(float).tiny)

    def angle(field: Smoothed) -> np.ndarray:
        return per_component(surface, weight * field.angle) / total

    most, farthest = AS_MANY * _load(surface, found.index, edge), angle(found) - SEEN
    settled = farthest <= 0.0
    mine = surface.component[surface.triangles[:, 0]]
    for number, edges in enumerate(EDGES, 1):
        if settled.all():
            break
        part = progress.part("Solving", number / count, (number + 1) / count)
        less = smoothed(edges * edge, part)
        better = (_load(surface, less.index, edge) <= most) & (angle(less) < farthest) & ~settled
        vertex = better[surface.component]
        found = Smoothed(
            np.where(vertex[:, None], less.direction, found.direction),
            np.where(vertex, less.strength, found.strength),
            np.where(better[mine], less.index, found.index),
            np.where(vertex, less.length, found.length),
            np.where(vertex, less.angle, found.angle),
        )
        settled |= better
    return found


def _load(surface: Surface, index: np.ndarray, edge: np.ndarray) -> np.ndarray:
    """How many poles each component has; those nearer than the edge (n,) of a quad to one of the
    other sign count twice."""
    single = np.flatnonzero(index)
    corner = surface.triangles[single]
    component = surface.component[corner[:, 0]]
    reach = edge[corner[:, 0]]
    # Components lie apart along a fourth axis.
    apart = 2.0 * float(np.ptp(surface.vertices, axis=0).max()) * component
    place = np.column_stack([surface.vertices[corner].mean(axis=1), apart])
    near = np.zeros(len(single), bool)
    for sign in (1.0, -1.0):
        own, other = (np.flatnonzero(sign * side * index[single] > 0) for side in (1.0, -1.0))
        if len(own) and len(other):
            near[own] = cKDTree(place[other]).query(place[own])[0] < reach[own]
    return surface.by_component(single, 4.0 * np.abs(index[single]) * (1 + near))
