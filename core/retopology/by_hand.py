"""What a user draws and moves, for the next plan: guide strokes and poles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from ..base.errors import GuidanceError
from ..base.options import check, setting
from ..base.subsets import spans
from ..mesh.half_edges import ends_of
from ..mesh.normals import vertex_normals
from ..mesh.surface import Surface
from ..umbilics.result import Region
from .features import Features
from .poles import Poles, poles_at

# Weight of a stroke at its line, in that of a sure crest: as a hard feature's.
STROKE_WEIGHT = 300.0
# A stroke holds at a vertex where the cross is this near to it, and is said not to if that is less
# of it than this share; vertices in the inner half of its influence count.
HELD, ENOUGH, INNER = 15.0, 0.9, 0.5
# What is said of strokes that pull at nothing.
FAR = "too far from the surface to count"
# So many sentences on strokes are read; of the others their number is enough.
MOST_SAID = 5
# A wanted pole farther from the surface than this share of its size is not on it.
OFF_SURFACE = 0.1
# Triangles tried for a wanted pole, so that no two of them are in one.
NEAREST = 8


@dataclass(frozen=True)
class StrokeSettings:
    """How guide strokes count; validated on construction.

    Raises
    ------
    InvalidSettingsError
        A value is of the wrong type or out of bounds.
    """

    influence: float = setting(
        0.1,
        label="Influence",
        help="How far a guide stroke counts to both sides, in parts of the size of the mesh; 0 is "
        "along the stroke alone",
        kind="number",
        minimum=0.0,
        maximum=1.0,
    )

    def __post_init__(self) -> None:
        check(self)


@dataclass(frozen=True)
class Strokes:
    """Lines that the cross field is to run along, l of them with p points in all.

    Attributes
    ----------
    start:
        (l + 1,) int: the points of stroke i are rows start[i]:start[i + 1].
    position:
        (p, 3) float64 points, on the mesh or near it, in its coordinates.
    influence:
        (l,) float64 length to both sides over which a stroke counts, less and less.

    Raises
    ------
    GuidanceError
        The arrays do not fit each other.
    """

    start: np.ndarray
    position: np.ndarray
    influence: np.ndarray

    def __post_init__(self) -> None:
        start, places = np.asarray(self.start), np.shape(self.position)
        ordered = start.ndim == 1 and len(start) == len(self.influence) + 1
        ordered = ordered and start[0] == 0 and bool((np.diff(start) >= 0).all())
        if not ordered or places != (int(start[-1]), 3):
            raise GuidanceError(
                "Strokes need positions of shape (p, 3), an influence for each stroke, and where "
                "each begins among the positions, 0 first and p last."
            )

    def __len__(self) -> int:
        return len(self.influence)


@dataclass(frozen=True)
class WantedPoles:
    """Poles where a user wants them, all that there are to be.

    Attributes
    ----------
    position:
        (k, 3) float64 points on the mesh or near it, in its coordinates.
    valence:
        (k,) int 3 or 5.

    Raises
    ------
    GuidanceError
        Another valence, or not one for each position.
    """

    position: np.ndarray
    valence: np.ndarray

    def __post_init__(self) -> None:
        places, valences = np.shape(self.position), np.asarray(self.valence)
        if places != (valences.size, 3) or not np.isin(valences, (3, 5)).all():
            raise GuidanceError(
                "Wanted poles need positions of shape (k, 3) and k valences, each 3 or 5."
            )


@dataclass(frozen=True)
class Pull:
    """Where strokes pull at the vertices of a surface, c of them, ascending.

    Attributes
    ----------
    vertex, stroke:
        (c,) int64 vertices, each once, and the stroke nearest to each.
    direction:
        (c, 3) float64 unit direction of the stroke there.
    share:
        (c,) float64 how much it counts, 1 at the line to 0 where its influence ends.
    drawn, reached:
        (l,) bool strokes that have a length, and those whose influence reaches the surface.
    """

    vertex: np.ndarray
    stroke: np.ndarray
    direction: np.ndarray
    share: np.ndarray
    drawn: np.ndarray
    reached: np.ndarray


def pull_of(surface: Surface, strokes: Strokes) -> Pull:
    """The vertices that strokes reach. A stroke reaches as far as the mesh has a vertex at least,
    and not through a sheet to its other side."""
    edge = surface.usual_side
    influence = np.maximum(np.asarray(strokes.influence, float) / surface.unit, edge)
    place, ahead, number = [np.zeros((0, 3))], [np.zeros((0, 3))], [np.zeros(0, np.int64)]
    for stroke in range(len(strokes)):
        points = np.asarray(strokes.position[strokes.start[stroke] : strokes.start[stroke + 1]])
        points = (points - surface.origin) / surface.unit
        chord = np.diff(points, axis=0)
        length = np.linalg.norm(chord, axis=1)
        chord, points, length = chord[length > 0], points[:-1][length > 0], length[length > 0]
        count = np.ceil(2.0 * length / edge).astype(np.int64)
        part = np.repeat(np.arange(len(chord)), count)
        share = (spans(0, count) + 0.5) / count[part]
        place.append(points[part] + share[:, None] * chord[part])
        ahead.append((chord / length[:, None])[part])
        number.append(np.full(len(part), stroke))
    points, direction, owner = (np.concatenate(some) for some in (place, ahead, number))
    drawn = np.bincount(owner, minlength=len(strokes)) > 0
    if not len(points):
        none = np.zeros(0, np.int64)
        return Pull(none, none, points, np.zeros(0), drawn, drawn)
    normal = vertex_normals(surface)
    away, at = cKDTree(surface.vertices).query(points)
    reached = np.bincount(owner[away < influence[owner]], minlength=len(strokes)) > 0
    distance, near = cKDTree(points).query(surface.vertices)
    same_side = np.einsum("nc,nc->n", normal, normal[at[near]]) > 0.0
    share = np.where(same_side, 1.0 - distance / influence[owner[near]], 0.0)
    vertex = np.flatnonzero(share > 0.0)
    return Pull(vertex, owner[near[vertex]], direction[near[vertex]], share[vertex], drawn, reached)


def with_strokes(surface: Surface, features: Features, pull: Pull) -> Features:
    """Features of which the strokes are part, in place of crests beside them; hard ones stay."""
    hard = np.zeros(len(surface.vertices), bool)
    for end in ends_of(surface.triangles, features.half_edge):
        hard[end] = True
    mine = ~hard[pull.vertex]
    rest = ~np.isin(features.crest_vertex, pull.vertex)
    vertex = np.concatenate([features.crest_vertex[rest], pull.vertex[mine]])
    direction = np.concatenate([features.crest_direction[rest], pull.direction[mine]])
    weight = np.concatenate([features.crest_weight[rest], STROKE_WEIGHT * pull.share[mine] ** 2])
    order = np.argsort(vertex)
    return replace(
        features,
        crest_vertex=vertex[order],
        crest_direction=direction[order],
        crest_weight=weight[order],
    )


def strokes_not_held(
    pull: Pull, strokes: int, direction: np.ndarray, normal: np.ndarray
) -> tuple[str, ...]:
    """Sentences on the strokes that a cross field (n, 3) with normals (n, 3) does not follow."""
    inner = pull.share >= INNER
    vertex, wanted = pull.vertex[inner], pull.direction[inner]
    one = direction[vertex]
    two = np.cross(normal[vertex], one)
    x, y = np.einsum("nc,nc->n", wanted, one), np.einsum("nc,nc->n", wanted, two)
    # To the nearest of the four directions.
    off = np.degrees(np.abs(np.angle((x + 1j * y) ** 4))) / 4.0
    count = np.bincount(pull.stroke[inner], minlength=strokes)
    held = np.bincount(pull.stroke[inner], weights=off <= HELD, minlength=strokes)
    found = []
    for stroke in range(strokes):
        if not pull.drawn[stroke]:
            found.append(f"Guide stroke {stroke + 1} has no length and does not count.")
        elif not pull.reached[stroke]:
            found.append(f"Guide stroke {stroke + 1} is {FAR}.")
        elif not count[stroke]:
            found.append(
                f"Guide stroke {stroke + 1} does not count: others are nearer to the surface "
                "beside it."
            )
        elif held[stroke] < ENOUGH * count[stroke]:
            share = 100.0 * (1.0 - held[stroke] / count[stroke])
            found.append(
                f"Guide stroke {stroke + 1} could not be followed over {share:.0f} % of it: a hard "
                "feature, a pole or another stroke is there."
            )
    return tuple(found)


def first_said(sentences: Sequence[str]) -> tuple[str, ...]:
    """As many sentences on strokes as are read, and how many more there would be."""
    more = len(sentences) - MOST_SAID
    if more <= 1:
        return tuple(sentences)
    return (*sentences[:MOST_SAID], f"{more} more guide strokes could not be followed everywhere.")


def poles_off_surface(surface: Surface, wanted: WantedPoles, poles: Poles) -> tuple[str, ...]:
    """What is said of wanted poles that are not on the surface, beside where they were put."""
    size = float(np.ptp(surface.vertices, axis=0).max()) * surface.unit
    asked = np.asarray(wanted.position, float).reshape(-1, 3)
    away = np.linalg.norm(asked - poles.position, axis=1)
    count = int(np.count_nonzero(away > OFF_SURFACE * size))
    if not count:
        return ()
    if count == 1:
        return ("1 pole was far from the surface: it stands where that is nearest now.",)
    return (f"{count} poles were far from the surface: they stand where that is nearest now.",)


def planned_by_hand(surface: Surface, regions: list[Region], wanted: WantedPoles) -> Poles:
    """The wanted poles in the middles of the nearest triangles, each in one of its own.

    Raises
    ------
    GuidanceError
        A position is not finite.
    """
    place = (np.asarray(wanted.position, float).reshape(-1, 3) - surface.origin) / surface.unit
    if not np.isfinite(place).all():
        raise GuidanceError("A wanted pole has no place: its coordinates are not numbers.")
    middle = surface.vertices[surface.triangles].mean(axis=1)
    most = min(len(middle), NEAREST)
    _, near = cKDTree(middle).query(place, k=most)
    near = near.reshape(len(place), most)
    triangle = near[:, 0].copy()
    taken: set[int] = set()
    for row, choices in enumerate(near):
        free = [int(choice) for choice in choices if int(choice) not in taken]
        triangle[row] = free[0] if free else choices[0]
        taken.add(int(triangle[row]))
    count = len(place)
    return poles_at(
        surface,
        regions,
        triangle,
        np.full((count, 3), 1.0 / 3.0),
        4 - np.asarray(wanted.valence, np.int64),
        np.full(count, -1),
        np.ones(count, bool),
        np.ones(count),
    )
