"""Quads for a piece that no layout was found for: every triangle of it cut into three.

They follow nothing but features and borders, yet the piece is covered, closed and joined as it
was, which a piece that is missing would not be.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....base.progress import Progress
from ....base.subsets import places_in
from ....fields.frames import side_axes
from ...poles import UNATTACHED
from ..conformity import conformity
from ..layout.wishes import Wishes
from ..result import QuadMesh
from ..surface.decimation import coarsened
from ..surface.subdivision import Triangles
from ..surface.working_surface import WorkingSurface
from .guides import Guides, vertex_normals
from .mending import mend, oriented_quality
from .projection import ClosestPoints
from .reporting import angle_to_curvature

# Quads that a triangle is cut into.
EACH = 3
# Vertices go to the surface if it is nearer than this part of the mean side.
NEAR = 0.5
# Quads of a tetrahedron: no closed surface has fewer triangles.
FEWEST = 12


@dataclass(frozen=True)
class Unlaid:
    """A piece without a layout, and what was wished for it."""

    working: WorkingSurface
    wishes: Wishes

    @property
    def asked(self) -> int:
        """How many quads fit its size."""
        _, area = self.working.surface.face_normal_area
        return max(round(float((area / self.wishes.size**2).sum())), FEWEST)


def cut_in_three(piece: Unlaid, progress: Progress) -> tuple[QuadMesh, int]:
    """About as many quads as were asked for, fewer where the surface has fewer triangles and more
    where features and borders have more vertices; and how many of them are folded."""
    surface = piece.working.surface
    triangles = surface.triangles.astype(np.int64)
    mesh = Triangles(
        surface.vertices,
        triangles,
        np.zeros((len(surface.vertices), 0)),
        np.arange(len(triangles)),
        piece.working.feature,
    )
    mesh = coarsened(mesh, piece.asked // EACH, progress)
    position, quads, held, on_feature = _thirds(mesh)
    closest = ClosestPoints(surface.vertices, surface.triangles, surface.twin)
    below = closest(position, vertex_normals(position, quads))[1]
    # Between sheets that are near each other the closest point may be on the wrong one.
    side = np.linalg.norm(position[quads] - position[np.roll(quads, -1, axis=1)], axis=2).mean()
    near = ~held & (np.linalg.norm(below - position, axis=1) < NEAR * side)
    position[near] = below[near]
    guides = Guides(
        surface=closest,
        direction=side_axes(surface)[0],
        size=piece.wishes.size,
        fixed=held,
        curve=np.full(len(position), -1),
        beside=np.full((len(position), 2), -1),
        curves={},
    )
    mend(position, quads, guides, progress)
    folded = int(np.count_nonzero(oriented_quality(position, quads, guides) <= 0.0))
    triangle, _ = closest(position, vertex_normals(position, quads))
    topology = conformity(quads, len(position))
    irregular = topology.irregular
    made = QuadMesh(
        vertices=position * surface.unit + surface.origin,
        quads=quads,
        pole=places_in(irregular, len(position)),
        pole_valence=topology.valence[irregular],
        pole_umbilic=np.full(len(irregular), -1),
        pole_confidence=np.full(len(irregular), UNATTACHED),
        border=topology.border,
        feature=on_feature & ~topology.border,
        patch=np.arange(len(quads)) // EACH,
        angle=angle_to_curvature(piece.working, position, quads),
        source_triangle=surface.source_triangle[triangle],
    )
    return made, folded


def _thirds(mesh: Triangles) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Vertices (n, 3): corners, middles of the edges and of the triangles; quads (q, 4); and (n,)
    bool each, vertices on features or borders, and on features."""
    triangles = mesh.triangles
    n, m = len(mesh.vertices), len(triangles)
    tail, head = mesh.ends
    low, high = np.minimum(tail, head), np.maximum(tail, head)
    edge, first, row, uses = np.unique(
        low * n + high, return_index=True, return_inverse=True, return_counts=True
    )
    middle = n + row.reshape(m, 3)
    centre = n + len(edge) + np.arange(m)
    place = mesh.vertices
    position = np.concatenate(
        [place, 0.5 * (place[low[first]] + place[high[first]]), place[triangles].mean(axis=1)]
    )
    quads = np.stack(
        [
            np.stack([triangles[:, k], middle[:, k], centre, middle[:, (k + 2) % 3]], axis=1)
            for k in range(3)
        ],
        axis=1,
    ).reshape(-1, 4)
    on_feature = np.zeros(len(position), bool)
    held = on_feature.copy()
    sharp = mesh.feature[first] > 0
    for found, edges in ((on_feature, sharp), (held, sharp | (uses == 1))):
        found[low[first[edges]]] = found[high[first[edges]]] = True
        found[n + np.flatnonzero(edges)] = True
    return position, quads, held, on_feature
