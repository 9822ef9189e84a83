"""From a detection to a plan for a quad mesh: cross field, poles, lines of curvature."""

from __future__ import annotations

import time
from dataclasses import fields, replace

import numpy as np

from ..base.progress import Progress
from ..curvature.field import CurvatureField
from ..fields.face_index import face_field_singularities
from ..fields.planes import FaceFrames, lay_out
from ..mesh.input_map import places_on_surface
from ..mesh.repair import clean
from ..mesh.surface import Surface
from ..umbilics.result import Detection
from .by_hand import Strokes, WantedPoles, planned_by_hand, pull_of, strokes_not_held, with_strokes
from .cross_field import cross_field, smoothing_length
from .features import Features, barriers, find_features
from .field.planned import with_poles
from .field.simplified import SimplifiedField, simplify_field
from .field.smoothed import smoothed_field, smoothness_by_noise
from .guidance import Guidance, disagreements, guidance_of
from .lines.polylines import Lines
from .lines.separatrices import Separatrices, discs, separatrices, skeleton
from .lines.streamlines import evenly_spaced_lines
from .lines.winding import Barriers
from .mirror import MirrorPlane, find_mirror_plane
from .poles import plan_poles
from .ridges.find import find_ridges, measure_slopes
from .ridges.ridge_lines import RidgeLines, ridge_lines
from .ridges.slopes import Slopes
from .settings import GuidanceSettings

# A crest that draws the cross field to it is longer than this many lengths over which the field is
# smoothed: shorter ones are bumps, and their ends would be poles.
CREST_LENGTHS = 8.0


