"""From a triangle mesh to a quad mesh whose edges follow the curvature.

The cross field is smoothed and mapped seamlessly to the plane; the motorcycle graph of the map
divides the surface into rectangles; whole numbers of quads are given to their sides; the quads
are laid out in the map, evened out and turned to the curvature on the surface.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np

from ...base.errors import RemeshError
from ...base.progress import Progress
from ...mesh.surface import Surface
from ...umbilics.detect import detect
from ...umbilics.result import Detection
from ..by_hand import Strokes, WantedPoles
from ..planner import Guide
from .conformity import conformity
from .finishing.crossings import crossings
from .finishing.directions import guiding_directions
from .finishing.guides import Guides, vertex_normals
from .finishing.mending import mend, oriented_quality
from .finishing.mirroring import mirrored
from .finishing.placement import Placement, place
from .finishing.projection import ClosestPoints
from .finishing.relaxation import relaxed
from .finishing.reporting import Report, reported
from .layout.counting import characteristic, counted, first_cuts, whole_grids
from .layout.grids import Grids
from .layout.laying_out import LaidOut, gentler, laid_out
from .layout.lines import QuadLayout, layout_lines
from .layout.words import words
from .preparation import Given, prepare
from .result import QuadMesh
from .settings import RemeshSettings

# How often a piece with folded quads is laid out anew.
ATTEMPTS = 3


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
    it run along creases, and every irregular vertex is a pole of the cross field.

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
        A piece of the surface cannot be covered with quads.

    Examples
    --------
    An ellipsoid of `vertices` and `triangles`, as in `detect`, in about 300 quads:

    >>> made = core.remesh(vertices, triangles, core.RemeshSettings(quads=300))
    >>> made.quads.shape[1], sorted(made.pole_valence.tolist())
    (4, [3, 3, 3, 3, 3, 3, 3, 3])
    """
    settings, progress = settings or RemeshSettings(), progress or Progress()
    clock = _Clock()
    if detection is None:
        detection = detect(vertices, triangles, progress=progress.part("Curvature", 0.0, 0.15))
    clock.lap("curvature")
    given = Given(triangles, detection, sharp, zone, strokes, wanted)
    guide = Guide(vertices, triangles, detection)
    part = progress.part("Mapping the surface", 0.15, 0.7)
    prepared = prepare(guide, given, settings, part)
    clock.lap("map and layout")
    parts, warnings = prepared.parts, prepared.warnings
    scale, whole_numbers = counted(parts, prepared.asked, progress.part("Whole numbers", 0.7, 0.8))
    clock.lap("whole numbers")
    part = progress.part("Evening out", 0.8, 0.98)
    finished = [
        _finished(
            laid,
            grid,
            scale,
            settings,
            part.part("Evening out", number / len(parts), (number + 1) / len(parts)),
        )
        for number, (laid, grid) in enumerate(zip(parts, whole_numbers, strict=True))
    ]
    clock.lap("evening out")
    warnings += words([one.laid for one in finished], settings.smoothness, prepared.wanted)
    folded = sum(one.folded for one in finished)
    if folded:
        warnings.append(
            f"{folded} quad{'' if folded == 1 else 's'} folded: too little room for "
            f"{'it' if folded == 1 else 'them'}. Ask for more quads, or mend the mesh there."
        )
    reports = [
        reported(one.laid, one.grid, one.placed, one.position, one.triangle) for one in finished
    ]
    clock.lap("report")
    progress.step(1.0)
    made = _joined(reports, warnings, clock.seconds)
    plane = prepared.plane
    if plane is not None:
        made = mirrored(made, plane, detection.umbilics, prepared.size)
    crossing = len(crossings(made.vertices, made.quads))
    if crossing:
        said = (
            f"{crossing} pair{'' if crossing == 1 else 's'} of quads pass through each other: "
            "sheets of the mesh lie nearer together than quads of this size bend, or cross "
            "already. Ask for more quads."
        )
        made = replace(made, warnings=(*made.warnings, said))
    return made


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

    With a plane of symmetry it is the half that is laid out.
    """
    settings, progress = settings or RemeshSettings(), progress or Progress()
    if detection is None:
        detection = detect(vertices, triangles, progress=progress.part("Curvature", 0.0, 0.2))
    given = Given(triangles, detection, sharp, zone, strokes, wanted)
    guide = Guide(vertices, triangles, detection)
    part = progress.part("Mapping the surface", 0.2, 1.0)
    prepared = prepare(guide, given, settings, part)
    progress.step(1.0)
    said = words(prepared.parts, settings.smoothness, prepared.wanted)
    return layout_lines(prepared.parts, prepared.warnings + said)


@dataclass(frozen=True)
class _Finished:
    """The quads of a piece in their places, and how many of them are folded."""

    laid: LaidOut
    grid: Grids
    placed: Placement
    position: np.ndarray
    triangle: np.ndarray
    folded: int


def _finished(
    laid: LaidOut, grid: Grids, scale: float, settings: RemeshSettings, progress: Progress
) -> _Finished:
    """A piece evened out; where quads stay folded it is laid out anew with fewer wishes."""
    tries: list[_Finished] = []
    for attempt in range(ATTEMPTS):
        placed = place(laid.map_, laid.layout, grid)
        _check(placed, laid)
        guides = _guides(placed, laid)
        position, triangle = relaxed(
            placed.position, placed.quads, guides, settings.relaxation, progress
        )
        if laid.working.fine is not None:
            position, guides = _on_fine(position, placed.quads, guides, laid.working.fine, progress)
        folds = oriented_quality(position, placed.quads, guides) <= 0.0
        folded = int(np.count_nonzero(folds))
        tries.append(_Finished(laid, grid, placed, position, triangle, folded))
        if not folded or attempt == ATTEMPTS - 1:
            break
        working = laid.working
        corners = working.surface.triangles[triangle[placed.quads[folds]]]
        near = np.zeros(len(working.surface.vertices), bool)
        near[corners.ravel()] = True
        wishes = gentler(working, laid.wishes, near, None, attempt)
        try:
            laid = laid_out(working, wishes, progress, ATTEMPTS)
        except RemeshError:
            break
        grid = whole_grids(laid, scale, first_cuts(laid), progress)
    return min(tries, key=lambda one: one.folded)


def _on_fine(
    position: np.ndarray, quads: np.ndarray, guides: Guides, fine: Surface, progress: Progress
) -> tuple[np.ndarray, Guides]:
    """Positions (n, 3) on the surface that the mapped one was coarsened from."""
    surface = ClosestPoints(fine.vertices, fine.triangles, fine.twin)
    guides = replace(guides, surface=surface)
    free = ~guides.fixed & (guides.curve < 0)
    position = position.copy()
    position[free] = surface(position[free], vertex_normals(position, quads)[free])[1]
    mend(position, quads, guides, progress)
    return position, guides


class _Clock:
    """Seconds of stages, by name."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._last = time.perf_counter()

    def lap(self, name: str) -> None:
        now = time.perf_counter()
        self.seconds[name] = now - self._last
        self._last = now


