"""From a detection to a plan for a quad mesh: cross field, poles, lines of curvature."""

from __future__ import annotations

import time

import numpy as np

from ..base.arguments import flags, vertex_pairs
from ..base.blas import one_blas_thread
from ..base.progress import Progress
from ..fields.face_index import face_field_singularities
from ..matching.mirror import MirrorPlane, find_mirror_plane
from ..mesh.input_map import places_on_surface
from .by_hand import (
    Strokes,
    WantedPoles,
    first_said,
    planned_by_hand,
    poles_off_surface,
    pull_of,
    strokes_not_held,
    with_strokes,
)
from .crosses.cross_field import cross_field
from .crosses.smoothing import smoothing_length
from .features import Features, barriers, find_features, flat_faces
from .field.planned import with_poles, with_poles_of_faces
from .field_settings import USUAL_SMOOTHNESS
from .groundwork import Groundwork
from .guidance import Guidance, disagreements, guidance_of
from .lines.polylines import Lines
from .lines.separatrices import Separatrices, discs, separatrices, skeleton
from .lines.streamlines import evenly_spaced_lines
from .lines.truncation import Barriers
from .poles import plan_poles, replanned
from .ridges.find import find_ridges
from .ridges.ridge_lines import RidgeLines, ridge_lines
from .settings import GuidanceSettings

# A crest that draws the cross field to it is longer than this many lengths over which the field is
# smoothed: shorter ones are bumps, and their ends would be poles.
CREST_LENGTHS = 8.0


class Guide(Groundwork):
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
    kept_from:
        Part of the area from which pieces of fewer vertices than a fit takes are kept, with
        features but no directions of their own.

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

    @one_blas_thread()
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
        zone = flags(zone, self._counts[0], "zone")
        begin = time.perf_counter()
        simple = self.simplified(progress.part("Simplifying the field", 0.0, 0.15))
        part = progress.part("Finding features", 0.15, 0.25)
        features = self.features(settings, part, sharp=sharp)
        pull = None if strokes is None else pull_of(surface, strokes)
        if pull is not None:
            features = with_strokes(surface, features, pull)
        part = progress.part("Smoothing the cross field", 0.25, 0.8)
        measured = self.measured(part.quiet())
        cross = cross_field(
            surface, measured, settings, part, undirected=self.undirected, features=features
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
            features,
            places_on_surface(surface, poles.triangle, poles.barycentric)[0],
            4 - poles.valence,
            progress.part("Moving poles", 0.95, 1.0),
            # What is wanted by hand may not fit the surface: features do not give way to that.
            exact=wanted is None,
        )
        if wanted is None and zone is None:
            triangle, _ = places_on_surface(surface, poles.triangle, poles.barycentric)
            cross, row, triangle, sign = with_poles_of_faces(
                surface, planes, cross, triangle, 4 - poles.valence, part.quiet()
            )
            poles = replanned(surface, regions, poles, row, triangle, sign)
        end = time.perf_counter()
        progress.step(1.0)
        warnings = disagreements(surface, len(simple.stayed), cross, poles)
        if strokes is not None and pull is not None:
            not_held = strokes_not_held(pull, len(strokes), cross.direction, cross.normal)
            warnings += first_said(not_held)
        if wanted is not None:
            warnings += poles_off_surface(surface, wanted, poles)
        timings = {"cross field": middle - begin, "poles": end - middle}
        return guidance_of(surface, self._counts, cross, poles, features, timings, warnings)

    @one_blas_thread()
    def features(
        self,
        settings: GuidanceSettings | None = None,
        progress: Progress | None = None,
        *,
        sharp: np.ndarray | None = None,
    ) -> Features:
        """What the cross field runs along, in rows of `surface`."""
        settings, progress = settings or GuidanceSettings(), progress or Progress()
        sharp = vertex_pairs(sharp, self._counts[0], "sharp edges")
        if not settings.align_crests:
            return find_features(self.surface, settings, sharp)
        bend, usual = settings.feature_angle, settings.smoothness
        if isinstance(usual, str):
            usual = USUAL_SMOOTHNESS
        ridges = find_ridges(self.surface, self.slopes(progress), least_bend=bend)
        shortest = CREST_LENGTHS * smoothing_length(self.surface, usual)
        return find_features(self.surface, settings, sharp, ridges, shortest)

    @one_blas_thread()
    def ridges(
        self, settings: GuidanceSettings | None = None, progress: Progress | None = None
    ) -> RidgeLines:
        """Ridges, ravines and crest lines, each with its kind, strength and bend.

        The third derivatives that they come from are measured once; with other settings the
        lines are only picked anew.
        """
        settings, progress = settings or GuidanceSettings(), progress or Progress()
        crests_only = settings.ridge_kinds == "crests"
        slopes = self.slopes(progress.part("Measuring ridges", 0.0, 0.9), crests_only)
        found = find_ridges(
            self.surface,
            slopes,
            crests_only=crests_only,
            least_bend=settings.least_bend,
            progress=progress.part("Joining ridges", 0.9, 1.0),
        )
        return ridge_lines(self.surface, slopes, found.chains, self.detection.umbilics)

    @one_blas_thread()
    def singular_vertices(self, guidance: Guidance) -> tuple[np.ndarray, np.ndarray]:
        """Input vertices (s,) where the field of the faces is singular, and 4 times its index."""
        planes = self.planes(Progress())
        direction = guidance.face_direction[self.surface.source_triangle]
        vertex, quarters = face_field_singularities(self.surface, planes, direction)
        return self.surface.source_vertex[vertex], quarters

    @one_blas_thread()
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

    @one_blas_thread()
    def lines(
        self, settings: GuidanceSettings | None = None, progress: Progress | None = None
    ) -> Lines:
        """Evenly spaced lines of curvature.

        Raises
        ------
        GuidanceError
            The surface has no preferred direction nearly everywhere, or the spacing is far below
            what the mesh tells.
        """
        settings, progress = settings or GuidanceSettings(), progress or Progress()
        part = progress.part("Laying out triangles", 0.0, 0.2)
        planes, singular = self._planes_of_lines(settings, part)
        flat = flat_faces(self.surface, find_features(self.surface, settings))
        obstacle = np.where(singular | self.undirected | flat, 0, -1)
        part = progress.part("Tracing lines", 0.2, 1.0)
        return evenly_spaced_lines(self.surface, planes, settings, obstacle, part)

    @one_blas_thread()
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
        slopes = self.slopes(progress)
        crests = find_ridges(self.surface, slopes, least_bend=settings.feature_angle)
        return barriers(find_features(self.surface, settings), crests.chains)
