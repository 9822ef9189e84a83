"""What the results of a guide share: the surface, its simplified field, its planes and slopes."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np

from ..base.progress import Progress
from ..curvature.field import CurvatureField, field_from_deviators
from ..fields.planes import FaceFrames, lay_out
from ..mesh.mending.repair import clean
from ..mesh.normals import vertex_normals
from ..mesh.surface import Surface
from ..umbilics.result import Detection
from .field.simplified import SimplifiedField, in_doubt, simplify_field
from .field.smoothed import smoothed_field, smoothness_by_noise
from .ridges.measure import measure_slopes
from .ridges.slopes import Slopes
from .settings import GuidanceSettings

# Part of the area from which pieces too small for a fit are kept: half a quad of two thousand.
SMALL = 1.0 / 4000.0


class Groundwork:
    """A mesh and its detection; what is made of them once, at first use.

    Parameters and attributes as of `Guide`.
    """

    def __init__(
        self,
        vertices: np.ndarray,
        triangles: np.ndarray,
        detection: Detection,
        kept: np.ndarray | None = None,
        kept_from: float = SMALL,
    ) -> None:
        self.surface, self.cleaning = clean(
            vertices, triangles, detection.borders_joined, kept_from
        )
        detection.check_mesh(len(vertices), len(triangles))
        if kept is not None:
            detection = replace(detection, umbilics=detection.candidates.select(kept))
        self.detection = detection
        self._counts = len(vertices), len(triangles)
        # Of pieces too small for a fit, which detections leave out.
        self._unfitted = np.isnan(detection.curvature.k1[self.surface.source_vertex])
        self._field = _on_surface(self.surface, detection.curvature, self._unfitted)
        self._simplified: SimplifiedField | None = None
        self._planes: FaceFrames | None = None
        self._slopes: dict[bool, Slopes] = {}

    def simplified(self, progress: Progress) -> SimplifiedField:
        """The principal directions without the umbilics that were dropped, made at first use."""
        if self._simplified is None:
            self._simplified = simplify_field(
                self.surface,
                self._field,
                self.detection.umbilics,
                self.detection.candidates,
                self._regions,
                self.undirected,
                progress,
            )
        return self._simplified

    def measured(self, progress: Progress) -> CurvatureField:
        """The measured directions, for the cross field, in doubt where umbilics were dropped."""
        return in_doubt(self.surface, self._field, self.simplified(progress).curvature)

    @property
    def undirected(self) -> np.ndarray:
        """(m,) bool over the surface's triangles: those in a region without directions, or in a
        piece too small for a fit."""
        inside = np.zeros(self._counts[1], bool)
        for region in self.detection.regions:
            inside[region.triangles] |= not region.has_directions
        unfitted = self._unfitted[self.surface.triangles[:, 0]]
        return inside[self.surface.source_triangle] | unfitted

    @property
    def _regions(self) -> list[np.ndarray]:
        """For each region, and each piece too small for a fit, the rows of its triangles of the
        surface."""
        number = np.full(self._counts[1], -1)
        for row, region in enumerate(self.detection.regions):
            number[region.triangles] = row
        mine = number[self.surface.source_triangle]
        found = [np.flatnonzero(mine == row) for row in range(len(self.detection.regions))]
        piece = self.surface.component[self.surface.triangles[:, 0]]
        small = np.unique(self.surface.component[self._unfitted])
        return found + [np.flatnonzero(piece == one) for one in small]

    def planes(self, progress: Progress) -> FaceFrames:
        """The triangles in their planes, laid out at first use."""
        if self._planes is None:
            field = self.simplified(progress.part("Simplifying the field", 0.0, 0.5)).curvature
            part = progress.part("Laying out triangles", 0.5, 1.0)
            self._planes = lay_out(self.surface, field.lines, part)
        return self._planes

    def slopes(self, progress: Progress, crests_only: bool = True) -> Slopes:
        """What ridges, or crests only, are found from, measured at first use."""
        # What holds for all ridges does for crests.
        known = self._slopes.get(False) or (self._slopes.get(True) if crests_only else None)
        if known is None:
            known = measure_slopes(self.surface, self._field, progress, crests_only)
            self._slopes[crests_only] = known
        return known

    def _planes_of_lines(
        self, settings: GuidanceSettings, progress: Progress, held: np.ndarray | None = None
    ) -> tuple[FaceFrames, np.ndarray]:
        """The triangles with the directions that lines follow, and which of them (m,) bool hold
        a singularity of these."""
        smoothness = settings.line_smoothness
        if isinstance(smoothness, str):
            smoothness = smoothness_by_noise(
                self.surface, self._field, self.detection.scale / self.surface.unit
            )
        if smoothness == 0.0:
            return self.planes(progress), self._singular
        smooth = smoothed_field(
            self.surface,
            self.simplified(progress.part("Simplifying the field", 0.0, 0.3)),
            smoothness,
            self._regions,
            progress.part("Smoothing the lines", 0.3, 1.0),
            held,
        )
        return lay_out(self.surface, smooth.field, Progress()), smooth.index != 0.0

    @property
    def _singular(self) -> np.ndarray:
        """(m,) bool over the surface's triangles: those of the kept umbilics, which lines end at,
        and those where the field that lines follow turns around.

        Pairs that cancel in the noise do not stop a line.
        """
        at = np.zeros(self._counts[1], bool)
        at[self.detection.umbilics.triangle] = True
        return at[self.surface.source_triangle] | (self.simplified(Progress()).index != 0.0)


def _on_surface(
    surface: Surface, curvature: CurvatureField, unfitted: np.ndarray
) -> CurvatureField:
    """The input's shape operators on the surface's vertices, in the surface's coordinates; where
    none were fitted (n,) bool the surface bends nowhere, so that nothing follows it there."""
    rows = surface.source_vertex
    values = {}
    for item in fields(CurvatureField):
        value = getattr(curvature, item.name)[rows]
        values[item.name] = value * surface.unit if item.name in ("k1", "k2", "noise") else value
    if unfitted.any():
        normal = vertex_normals(surface)[unfitted]
        none = np.zeros(len(normal))
        flat = field_from_deviators(none, none.astype(np.complex128), normal, none)
        for name, value in vars(flat).items():
            values[name][unfitted] = value
    return CurvatureField(**values)
