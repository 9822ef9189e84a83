"""From a triangle mesh to a quad mesh whose edges follow the curvature.

The cross field is smoothed and mapped seamlessly to the plane; the motorcycle graph of the map
divides the surface into rectangles; whole numbers of quads are given to their sides; the quads
are laid out in the map, evened out and turned to the curvature on the surface.
"""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np

from ...base.arguments import flags
from ...base.blas import one_blas_thread
from ...base.errors import RemeshError
from ...base.progress import Clock, Progress
from ...base.words import counted
from ...umbilics.detect import detect
from ...umbilics.result import Detection
from ..by_hand import Strokes, WantedPoles
from ..planner import Guide
from .finishing.faults.crossings import OwnCrossings, crossings
from .finishing.faults.last_check import checked
from .finishing.finished import filled
from .finishing.mirroring import mirrored, words_of_images
from .finishing.parting import parted
from .finishing.planned_poles import planned_poles
from .finishing.reporting import reported, words_of_folds, words_of_shape
from .finishing.unlaid import Unlaid, cut_in_three, needed
from .layout.counting import countable, grids_of_about, outnumbered
from .layout.grids import Grids
from .layout.laying_out import LEAST_EACH, LaidOut
from .layout.lines import QuadLayout, layout_lines
from .layout.words import words, words_of_count, words_of_outnumbered, words_of_unlaid
from .preparation import Given, Prepared, prepare, scrap
from .result import QuadMesh
from .settings import RemeshSettings

# A layout that needs so many times the quads that were asked for is not taken.
CROWDED = 2.0


@one_blas_thread()
def remesh(
    vertices: np.ndarray,
    triangles: np.ndarray,
    settings: RemeshSettings | None = None,
    progress: Progress | None = None,
    *,
    detection: Detection | None = None,
    sharp: np.ndarray | None = None,
    zone: np.ndarray | None = None,
    strokes: Strokes | None = None,
    wanted: WantedPoles | None = None,
) -> QuadMesh:
    """A quad mesh on the surface of a triangle mesh, along its curvature.

    It is closed where the surface is, all quads and manifold; its borders lie on borders, edges of
    it run along creases, and every irregular vertex is a pole of the cross field. A piece that no
    such quads are found for gets triangles cut into three, and a warning says so.

    Parameters
    ----------
    vertices, triangles:
        (n, 3) real and (m, 3) integer; cleaned as in `detect`.
    detection:
        The result of `detect` on the very mesh; made here without.
    sharp:
        (s, 2) vertex pairs of the edges marked as sharp.
    zone:
        (n,) bool vertices where no pole is wanted.
    strokes:
        Lines that the quads are to run along, less than along hard features.
    wanted:
        All the poles that there are to be, in place of those that would be planned.

    Raises
    ------
    InvalidMeshError
        As `detect`.
    RemeshError
        There is no area to cover, or nothing on the chosen side of the plane of symmetry; the edge
        length makes more than a million quads; or areas of so small or large a mesh are no numbers.

    Examples
    --------
    An ellipsoid of `vertices` and `triangles`, as in `detect`, in about 300 quads:

    >>> made = core.remesh(vertices, triangles, core.RemeshSettings(quads=300))
    >>> made.quads.shape[1], sorted(made.pole_valence.tolist())
    (4, [3, 3, 3, 3, 3, 3, 3, 3])
    """
    settings, progress = settings or RemeshSettings(), progress or Progress()
    clock = Clock()
    with clock.stage("curvature"):
        if detection is None:
            detection = detect(vertices, triangles, progress=progress.part("Curvature", 0.0, 0.15))
    with clock.stage("map and layout"):
        given = Given(triangles, detection, sharp, zone, strokes, wanted)
        part = progress.part("Mapping the surface", 0.15, 0.7)
        guide, prepared = _prepared(vertices, given, settings, part)
    with clock.stage("whole numbers"):
        part = progress.part("Whole numbers", 0.7, 0.75)
        parts, without, whole_numbers = _whole_numbers(prepared.parts, prepared.asked, part)
    with clock.stage("evening out"):
        part = progress.part("Evening out", 0.75, 0.95)
        own = OwnCrossings(guide.surface)
        steps, effort = settings.relaxation, prepared.effort
        done, torn = filled(parts, whole_numbers, steps, effort, own, prepared.asked, part)
    unlaid = prepared.unlaid + without + torn
    many = sum(map(outnumbered, prepared.parts))
    scraps = sum(one.scrap for one in unlaid)
    warnings = prepared.warnings + words_of_unlaid(len(unlaid) - many, scraps)
    warnings += words_of_outnumbered(many)
    warnings += words([one.laid for one in done], settings.smoothness, prepared.wanted)
    with clock.stage("report"):
        part = progress.part("Evening out", 0.95, 0.98)
        cut = [cut_in_three(one, part) for one in unlaid]
        pieces = [
            reported(one.laid, one.grid, one.placed, one.position, one.triangle, one.surface)
            for one in done
        ]
        pieces += cut
    progress.step(1.0)
    made = _parted(_joined(pieces, [], clock.seconds), own, progress)
    made, folded = checked(made, guide.surface, progress, own)
    left = sum(one.left for one in done)
    farthest = max((one.farthest for one in done), default=0.0)
    warnings += words_of_folds(left, farthest, folded)
    ends = np.cumsum([0] + [len(one.position) for one in done])
    places = [made.vertices[first:end] for first, end in itertools.pairwise(ends)]
    shapes = [(one.placed, place) for one, place in zip(done, places, strict=True)]
    warnings += words_of_shape(shapes)
    made = replace(made, warnings=(*warnings, *made.warnings))
    plane = prepared.plane
    if plane is not None:
        wishes = [one.laid.wishes for one in done] + [one.wishes for one in unlaid]
        counts = [len(one.vertices) for one in pieces]
        single, imaged = (
            np.repeat(of, counts)
            for of in zip(*((one.single, one.imaged) for one in wishes), strict=True)
        )
        images = plane.reflected(made.vertices[imaged])
        said = words_of_images(images, guide.surface, prepared.size)
        made = mirrored(made, single, plane, detection.umbilics, prepared.size)
        made = replace(made, warnings=(*made.warnings, *said))
    poles = planned_poles(
        guide.surface, list(detection.regions), [one.laid for one in done], plane
    )
    made = replace(made, planned=poles)
    said = words_of_count(len(made.quads), prepared.requested, len(made.pole_valence), len(unlaid))
    return replace(made, warnings=(*made.warnings, *said))


