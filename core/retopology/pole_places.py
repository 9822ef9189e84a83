"""Places for poles that the cross field does not hold, and places outside of a zone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csgraph
from scipy.spatial import cKDTree

from ..base.progress import Progress
from ..base.subsets import places_in
from ..fields.planes import FaceFrames, barycentric_of, in_plane, places
from ..mesh.rings import adjacency
from ..mesh.surface import Surface
from ..umbilics.result import Region, Umbilics
from .crosses.cross_field import CrossField
from .lines.tracing import Obstacles, Starts, trace

# Poles of an umbilic whose singularities are not in the field stand this many smoothing lengths,
# but at least so many edges, to either side.
APART_LENGTHS, APART_EDGES = 0.5, 1.0


@dataclass(frozen=True)
class Singularities:
    """The quarter singularities of a cross field, one row for each quarter.

    Attributes
    ----------
    triangle:
        (s,) int64 triangle of the surface.
    sign:
        (s,) int64 of the index, 1 or -1.
    place:
        (s, 3) float64 its middle, in the coordinates of the surface.
    """

    triangle: np.ndarray
    sign: np.ndarray
    place: np.ndarray

    def __len__(self) -> int:
        return len(self.sign)

    @classmethod
    def of(cls, surface: Surface, index: np.ndarray) -> Singularities:
        """Those of a field with the indices (m,) in the triangles.

        A triangle with all corners on a border has room for none: they leave over it.
        """
        quarters = np.rint(4.0 * index).astype(np.int64)
        quarters[surface.border[surface.triangles].all(axis=1)] = 0
        found = np.flatnonzero(quarters)
        repeat = np.abs(quarters[found])
        triangle = np.repeat(found, repeat)
        place = surface.vertices[surface.triangles[triangle]].mean(axis=1)
        return cls(triangle, np.repeat(np.sign(quarters[found]), repeat), place)


@dataclass
class Gathered:
    """Poles by rows of the surface while they are gathered."""

    triangle: list[np.ndarray]
    barycentric: list[np.ndarray]
    sign: list[np.ndarray]
    umbilic: list[np.ndarray]

    def add(
        self, triangle: np.ndarray, barycentric: np.ndarray, sign: np.ndarray, umbilic: np.ndarray
    ) -> None:
        """Some more: triangles (p,), weights (p, 3), signs of the index, umbilics or -1 (p,)."""
        self.triangle.append(triangle)
        self.barycentric.append(barycentric)
        self.sign.append(sign)
        self.umbilic.append(umbilic)


def across_separatrices(
    surface: Surface,
    planes: FaceFrames,
    cross: CrossField,
    umbilics: Umbilics,
    rows: np.ndarray,
    owner: np.ndarray,
    edge: float,
    plan: Gathered,
) -> None:
    """Poles for what the field does not hold: to either side of the first separatrix."""
    wants = np.rint(4.0 * np.abs(umbilics.index)).astype(np.int64)
    has = np.bincount(owner[owner >= 0], minlength=len(umbilics))
    missing = np.where(rows >= 0, wants - has, 0)
    umbilic = np.repeat(np.arange(len(umbilics)), np.maximum(missing, 0))
    if not len(umbilic):
        return
    _, turn = np.unique(umbilic, return_index=True)
    side = np.arange(len(umbilic)) - np.repeat(turn, np.bincount(umbilic)[umbilic[turn]])
    triangle = rows[umbilic]
    ray = umbilics.separatrix[umbilic, 0]
    normal = surface.face_normal_area[0][triangle]
    across = np.cross(normal, np.nan_to_num(ray))
    unknown = np.linalg.norm(across, axis=1) < 1e-9
    corner = surface.vertices[surface.triangles[triangle]]
    across = np.where(unknown[:, None], corner[:, 1] - corner[:, 0], across)
    across *= np.where(side % 2 == 0, 1.0, -1.0)[:, None]
    z = places(planes, triangle, umbilics.barycentric[umbilic])
    distance = max(APART_LENGTHS * cross.smoothing, APART_EDGES * edge)
    count = len(umbilic)
    walk = trace(
        surface,
        planes,
        Starts.plain(
            triangle,
            z + 1e-6 * (planes.corner[triangle].mean(axis=1) - z),
            in_plane(surface, triangle, across),
            np.zeros(count),
            distance * (1.0 + side // 2),
            straight=np.inf,
        ),
        Obstacles.none(surface),
        Progress(),
    )
    last = walk.start[1:] - 1
    plan.add(
        walk.triangle[last],
        barycentric_of(planes, walk.triangle[last], walk.z[last]),
        np.sign(umbilics.index[umbilic]),
        umbilic,
    )


def remaining(
    surface: Surface,
    regions: list[Region],
    cross: CrossField,
    singular: Singularities,
    owner: np.ndarray,
    plan: Gathered,
) -> None:
    """Unclaimed singularities that the sum of each component still wants."""
    component = surface.component[surface.triangles[:, 0]]
    count = len(surface.closed)
    planned = np.concatenate(plan.triangle).astype(np.int64)
    have = np.bincount(component[planned], weights=np.concatenate(plan.sign), minlength=count)
    spread = np.zeros(count)
    rows = places_in(surface.source_triangle, int(surface.source_triangle.max()) + 1)
    for region in regions:
        inside = rows[region.triangles]
        inside = inside[inside >= 0]
        if len(inside):
            spread[component[inside[0]]] += 4.0 * region.index
    lacking = np.where(surface.closed, 4.0 * surface.euler_characteristic - have, spread)
    lacking = np.rint(lacking).astype(np.int64)
    free = np.flatnonzero(owner < 0)
    whose = component[singular.triangle[free]]
    for number in np.flatnonzero(lacking):
        mine = free[whose == number]
        wanted = int(np.sign(lacking[number]))
        left = _uncancelled(singular.place[mine], singular.sign[mine], wanted)
        chosen = singular.triangle[mine[left]][: abs(int(lacking[number]))]
        more = abs(int(lacking[number])) - len(chosen)
        if more > 0:
            chosen = np.concatenate([chosen, _weakest(surface, cross, component == number, more)])
        plan.add(
            chosen,
            np.full((len(chosen), 3), 1.0 / 3.0),
            np.full(len(chosen), wanted),
            np.full(len(chosen), -1),
        )


def _uncancelled(place: np.ndarray, sign: np.ndarray, wanted: int) -> np.ndarray:
    """Singularities of the wanted sign, those last that lie nearest to one of the other sign."""
    mine = np.flatnonzero(sign == wanted)
    other = np.flatnonzero(sign == -wanted)
    if not len(mine) or not len(other):
        return mine
    distance, _ = cKDTree(place[other]).query(place[mine])
    return mine[np.argsort(-distance, kind="stable")]


def _weakest(surface: Surface, cross: CrossField, mine: np.ndarray, count: int) -> np.ndarray:
    """The triangles where the field is weakest, for poles that nothing else places."""
    rows = np.flatnonzero(mine)
    strength = cross.strength[surface.triangles[rows]].mean(axis=1)
    order = rows[np.argsort(strength, kind="stable")]
    return np.resize(order, count)


def outside(
    surface: Surface, zone: np.ndarray | None, triangle: np.ndarray, barycentric: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Poles in the marked zone put on the nearest triangles outside it, each on its own."""
    moved = np.zeros(len(triangle), bool)
    if zone is None or not zone.any():
        return triangle, barycentric, moved
    marked = zone[surface.source_vertex]
    touched = marked[surface.triangles].any(axis=1)
    inside = np.flatnonzero(touched[triangle])
    if not len(inside):
        return triangle, barycentric, moved
    graph = adjacency(surface, surface.ring_lengths)
    triangle, barycentric = triangle.copy(), barycentric.copy()
    allowed = np.flatnonzero(~touched)
    taken = set(np.delete(triangle, inside).tolist())
    for row in inside:
        start = surface.triangles[triangle[row], barycentric[row].argmax()]
        distance = csgraph.dijkstra(graph, indices=start)
        reach = distance[surface.triangles[allowed]].min(axis=1)
        for choice in allowed[np.argsort(reach, kind="stable")[: len(taken) + 1]]:
            if int(choice) not in taken:
                break
        else:
            continue
        if not np.isfinite(distance[surface.triangles[choice]]).any():
            continue
        taken.add(int(choice))
        triangle[row], barycentric[row], moved[row] = choice, 1.0 / 3.0, True
    return triangle, barycentric, moved
