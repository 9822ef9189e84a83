"""From a surface and its plan to a layout of each of its pieces."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from ...base.errors import RemeshError
from ...base.progress import Progress
from ...base.settings import options
from ...base.words import counted
from ...mesh.surface import Surface, relative_areas
from ...umbilics.result import Detection, Umbilics
from ..by_hand import Strokes, WantedPoles, planned_by_hand
from ..planner import Guide
from ..settings import GuidanceSettings
from .field.wishes import Wishes
from .finishing.mirroring import ON, Plane, on_sides, wanted_plane
from .finishing.unlaid import Unlaid
from .layout.effort import Effort
from .layout.laying_out import LaidOut, laid_out
from .settings import RemeshSettings
from .surface.sizes import sizes
from .surface.subdivision import pieces
from .surface.working_surface import SCRAP, prepared, working_surface

# Wanted poles beyond the plane of symmetry by less than this, in lengths of quads, lie on it.
BEYOND = 0.5
# Edges of quads longer than this many times the size of the surface are taken to be as long: they
# ask for the same quads, and their squares are numbers.
LONGEST = 1e9
# Half the size of a mesh, at least and at most, for squares of its lengths to be numbers.
SMALLEST, LARGEST = 1e-150, 1e150


@dataclass(frozen=True)
class Given:
    """What a user brings besides the vertices; see `remesh`."""

    triangles: np.ndarray
    detection: Detection
    sharp: np.ndarray | None
    zone: np.ndarray | None
    strokes: Strokes | None
    wanted: WantedPoles | None


@dataclass(frozen=True)
class Prepared:
    """Layouts of all pieces, or of one half of them on a side of a plane.

    Attributes
    ----------
    unlaid:
        The pieces that no layout was found for.
    size:
        Length of a quad's edge in the coordinates of the input.
    requested, asked:
        How many quads are wanted in all, and how many the pieces with a layout shall have
        together.
    effort:
        What is left to be tried on them.
    wanted:
        The wanted poles that lie on them, None without any wishes.
    warnings:
        Sentences about what was mended and left out before.
    """

    parts: list[LaidOut]
    unlaid: list[Unlaid]
    plane: Plane | None
    size: float
    requested: int
    asked: int
    effort: Effort
    wanted: WantedPoles | None
    warnings: list[str]


def prepare(guide: Guide, given: Given, settings: RemeshSettings, progress: Progress) -> Prepared:
    """Lay out every piece of the guide's surface."""
    whole, detection = guide.surface, given.detection
    if not SMALLEST < whole.unit < LARGEST:
        raise RemeshError(
            f"The mesh is {whole.unit:g} in size: areas as small or large are no numbers. Scale it "
            "first."
        )
    warnings = list(guide.cleaning)
    area = float(whole.face_normal_area[1].sum())
    size, requested = _size(area, whole.unit, settings)
    asked = requested
    field = guide.measured(progress.part("Simplifying the field", 0.0, 0.1))
    plane = wanted_plane(settings.symmetry, whole, detection, warnings)
    planning = GuidanceSettings(
        smoothness=settings.smoothness,
        feature_angle=settings.feature_angle,
        align_sharp=settings.align_sharp,
    )
    found = guide.features(planning, sharp=given.sharp)
    mesh, short = prepared(whole, field, found, size / whole.unit, settings.feature_angle)
    if short:
        warnings.append(
            f"{counted(short, 'crease')} left out, shorter than two quads or weak and ending in "
            "the open. Mark the edges as sharp to keep them."
        )
    if plane is None:
        cut = pieces(mesh)
        single = imaged = np.zeros(len(cut), bool)
    else:
        offset = (plane.offset - whole.origin @ plane.normal) / whole.unit
        cut, single, imaged = on_sides(
            mesh, plane.normal, offset, size / whole.unit, settings.mirror_single
        )
        areas = np.array([piece.area for piece in cut])
        once, twice = areas.sum(), areas.sum() + areas[~single].sum()
        size, requested = _size(float(twice), whole.unit, settings)
        asked = max(1, round(requested * once / twice))
        if single.any():
            warnings.append(
                f"{counted(int(single.sum()), 'piece')} not mirrored: on one side of the plane of "
                "symmetry, with nothing alike on the other. Mirror Single Pieces mirrors them."
            )
    undirected = np.zeros(len(given.triangles), bool)
    undirected[whole.source_triangle] = guide.undirected
    poles = None
    if given.wanted is not None:
        alone = [piece.source for piece, stays in zip(cut, single, strict=True) if stays]
        poles = _reachable(whole, given.wanted, plane, size, np.concatenate([[-1], *alone]))
    parts: list[LaidOut] = []
    unlaid: list[Unlaid] = []
    part = progress.part("Mapping the surface", 0.1, 0.15)
    surfaces = [working_surface(piece, whole, size / whole.unit, part) for piece in cut]
    effort = Effort(sum(len(one.surface.triangles) for one in surfaces))
    for number, working in enumerate(surfaces):
        share = 0.15 + 0.85 * np.array([number, number + 1]) / len(cut)
        mine = progress.part("Mapping the surface", float(share[0]), float(share[1]))
        surface = working.surface
        umbilics, rows = _umbilics(surface, detection.umbilics)
        wishes = Wishes(
            smoothness=settings.smoothness,
            feature=working.feature,
            size=sizes(working, size / surface.unit, settings.adaptivity),
            undirected=undirected[surface.source_triangle],
            avoided=_in_zone(surface, given.triangles, given.zone),
            mirror=_on_plane(surface, None if single[number] else plane),
            single=bool(single[number]),
            imaged=bool(imaged[number]),
            umbilics=umbilics,
            umbilic_row=rows,
            strokes=given.strokes,
            wanted=None if poles is None else _of_piece(poles, surface),
        )
        without = Unlaid(working, wishes)
        laid = None if without.scrap else laid_out(working, wishes, mine, effort)
        if laid is None:
            unlaid.append(without)
        else:
            parts.append(laid)
    asked = max(asked - sum(one.asked for one in unlaid), 1)
    return Prepared(
        parts, unlaid, plane, size, requested, asked, effort, poles and poles[0], warnings
    )


