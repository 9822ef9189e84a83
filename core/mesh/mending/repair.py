"""From any triangle soup to an oriented manifold `Surface`, with a word on what was mended."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ...base.arguments import in_range, numbers, whole_numbers
from ...base.errors import InvalidMeshError
from ...base.words import counted
from ..half_edges import HalfEdges, ends_of, link
from ..neighbourhoods import FEWEST_SAMPLES
from ..rings import adjacency
from ..surface import NO_AREA, Surface, relative_areas
from .cavities import cavities
from .joining import corners_in_input, in_one_place, joined_with, mend_borders, proper
from .sheets import linked, separate, split_fans
from .slits import without_slits

# Half the size of a mesh, at least: rounded to so many digits no bump bends by more than the root
# of that within the unit box, and over this its curvature is a number still.
SMALLEST = np.finfo(float).tiny / np.sqrt(np.finfo(float).eps)


def clean(
    vertices: np.ndarray,
    triangles: np.ndarray,
    join_borders: bool = True,
    kept_from: float = np.inf,
) -> tuple[Surface, list[str]]:
    """The surface that a triangle mesh describes, and warnings about what was changed.

    Triangles with repeated corners or corners that are not finite, and copies of a triangle,
    are left out. Borders that coincide are joined, vertices on a border edge inserted there, and
    both ends of edges without a length taken for one vertex.
    Windings are made to agree. Sheets that meet at an edge of three or more triangles or at a
    pinched vertex are separated. Pieces too small for a fit are left out, unless there are no
    others. A clean manifold passes through untouched.

    Parameters
    ----------
    vertices:
        (n, 3) real positions.
    triangles:
        (m, 3) integer corners.
    join_borders:
        False leaves borders open that lie on each other, and edges without a length.
    kept_from:
        Part of the area from which pieces too small for a fit are kept beside larger ones; not
        those that mending took off others.

    Raises
    ------
    InvalidMeshError
        Wrong shapes or types, corners out of range, or no usable triangle.
    """
    vertices, triangles = _checked(vertices, triangles)
    as_given = np.arange(len(vertices))
    surface, warnings = _cleaned(vertices, triangles, as_given, join_borders, kept_from)
    same = in_one_place(surface, len(vertices)) if join_borders else None
    if same is not None:
        surface, warnings = _cleaned(vertices, triangles, same, join_borders, kept_from)
        number = counted(int(np.count_nonzero(same != as_given)), "vertex", "vertices")
        warnings.append(
            f"Edges without a length: {number} taken together with others in the same place for "
            "the analysis. Merge by Distance does so in the mesh."
        )
    _warn_about_geometry(surface, warnings)
    return surface, warnings


def _cleaned(
    vertices: np.ndarray,
    triangles: np.ndarray,
    same: np.ndarray,
    join_borders: bool,
    kept_from: float,
) -> tuple[Surface, list[str]]:
    """As `clean`, with vertices taken for the others that `same` (n,) names."""
    warnings: list[str] = []
    rows = _usable(vertices, triangles, warnings)
    corners = triangles[rows] if len(rows) < len(triangles) else triangles
    copies = np.flatnonzero(same != np.arange(len(same)))
    joined = np.stack([copies, same[copies]], axis=1)
    as_given = not len(copies)
    if len(copies):
        corners = same[corners].astype(np.int32)
        sound = proper(corners)
        corners, rows = corners[sound], rows[sound]
    links = link(corners, len(vertices))
    if join_borders and (links is None or (links.twin < 0).any()):
        mended = mend_borders(vertices, corners, rows, links, warnings)
        if mended is not None:
            corners, rows, again = mended
            joined[:, 1] = joined_with(joined[:, 1], again)
            joined = np.concatenate([joined, again])
            as_given = False
            links = link(corners, len(vertices))
    manifold = links is not None
    together = corners
    kept, corners, source, links = _apart(corners, len(vertices), links, warnings)
    rows, together = rows[kept], together[kept]
    component = _components(links)
    specks = _specks(component)
    if specks.any() and np.isfinite(kept_from):
        piece = component[corners[:, 0]]
        area, _ = relative_areas(vertices, triangles[rows])
        large = np.bincount(piece, area) >= kept_from * area.sum()
        specks &= ~(large & _by_themselves(together, piece, len(vertices)))
    if specks.any():
        warnings.append(
            f"{counted(int(specks.sum()), 'piece')} of fewer than {FEWEST_SAMPLES} vertices left "
            "out: no curvature can be fitted to so few. Analyse them by themselves, or delete "
            "them."
        )
        large = ~specks[component[corners[:, 0]]]
        rows, together = rows[large], together[large]
        # What only they have taken apart comes together again; all else was said.
        links = link(together, len(vertices))
        kept, corners, source, links = _apart(together, len(vertices), links, [])
        rows = rows[kept]
        component = _components(links)
    if not manifold:
        corners, source, links = without_slits(corners, vertices, source, links)
        component = _components(links)
    recut = (np.zeros(0, np.int64), np.zeros((0, 3, 3)))
    if not (as_given and manifold):
        recut = corners_in_input(vertices, triangles, source[corners], rows, joined)
    surface = _assemble(vertices, corners, rows, source, links, component, joined, recut)
    return surface, warnings


def _apart(
    corners: np.ndarray, count: int, links: HalfEdges | None, warnings: list[str]
) -> tuple[np.ndarray | slice, np.ndarray, np.ndarray, HalfEdges]:
    """Triangles on `count` vertices as a manifold: the rows that are kept, their corners among its
    vertices, the old vertex of each of these, and its half-edges."""
    kept: np.ndarray | slice = slice(None)
    source = np.arange(count)
    if links is None:
        kept, corners, source = separate(corners, count, warnings)
        links = linked(corners, len(source))
    return kept, *split_fans(corners, source, links, warnings)


def _checked(vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    vertices = numbers(vertices, "The vertices must be numbers, three to a vertex.")
    triangles = whole_numbers(
        triangles, "The triangles must be whole numbers: rows of the vertices."
    )
    if vertices.ndim != 2 or vertices.shape[1] != 3:
        raise InvalidMeshError(f"The vertices must have shape (n, 3), not {vertices.shape}.")
    if triangles.size == 0:
        raise InvalidMeshError("The mesh has no faces: umbilics need a surface.")
    if triangles.ndim != 2 or triangles.shape[1] != 3:
        raise InvalidMeshError(f"The triangles must have shape (m, 3), not {triangles.shape}.")
    in_range(triangles, len(vertices), "triangles")
    if 3 * len(triangles) >= np.iinfo(np.int32).max:
        raise InvalidMeshError("The mesh has more than 700 million triangles: split it.")
    return vertices, triangles.astype(np.int32, copy=False)


def _usable(vertices: np.ndarray, triangles: np.ndarray, warnings: list[str]) -> np.ndarray:
    """Rows of the triangles with three different, finite corners."""
    good = proper(triangles)
    if not good.all():
        warnings.append(
            f"{counted(int(np.count_nonzero(~good)), 'triangle')} with repeated corners left out."
        )
    if not np.isfinite(vertices).all():
        finite = np.isfinite(vertices).all(axis=1)[triangles].all(axis=1)
        broken = int(np.count_nonzero(good & ~finite))
        if broken:
            warnings.append(
                f"{counted(broken, 'triangle')} left out: their corners are not finite numbers. "
                "Delete or repair those vertices."
            )
        good &= finite
    if not good.any():
        raise InvalidMeshError("No face of the mesh has three different, finite corners.")
    return np.flatnonzero(good)


def _specks(component: np.ndarray) -> np.ndarray:
    """(components,) bool, those with fewer vertices than a fit takes, if there are larger ones."""
    small = np.bincount(component) < FEWEST_SAMPLES
    return small & ~small.all()


def _by_themselves(corners: np.ndarray, piece: np.ndarray, count: int) -> np.ndarray:
    """(components,) bool, the pieces whose triangles (m, 3) share none of `count` vertices with
    another; (m,) the piece of each."""
    tail, head = corners[:, :2].ravel(), corners[:, 1:].ravel()
    joined = sparse.coo_array((np.ones(len(tail), np.int8), (tail, head)), shape=(count, count))
    body = csgraph.connected_components(joined, directed=False)[1][corners[:, 0]]
    # Each piece once, with the body that it is of.
    first = np.unique(piece, return_index=True)[1]
    return np.asarray(np.bincount(body[first])[body[first]] == 1)


def _assemble(
    vertices: np.ndarray,
    corners: np.ndarray,
    rows: np.ndarray,
    source: np.ndarray,
    links: HalfEdges,
    component: np.ndarray,
    joined: np.ndarray,
    recut: tuple[np.ndarray, np.ndarray],
) -> Surface:
    points = vertices.take(source, axis=0, mode="clip")
    # By columns: several times faster than along the first axis of (n, 3).
    low = np.array([column.min() for column in points.T])
    high = np.array([column.max() for column in points.T])
    # Halves first: the sum of two huge coordinates would overflow.
    origin = 0.5 * low + 0.5 * high
    unit = float((0.5 * high - 0.5 * low).max())
    if unit == 0.0:
        raise InvalidMeshError("All faces of the mesh lie in one point: there is no surface.")
    if unit < SMALLEST:
        raise InvalidMeshError(
            f"The mesh is {unit:g} in size: curvatures of so small a surface are too large to be "
            "numbers. Scale it up."
        )
    points -= origin
    points /= unit
    border = np.zeros(len(source), bool)
    for end in ends_of(corners, np.flatnonzero(links.twin < 0)):
        border[end] = True
    return Surface(
        vertices=points,
        triangles=corners,
        source_vertex=source,
        source_triangle=rows,
        twin=links.twin,
        neighbour_start=links.neighbour_start,
        neighbours=links.neighbours,
        border=border,
        component=component,
        origin=origin,
        unit=unit,
        joined=joined,
        recut=recut[0],
        recut_corners=recut[1],
    )


def _components(links: HalfEdges) -> np.ndarray:
    """(n,) int32 connected component of each vertex."""
    count = len(links.neighbour_start) - 1
    graph = adjacency(links)
    reached = csgraph.breadth_first_order(graph, 0, return_predecessors=False)
    if len(reached) == count:  # most meshes are one piece, which this tells four times faster
        return np.zeros(count, np.int32)
    return csgraph.connected_components(graph, directed=False)[1]


def _warn_about_geometry(surface: Surface, warnings: list[str]) -> None:
    _, areas = surface.face_normal_area
    flat = int(np.count_nonzero(areas <= NO_AREA))
    if flat:
        warnings.append(
            f"{counted(flat, 'triangle')} without area: their neighbourhood is less certain."
        )
    inward = int(np.count_nonzero(surface.closed & (surface.volume < 0) & ~cavities(surface)))
    if inward:
        warnings.append(
            f"The normals of {counted(inward, 'closed piece')} point inwards, so curvatures have "
            "the opposite sign there. Recalculate Outside mends this in the mesh."
        )