@one_blas_thread()
def quad_layout(
    vertices: np.ndarray,
    triangles: np.ndarray,
    settings: RemeshSettings | None = None,
    progress: Progress | None = None,
    *,
    detection: Detection | None = None,
    sharp: np.ndarray | None = None,
    zone: np.ndarray | None = None,
    strokes: Strokes | None = None,
    wanted: WantedPoles | None = None,
) -> QuadLayout:
    """The layout that `remesh` would fill with quads; arguments and errors are the same.

    With a plane of symmetry it is the half, and what is not mirrored, that is laid out.

    Examples
    --------
    On an ellipsoid of `vertices` and `triangles`, as in `detect`:

    >>> core.quad_layout(vertices, triangles, core.RemeshSettings(quads=300)).rectangles
    18
    """
    settings, progress = settings or RemeshSettings(), progress or Progress()
    if detection is None:
        detection = detect(vertices, triangles, progress=progress.part("Curvature", 0.0, 0.2))
    given = Given(triangles, detection, sharp, zone, strokes, wanted)
    part = progress.part("Mapping the surface", 0.2, 1.0)
    _, prepared = _prepared(vertices, given, settings, part)
    progress.step(1.0)
    said = words_of_unlaid(len(prepared.unlaid), sum(one.scrap for one in prepared.unlaid))
    said += words_of_outnumbered(sum(map(outnumbered, prepared.parts)))
    said += words(prepared.parts, settings.smoothness, prepared.wanted)
    return layout_lines(prepared.parts, prepared.warnings + said)


