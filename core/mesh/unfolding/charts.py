"""Charts: the pieces of a surface between seams or UV borders, and their unfolding."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ...base.arguments import numbers
from ...base.errors import ChartError, InvalidMeshError
from ...base.plane import doubled_areas
from ...base.progress import Progress
from ...base.words import counted
from ..half_edges import edge_keys, ends_of, following
from ..input_map import kept_vertices
from ..surface import Surface
from .lscm import conformal_map

# Charts are unfolded together until they hold this many triangles.
_BATCH = 200_000


@dataclass(frozen=True)
class Charts:
    """A surface of m triangles cut into charts with c vertices of their own.

    Attributes
    ----------
    corners:
        (m, 3) int64 chart vertices of each triangle.
    vertex:
        (c,) int64 vertex of the surface that each chart vertex is a copy of.
    chart:
        (m,) int64 chart of each triangle.
    border:
        (3m,) bool half-edges (3 * triangle + position) at the charts' borders.
    """

    corners: np.ndarray
    vertex: np.ndarray
    chart: np.ndarray
    border: np.ndarray

    @property
    def count(self) -> int:
        """How many charts there are."""
        return int(self.chart.max()) + 1

    @cached_property
    def of_vertex(self) -> np.ndarray:
        """(c,) int64 chart of each chart vertex."""
        chart = np.empty(len(self.vertex), dtype=np.int64)
        chart[self.corners] = self.chart[:, None]
        return chart

    @property
    def loops(self) -> np.ndarray:
        """(c,) int number of the border loop that each chart vertex is on; the others have one of
        their own."""
        graph_of = ends_of(self.corners, np.flatnonzero(self.border))
        size = len(self.vertex)
        graph = sparse.coo_array((np.ones(len(graph_of[0])), graph_of), shape=(size, size))
        return csgraph.connected_components(graph, directed=False)[1]


def charts_from_seams(surface: Surface, seams: np.ndarray) -> Charts:
    """Cut along edges given as (s, 2) pairs of input vertices; other pairs are ignored."""
    seams = kept_vertices(surface, np.asarray(seams, dtype=np.int64).reshape(-1, 2))
    start, end = (surface.source_vertex[vertex] for vertex in ends_of(surface.triangles))
    count = max(int(surface.source_vertex.max()), int(seams.max(initial=0))) + 1
    edges = edge_keys(start, end, count)
    return cut_along(surface, np.isin(edges, edge_keys(seams[:, 0], seams[:, 1], count)))


def corner_uv(surface: Surface, input_triangles: np.ndarray, uv: np.ndarray) -> np.ndarray:
    """(m, 3) complex UV of the surface's corners from those of the input's (t, 3, 2).

    Cleaning may have dropped, turned or split triangles.
    Raises `InvalidMeshError` on a UV map of another shape or with coordinates not finite.
    """
    uv = numbers(uv, "The UV map must hold numbers.")
    if uv.shape != (len(input_triangles), 3, 2):
        raise InvalidMeshError(
            f"The UV map must have shape ({len(input_triangles)}, 3, 2), not {uv.shape}."
        )
    chosen = uv[surface.source_triangle]
    chosen[surface.recut] = surface.recut_corners @ chosen[surface.recut]
    if not np.isfinite(chosen).all():
        raise InvalidMeshError("The UV map has coordinates that are not numbers: unwrap it anew.")
    return chosen[..., 0] + 1j * chosen[..., 1]


def charts_from_uv(surface: Surface, uv: np.ndarray) -> Charts:
    """The islands of a UV map (m, 3) complex: edges whose two sides lie apart are cut."""
    start, end = ends_of(uv)
    twin = surface.twin
    # Blender stores UVs in single precision.
    close = 1e-6 * np.abs(uv).max(initial=0.0)
    apart = (np.abs(start - end[twin]) > close) | (np.abs(end - start[twin]) > close)
    return cut_along(surface, apart)


def cut_along(surface: Surface, seam: np.ndarray) -> Charts:
    """Charts between the half-edges (3m,) marked as seam, and the open borders."""
    m, twin = len(surface.triangles), surface.twin
    border = seam | (twin < 0)
    inner = np.flatnonzero(~border)
    other = twin[inner]

    def components(size: int, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        graph = sparse.coo_array((np.ones(len(a), dtype=np.int8), (a, b)), shape=(size, size))
        return csgraph.connected_components(graph, directed=False)[1].astype(np.int64)

    chart = components(m, inner // 3, other // 3)
    # Corners are one chart vertex when an uncut edge joins them: its tail here is its head there.
    corners = components(3 * m, inner, following(other))
    vertex = np.empty(int(corners.max()) + 1, dtype=np.int64)
    vertex[corners] = surface.triangles.ravel()
    return Charts(corners.reshape(m, 3), vertex, chart, border)


def require_disks(charts: Charts) -> None:
    """Raise `ChartError`, naming the remedy, unless every chart is a disk."""
    count = charts.count
    vertices = np.bincount(charts.of_vertex, minlength=count)
    faces = np.bincount(charts.chart, minlength=count)
    on_border = np.bincount(charts.chart, charts.border.reshape(-1, 3).sum(1), minlength=count)
    edges = (3 * faces + on_border) / 2
    euler = np.rint(vertices - edges + faces).astype(np.int64)
    wrong = np.flatnonzero(euler != 1)
    if not len(wrong):
        return
    loops = _border_loops(charts)
    worst = wrong[faces[wrong].argmax()]
    handles = (2 - euler[worst] - loops[worst]) // 2
    what = "it is closed" if on_border[worst] == 0 else "its border is one loop"
    if loops[worst] > 1:
        what = f"it has {loops[worst]} border loops"
    if handles > 0:
        what += f" with {counted(int(handles), 'handle')}"
    which = (
        "The mesh"
        if count == 1
        else f"A chart of {faces[worst]} triangles (1 of {len(wrong)} unfit among {count})"
    )
    raise ChartError(
        f"{which} cannot be laid into the plane: {what}, and method C needs disks. Mark seams "
        "(Edge > Mark Seam) that cut it open into pieces with a single border, or use method S, "
        "which needs none."
    )


def _border_loops(charts: Charts) -> np.ndarray:
    """(charts,) how many loops the border of each chart has."""
    start = charts.corners.ravel()[charts.border]
    first = np.unique(charts.loops[start], return_index=True)[1]
    return np.bincount(charts.of_vertex[start[first]], minlength=charts.count)


def unfold(surface: Surface, charts: Charts, progress: Progress | None = None) -> np.ndarray:
    """(c,) complex places of the chart vertices by least squares conformal maps.

    Two border vertices of each chart that lie far apart are pinned, and each chart is scaled
    to the area that it has on the surface. Raises `ChartError` where a chart is no disk.
    """
    require_disks(charts)
    progress = progress or Progress()
    place = np.zeros(len(charts.vertex), dtype=complex)
    points = surface.vertices[charts.vertex]
    pins = border_pins(charts, points)
    distance = np.linalg.norm(points[pins[:, 1]] - points[pins[:, 0]], axis=1)
    size = np.bincount(charts.chart)
    batch = np.cumsum(size) // _BATCH
    # A batch of its own number for each run of charts; a large chart is alone in its own.
    batch = np.unique(batch, return_inverse=True)[1]
    batch_of_triangle = batch[charts.chart]
    order = np.argsort(batch_of_triangle, kind="stable")
    ends = np.cumsum(np.bincount(batch_of_triangle))
    for number, rows in enumerate(np.split(order, ends[:-1])):
        progress.step(number / len(ends))
        used, corners = np.unique(charts.corners[rows], return_inverse=True)
        own = np.flatnonzero(batch == number)
        held = np.searchsorted(used, pins[own])
        pinned = np.stack([np.zeros(len(own)), distance[own]], axis=1)
        place[used] = conformal_map(
            points[used], corners.reshape(-1, 3), held.ravel(), pinned.ravel()
        )
    return scaled_to_area(surface, charts, place)


def scaled_to_area(surface: Surface, charts: Charts, place: np.ndarray) -> np.ndarray:
    """The places (c,) with each chart turned the right side up and given its own area."""
    signed = np.bincount(charts.chart, 0.5 * doubled_areas(place[charts.corners]))
    true = np.bincount(charts.chart, surface.face_normal_area[1])
    scale = np.sqrt(true / np.where(signed == 0, 1.0, np.abs(signed)))
    mirrored = (signed < 0)[charts.of_vertex]
    return np.where(mirrored, np.conj(place), place) * scale[charts.of_vertex]


def border_pins(charts: Charts, points: np.ndarray) -> np.ndarray:
    """(charts, 2) border vertices far apart: the farthest from the middle of the border, and
    the one farthest from that."""
    half_edges = np.flatnonzero(charts.border)
    vertex = charts.corners.ravel()[half_edges]
    chart = charts.chart[half_edges // 3]
    order = np.lexsort((vertex, chart))
    vertex, chart = vertex[order], chart[order]
    number = np.bincount(chart, minlength=charts.count)
    middle = np.stack(
        [np.bincount(chart, points[vertex, k], minlength=charts.count) / number for k in range(3)],
        axis=1,
    )
    last = np.cumsum(number) - 1

    def farthest(centre: np.ndarray) -> np.ndarray:
        distance = np.linalg.norm(points[vertex] - centre[chart], axis=1)
        return vertex[np.lexsort((distance, chart))[last]]

    first = farthest(middle)
    second = farthest(points[first])
    # All border vertices in one place: any two different ones.
    same = first == second
    second[same] = np.where(vertex[last][same] != first[same], vertex[last][same],
                            vertex[last - number + 1][same])  # fmt: skip
    return np.stack([first, second], axis=1)
