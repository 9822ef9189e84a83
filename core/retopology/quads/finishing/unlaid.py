"""Quads for a piece that no layout was found for: every triangle of it cut into three.

They follow nothing but features and borders, yet the piece is covered, closed and joined as it
was, which a piece that is missing would not be. Within a triangle that is not flat no quad is
folded; vertices leave their triangles for the surface as far as that stays so.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ....base.progress import Progress
from ....base.subsets import places_in
from ....fields.frames import side_axes
from ...poles import UNATTACHED
from ..conformity import conformity
from ..field.wishes import Wishes
from ..result import QuadMesh
from ..surface.decimation import coarsened
from ..surface.subdivision import Triangles
from ..surface.working_surface import SCRAP, WorkingSurface
from .faults.mending import against, mend
from .faults.unfolding import laid_on, own_quality, unfolded
from .guides import Guides, on_curve, vertex_normals
from .parting import without_folds
from .projection import ClosestPoints
from .reporting import angle_to_curvature

# Quads that a triangle is cut into.
EACH = 3
# Features go where there are more triangles than so many times those that are wanted.
FAR = 4.0
# Quads of a tetrahedron: no closed surface has fewer triangles.
FEWEST = 12


@dataclass(frozen=True)
class Unlaid:
    """A piece without a layout, and what was wished for it."""

    working: WorkingSurface
    wishes: Wishes

    @property
    def area(self) -> float:
        """Its area, in quads."""
        _, area = self.working.surface.face_normal_area
        return float((area / self.wishes.size**2).sum())

    @property
    def scrap(self) -> bool:
        """Whether no layout is sought for so small a piece."""
        return self.area < SCRAP

    @property
    def asked(self) -> int:
        """How many quads fit its size."""
        return max(round(self.area), FEWEST)


def needed(piece: Unlaid, progress: Progress) -> int:
    """How many quads `cut_in_three` makes of a piece: thin rods cannot have few triangles."""
    return EACH * len(_coarse(piece, progress).triangles)


def cut_in_three(piece: Unlaid, progress: Progress) -> QuadMesh:
    """About as many quads as were asked for, fewer where the surface has fewer triangles and more
    where features and borders have more vertices, or it is thin."""
    surface = piece.working.surface
    position, quads, held, on_feature = _thirds(_coarse(piece, progress))
    closest = ClosestPoints(surface.vertices, surface.triangles, surface.twin)
    guides = Guides(
        surface=closest,
        direction=side_axes(surface)[0],
        size=piece.wishes.size,
        fixed=held,
        curve=np.full(len(position), -1),
        beside=np.full((len(position), 2), -1),
        curves={},
        thin=True,
    )
    places = _on_lines(position, held, on_feature, piece.working)
    moving = ~held | np.isfinite(places[:, 0])
    position = laid_on(position, moving, quads, guides, places)
    better = position.copy()
    mend(better, quads, guides, progress)
    position = without_folds(better, position, quads, closest)
    if (own_quality(position, quads) <= 0.0).any() or against(position, quads, closest).any():
        position = unfolded(position, quads, guides, progress)
    triangle, _ = closest(position, vertex_normals(position, quads))
    topology = conformity(quads, len(position))
    irregular = topology.irregular
    return QuadMesh(
        vertices=position * surface.unit + surface.origin,
        quads=quads,
        pole=places_in(irregular, len(position)),
        pole_valence=topology.valence[irregular],
        pole_umbilic=np.full(len(irregular), -1),
        pole_confidence=np.full(len(irregular), UNATTACHED),
        border=topology.border,
        feature=on_feature & ~topology.border,
        patch=np.arange(len(quads)) // EACH,
        angle=angle_to_curvature(piece.working, position, quads, closest),
        source_triangle=surface.source_triangle[triangle],
    )


def _on_lines(
    position: np.ndarray, held: np.ndarray, on_feature: np.ndarray, working: WorkingSurface
) -> np.ndarray:
    """(n, 3) places on borders and features nearest to the vertices that are held on them; the
    middles of coarse edges are not there. NaN for others."""
    surface = working.surface
    tail, head = surface.triangles.ravel(), surface.triangles[:, [1, 2, 0]].ravel()
    places = np.full_like(position, np.nan)
    for rows, edges in (
        (held & ~on_feature, surface.twin < 0),
        (on_feature, working.feature > 0),
    ):
        if rows.any():
            start, end = surface.vertices[tail[edges]], surface.vertices[head[edges]]
            places[rows] = on_curve(position[rows], start, end)
    return places


def _coarse(piece: Unlaid, progress: Progress) -> Triangles:
    """The surface with about as many triangles as are wanted, or as it came with where these are
    fewer; where its features have too many vertices for that, without them."""
    surface, most = piece.working.surface, piece.asked // EACH
    triangles = surface.triangles.astype(np.int64)
    mesh = Triangles(
        surface.vertices,
        triangles,
        np.zeros((len(surface.vertices), 0)),
        np.arange(len(triangles)),
        piece.working.feature,
    )
    found = coarsened(mesh, most, progress, borders=True)
    if len(found.triangles) > FAR * most and mesh.feature.any():
        found = coarsened(replace(mesh, feature=np.zeros_like(mesh.feature)), most, progress, True)
    # Along thin rods few of the edges that a map needed can go again.
    return min(found, piece.working.unrefined, key=lambda one: len(one.triangles))


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