class Guide:
    """A mesh and its detection, ready for guidance; what several results share is made once.

    Parameters
    ----------
    vertices, triangles:
        (n, 3) and (m, 3), the very mesh that was detected on.
    detection:
        The result of `core.detect`.
    kept:
        (k,) rows of the detection's candidates to go on with, in place of those that its filters
        kept; None for these.

    Attributes
    ----------
    surface, cleaning:
        What is worked on, and sentences about what was mended to get it.

    Raises
    ------
    InvalidMeshError
        As `core.detect`.

    Examples
    --------
    Of an ellipsoid of `vertices` and `triangles`, as in `detect`: every lemon asks for two
    vertices of three edges, and separatrices join the lemons.

    >>> guide = core.Guide(vertices, triangles, core.detect(vertices, triangles))
    >>> poles = guide.guidance().poles
    >>> poles.valence.tolist(), poles.total
    ([3, 3, 3, 3, 3, 3, 3, 3], 8)
    >>> len(guide.separatrices())
    4
    """

    def __init__(
        self,
        vertices: np.ndarray,
        triangles: np.ndarray,
        detection: Detection,
        kept: np.ndarray | None = None,
    ) -> None:
        self.surface, self.cleaning = clean(vertices, triangles, detection.borders_joined)
        if kept is not None:
            detection = replace(detection, umbilics=detection.candidates.select(kept))
        self.detection = detection
        self._counts = len(vertices), len(triangles)
        self._field = _on_surface(self.surface, detection.curvature)
        self._simplified: SimplifiedField | None = None
        self._planes: FaceFrames | None = None
        self._slopes: Slopes | None = None

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

    @property
    def undirected(self) -> np.ndarray:
        """(m,) bool over the surface's triangles: those in a region without directions."""
        inside = np.zeros(self._counts[1], bool)
        for region in self.detection.regions:
            inside[region.triangles] |= not region.has_directions
        return inside[self.surface.source_triangle]

    @property
    def _regions(self) -> list[np.ndarray]:
        """For each region the rows of its triangles of the surface."""
        number = np.full(self._counts[1], -1)
        for row, region in enumerate(self.detection.regions):
            number[region.triangles] = row
        mine = number[self.surface.source_triangle]
        return [np.flatnonzero(mine == row) for row in range(len(self.detection.regions))]

    def planes(self, progress: Progress) -> FaceFrames:
        """The triangles in their planes, laid out at first use."""
        if self._planes is None:
            field = self.simplified(progress.part("Simplifying the field", 0.0, 0.5)).curvature
            part = progress.part("Laying out triangles", 0.5, 1.0)
            self._planes = lay_out(self.surface, field.lines, part)
        return self._planes

    def guidance(
        self,
        settings: GuidanceSettings | None = None,
        progress: Progress | None = None,
        *,
        sharp: np.ndarray | None = None,
        zone: np.ndarray | None = None,
        strokes: Strokes | None = None,
        wanted: WantedPoles | None = None,
    ) -> Guidance:
        """Cross field and pole plan.

        Parameters
        ----------
        sharp:
            (s, 2) vertex pairs of the edges marked as sharp.
        zone:
            (n,) bool vertices where no pole is wanted.
        strokes:
            Lines that the field is to run along, less than along hard features.
        wanted:
            All the poles that there are to be, in place of those that would be planned.
        """
        settings, progress = settings or GuidanceSettings(), progress or Progress()
        surface = self.surface
        begin = time.perf_counter()
        simple = self.simplified(progress.part("Simplifying the field", 0.0, 0.15))
        part = progress.part("Finding features", 0.15, 0.25)
        features = self.features(settings, part, sharp=sharp)
        pull = None if strokes is None else pull_of(surface, strokes)
        if pull is not None:
            features = with_strokes(surface, features, pull)
        part = progress.part("Smoothing the cross field", 0.25, 0.8)
        cross = cross_field(
            surface, simple.curvature, settings, part, undirected=self.undirected, features=features
        )
        middle = time.perf_counter()
        planes = self.planes(progress.part("Planning poles", 0.8, 0.95))
        regions = list(self.detection.regions)
        umbilics = self.detection.umbilics
        if wanted is not None:
            poles = planned_by_hand(surface, regions, wanted)
        else:
            poles = plan_poles(surface, planes, cross, umbilics, regions, zone, settings.plan)
        cross = with_poles(
            surface,
            planes,
            cross,
            places_on_surface(surface, poles.triangle, poles.barycentric)[0],
            4 - poles.valence,
            progress.part("Moving poles", 0.95, 1.0),
        )
        end = time.perf_counter()
        progress.step(1.0)
        warnings = disagreements(surface, len(simple.stayed), cross.triangle_index, poles)
        if strokes is not None and pull is not None:
            warnings += strokes_not_held(pull, len(strokes), cross.direction, cross.normal)
        timings = {"cross field": middle - begin, "poles": end - middle}
        return guidance_of(surface, self._counts, cross, poles, features, timings, warnings)

    def features(
        self,
        settings: GuidanceSettings | None = None,
        progress: Progress | None = None,
        *,
        sharp: np.ndarray | None = None,
    ) -> Features:
        """What the cross field runs along, in rows of `surface`."""
        settings, progress = settings or GuidanceSettings(), progress or Progress()
        if not settings.align_crests:
            return find_features(self.surface, settings, sharp)
        bend = settings.feature_angle
        ridges = find_ridges(self.surface, self._measured(progress), least_bend=bend)
        shortest = CREST_LENGTHS * smoothing_length(self.surface, settings.smoothness)
        return find_features(self.surface, settings, sharp, ridges, shortest)

    def ridges(
        self, settings: GuidanceSettings | None = None, progress: Progress | None = None
    ) -> RidgeLines:
        """Ridges, ravines and crest lines, each with its kind, strength and bend.

        The third derivatives that they come from are measured once; with other settings the
        lines are only picked anew.
        """
        settings, progress = settings or GuidanceSettings(), progress or Progress()
        slopes = self._measured(progress.part("Measuring ridges", 0.0, 0.9))
        progress.part("Joining ridges", 0.9, 1.0)
        found = find_ridges(
            self.surface,
            slopes,
            crests_only=settings.ridge_kinds == "crests",
            least_bend=settings.least_bend,
        )
        return ridge_lines(self.surface, slopes, found.chains, self.detection.umbilics)

    def _measured(self, progress: Progress) -> Slopes:
        if self._slopes is None:
            self._slopes = measure_slopes(self.surface, self._field, progress)
        return self._slopes

    def singular_vertices(self, guidance: Guidance) -> tuple[np.ndarray, np.ndarray]:
        """Input vertices (s,) where the field of the faces is singular, and 4 times its index."""
        planes = self.planes(Progress())
        direction = guidance.face_direction[self.surface.source_triangle]
        vertex, quarters = face_field_singularities(self.surface, planes, direction)
        return self.surface.source_vertex[vertex], quarters

    def symmetry(self, progress: Progress | None = None) -> MirrorPlane:
        """The mirror plane of the surface.

        Raises
        ------
        GuidanceError
            It has none.
        """
        surface = self.surface
        return find_mirror_plane(
            surface.vertices * surface.unit + surface.origin,
            surface.face_normal_area,
            surface.triangles,
            self.detection.umbilics,
            progress or Progress(),
        )

    def lines(
        self, settings: GuidanceSettings | None = None, progress: Progress | None = None
    ) -> Lines:
        """Evenly spaced lines of curvature.

        Raises
        ------
        GuidanceError
            The surface has no preferred direction nearly everywhere.
        """
        settings, progress = settings or GuidanceSettings(), progress or Progress()
        part = progress.part("Laying out triangles", 0.0, 0.2)
        planes, singular = self._planes_of_lines(settings, part)
        obstacle = np.where(singular | self.undirected, 0, -1)
        part = progress.part("Tracing lines", 0.2, 1.0)
        return evenly_spaced_lines(self.surface, planes, settings, obstacle, part)

    def separatrices(
        self,
        settings: GuidanceSettings | None = None,
        progress: Progress | None = None,
        *,
        both_ways: bool = False,
    ) -> Separatrices:
        """Separatrices of the kept umbilics; each arc between two once, unless `both_ways`.

        Where the lines are smoothed, the directions around the umbilics stay as they are: the
        separatrices leave in their exact directions and the umbilics stay where they lie.
        """
        settings, progress = settings or GuidanceSettings(), progress or Progress()
        part = progress.part("Laying out triangles", 0.0, 0.5)
        around = discs(self.surface, self.detection.umbilics)
        held = np.zeros(len(self.surface.vertices), bool)
        held[self.surface.triangles[around >= 0]] = True
        planes, _ = self._planes_of_lines(settings, part, held)
        part = progress.part("Tracing separatrices", 0.5, 1.0)
        found = separatrices(
            self.surface,
            planes,
            self.detection.umbilics,
            settings,
            part,
            self.undirected,
            around,
            lambda: self._barriers(settings, part.quiet()),
        )
        return found if both_ways else skeleton(found)

    def _barriers(self, settings: GuidanceSettings, progress: Progress) -> Barriers:
        """Creases and the crests that bend as far."""
        slopes = self._measured(progress)
        crests = find_ridges(self.surface, slopes, least_bend=settings.feature_angle)
        return barriers(find_features(self.surface, settings), crests.chains)

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


def _on_surface(surface: Surface, curvature: CurvatureField) -> CurvatureField:
    """The input's shape operators on the surface's vertices, in the surface's coordinates."""
    rows = surface.source_vertex
    values = {}
    for item in fields(CurvatureField):
        value = getattr(curvature, item.name)[rows]
        values[item.name] = value * surface.unit if item.name in ("k1", "k2", "noise") else value
    return CurvatureField(**values)
