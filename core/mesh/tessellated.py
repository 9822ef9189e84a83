"""Tessellated CAD: which edges are creases, and which faces between them are exact.

Programs that make parts of planes, cylinders, cones and spheres write them as facets: flat faces
as a few large triangles whose vertices lie on their outline only, cylinders as strips of long
ones. No fit to such vertices tells how the face bends, but the facets do, exactly. A mesh is
taken for one of these by its dihedral angles: many are none at all, and among the others there is
a gap between those by which round faces turn from facet to facet and those of the creases.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ..base.unit import angles_between
from ..base.words import counted
from .exact_shapes import (
    CONICAL,
    CYLINDRICAL,
    FLAT,
    KINDS,
    NONE,
    PLANAR,
    SPHERICAL,
    normal_rounding,
    shapes_of,
)
from .half_edges import inner_edges
from .surface import Surface

# Share of flat edges from which a mesh may be a part: 0.35 to 0.6 on parts written by SolidWorks
# and OpenSCAD, 0.31 and 0.33 on a modeller's cone and cube, below 0.1 on scans and sculptures.
# Round bodies of quads have 0.33 as well, but no creases.
MOST_FLAT = 0.2
# Some creases turn by this many degrees at least, the others by the next, and all of them by so
# many times more than any facet.
CREASE, LEAST_CREASE, GAP = 35.0, 15.0, 2.0
# Creases by angle where no face is round, so that there is no gap to look for.
USUAL = 30.0
# Share of the area that must be exact faces: what has creases but is free-form is no such part.
MOST_EXACT = 0.5
# Triangles that are looked at to tell that a mesh is none.
SAMPLED = 4096


@dataclass(frozen=True)
class Tessellation:
    """Faces of a tessellated part.

    Attributes
    ----------
    crease_angle:
        Angle in degrees that parts creases from the turns between the facets of round faces.
    face:
        (m,) int32 exact face of each triangle of the surface, -1 where it is free-form.
    kinds:
        For each face "planar", "cylindrical", "conical" or "spherical".
    mean_curvature:
        (f,) float64 mean curvature of each face, in the coordinates of the surface.
    axis:
        (f, 3) float64 unit axis of each cylinder or cone, zero for the others.
    """

    crease_angle: float
    face: np.ndarray
    kinds: tuple[str, ...]
    mean_curvature: np.ndarray
    axis: np.ndarray

    def exact_vertices(self, surface: Surface) -> np.ndarray:
        """(n,) bool, vertices all of whose triangles belong to exact faces."""
        exact = np.ones(len(surface.vertices), bool)
        exact[surface.triangles[self.face < 0]] = False
        return exact

    def sentence(self) -> str:
        """What was met, for the user."""
        parts = [
            counted(number, f"{kind} face")
            for kind in (PLANAR, CYLINDRICAL, CONICAL, SPHERICAL)
            if (number := self.kinds.count(kind))
        ]
        free = int(np.count_nonzero(self.face < 0))
        text = (
            f"The mesh is a tessellated part: {', '.join(parts)} between creases of more than "
            f"{self.crease_angle:.0f} degrees, which are regions without isolated umbilics."
        )
        if free:
            text += (
                f" {counted(free, 'triangle')} of other faces show umbilics only as well as the "
                "facets do: export finer where these matter."
            )
        elif set(self.kinds) == {PLANAR}:
            text += " If it stands for a round body, subdivide it smoothly first."
        return text


def tessellation(surface: Surface, angle: float | None = None) -> Tessellation | None:
    """The exact faces of a surface; None unless it is a tessellated part.

    Turns are measured at every edge only where a sample of them says that it may be one.

    Parameters
    ----------
    angle:
        Degrees from which an edge is a crease; None for those in the gap.
    """
    edges = inner_edges(surface.twin)
    sample = edges[:: max(len(edges) // SAMPLED, 1)]
    if len(sample) == 0 or not _may_be(_turns(surface, sample), flat_edges(surface, sample)):
        return None
    turns = _turns(surface, edges)
    rounding = normal_rounding(surface)
    flat = turns <= FLAT + rounding[edges // 3] + rounding[surface.twin[edges] // 3]
    if not _may_be(turns, flat):
        return None
    angles = _crease_angles(turns[~flat])
    if angle is not None and angles:
        # Without a gap no angle makes facets of what bends all over between its creases.
        angles = [angle]
    _, area = surface.face_normal_area
    best, most = None, MOST_EXACT * area.sum()
    for one in angles:
        faces = _between(surface, rounding, edges, flat, turns >= np.radians(one))
        exact = area[faces.face >= 0].sum()
        # Of several gaps the one that leaves least free-form, and of these the widest faces.
        if exact > most * (1.0 + 1e-6):
            best, most = (one, faces), exact
    if best is None:
        return None
    crease, faces = best
    return Tessellation(
        crease, faces.face, tuple(faces.kinds), np.array(faces.curvatures), np.array(faces.axes)
    )


def _may_be(turns: np.ndarray, flat: np.ndarray) -> bool:
    """Whether edges that turn so far (e,), or are `flat` (e,), may be those of a part: many are
    flat, or else all are creases, as those of a polyhedron."""
    return bool(flat.mean() >= MOST_FLAT or turns[~flat].min() >= np.radians(CREASE))


def flat_edges(surface: Surface, edges: np.ndarray) -> np.ndarray:
    """(e,) bool, half-edges (e,) inside the surface across which it does not turn."""
    one, other = (normal_rounding(surface, side // 3) for side in (edges, surface.twin[edges]))
    return np.asarray(_turns(surface, edges) <= FLAT + one + other)


def _between(
    surface: Surface, rounding: np.ndarray, edges: np.ndarray, flat: np.ndarray, bent: np.ndarray
) -> _Faces:
    """The exact faces between the half-edges `edges` (e,) that are `bent` (e,); across those that
    are `flat` (e,) facets go on. `rounding` (m,) is as from `normal_rounding`."""
    m = len(surface.triangles)
    first, second = edges // 3, surface.twin[edges] // 3

    def pieces(joined: np.ndarray) -> np.ndarray:
        ones = np.ones(int(joined.sum()), np.int8)
        graph = sparse.coo_array((ones, (first[joined], second[joined])), shape=(m, m))
        return csgraph.connected_components(graph, directed=False)[1]

    facet, between = pieces(flat), pieces(~bent)
    faces = _Faces(surface, rounding)
    left = np.arange(m)[faces.claim(between, np.ones(m, bool))]
    if len(left):
        # Where a round face leaves a flat one without a crease, the flat one is the facet that
        # is larger than those of its neighbours.
        _, area = surface.face_normal_area
        size = np.bincount(facet, area)[facet]
        usual = np.zeros(int(between.max()) + 1)
        for piece in np.unique(between[left]):
            inside = left[between[left] == piece]
            usual[piece] = np.median(size[inside])
        count = np.bincount(facet)[facet]
        large = np.zeros(m, bool)
        large[left] = (count[left] > 2) | (size[left] > 4.0 * usual[between[left]])
        faces.claim(facet, large)
        free = faces.face < 0
        rest = pieces(~bent & free[first] & free[second])
        faces.claim(rest, free)
    return faces


def _turns(surface: Surface, edges: np.ndarray) -> np.ndarray:
    """(e,) angle in radians between the normals at half-edges."""
    normal, _ = surface.face_normal_area
    # `take` gathers rows several times faster than an index does.
    one, other = (normal.take(side // 3, axis=0) for side in (edges, surface.twin[edges]))
    return angles_between(one, other)


def _crease_angles(turns: np.ndarray) -> list[float]:
    """Degrees in the gaps between the facets' turns and the creases', the widest gap of a
    crease's turn first; none where they are not apart."""
    degrees = np.sort(np.degrees(turns))
    if not len(degrees) or degrees[-1] < CREASE:
        return []
    if degrees[0] >= CREASE:
        return [USUAL]
    gap = np.flatnonzero((degrees[1:] >= GAP * degrees[:-1]) & (degrees[1:] >= LEAST_CREASE))
    return [float(np.sqrt(degrees[row] * degrees[row + 1])) for row in gap[::-1]]


