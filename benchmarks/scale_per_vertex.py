"""The alternative that `core.scale` was measured against: a scale for every vertex.

The same rule (Lepski 1991) with the same limits, but its medians are taken over the patch around
each vertex instead of the whole mesh. It stands in for the project's own choice while the
benchmark runs; no setting leads here.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from contextlib import contextmanager
from unittest import mock

import numpy as np
from scipy.spatial import cKDTree

from core.base.progress import Progress
from core.base.settings import Settings
from core.curvature import estimate as curvature
from core.curvature import scale
from core.curvature.estimate import Estimate
from core.curvature.field import CurvatureField
from core.curvature.from_normals import curvature_from_normals
from core.curvature.jets import Jets, fit_jets
from core.fields.frames import frame
from core.mesh.neighbourhoods import Neighbourhood, adjacency, by_size, grow, selection
from core.mesh.surface import Surface
from core.umbilics import assembly
from core.umbilics.refine import Places

PATCH_RINGS = 12
"""Rings of the patches; fewer leave so few independent fits that noise chooses the scale."""

EVERY = 12
"""One patch for so many vertices; those in between go with the nearest."""

_refine, _change_of_scale = assembly.refine, assembly.change_of_scale


@dataclasses.dataclass(frozen=True)
class Neighbourhoods:
    """Stands in for one `Neighbourhood`: `number` (n,) says which of `some` each vertex has."""

    some: list[Neighbourhood]
    number: np.ndarray

    @property
    def rings(self) -> int:
        return self.some[int(np.median(self.number))].rings


class Patches:
    """Medians over the patch around each vertex."""

    def __init__(self, surface: Surface, neighbourhood: Neighbourhood) -> None:
        n = len(surface.vertices)
        centres = np.random.default_rng(0).permutation(n)[: -(-n // EVERY)]
        start = selection(centres[:, None], n)
        self.blocks = [
            (some[rows], members)
            for some, reach in grow(start, neighbourhood.graph, PATCH_RINGS)
            for rows, members in by_size(reach, 1 << 22)
        ]
        self.count = len(centres)
        self.nearest = cKDTree(surface.vertices[centres]).query(surface.vertices)[1]

    def median(self, values: np.ndarray) -> np.ndarray:
        """(n,) median of values (n,) over the patch of each vertex."""
        result = np.empty(self.count)
        for rows, members in self.blocks:
            result[rows] = np.median(values[members], axis=0)
        return result[self.nearest]

    def disagreement(self, smaller: Jets, larger: Jets, normals: np.ndarray) -> np.ndarray:
        """(n,) median change from one scale to the next, in standard errors of the smaller."""
        e1, e2 = frame(normals.T)
        bent = np.abs(scale._deviator(smaller, e1, e2) - scale._deviator(larger, e1, e2))
        curved = np.abs(smaller.k1 + smaller.k2 - larger.k1 - larger.k2)
        change = np.maximum(self.median(bent), self.median(curved))
        error = self.median(smaller.noise)
        return np.divide(change, error, out=np.full(len(error), np.inf), where=error > 0)


@contextmanager
def scale_per_vertex() -> Iterator[None]:
    """`core.detect` chooses the scale at each vertex within this context; for jets on `auto`."""
    with (
        mock.patch.object(curvature, "_from_jets", _estimate),
        mock.patch.object(assembly, "change_of_scale", _change),
        mock.patch.object(assembly, "refine", _refined),
    ):
        yield


def _estimate(
    surface: Surface, normals: np.ndarray, settings: Settings, sharp: None, progress: Progress
) -> Estimate:
    base = Neighbourhood(surface, adjacency(surface), rings=2, focused=False)
    patches, quiet = Patches(surface, base), Progress()

    def fitted(candidate: Neighbourhood) -> Jets:
        return fit_jets(
            surface, scale.starting_normals(surface, normals, candidate, quiet), candidate, quiet
        )

    some = [dataclasses.replace(base, focused=True), base]
    fits = [fitted(neighbourhood) for neighbourhood in some]
    three = fit_jets(surface, normals, dataclasses.replace(base, rings=3), quiet)
    clean = patches.median(fits[1].residual) <= scale.ROUND_OFF * np.median(fits[1].radius)
    clean |= patches.disagreement(fits[1], three, normals) > scale.CLEAN
    number, growing = np.where(clean, 0, 1), ~clean
    stretch = scale._stretch(base, np.arange(0, len(clean), max(len(clean) // scale.SAMPLED, 1)))
    for rings in range(3, scale.MOST_RINGS + 1):
        if not growing.any():
            break
        some.append(
            dataclasses.replace(
                base, rings=rings, stretch=stretch if stretch >= scale.STRETCHED else 1.0
            )
        )
        fits.append(fitted(some[-1]))
        growing &= patches.disagreement(fits[-2], fits[-1], normals) <= scale.AGREEMENT
        number[growing] = rings - 1

    def chosen(name: str) -> np.ndarray:
        return np.array([getattr(fit, name) for fit in fits])[number, np.arange(len(number))]

    names = [item.name for item in dataclasses.fields(CurvatureField)]
    field, determined = CurvatureField(*map(chosen, names)), chosen("determined")
    if not determined.all():
        field = curvature._filled(field, curvature_from_normals(surface, normals), determined)
    residual = float(np.median(chosen("residual")))
    return Estimate(field, chosen("radius"), determined, Neighbourhoods(some, number), residual)


def _change(
    surface: Surface,
    field: CurvatureField,
    neighbourhoods: Neighbourhoods,
    vertices: np.ndarray,
    progress: Progress,
) -> np.ndarray:
    change = np.zeros(len(vertices))
    number = neighbourhoods.number[vertices]
    for one in np.unique(number):
        rows = number == one
        change[rows] = _change_of_scale(
            surface, field, neighbourhoods.some[one], vertices[rows], progress
        )
    return change


def _refined(
    surface: Surface,
    normals: np.ndarray,
    triangle: np.ndarray,
    barycentric: np.ndarray,
    neighbourhoods: Neighbourhoods,
    progress: Progress,
) -> Places:
    # The corner in the middle decides for its triangle.
    number = np.sort(neighbourhoods.number[surface.triangles[triangle]], axis=1)[:, 1]
    order, parts = np.argsort(number, kind="stable"), []
    for one, neighbourhood in enumerate(neighbourhoods.some):
        rows = np.flatnonzero(number == one)
        parts.append(
            _refine(surface, normals, triangle[rows], barycentric[rows], neighbourhood, progress)
        )
    back = np.argsort(order)
    return Places(
        **{
            name: np.concatenate([getattr(part, name) for part in parts])[back]
            for name in vars(parts[0])
        }
    )