def _check(placed: Placement, laid: LaidOut) -> None:
    """Nothing torn is ever returned."""
    found = conformity(placed.quads, len(placed.position))
    if not found.manifold or found.characteristic != characteristic(laid):
        raise RemeshError(
            "The quads do not join up on a piece of the mesh. Change the number of quads or the "
            "smoothness a little."
        )


def _guides(placed: Placement, laid: LaidOut) -> Guides:
    """What holds the quads of a piece: poles are free, ends and corners of features are not."""
    surface = laid.working.surface
    crossed = laid.map_.crosses
    held = placed.vertex >= 0
    on = held & crossed.on_feature[np.maximum(placed.vertex, 0)]
    curves = {
        number: (
            surface.vertices[crossed.tail[track.chain]],
            surface.vertices[crossed.head[track.chain]],
        )
        for number, track in enumerate(laid.layout.tracks)
        if track.feature
    }
    return Guides(
        ClosestPoints(surface.vertices, surface.triangles, surface.twin),
        guiding_directions(laid),
        crossed.size,
        # Poles that were moved out of a zone do not slide back, those that a user placed stay.
        on | (held & (laid.wishes.avoided.any() or laid.wishes.wanted is not None)),
        np.where(on, -1, placed.track),
        placed.beside,
        curves,
    )


def _joined(reports: list[Report], warnings: list[str], timings: dict[str, float]) -> QuadMesh:
    """The pieces as one mesh, their poles and patches numbered through."""
    first = np.cumsum([0] + [len(one.vertices) for one in reports])
    poles = np.cumsum([0] + [len(one.pole_valence) for one in reports])
    patches = np.cumsum([0] + [one.patches for one in reports])
    return QuadMesh(
        vertices=np.concatenate([one.vertices for one in reports]),
        quads=np.concatenate([one.quads + at for one, at in zip(reports, first, strict=False)]),
        pole=np.concatenate(
            [
                np.where(one.pole >= 0, one.pole + at, -1)
                for one, at in zip(reports, poles, strict=False)
            ]
        ),
        pole_valence=np.concatenate([one.pole_valence for one in reports]),
        pole_umbilic=np.concatenate([one.pole_umbilic for one in reports]),
        pole_confidence=np.concatenate([one.pole_confidence for one in reports]),
        border=np.concatenate([one.border for one in reports]),
        feature=np.concatenate([one.feature for one in reports]),
        patch=np.concatenate([one.patch + at for one, at in zip(reports, patches, strict=False)]),
        angle=np.concatenate([one.angle for one in reports]),
        source_triangle=np.concatenate([one.source_triangle for one in reports]),
        warnings=tuple(warnings),
        timings=timings,
    )
