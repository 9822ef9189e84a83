"""Fits around places laid over a field of shape operators, without a seam.

Each fit holds over a disc around its place and fades into the field towards the disc's rim; where
discs overlap, the fits are averaged by their inverse variances.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ...fields.transport import carried, doubled_angle, tangents
from ...mesh.surface import Surface
from ..field import CurvatureField, field_from_deviators
from ..fits.flattened import flattened, round_operator
from .windows import Fits, growth_of

# Radius of the disc over which a fit replaces the field, in radii of the narrowest window: as far
# as the windows were compared. From half of it on it fades into the field.
DISC = 1.0
# Parts of the surface's length along each axis by which vertices far from all discs are left out.
SLABS = 1024


@dataclass
class Blend:
    """A field and what is laid over it, vertex by vertex; see `add`."""

    under: CurvatureField
    upper: CurvatureField
    share: np.ndarray
    weight: np.ndarray
    spread: np.ndarray
    mean: np.ndarray
    deviator: np.ndarray
    normal: np.ndarray
    radius: np.ndarray
    rings: np.ndarray
    degrees: np.ndarray
    best: np.ndarray

    @classmethod
    def over(cls, field: CurvatureField, radius: np.ndarray) -> Blend:
        """A blend with nothing yet over a field of n vertices, whose fits have radii (n,)."""
        n = len(radius)
        return cls(
            under=field,
            upper=CurvatureField(**{name: value.copy() for name, value in vars(field).items()}),
            share=np.zeros(n),
            weight=np.zeros(n),
            spread=np.zeros(n),
            mean=np.zeros(n),
            deviator=np.zeros(n, np.complex128),
            normal=np.zeros((n, 3)),
            radius=radius.copy(),
            rings=np.zeros(n, np.int64),
            degrees=np.zeros(n, np.int64),
            best=np.zeros(n),
        )

    def add(self, surface: Surface, fits: Fits, exact: np.ndarray | None) -> None:
        """Lay fits over the field, each over its disc, weighted by their inverse variances."""
        reach = DISC * fits.narrow
        known = np.flatnonzero(fits.rings > 0)
        near = _within_slabs(surface.coordinates, fits.centre[known].T, reach[known])
        tree = cKDTree(surface.vertices[near])
        balls = tree.query_ball_point(fits.centre[known], reach[known])
        of = np.repeat(known, [len(ball) for ball in balls])
        row = np.concatenate([near[ball] for ball in balls] or [np.zeros(0, np.int64)])
        offset = surface.vertices[row] - fits.centre[of]
        x, y, z = np.einsum("bc,kcb->kb", offset, fits.axes[:, :, of])
        distance = np.sqrt(x * x + y * y) / reach[of]
        # Not what lies on another sheet of the surface, nor where the cubics know better.
        inside = (distance < 1.0) & (np.abs(z) < reach[of])
        inside &= np.einsum("bc,cb->b", self.under.normal[row], fits.axes[2][:, of]) > 0.5
        away = distance * reach[of] / fits.radius[of]
        square = fits.error[of] ** 2 * growth_of(fits.degree[of], away) + fits.bias[of] ** 2
        inside &= square < self.under.noise[row] ** 2
        if exact is not None:
            inside &= ~exact[row]
        of, row, x, y, z = (a[inside] for a in (of, row, x, y, z))
        distance, square = distance[inside], square[inside]
        unit, bend = fits.radius[of], fits.bend[of]
        coefficients = {term: values[of] for term, values in fits.coefficients.items()}
        u, v, _, _ = flattened(x, y, z, bend)
        operator = round_operator(coefficients, unit, bend, u / unit, v / unit)
        axes = fits.axes[:, :, of]
        normal = operator.normal(axes)
        under = self.under.normal[row]
        e1, e2 = tangents(under)
        first = carried(operator.tangent(1.0, 0.0, axes), normal, under)
        turned = doubled_angle(first, e1, e2)
        turned /= np.abs(turned)
        taper = np.clip(2.0 - 2.0 * distance, 0.0, 1.0)
        weight = taper / square
        value = turned * operator.deviator
        np.maximum.at(self.share, row, taper)
        for whole, part in (
            (self.weight, weight),
            (self.spread, taper),
            (self.mean, weight * operator.mean),
            (self.deviator, weight * value),
            (self.normal, weight[:, None] * normal),
        ):
            np.add.at(whole, row, part)
        order = np.argsort(weight, kind="stable")
        order = order[weight[order] > self.best[row[order]]]
        self.best[row[order]] = weight[order]
        self.radius[row[order]] = unit[order]
        self.rings[row[order]] = fits.rings[of[order]]
        self.degrees[row[order]] = fits.degree[of[order]]

    def field(self) -> CurvatureField:
        """What lies uppermost, of which a later `field` is the same one, brought up to date."""
        rows = np.flatnonzero(self.weight > 0)
        field, share, weight = self.under, self.share[rows], self.weight[rows]
        under = field.normal[rows]
        normal = (1 - share)[:, None] * under + (share / weight)[:, None] * self.normal[rows]
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        e1, e2 = tangents(under)
        old = doubled_angle(field.d1[rows], e1, e2, (field.k1 - field.k2)[rows])
        deviator = (1 - share) * old + share / weight * self.deviator[rows]
        mean = 0.5 * (1 - share) * (field.k1 + field.k2)[rows] + share / weight * self.mean[rows]
        noise = np.sqrt((1 - share) * field.noise[rows] ** 2 + share * self.spread[rows] / weight)
        flat = field_from_deviators(mean, deviator, under, noise)
        d1 = carried(flat.d1, under, normal)
        for name, value in (
            ("k1", flat.k1),
            ("k2", flat.k2),
            ("d1", d1),
            ("d2", np.cross(normal, d1)),
            ("normal", normal),
            ("noise", noise),
        ):
            getattr(self.upper, name)[rows] = value
        return self.upper


def _within_slabs(points: np.ndarray, centres: np.ndarray, reach: np.ndarray) -> np.ndarray:
    """Ascending numbers of the points (3, n) that lie, axis by axis, as near to some of the
    centres (3, k) as these reach (k,) or a little farther: all that balls around them can hold."""
    inside = np.ones(points.shape[1], bool)
    for along, middle in zip(points, centres, strict=True):
        low, width = along.min(), max(float(np.ptp(along)), np.finfo(float).tiny) / SLABS
        first, last = (
            np.clip((middle + side - low) / width, 0, SLABS - 1).astype(np.intp)
            for side in (-reach, reach)
        )
        # Slabs that centres reach into: as many begin before as end after.
        begun = np.bincount(first, minlength=SLABS + 1) - np.bincount(last + 1, minlength=SLABS + 1)
        touched = np.append(np.cumsum(begun)[:SLABS] > 0, False)
        touched[SLABS] = touched[SLABS - 1]
        inside &= touched[((along - low) / width).astype(np.intp)]
    return np.flatnonzero(inside)
