"""The last check of all quads, held against the input: what faces against it is unfolded.

Pieces are finished by themselves, on a surface that may be coarser than the input, and parted after
that. What is folded or faces against the input then is opened in its place: with creases held and,
where that finds nothing, without. Nothing leaves the surface for it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from .....base.progress import Progress
from .....base.subsets import places_in
from .....mesh.rings import with_rings
from .....mesh.surface import Surface
from ...conformity import side_ends
from ...result import QuadMesh
from ..finished import OFF
from ..guides import Guides, vertex_normals
from ..parting import made_crossings
from ..projection import ClosestPoints
from .crossings import OwnCrossings
from .mending import against, mend
from .unfolding import locally_unfolded, own_quality

# Rings around wrong quads within which vertices may move, and beyond these for what tells whether
# quads at the rim are folded.
RINGS, RIM = 4, 2


def checked(
    made: QuadMesh, whole: Surface, progress: Progress, own: OwnCrossings | None = None
) -> tuple[QuadMesh, int]:
    """With fewer quads that are folded or face against the surface, as far as that was found and no
    more quads cross by it.

    Parameters
    ----------
    whole:
        The input.
    own:
        What is known of its crossings so far.

    Returns
    -------
    made, wrong:
        The quads, and how many are still wrong.
    """
    position, source, wrong = made.vertices, made.source_triangle, 0
    own = OwnCrossings(whole) if own is None else own
    count = int(max(whole.source_triangle.max(), made.source_triangle.max())) + 1
    near = places_in(whole.source_triangle, count)[made.source_triangle[made.quads[:, 0]]]
    for rows, triangles in _pieces(near, whole):
        quads, closest = made.quads[rows], _closest(whole, triangles)
        found, left = _piece_checked(position, made, quads, closest, own, progress)
        wrong += left
        moved = np.flatnonzero((found != position).any(axis=1))
        position = found
        if len(moved):
            place = (position - whole.origin) / whole.unit
            on, _ = closest(place[moved], vertex_normals(place, quads)[moved])
            source = source.copy()
            source[moved] = whole.source_triangle[triangles[on]]
    return replace(made, vertices=position, source_triangle=source), wrong


def wrong_quads(
    place: np.ndarray, quads: np.ndarray, near: np.ndarray, whole: Surface
) -> np.ndarray:
    """(q,) bool quads of any mesh that are folded or face against the surface, by what `checked`
    goes by; where most of a piece does, the piece is wound the other way.

    Parameters
    ----------
    place:
        (n, 3) in the coordinates of the surface.
    near:
        (q,) triangles of the surface at the quads.
    """
    found = np.zeros(len(quads), bool)
    for rows, triangles in _pieces(near, whole):
        mine, closest = quads[rows], _closest(whole, triangles)
        at = place[mine]
        normal = np.cross(at[:, 2] - at[:, 0], at[:, 3] - at[:, 1])
        triangle, _ = closest(at.mean(axis=1))
        if np.einsum("qc,qc->", closest.normal[triangle], normal) < 0.0:
            mine = mine[:, ::-1]
        found[rows] = _wrong(place, mine, closest) > 0
    return found


def _pieces(near: np.ndarray, whole: Surface) -> list[tuple[np.ndarray, np.ndarray]]:
    """The quads (r,) of each connected piece of the input that has any, by the triangles (q,) that
    they lie at, and its triangles (t,). What lies within another piece faces against that one where
    it is right."""
    of_quad = whole.component[whole.triangles[near, 0]]
    of_triangle = whole.component[whole.triangles[:, 0]]
    return [
        (np.flatnonzero(of_quad == number), np.flatnonzero(of_triangle == number))
        for number in np.unique(of_quad).tolist()
    ]


def _closest(whole: Surface, triangles: np.ndarray) -> ClosestPoints:
    """Closest points on the triangles (t,) of a connected piece of the input."""
    half_edges = (3 * triangles[:, None] + np.arange(3)).ravel()
    twin = whole.twin[half_edges]
    place = places_in(half_edges, 3 * len(whole.triangles))
    twin = np.where(twin >= 0, place[twin], -1)
    return ClosestPoints(whole.vertices, whole.triangles[triangles], twin)


def _piece_checked(
    position: np.ndarray,
    made: QuadMesh,
    quads: np.ndarray,
    closest: ClosestPoints,
    own: OwnCrossings,
    progress: Progress,
) -> tuple[np.ndarray, int]:
    """Positions (n, 3) in which the quads (r, 4) of one piece are held against that, and how many
    of them are still wrong."""
    whole = own.surface
    place = (position - whole.origin) / whole.unit
    wrong = _wrong(place, quads, closest)
    if not wrong.any():
        return position, 0
    crossing = len(made_crossings(position, made.quads, own))
    for held in (made.border | made.feature, made.border):
        trial = _opened(place, quads, wrong > 0, held, closest, progress)
        trial, found = _where_better(trial, place, quads, wrong, closest)
        there = np.where(trial == place, position, trial * whole.unit + whole.origin)
        if found.sum() < wrong.sum() and len(made_crossings(there, made.quads, own)) <= crossing:
            position, place, wrong = there, trial, found
        if not wrong.any() or not made.feature.any():
            break
    return position, int(np.count_nonzero(wrong))


def _wrong(place: np.ndarray, quads: np.ndarray, closest: ClosestPoints) -> np.ndarray:
    """(q,) int64 how wrong quads are: 2 where they are folded, 1 where they face against the
    surface only."""
    folded = own_quality(place, quads) <= 0.0
    return np.where(folded, 2, against(place, quads, closest).astype(np.int64))


def _opened(
    place: np.ndarray,
    quads: np.ndarray,
    wrong: np.ndarray,
    held: np.ndarray,
    closest: ClosestPoints,
    progress: Progress,
) -> np.ndarray:
    """Positions (n, 3) that may be better around the quads that are `wrong` (q,) bool."""
    moving = _around(place, quads, wrong)
    some = quads[with_rings(quads, moving, RIM)[quads].any(axis=1)]
    rows, corner = np.unique(some, return_inverse=True)
    local, none = corner.reshape(-1, 4), np.full(len(rows), -1)
    guides = Guides(
        surface=closest,
        direction=np.zeros((0, 3)),
        size=np.zeros(0),
        fixed=(held | ~moving)[rows],
        curve=none,
        beside=np.stack([none, none], axis=1),
        curves={},
    )
    beside_it = locally_unfolded(place[rows], local, guides, progress)
    on_it = beside_it.copy()
    moved = with_rings(local, (beside_it != place[rows]).any(axis=1), 1)
    mend(on_it, local, replace(guides, fixed=guides.fixed | ~moved, thin=True), progress)
    trial = place.copy()
    trial[rows] = on_it
    return trial


def _around(place: np.ndarray, quads: np.ndarray, wrong: np.ndarray) -> np.ndarray:
    """(n,) bool vertices within the rings around quads that are `wrong` (q,) bool."""
    near = np.zeros(len(place), bool)
    near[quads[wrong]] = True
    return with_rings(quads, near, RINGS)


def _where_better(
    trial: np.ndarray,
    place: np.ndarray,
    quads: np.ndarray,
    wrong: np.ndarray,
    closest: ClosestPoints,
) -> tuple[np.ndarray, np.ndarray]:
    """The trial in those places where less is wrong by it and nothing is off the surface, what was
    before in others, and how wrong (q,) quads are then."""
    found = _wrong(trial, quads, closest)
    label = _places(quads, _around(place, quads, wrong > 0))
    more = np.bincount(label + 1, found - wrong, int(label.max()) + 2)
    moved = np.flatnonzero((trial != place).any(axis=1))
    side = np.linalg.norm(place[quads] - place[np.roll(quads, -1, axis=1)], axis=2).mean()
    off = np.zeros(len(place), bool)
    off[moved] = np.linalg.norm(closest(trial[moved])[1] - trial[moved], axis=1) > OFF * side
    more[np.unique(label[off[quads].any(axis=1)]) + 1] = 0
    back = np.zeros(len(place), bool)
    back[quads[(label >= 0) & (more[label + 1] >= 0)]] = True
    if not back.any():
        return trial, found
    trial = np.where(back[:, None], place, trial)
    return trial, _wrong(trial, quads, closest)


def _places(quads: np.ndarray, near: np.ndarray) -> np.ndarray:
    """(q,) number of the connected place of vertices `near` (n,) bool that each quad has corners
    in, -1 for none."""
    one, other = side_ends(quads)
    both = near[one] & near[other]
    n = len(near)
    graph = sparse.coo_array((np.ones(both.sum()), (one[both], other[both])), shape=(n, n))
    _, label = csgraph.connected_components(graph, directed=False)
    return np.where(near[quads], label[quads], -1).max(axis=1)