class _Faces:
    """Collects the exact faces of a surface."""

    def __init__(self, surface: Surface, rounding: np.ndarray) -> None:
        self.surface, self.rounding = surface, rounding
        self.face = np.full(len(surface.triangles), -1, np.int32)
        self.kinds: list[str] = []
        self.curvatures: list[float] = []
        self.axes: list[np.ndarray] = []

    def claim(self, piece: np.ndarray, asked: np.ndarray) -> np.ndarray:
        """Make faces of the pieces (m,) of the triangles `asked` (m,) that are exact; (m,) bool,
        the asked ones that are none."""
        rows = np.flatnonzero(asked)
        if len(rows):
            rows = rows[np.argsort(piece[rows], kind="stable")]
            cuts = np.flatnonzero(np.diff(piece[rows])) + 1
            starts = np.concatenate([[0], cuts, [len(rows)]])
            shapes = shapes_of(self.surface, rows, starts, self.rounding)
            exact = shapes.kind != NONE
            number = np.full(len(exact), -1, np.int32)
            number[exact] = np.arange(exact.sum()) + len(self.kinds)
            self.face[rows] = np.repeat(number, np.diff(starts))
            self.kinds.extend(KINDS[kind] for kind in shapes.kind[exact])
            self.curvatures.extend(shapes.mean_curvature[exact])
            self.axes.extend(shapes.axis[exact])
        return asked & (self.face < 0)
