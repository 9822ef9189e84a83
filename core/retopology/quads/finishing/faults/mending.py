"""Opening folded, flat and skewed quads: their vertices and those around move together until every
corner is well open.

The neighbourhoods of bad quads are opened in the tangent planes of their vertices, those on
features along them.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from .....base.progress import Progress
from .....base.subsets import places_in
from .....base.unit import unit
from .....mesh.rings import with_rings
from ...conformity import scaled_jacobian, side_ends, signed
from ..guides import Guides, beside, filled_corner, moved_along, surface_axes, vertex_normals
from ..opening import Opening
from ..projection import ClosestPoints

# Below the scaled Jacobian in front quads are bad, and their corners are opened up to the sine
# behind it: first all that are worse than a pole of valence 3 needs them (0.87), which makes the
# mean better, then the worst alone. A round that wins no more than the part behind of what is
# missing is the last, or the last of few rings. Chosen on wave 1 of the benchmark, the face, the
# skull and Suzanne; confirmed on the hand, the bunny, the fandisk, the wing nut, the beetle and
# wave 3.
STAGES = ((0.75, 1.0, 0.05), (0.6, 0.7, 0.0))
# How much a move by the mean side costs beside a corner that misses all.
STAY = 0.02
# Rounds, and rings around bad quads that move in the first and the most.
ROUNDS, FIRST_RINGS, MOST_RINGS = 10, 2, 5
# Where a round's move makes things worse it is halved, so often.
HALVINGS = 6


def mend(
    position: np.ndarray,
    quads: np.ndarray,
    guides: Guides,
    progress: Progress,
    stages: tuple[tuple[float, float, float], ...] = STAGES,
) -> None:
    """Move the vertices around bad quads, in place, while that makes them better."""
    for sound, wanted, little in stages:
        _opened(position, quads, guides, sound, wanted, little, progress)


def _opened(
    position: np.ndarray,
    quads: np.ndarray,
    guides: Guides,
    sound: float,
    wanted: float,
    little: float,
    progress: Progress,
) -> None:
    """One of the `STAGES`, in place."""
    movable = ~guides.fixed & ((guides.curve < 0) | (guides.beside >= 0).all(axis=1))
    rings = FIRST_RINGS
    for _ in range(ROUNDS):
        progress.step(1.0)
        bad = oriented_quality(position, quads, guides) < sound
        if not bad.any():
            return
        near = np.zeros(len(position), bool)
        near[quads[bad]] = True
        near = with_rings(quads, near, rings)
        rows = np.flatnonzero(near & movable)
        mine = np.flatnonzero(near[quads].any(axis=1))
        if not len(rows):
            return
        some = quads[mine]
        up = surface_axes(position[some], vertex_normals(position, quads)[some], guides)
        local = places_in(rows, len(position))[some]
        axes = move_axes(position, quads, guides, rows)
        step = Opening(position[some], up, local, axes, STAY, wanted).step()
        if _won(position, some, guides, rows, step, wanted) <= little:
            if rings == MOST_RINGS:
                return
            rings = MOST_RINGS


def oriented_quality(position: np.ndarray, quads: np.ndarray, guides: Guides) -> np.ndarray:
    """(q,) scaled Jacobians, negative where a quad faces against the surface: as `against` has it
    and, but where this may be thin, against the closest triangle that faces the quads around."""
    away, turned = _seen(position, quads, guides.surface)
    against_ = turned if guides.thin else turned | away
    quality = scaled_jacobian(position, quads)
    return signed(quality, against_)


def quality_to_mend(position: np.ndarray, quads: np.ndarray, guides: Guides) -> np.ndarray:
    """(q,) as `oriented_quality`, 1 for quads that are not folded and fill a held corner of
    features: no vertex moves that could open them."""
    quality = oriented_quality(position, quads, guides)
    rows = np.flatnonzero((quality > 0.0) & (quality < 1.0) & guides.fixed[quads].any(axis=1))
    corner = filled_corner(position, quads[rows], guides.beside)
    quality[rows[(corner >= 0) & guides.fixed[corner]]] = 1.0
    return quality


def against(position: np.ndarray, quads: np.ndarray, surface: ClosestPoints) -> np.ndarray:
    """(q,) bool quads that face against the surface: away from the closest triangle, and from the
    quads across their sides as a mean or from every triangle within half a side. At sharp edges
    and on thin sheets the closest alone says little."""
    return _seen(position, quads, surface)[1]


def _seen(
    position: np.ndarray, quads: np.ndarray, surface: ClosestPoints
) -> tuple[np.ndarray, np.ndarray]:
    """(q,) bool quads that face away from the closest triangle of those that face the quads
    around, and those `against` the surface."""
    at = position[quads]
    normal, middle = np.cross(at[:, 2] - at[:, 0], at[:, 3] - at[:, 1]), at.mean(axis=1)
    reach = 0.5 * np.linalg.norm(np.roll(at, -1, axis=1) - at, axis=2).max(axis=1)
    around = vertex_normals(position, quads)[quads].sum(axis=1)
    triangle, place = surface(middle, around)
    side = np.einsum("qc,qc->q", surface.normal[triangle], normal)
    turned = np.einsum("qc,qc->q", beside(position, quads), normal) < 0.0
    found = turned | (side <= 0.0) | (np.linalg.norm(place - middle, axis=1) > reach)
    rows = np.flatnonzero(found)
    if len(rows):
        triangle, _ = surface(middle[rows])
        found[rows] = np.einsum("qc,qc->q", surface.normal[triangle], normal[rows]) <= 0.0
        rows = np.flatnonzero(found & ~turned)
        found[rows] = ~surface.faced(middle[rows], normal[rows], reach[rows])
    return side < 0.0, found


def _won(
    position: np.ndarray,
    quads: np.ndarray,
    guides: Guides,
    rows: np.ndarray,
    step: np.ndarray,
    wanted: float,
) -> float:
    """Move the vertices by the step, by a part of it where it makes quads worse, in place, in each
    place where all is better then: the part of what is missing that this wins.

    Places are sets of moving vertices that quads connect: what cannot be mended in one of them
    does not hold up the others.
    """
    before = position[rows]
    missing = _missing(position, quads, guides, wanted)
    of_row, of_quad = _places(quads, rows, len(position))
    count = int(of_row.max()) + 1
    mine = of_quad >= 0
    had = np.bincount(of_quad[mine], missing[mine], count)
    done = np.zeros(count, bool)
    part = np.ones(len(rows))
    for _ in range(HALVINGS):
        going = ~done[of_row]
        by = (step * part[:, None])[going]
        start, some = before[going], rows[going]
        position[some] = moved_along(start, by, some, position, quads, guides)
        now = _missing(position, quads, guides, wanted)
        better = np.bincount(of_quad[mine], now[mine], count) < had
        position[some] = np.where(better[of_row[going], None], position[some], start)
        done |= better
        if done.all():
            break
        worse = np.zeros(len(position), bool)
        worse[quads[now > missing]] = True
        part = np.where(worse[rows], 0.5 * part, part)
    if not done.any():
        return 0.0
    return float(1.0 - _missing(position, quads, guides, wanted).sum() / missing.sum())


def _places(quads: np.ndarray, rows: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The connected set of moving vertices that each of the rows (r,) and quads (q,) is in, -1 for
    quads in none."""
    local = places_in(rows, count)[quads]
    one, other = side_ends(local)
    far, across = local[:, :2].ravel(), local[:, 2:].ravel()
    one, other = np.concatenate([one, far]), np.concatenate([other, across])
    both = (one >= 0) & (other >= 0)
    n = len(rows)
    graph = sparse.coo_array((np.ones(both.sum()), (one[both], other[both])), shape=(n, n))
    _, label = csgraph.connected_components(graph, directed=False)
    chosen = local.max(axis=1)
    return label, np.where(chosen >= 0, label[np.maximum(chosen, 0)], -1)


def _missing(position: np.ndarray, quads: np.ndarray, guides: Guides, wanted: float) -> np.ndarray:
    """(q,) squares of what quads lack."""
    return np.maximum(wanted - oriented_quality(position, quads, guides), 0.0) ** 2


def move_axes(
    position: np.ndarray, quads: np.ndarray, guides: Guides, rows: np.ndarray
) -> np.ndarray:
    """(r, 2, 3) directions in which vertices may move, the second 0 on features."""
    normal = unit(vertex_normals(position, quads)[rows])
    least = np.eye(3)[np.abs(normal).argmin(axis=1)]
    x = unit(np.cross(normal, least))
    y = np.cross(normal, x)
    held = np.flatnonzero(guides.curve[rows] >= 0)
    ends = position[guides.beside[rows[held]]]
    x[held] = unit(ends[:, 1] - ends[:, 0])
    y[held] = 0.0
    return np.stack([x, y], axis=1)
