"""From a triangle mesh to a quad mesh whose edges follow the curvature.

The cross field is smoothed and mapped seamlessly to the plane; the motorcycle graph of the map
divides the surface into rectangles; whole numbers of quads are given to their sides; the quads
are laid out in the map, evened out and turned to the curvature on the surface.
"""

from __future__ import annotations

import time

import numpy as np

from ...base.errors import RemeshError
from ...base.options import AUTO
from ...base.progress import Progress
from ...mesh.repair import clean
from ...mesh.surface import Surface
from ...umbilics.detect import detect
from ...umbilics.result import Detection
from .conformity import conformity
from .grids import Grids, grids, violations
from .integers import whole_lengths
from .laying_out import LaidOut, laid_out
from .pieces import pieces
from .placement import Placement, place
from .projection import ClosestPoints
from .relaxation import Guides, relaxed
from .reporting import Report, reported
from .result import QuadMesh
from .settings import RemeshSettings
from .working_surface import working_surface

# The number of quads may be off by this part; rounds of asking for more or fewer.
CLOSE, ROUNDS = 0.03, 5
# Rounds of forbidding merges before every arc gets a length.
MOST_CUTS = 12


def remesh(
    vertices: np.ndarray,
    triangles: np.ndarray,
    settings: RemeshSettings | None = None,
    progress: Progress | None = None,
    *,
    detection: Detection | None = None,
    sharp: np.ndarray | None = None,
    zone: np.ndarray | None = None,
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

    Raises
    ------
    InvalidMeshError
        As `detect`.
    RemeshError
        A piece of the surface cannot be covered with quads.
    """
    settings, progress = settings or RemeshSettings(), progress or Progress()
    clock = _Clock()
    if detection is None:
        detection = detect(vertices, triangles, progress=progress.part("Curvature", 0.0, 0.15))
    whole, warnings = clean(vertices, triangles)
    size = _size(whole, settings)
    clock.lap("curvature")
    undirected = np.zeros(len(triangles), bool)
    for region in detection.regions:
        undirected[region.triangles] = True
    parts: list[LaidOut] = []
    surfaces = pieces(whole)
    part = progress.part("Mapping the surface", 0.15, 0.7)
    for number, surface in enumerate(surfaces):
        mine = part.part(
            "Mapping the surface", number / len(surfaces), (number + 1) / len(surfaces)
        )
        working = working_surface(
            surface, detection.curvature, settings, sharp, size / surface.unit
        )
        found = laid_out(
            working,
            settings,
            np.full(len(working.surface.triangles), size / working.surface.unit),
            undirected[working.surface.source_triangle],
            _in_zone(working.surface, triangles, zone),
            mine,
        )
        parts.append(found)
        warnings += [sentence for sentence in found.warnings if sentence not in warnings]
    clock.lap("map and layout")
    asked = _asked(whole, settings, size)
    made = _counted(parts, asked, progress.part("Whole numbers", 0.7, 0.8))
    clock.lap("whole numbers")
    part = progress.part("Evening out", 0.8, 0.98)
    reports: list[Report] = []
    for number, (laid, grid) in enumerate(zip(parts, made, strict=True)):
        mine = part.part("Evening out", number / len(parts), (number + 1) / len(parts))
        placed = place(laid.map_, laid.layout, grid)
        _check(placed, laid, grid)
        position, triangle = _on_surface(placed, laid, settings, mine)
        reports.append(reported(laid, grid, placed, position, triangle, detection))
    clock.lap("evening out")
    progress.step(1.0)
    return _joined(reports, warnings, clock.seconds)


class _Clock:
    """Seconds of stages, by name."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._last = time.perf_counter()

    def lap(self, name: str) -> None:
        now = time.perf_counter()
        self.seconds[name] = now - self._last
        self._last = now


def _area(whole: Surface) -> float:
    return float(whole.face_normal_area[1].sum()) * whole.unit**2


def _size(whole: Surface, settings: RemeshSettings) -> float:
    """Length of a quad's edge in the coordinates of the input."""
    if settings.edge_length != AUTO and settings.edge_length > 0:
        return float(settings.edge_length)
    area = _area(whole)
    if not area > 0:
        raise RemeshError("The mesh has no area that quads could cover.")
    return float(np.sqrt(area / settings.quads))


def _asked(whole: Surface, settings: RemeshSettings, size: float) -> int:
    if settings.edge_length == AUTO or settings.edge_length <= 0:
        return settings.quads
    return max(1, round(_area(whole) / size**2))


def _in_zone(surface: Surface, triangles: np.ndarray, zone: np.ndarray | None) -> np.ndarray:
    """(n,) bool vertices of triangles that touch the zone."""
    found = np.zeros(len(surface.vertices), bool)
    if zone is not None and zone.any():
        touched = np.asarray(zone)[np.asarray(triangles)].any(axis=1)
        found[surface.triangles[touched[surface.source_triangle]]] = True
    return found


def _counted(parts: list[LaidOut], asked: int, progress: Progress) -> list[Grids]:
    """Grids with about as many quads as asked for."""
    scale, best = 1.0, None
    cuts: list[set[frozenset[int]]] = [_first_cuts(laid) for laid in parts]
    for attempt in range(ROUNDS):
        progress.step(attempt / ROUNDS)
        made = [
            _whole(laid, scale, cut, progress) for laid, cut in zip(parts, cuts, strict=True)
        ]
        total = sum(len(grid.quads) for grid in made)
        off = abs(np.log(max(total, 1) / asked))
        if best is None or off < best[0]:
            best = off, made
        if off <= CLOSE:
            break
        scale *= float(np.clip(np.sqrt(asked / max(total, 1)), 0.5, 2.0))
    return best[1]


def _first_cuts(laid: LaidOut) -> set[frozenset[int]]:
    """Arcs between two poles or ends of features always have a length."""
    special = np.array([node.vertex >= 0 for node in laid.layout.nodes])
    both = special[laid.layout.arc_node].all(axis=1)
    return {frozenset([arc]) for arc in np.flatnonzero(both).tolist()}


def _whole(
    laid: LaidOut, scale: float, cuts: set[frozenset[int]], progress: Progress
) -> Grids:
    """Grids that merge nothing that must stay apart; `cuts` gathers what was forbidden."""
    layout = laid.layout
    for _ in range(MOST_CUTS):
        grid = grids(layout, whole_lengths(layout, scale, cuts, 0, progress))
        new = violations(layout, grid) - cuts
        if not new and len(grid.quads):
            if _conforms(grid, laid):
                return grid
            break
        cuts |= new
    # Where every arc has a length nothing is merged.
    return grids(layout, whole_lengths(layout, scale, set(), 1, progress))


def _conforms(grid: Grids, laid: LaidOut) -> bool:
    quads = grid.merged[grid.quads]
    found = conformity(quads, int(grid.merged.max()) + 1)
    return found.manifold and found.characteristic == _characteristic(laid)


def _characteristic(laid: LaidOut) -> int:
    return int(laid.working.surface.euler_characteristic.sum())


def _check(placed: Placement, laid: LaidOut, grid: Grids) -> None:
    """Nothing torn is ever returned."""
    found = conformity(placed.quads, len(placed.position))
    if not found.manifold or found.characteristic != _characteristic(laid):
        raise RemeshError(
            "The quads do not join up on a piece of the mesh. Change the number of quads or the "
            "smoothness a little."
        )


def _on_surface(
    placed: Placement, laid: LaidOut, settings: RemeshSettings, progress: Progress
) -> tuple[np.ndarray, np.ndarray]:
    surface = laid.working.surface
    crossed = laid.map_.crosses
    held = placed.vertex >= 0
    on = np.where(held, crossed.on_feature[np.maximum(placed.vertex, 0)], False)
    curves = {
        number: (
            surface.vertices[crossed.tail[track.chain]],
            surface.vertices[crossed.head[track.chain]],
        )
        for number, track in enumerate(laid.layout.tracks)
        if track.feature
    }
    guides = Guides(
        ClosestPoints(surface.vertices, surface.triangles, surface.twin),
        crossed.direction,
        np.ones(len(crossed.direction)),
        on,
        np.where(on, -1, placed.track),
        curves,
    )
    return relaxed(placed.position, placed.quads, guides, settings.relaxation, progress)


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
