"""Ridges as they are handed on: lines of the input mesh that end at its umbilics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.spatial import cKDTree

from ...mesh.surface import Surface
from ...umbilics.result import Umbilics
from ..lines.polylines import Lines
from .find import KINDS, Chains
from .slopes import Slopes

# A ridge that ends within this many edges of an umbilic, or within its uncertainty, ends at it,
# if it comes along a branch of the cubic form there, to so many degrees.
REACH, BRANCH = 3.0, 30.0


@dataclass(frozen=True)
class RidgeLines(Lines):
    """Ridges, ravines and crest lines: l lines of p points.

    Attributes
    ----------
    kind:
        (l,) str of `KINDS`: "crest", "maximal" or "minimal", or one of these with "hyperbolic"
        before it, where the curvature is not largest (or least) across the line.
    strength, sharpness:
        (p,) float64 size of the principal curvature across the line, in 1 / length, and of its
        second derivative there, in 1 / length^3.
    bend:
        (p,) float64 degrees that the normal turns across the line.
    certainty:
        (p,) float64 how far it rises out of the noise, in standard errors.
    """

    kind: np.ndarray
    strength: np.ndarray
    sharpness: np.ndarray
    bend: np.ndarray
    certainty: np.ndarray

    OF_POINTS: ClassVar[tuple[str, ...]] = (
        *Lines.OF_POINTS, "strength", "sharpness", "bend", "certainty",
    )  # fmt: skip
    OF_LINES: ClassVar[tuple[str, ...]] = (*Lines.OF_LINES, "kind")


def ridge_lines(surface: Surface, slopes: Slopes, chains: Chains, umbilics: Umbilics) -> RidgeLines:
    """Chains in the rows and coordinates of the input, their open ends led to umbilics.

    Parameters
    ----------
    umbilics:
        k umbilics in input rows and coordinates; `Lines.source` and `Lines.target` are rows.
    """
    normal, _ = surface.face_normal_area
    with np.errstate(over="ignore"):
        # One after the other, as the cube of a size may be beyond all numbers, as this may be.
        sharpness = np.abs(chains.bending) / surface.unit / surface.unit / surface.unit
    points = {
        "position": chains.position * surface.unit + surface.origin,
        "normal": normal[chains.triangle],
        "triangle": surface.source_triangle[chains.triangle],
        "barycentric": chains.barycentric,
        "strength": np.abs(chains.curvature) / surface.unit,
        "sharpness": np.minimum(sharpness, np.finfo(float).max),
        "bend": chains.bend,
        "certainty": chains.certainty,
    }
    count = np.diff(chains.start)
    line = np.repeat(np.arange(len(chains)), count)
    first, last = chains.start[:-1], chains.start[1:] - 1
    source = _reached(surface, slopes, chains, first, umbilics)
    target = _reached(surface, slopes, chains, last, umbilics)
    target[target == source] = -1
    # Rows of the points in their new order; those of umbilics come from the chain's own end.
    front, back = np.flatnonzero(source >= 0), np.flatnonzero(target >= 0)
    rows = np.concatenate([first[front], np.arange(len(line)), last[back]])
    owner = np.concatenate([front, line, back])
    umbilic = np.concatenate([source[front], np.full(len(line), -1), target[back]])
    order = np.argsort(owner, kind="stable")
    rows, owner, umbilic = rows[order], owner[order], umbilic[order]
    points = {name: values[rows] for name, values in points.items()}
    at = umbilic >= 0
    for name in ("position", "normal", "triangle", "barycentric"):
        points[name][at] = getattr(umbilics, name)[umbilic[at]]
    start = np.concatenate([[0], np.cumsum(np.bincount(owner, minlength=len(chains)))])
    return RidgeLines(
        start=start.astype(np.int64),
        **points,
        family=chains.family,
        length=_lengths(points["position"], start, chains.closed),
        closed=chains.closed,
        source=source,
        target=target,
        kind=np.array(KINDS)[chains.kind],
    )


def _reached(
    surface: Surface, slopes: Slopes, chains: Chains, ends: np.ndarray, umbilics: Umbilics
) -> np.ndarray:
    """(l,) umbilic that each chain comes to at its point `ends` (l,), -1 for none."""
    reached = np.full(len(ends), -1)
    if not len(umbilics) or not len(ends):
        return reached
    place = (umbilics.position - surface.origin) / surface.unit
    distance, nearest = cKDTree(place).query(chains.position[ends])
    edge = surface.mean_sides(chains.triangle[ends])
    error = np.nan_to_num(umbilics.uncertainty, nan=0.0, posinf=0.0)[nearest] / surface.unit
    near = ~chains.closed & (distance <= REACH * np.maximum(edge, np.minimum(error, 2.0 * edge)))
    rows = np.flatnonzero(near)
    way = chains.position[ends[rows]] - place[nearest[rows]]
    vertex = surface.triangles[chains.triangle[ends[rows]], 0]
    on_branch = _on_branch(slopes, vertex, way, chains.family[rows]) | (
        distance[rows] <= 0.5 * edge[rows]
    )
    reached[rows[on_branch]] = nearest[rows[on_branch]]
    return reached


def _on_branch(
    slopes: Slopes, vertex: np.ndarray, way: np.ndarray, family: np.ndarray
) -> np.ndarray:
    """(r,) whether ways (r, 3) out of an umbilic are those of a ridge of a family (r,).

    Along the way at an angle phi the first direction has half the angle of p e^(i phi) +
    q e^(-i phi), the second is at right angles to it; on a ridge it is a root of the cubic form
    C(d, d, d) (Cazals, Faugere, Pouget & Rouillier 2006). The form is that of the fit at a vertex
    (r,) nearby.
    """
    d1, d2 = slopes.d[:, vertex]
    middle = np.arctan2(np.einsum("rc,rc->r", way, d2), np.einsum("rc,rc->r", way, d1))
    phi = middle[:, None] + np.radians(np.linspace(-BRANCH, BRANCH, 31))
    b0, b3 = slopes.e[:, vertex, None]
    b1, b2 = slopes.mixed[:, vertex, None]
    p = 0.5 * (b0 + b2 + 1j * (b1 + b3))
    q = 0.5 * (b0 - 3 * b2 + 1j * (3 * b1 - b3))
    deviator = p * np.exp(1j * phi) + q * np.exp(-1j * phi)
    angle = 0.5 * np.unwrap(np.angle(deviator), axis=1) + 0.5 * np.pi * family[:, None]
    c, s = np.cos(angle), np.sin(angle)
    form = b0 * c**3 + 3 * b1 * c * c * s + 3 * b2 * c * s * s + b3 * s**3
    return np.asarray((form.min(axis=1) <= 0) & (form.max(axis=1) >= 0))


def _lengths(points: np.ndarray, start: np.ndarray, closed: np.ndarray) -> np.ndarray:
    """(l,) lengths of lines."""
    before = np.arange(len(points)) - 1
    before[start[:-1]] = np.where(closed, start[1:] - 1, start[:-1])
    chord = np.linalg.norm(points - points[before], axis=1)
    return np.add.reduceat(chord, start[:-1]) if len(closed) else np.zeros(0)
