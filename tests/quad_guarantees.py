"""What every quad mesh must hold, whatever it was made from."""

from __future__ import annotations

import numpy as np

import core
from core.mesh.mending.repair import clean
from core.retopology.quads.conformity import Conformity, conformity, scaled_jacobian
from core.retopology.quads.finishing.faults.crossings import crossings
from core.retopology.quads.finishing.projection import ClosestPoints
from core.retopology.quads.preparation import scrap

# Vertices lie on the surface within this part of its size.
ON_SURFACE = 1e-6
# The number of quads is this near to the request where there are so many for each pole.
COUNT, PER_POLE = 0.03, 20


def broken_guarantees(
    vertices: np.ndarray, triangles: np.ndarray, made: core.QuadMesh, quads: int | None = None
) -> list[str]:
    """Sentences on every guarantee that quads made from a triangle mesh do not hold.

    `quads` is how many were asked for, None where that does not matter.
    """
    settings = core.RemeshSettings(quads=quads or len(made.quads))
    surface, _ = clean(vertices, triangles, kept_from=scrap(vertices, triangles, settings))
    topology = conformity(made.quads, len(made.vertices))
    broken = []

    def expect(holds: object, sentence: str) -> None:
        if not holds:
            broken.append(sentence)

    euler = int(surface.euler_characteristic.sum())
    expect(topology.manifold, "not manifold")
    expect(
        topology.characteristic == euler,
        f"Euler characteristic {topology.characteristic}, not {euler}",
    )
    expect(
        surface.closed.all() == (not topology.border.any()),
        "open where the input is closed, or not",
    )
    inner = ~topology.border
    lack = (4 - topology.valence)[inner].sum() + (3 - topology.valence)[topology.border].sum()
    expect(lack == 4 * euler, f"valences lack {lack}, not {4 * euler}")
    irregular = np.flatnonzero(inner & (topology.valence != 4))
    expect(np.array_equal(np.flatnonzero(made.pole >= 0), irregular), "poles are not told")
    if not broken:
        told = made.pole_valence[made.pole[irregular]]
        expect(np.array_equal(told, topology.valence[irregular]), "wrong valences of poles")
    expect(np.array_equal(made.border, topology.border), "borders are not told")

    place = (made.vertices - surface.origin) / surface.unit
    off = np.zeros(len(place))
    against = 0
    for quads_, triangles_ in _pieces(made, surface):
        closest = ClosestPoints(surface.vertices, triangles_, np.full(triangles_.size, -1))
        used = np.unique(quads_)
        off[used] = np.abs(place[used] - closest(place[used])[1]).max(axis=1)
        against += _against(place, quads_, closest, surface.vertices[triangles_])
    worst_off = float(off.max())
    expect(worst_off < ON_SURFACE, f"{worst_off:.1e} off the surface")
    if surface.border.any() and topology.border.any():
        off = _off_edges(place[topology.border], surface, np.flatnonzero(surface.twin < 0))
        expect(off < ON_SURFACE, f"border {off:.1e} off the border")

    worst = float(scaled_jacobian(made.vertices, made.quads).min())
    expect(worst > 0.0, f"scaled Jacobian {worst:.2f}")
    expect(not against, f"{against} quads against the surface")
    pairs = crossings(place, made.quads)
    if len(pairs) and not len(crossings(surface.vertices, surface.triangles)):
        broken.append(f"{len(pairs)} pairs of quads cross")
    if quads is not None and quads >= PER_POLE * len(made.pole_valence):
        ratio = len(made.quads) / quads
        expect(abs(ratio - 1.0) <= COUNT, f"{len(made.quads)} quads, {quads} asked for")
    return broken


