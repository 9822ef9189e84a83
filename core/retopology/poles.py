"""The pole plan: where a quad mesh that follows the curvature has its irregular vertices.

An umbilic of index +1/2 becomes two vertices of valence 3, one of index -1/2 two of valence 5:
the valence is 4 - 4 I for a singularity of index I of the cross field, and on a closed surface
the sum of 4 - valence over all poles is four times the Euler characteristic.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from ..base.unit import unit
from ..curvature.tolerances import PAIR_NOISE
from ..fields.planes import FaceFrames
from ..mesh.input_map import places_in_input, places_on_surface
from ..mesh.surface import Surface
from ..umbilics.result import Region, Umbilics
from .crosses.cross_field import CrossField
from .pole_places import Gathered, Singularities, across_separatrices, outside, remaining

# A singularity of the smoothed field belongs to an umbilic up to this many smoothing lengths
# and edges away.
CLAIM_LENGTHS, CLAIM_EDGES = 8.0, 6.0
# Candidates looked at for each singularity.
CANDIDATES = 12
# Confidence of a pole that no umbilic asks for: the sum does, its place is the field's.
UNATTACHED = 0.5


@dataclass(frozen=True)
class Poles:
    """The planned poles, one row each, in the rows and coordinates of the input mesh.

    Attributes
    ----------
    position, normal:
        (k, 3) float64 point on the mesh and unit normal there.
    triangle, barycentric:
        (k,) int64 input triangle and (k, 3) float64 weights of its corners.
    valence:
        (k,) int64 number of edges that should meet there: 3 or 5.
    umbilic:
        (k,) int64 row of the kept umbilic it comes from, -1 for none.
    region:
        (k,) int64 region it stands in, -1 for none.
    moved:
        (k,) bool, True where a marked zone was avoided.
    confidence:
        (k,) float64 0 to 1: how far the umbilic rises out of the noise.
    total:
        Sum of 4 - valence.
    expected:
        Four times the Euler characteristic; NaN where an open border leaves it free.
    """

    position: np.ndarray
    normal: np.ndarray
    triangle: np.ndarray
    barycentric: np.ndarray
    valence: np.ndarray
    umbilic: np.ndarray
    region: np.ndarray
    moved: np.ndarray
    confidence: np.ndarray
    total: int
    expected: float

    def __len__(self) -> int:
        return len(self.valence)

    @classmethod
    def none(cls) -> Poles:
        """No poles at all."""
        places, rows = np.zeros((0, 3)), np.zeros(0, np.int64)
        return cls.placed(places, np.zeros((0, 3), np.int64), rows, places, rows)

    @classmethod
    def placed(
        cls,
        vertices: np.ndarray,
        triangles: np.ndarray,
        triangle: np.ndarray,
        barycentric: np.ndarray,
        valence: np.ndarray,
    ) -> Poles:
        """Poles that are known by triangle (k,), weights (k, 3) and valence (k,) on a mesh of
        vertices (n, 3) and triangles (m, 3); where they come from is not told."""
        corner = vertices[triangles[triangle]]
        count = len(valence)
        none = np.full(count, -1)
        return cls(
            position=np.einsum("kc,kcx->kx", barycentric, corner),
            normal=unit(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])),
            triangle=triangle,
            barycentric=barycentric,
            valence=valence,
            umbilic=none,
            region=none,
            moved=np.zeros(count, bool),
            confidence=np.full(count, UNATTACHED),
            total=int((4 - valence).sum()),
            expected=float("nan"),
        )


def plan_poles(
    surface: Surface,
    planes: FaceFrames,
    cross: CrossField,
    umbilics: Umbilics,
    regions: list[Region],
    zone: np.ndarray | None = None,
    plan: str = "field",
) -> Poles:
    """Poles from the kept umbilics and the singularities of the cross field.

    Each umbilic takes the nearest singularities of its sign, two of them, as they stand apart
    in the smoothed field. With plan "field" these and all its other singularities are the
    poles. With "umbilics" every umbilic has its two: what the field has lost is put across the
    separatrix; of the other singularities only as many are planned as the sum still wants, on
    regions, whose indices are spread by the field, and where the filters left the sum open.

    Parameters
    ----------
    umbilics, regions:
        Those kept by the detection, in input rows.
    zone:
        (input vertices,) bool, True where no pole is wanted.
    plan:
        `GuidanceSettings.plan`.
    """
    rows, weights = places_on_surface(surface, umbilics.triangle, umbilics.barycentric)
    umbilics = replace(umbilics, barycentric=weights)
    singular = Singularities.of(surface, cross.triangle_index)
    edge = surface.usual_side
    owner = _claimed(surface, cross, umbilics, rows, singular, edge)
    poles = Gathered([], [], [], [])
    mine = np.flatnonzero(owner >= 0)
    centre = np.full((len(singular), 3), 1.0 / 3.0)
    poles.add(singular.triangle[mine], centre[mine], singular.sign[mine], owner[mine])
    if plan == "field":
        others = np.flatnonzero(owner < 0)
        poles.add(singular.triangle[others], centre[others], singular.sign[others], owner[others])
    else:
        across_separatrices(surface, planes, cross, umbilics, rows, owner, edge, poles)
        remaining(surface, regions, cross, singular, owner, poles)
    triangle = np.concatenate(poles.triangle).astype(np.int64)
    barycentric = np.concatenate(poles.barycentric).reshape(-1, 3)
    sign = np.concatenate(poles.sign).astype(np.int64)
    umbilic = np.concatenate(poles.umbilic).astype(np.int64)
    order = np.lexsort((np.where(umbilic < 0, len(umbilics), umbilic),))
    triangle, barycentric = triangle[order], barycentric[order]
    sign, umbilic = sign[order], umbilic[order]
    triangle, barycentric, moved = outside(surface, zone, triangle, barycentric)
    confidence = _confidence(umbilics, umbilic)
    return poles_at(surface, regions, triangle, barycentric, sign, umbilic, moved, confidence)


def replanned(
    surface: Surface,
    regions: list[Region],
    poles: Poles,
    row: np.ndarray,
    triangle: np.ndarray,
    sign: np.ndarray,
) -> Poles:
    """Some of the poles and others: (p,) the row of each among them, -1 for none, its triangle of
    the surface, in whose middle it stands if that is another one, and 4 - valence."""
    known = row >= 0
    barycentric = np.full((len(row), 3), 1.0 / 3.0)
    before, weights = places_on_surface(surface, poles.triangle, poles.barycentric)
    stay = known & (triangle == before[row])
    barycentric[stay] = weights[row[stay]]
    umbilic, moved = np.full(len(row), -1), np.zeros(len(row), bool)
    umbilic[known], moved[known] = poles.umbilic[row[known]], poles.moved[row[known]]
    confidence = np.full(len(row), UNATTACHED)
    confidence[known] = poles.confidence[row[known]]
    return poles_at(surface, regions, triangle, barycentric, sign, umbilic, moved, confidence)


def poles_at(
    surface: Surface,
    regions: list[Region],
    triangle: np.ndarray,
    barycentric: np.ndarray,
    sign: np.ndarray,
    umbilic: np.ndarray,
    moved: np.ndarray,
    confidence: np.ndarray,
) -> Poles:
    """Poles (k,) from their places on the surface, 4 - valence and what `Poles` says of them."""
    position = np.einsum("kc,kcx->kx", barycentric, surface.vertices[surface.triangles[triangle]])
    whose = np.full(int(surface.source_triangle.max()) + 1, -1)
    for number, found in enumerate(regions):
        whose[found.triangles] = number
    region = whose[surface.source_triangle]
    closed = bool(surface.closed.all())
    input_triangle, input_barycentric = places_in_input(surface, triangle, barycentric)
    return Poles(
        position=position * surface.unit + surface.origin,
        normal=surface.face_normal_area[0][triangle],
        triangle=input_triangle,
        barycentric=input_barycentric,
        valence=4 - sign,
        umbilic=umbilic,
        region=region[triangle],
        moved=moved,
        confidence=confidence,
        total=int(sign.sum()),
        expected=4.0 * float(surface.euler_characteristic.sum()) if closed else float("nan"),
    )


def _claimed(
    surface: Surface,
    cross: CrossField,
    umbilics: Umbilics,
    rows: np.ndarray,
    singular: Singularities,
    edge: float,
) -> np.ndarray:
    """(s,) the umbilic that takes each singularity, -1 for none; nearest pairs first."""
    owner = np.full(len(singular), -1)
    reach = CLAIM_LENGTHS * cross.smoothing + CLAIM_EDGES * edge
    component = surface.component[surface.triangles[:, 0]]
    there = (umbilics.position - surface.origin) / surface.unit
    wants = np.rint(4.0 * np.abs(umbilics.index)).astype(np.int64)
    for direction in (1, -1):
        mine = np.flatnonzero((np.sign(umbilics.index) == direction) & (rows >= 0))
        free = np.flatnonzero(singular.sign == direction)
        if not len(mine) or not len(free):
            continue
        most = min(CANDIDATES, len(mine))
        distance, near = cKDTree(there[mine]).query(singular.place[free], k=most)
        distance, near = distance.reshape(len(free), -1), near.reshape(len(free), -1)
        which = np.repeat(np.arange(len(free)), near.shape[1])
        umbilic, distance = mine[near.ravel()], distance.ravel()
        fits = distance <= reach
        fits &= component[singular.triangle[free[which]]] == component[rows[umbilic]]
        order = np.flatnonzero(fits)[np.argsort(distance[fits], kind="stable")]
        left = wants.copy()
        for item in order:
            row = free[which[item]]
            if owner[row] < 0 and left[umbilic[item]] > 0:
                owner[row] = umbilic[item]
                left[umbilic[item]] -= 1
    return owner


def _confidence(umbilics: Umbilics, umbilic: np.ndarray) -> np.ndarray:
    """(k,) persistence against the noise of a pair; halved at borders and damage."""
    result = np.full(len(umbilic), UNATTACHED)
    of = umbilic >= 0
    row = umbilic[of]
    persistence = np.nan_to_num(umbilics.persistence[row], nan=0.0, posinf=np.inf)
    noise = np.nan_to_num(PAIR_NOISE * umbilics.noise[row], nan=0.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.where(np.isinf(persistence), 1.0, persistence / (persistence + noise))
    result[of] = np.nan_to_num(share, nan=UNATTACHED) * np.where(umbilics.certain[row], 1.0, 0.5)
    return result