def _prepared(
    vertices: np.ndarray, given: Given, settings: RemeshSettings, progress: Progress
) -> tuple[Guide, Prepared]:
    """The guide to what is remeshed, and the layouts of its pieces."""
    given = replace(given, zone=flags(given.zone, len(vertices), "zone"))
    least = scrap(vertices, given.triangles, settings)
    guide = Guide(vertices, given.triangles, given.detection, kept_from=least)
    return guide, prepare(guide, given, settings, progress)


def _whole_numbers(
    parts: list[LaidOut], asked: int, progress: Progress
) -> tuple[list[LaidOut], list[Unlaid], list[Grids]]:
    """The pieces that have whole numbers of quads, those that have none, and the grids of the
    first."""
    without: list[LaidOut] = []
    try:
        made = grids_of_about(parts, asked, progress) if parts else []
    except RemeshError:
        parts, without = countable(parts, progress)
        made = grids_of_about(parts, asked, progress) if parts else []
    unlaid = [Unlaid(laid.working, laid.wishes) for laid in without]
    # Poles that are nearer together than quads need many: then what is asked for counts more. Thin
    # rods need as many in any way, and cut in three even more.
    crowded = []
    for laid, grid in zip(parts, made, strict=True):
        instead = Unlaid(laid.working, laid.wishes)
        poles = int(np.count_nonzero(laid.map_.crosses.singular))
        crowded.append(
            len(grid.quads) > CROWDED * instead.asked
            and poles * LEAST_EACH > instead.asked
            and needed(instead, progress) < len(grid.quads)
        )
    if any(crowded):
        unlaid += [
            Unlaid(one.working, one.wishes) for one, no in zip(parts, crowded, strict=True) if no
        ]
        parts = [one for one, no in zip(parts, crowded, strict=True) if not no]
        made = [grid for grid, no in zip(made, crowded, strict=True) if not no]
    return parts, unlaid, made


def _parted(made: QuadMesh, own: OwnCrossings, progress: Progress) -> QuadMesh:
    """Without quads that pass through each other, as far as the surface does not."""
    place = parted(made.vertices, made.quads, made.border, own, progress)
    said = []
    moved = np.linalg.norm(place - made.vertices, axis=1)
    if moved.any():
        number = int(np.count_nonzero(moved))
        said.append(
            f"{counted(number, 'vertex', 'vertices')} moved off the surface, by "
            f"{moved.max():.3g} at most: its sheets lie nearer together there than quads of this "
            "size bend. Ask for more quads to have them on it."
        )
    crossing = len(crossings(place, made.quads))
    if crossing:
        said.append(
            f"{counted(crossing, 'pair')} of quads pass through each other: the "
            "mesh does so, or its sheets lie nearer together than quads of this size bend. Mend "
            "it there, or ask for more quads."
        )
    return replace(made, vertices=place, warnings=(*made.warnings, *said))


def _joined(pieces: list[QuadMesh], warnings: list[str], timings: dict[str, float]) -> QuadMesh:
    """The pieces as one mesh, their poles and patches numbered through."""
    first = np.cumsum([0] + [len(one.vertices) for one in pieces])
    poles = np.cumsum([0] + [len(one.pole_valence) for one in pieces])
    patches = np.cumsum([0] + [int(one.patch.max(initial=-1)) + 1 for one in pieces])
    return QuadMesh(
        vertices=np.concatenate([one.vertices for one in pieces]),
        quads=np.concatenate([one.quads + at for one, at in zip(pieces, first, strict=False)]),
        pole=np.concatenate(
            [
                np.where(one.pole >= 0, one.pole + at, -1)
                for one, at in zip(pieces, poles, strict=False)
            ]
        ),
        pole_valence=np.concatenate([one.pole_valence for one in pieces]),
        pole_umbilic=np.concatenate([one.pole_umbilic for one in pieces]),
        pole_confidence=np.concatenate([one.pole_confidence for one in pieces]),
        border=np.concatenate([one.border for one in pieces]),
        feature=np.concatenate([one.feature for one in pieces]),
        patch=np.concatenate([one.patch + at for one, at in zip(pieces, patches, strict=False)]),
        angle=np.concatenate([one.angle for one in pieces]),
        source_triangle=np.concatenate([one.source_triangle for one in pieces]),
        warnings=tuple(warnings),
        timings=timings,
    )
