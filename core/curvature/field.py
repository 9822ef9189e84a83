"""The shape operators of a surface, vertex by vertex."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..fields.directions import DirectionField
from ..fields.frames import principal_directions
from ..fields.transport import tangents


@dataclass(frozen=True)
class CurvatureField:
    """Shape operators at the vertices of the input mesh.

    Attributes
    ----------
    k1, k2:
        (n,) float64 principal curvatures, k1 >= k2, in 1 / length; a sphere of radius R with
        outward normals has both +1/R. NaN at vertices without a face.
    d1, d2:
        (n, 3) float64 unit principal directions (a line: the sign means nothing), with
        d1 x d2 = normal. NaN at vertices without a face.
    normal:
        (n, 3) float64 unit outward normals. NaN at vertices without a face.
    noise:
        (n,) float64 standard error of the gap k1 - k2 estimated from the fit, in 1 / length;
        NaN where it is not known (curvature "normals" or "given").
    """

    k1: np.ndarray
    k2: np.ndarray
    d1: np.ndarray
    d2: np.ndarray
    normal: np.ndarray
    noise: np.ndarray

    @property
    def gap(self) -> np.ndarray:
        """(n,) k1 - k2, the length of the deviator, in 1 / length; 0 at an umbilic."""
        return self.k1 - self.k2

    @property
    def lines(self) -> DirectionField:
        """The field of the first principal directions, with the gap for magnitude."""
        return DirectionField(self.d1, self.normal, self.gap)


def field_from_deviators(
    mean: np.ndarray, deviator: np.ndarray, normals: np.ndarray, noise: np.ndarray
) -> CurvatureField:
    """The curvatures and directions of mean curvature (n,) and complex deviator (n,) in the
    frames `tangents(normals)`."""
    e1, e2 = tangents(normals)
    gap = np.abs(deviator)
    cosine, sine = principal_directions(deviator.real, deviator.imag, gap)
    d1 = cosine[:, None] * e1 + sine[:, None] * e2
    d2 = cosine[:, None] * e2 - sine[:, None] * e1
    return CurvatureField(mean + 0.5 * gap, mean - 0.5 * gap, d1, d2, normals, noise)