def scrap(vertices: np.ndarray, triangles: np.ndarray, settings: RemeshSettings) -> float:
    """Part of the area that a piece has for which no layout is sought."""
    if isinstance(settings.edge_length, float | int) and settings.edge_length > 0:
        vertices, triangles = np.asarray(vertices, float), np.asarray(triangles)
        sound = np.isfinite(vertices).all(axis=1)[triangles].all(axis=1)
        area, side = relative_areas(vertices, triangles[sound])
        whole = float(area.sum())
        ratio = settings.edge_length / side
        return SCRAP * ratio * ratio / whole if whole > 0.0 else np.inf
    return SCRAP / settings.quads


def _size(area: float, unit: float, settings: RemeshSettings) -> tuple[float, int]:
    """Length of a quad's edge in the coordinates of the input, and how many quads that makes on so
    large a surface, measured in lengths of `unit`."""
    if isinstance(settings.edge_length, float | int) and settings.edge_length > 0:
        size = float(settings.edge_length)
        # The root first: the square of a length may be no number.
        across = float(np.sqrt(area)) * (unit / size)
        most = options(RemeshSettings)["quads"].maximum
        if not across * across <= most:
            raise RemeshError(
                f"Edges of length {size:g} would make more than {most:,.0f} quads of this surface. "
                "Choose a larger edge length."
            )
        size = min(size, LONGEST * float(np.sqrt(area)) * unit)
        return size, max(1, round(across * across))
    if not area > 0:
        raise RemeshError("The mesh has no area that quads could cover.")
    return unit * float(np.sqrt(area / settings.quads)), settings.quads


def _umbilics(surface: Surface, umbilics: Umbilics) -> tuple[Umbilics, np.ndarray]:
    """The umbilics of a piece in its triangles, and their rows."""
    rows = np.flatnonzero(np.isin(umbilics.triangle, surface.source_triangle))
    mine = umbilics.select(rows)
    middle = surface.vertices[surface.triangles].mean(axis=1)
    _, triangle = cKDTree(middle).query((mine.position - surface.origin) / surface.unit)
    third = np.full((len(rows), 3), 1.0 / 3.0)
    return replace(mine, triangle=triangle.astype(np.int64), barycentric=third), rows


def _reachable(
    whole: Surface, wanted: WantedPoles, plane: Plane | None, size: float, single: np.ndarray
) -> tuple[WantedPoles, np.ndarray]:
    """The wanted poles on what is laid out, a half and the input triangles that are `single`, and
    their input triangles."""
    position = np.asarray(wanted.position, float).reshape(-1, 3)
    valence = np.asarray(wanted.valence, np.int64)
    poles = WantedPoles(position, valence)
    triangle = planned_by_hand(whole, [], poles).triangle
    if plane is None:
        return poles, triangle
    here = plane.height(position) > -BEYOND * size
    here |= np.isin(triangle, single)
    return WantedPoles(position[here], valence[here]), triangle[here]


def _of_piece(poles: tuple[WantedPoles, np.ndarray], surface: Surface) -> WantedPoles:
    wanted, triangle = poles
    mine = np.isin(triangle, surface.source_triangle)
    return WantedPoles(wanted.position[mine], wanted.valence[mine])


def _on_plane(surface: Surface, plane: Plane | None) -> np.ndarray:
    """(n,) bool border vertices on the plane of symmetry."""
    if plane is None:
        return np.zeros(len(surface.vertices), bool)
    height = plane.height(surface.vertices * surface.unit + surface.origin)
    return surface.border & (np.abs(height) <= ON * surface.unit)


def _in_zone(surface: Surface, triangles: np.ndarray, zone: np.ndarray | None) -> np.ndarray:
    """(n,) bool vertices of triangles that touch the zone."""
    found = np.zeros(len(surface.vertices), bool)
    if zone is not None and zone.any():
        touched = zone[np.asarray(triangles)].any(axis=1)
        found[surface.triangles[touched[surface.source_triangle]]] = True
    return found
