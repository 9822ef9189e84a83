"""A shape as matching sees it: its umbilics with what no motion changes, and its surface."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from ..base.errors import MatchError
from ..base.words import WITHOUT_AREA
from ..curvature.field import CurvatureField
from ..fields.transport import carried, doubled_angle, tangents
from ..mesh.mending.repair import clean
from ..mesh.samples import spread_points
from ..umbilics.result import Detection, Umbilics

# Umbilics that take part: the most persistent ones.
MOST = 60
# Points of the surface that are brought onto another one, and of a denser set that they meet.
SAMPLES, DENSE = 2000, 30000
# And of those that say how exact the best motion is, and of those that a first look is taken at.
FINE, ROUGH, ROUGH_DENSE = 12000, 500, 5000
# Vertices to which the cubic form of an umbilic is fitted.
_AROUND = 24


@dataclass(frozen=True)
class Shape:
    """A mesh and its umbilics.

    Attributes
    ----------
    vertices, triangles:
        (n, 3) and (m, 3) of the mesh that was detected on.
    umbilics:
        Those to go by, at most `MOST`.
    curvature:
        Shape operators at the vertices.
    noise:
        Standard deviation of the positions as the fits see it, in length; NaN where unknown.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    umbilics: Umbilics
    curvature: CurvatureField
    noise: float

    @classmethod
    def of(cls, vertices: np.ndarray, triangles: np.ndarray, detection: Detection) -> Shape:
        """The shape of a mesh (n, 3), (m, 3) and its detection.

        Raises
        ------
        InvalidMeshError
            As `core.detect`.
        """
        surface, _ = clean(vertices, triangles)
        detection.check_mesh(len(vertices), len(triangles))
        found = detection.umbilics
        weight = np.nan_to_num(found.persistence, nan=0.0, posinf=1e300)
        rows = np.sort(np.argsort(-weight, kind="stable")[:MOST])
        field = detection.curvature
        kept = surface.source_vertex
        return cls(
            surface.vertices * surface.unit + surface.origin,
            surface.triangles,
            found.select(rows),
            CurvatureField(**{name: value[kept] for name, value in vars(field).items()}),
            detection.noise,
        )

    @cached_property
    def size(self) -> float:
        """Diagonal of the bounding box."""
        return float(np.linalg.norm(np.ptp(self.vertices, axis=0)))

    @cached_property
    def face_normal_area(self) -> tuple[np.ndarray, np.ndarray]:
        """(m, 3) unit normals of the triangles and (m,) their areas."""
        a, b, c = (self.vertices[self.triangles[:, k]] for k in range(3))
        cross = np.cross(b - a, c - a)
        length = np.linalg.norm(cross, axis=1)
        return cross / np.maximum(length, np.finfo(float).tiny)[:, None], 0.5 * length

    @cached_property
    def samples(self) -> tuple[np.ndarray, np.ndarray]:
        """(s, 3) points of the surface and their normals."""
        return self._spread(SAMPLES, 0)

    @cached_property
    def fine_samples(self) -> tuple[np.ndarray, np.ndarray]:
        """As `samples`, more of them."""
        return self._spread(FINE, 2)

    @cached_property
    def target(self) -> tuple[cKDTree, np.ndarray]:
        """A tree of many more points, and their normals."""
        points, normals = self._spread(DENSE, 1)
        return cKDTree(points), normals

    @cached_property
    def rough_target(self) -> tuple[cKDTree, np.ndarray]:
        """As `target`, of fewer points."""
        points, normals = self._spread(ROUGH_DENSE, 1)
        return cKDTree(points), normals

    def _spread(self, count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
        random = np.random.default_rng(seed)
        area = self.face_normal_area
        if not area[1].any():
            raise MatchError(WITHOUT_AREA)
        return spread_points(self.vertices, self.triangles, area, count, random)

    @cached_property
    def cubic(self) -> tuple[np.ndarray, np.ndarray]:
        """(k,) steepness |p| + |q| of the deviator D = p z + q conj(z) at each umbilic, in
        1 / length^2, and (k,) |q| over it: what no rotation of the tangent plane changes of the
        cubic form. Fitted to the operators of the nearest vertices."""
        places, normals = self.umbilics.position, self.umbilics.normal
        if not len(places):
            return np.zeros(0), np.zeros(0)
        count = min(_AROUND, len(self.vertices))
        _, near = cKDTree(self.vertices).query(places, k=count)
        near = near.reshape(len(places), count)
        field = self.curvature
        e1, e2 = tangents(normals)
        flat = near.ravel()
        owner = np.repeat(np.arange(len(places)), count)
        d1 = carried(field.d1[flat], field.normal[flat], normals[owner])
        deviator = doubled_angle(d1, e1[owner], e2[owner], field.gap[flat]).reshape(near.shape)
        offset = self.vertices[near] - places[:, None]
        z = np.einsum("kac,kc->ka", offset, e1) + 1j * np.einsum("kac,kc->ka", offset, e2)
        scale = np.abs(z).max(axis=1, keepdims=True)
        scale = np.maximum(scale, np.finfo(float).tiny)
        # The other side of a thin part lies near too, but turned away.
        here = np.einsum("kac,kc->ka", field.normal[near], normals) > 0.5
        design = np.stack([np.ones_like(z), z / scale, np.conj(z / scale)], axis=2)
        design = np.where(here[..., None], design, 0.0)
        inverse = np.linalg.pinv(design)
        found = np.einsum("kja,ka->kj", inverse, np.where(here, deviator, 0.0))
        p, q = np.abs(found[:, 1] / scale[:, 0]), np.abs(found[:, 2] / scale[:, 0])
        return p + q, q / np.maximum(p + q, np.finfo(float).tiny)