def _pieces(made: core.QuadMesh, surface) -> list[tuple[np.ndarray, np.ndarray]]:
    """The quads (r, 4) and the triangles (t, 3) of each connected piece of the surface: what lies
    within another one, such as an eye, faces away from that where it is right."""
    rows = {int(source): row for row, source in enumerate(surface.source_triangle)}
    at = np.array([rows[int(source)] for source in made.source_triangle[made.quads[:, 0]]])
    of_quad = surface.component[surface.triangles[at, 0]]
    of_triangle = surface.component[surface.triangles[:, 0]]
    return [
        (made.quads[of_quad == number], surface.triangles[of_triangle == number])
        for number in np.unique(of_quad)
    ]


def _against(
    place: np.ndarray, quads: np.ndarray, closest: ClosestPoints, corner: np.ndarray
) -> int:
    """How many quads face against the surface: away from the closest triangle, and from the quads
    beside them as a mean or from every triangle within half a side. At sharp edges and on thin
    sheets the closest alone says little."""
    at = place[quads]
    normal, middle = np.cross(at[:, 2] - at[:, 0], at[:, 3] - at[:, 1]), at.mean(axis=1)
    reach = 0.5 * np.linalg.norm(np.roll(at, -1, axis=1) - at, axis=2).max(axis=1)
    row, _ = closest(middle)
    away = np.flatnonzero(np.einsum("qc,qc->q", closest.normal[row], normal) <= 0.0)
    against = 0
    for quad in away.tolist():
        beside = normal[np.isin(quads, quads[quad]).sum(axis=1) == 2]
        beside = beside / np.maximum(np.linalg.norm(beside, axis=1), 1e-300)[:, None]
        distance = np.linalg.norm(closest_in(corner, middle[quad]) - middle[quad], axis=1)
        facing = closest.normal[distance <= reach[quad]] @ normal[quad] > 0.0
        against += bool(beside.sum(axis=0) @ normal[quad] < 0.0 or not facing.any())
    return against


def _off_edges(points: np.ndarray, surface, edges: np.ndarray) -> float:
    """How far the farthest of points (p, 3) is from the half-edges of a surface."""
    corners = surface.triangles.ravel()
    start = surface.vertices[corners[edges]]
    end = surface.vertices[surface.triangles[:, [1, 2, 0]].ravel()[edges]]
    along = end - start
    square = (along**2).sum(axis=1)
    worst = 0.0
    for block in np.array_split(points, len(points) * len(edges) // 10**6 + 1):
        share = np.clip(((block[:, None] - start) * along).sum(axis=2) / square, 0.0, 1.0)
        gap = block[:, None] - start - share[:, :, None] * along
        worst = max(worst, float(np.sqrt((gap**2).sum(axis=2).min(axis=1)).max(initial=0.0)))
    return worst


def holds(
    vertices: np.ndarray, triangles: np.ndarray, made: core.QuadMesh, quads: int | None = None
) -> Conformity:
    """Every guarantee of a quad mesh; the topology of it."""
    assert broken_guarantees(vertices, triangles, made, quads) == []
    return conformity(made.quads, len(made.vertices))


def closest_in(corner: np.ndarray, point: np.ndarray) -> np.ndarray:
    """(t, 3) the point of each triangle (t, 3, 3) that is closest to one point (3,): below it, or
    on the nearest of the three sides."""
    a, b = corner, np.roll(corner, -1, axis=1)
    along = b - a
    length = np.maximum((along**2).sum(axis=2), np.finfo(float).tiny)
    share = np.clip(((point - a) * along).sum(axis=2) / length, 0.0, 1.0)
    on_side = a + share[..., None] * along
    nearest = ((on_side - point) ** 2).sum(axis=2).argmin(axis=1)
    result = on_side[np.arange(len(corner)), nearest]
    normal = np.cross(along[:, 0], along[:, 1])
    square = np.maximum((normal**2).sum(axis=1, keepdims=True), np.finfo(float).tiny)
    foot = point - ((point - a[:, 0]) * normal).sum(axis=1, keepdims=True) / square * normal
    side = np.cross(along, foot[:, None] - a) * normal[:, None]
    inside = (side.sum(axis=2) > 0.0).all(axis=1)
    result[inside] = foot[inside]
    return result
