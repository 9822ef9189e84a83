"""The quads of one piece in their places: laid out in the map, evened out, on the surface."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ....base.errors import RemeshError
from ....base.progress import Progress
from ....mesh.surface import Surface
from ..conformity import conformity
from ..field.directions import direction_weights, guiding_directions
from ..layout.counting import characteristic, grids_of_about
from ..layout.effort import EVENING, Effort
from ..layout.giving_way import LAST_LOCAL, gentler, without_open_creases
from ..layout.grids import Grids
from ..layout.laying_out import LaidOut, laid_out
from ..surface.working_surface import WorkingSurface
from .faults.crossings import OwnCrossings
from .faults.mending import against, mend, oriented_quality, quality_to_mend
from .faults.unfolding import own_quality, unfolded
from .faults.worst import worst_opened
from .guides import Guides, vertex_normals
from .parting import made_crossings
from .placement import Placement, place
from .projection import ClosestPoints
from .relaxation import relaxed, squared
from .unlaid import Unlaid

# How often a piece with folded or bad quads is laid out anew, and the scaled Jacobian of these.
ATTEMPTS, BAD = 3, 0.3
# Another number of quads than was asked for, by more than this part of it, is told.
OTHER_COUNT = 0.03
# Below this scaled Jacobian quads are evened out anew, where that may help, with those that face
# away from the nearest surface taken for folded even where another is as near.
POOR = 0.5
# With more than this share of its quads folded a piece has no room for them: others would be too.
HOPELESS = 0.05
# Vertices count as off the surface beyond the first part of a side; beyond the second, where they
# are as far from it as from each other, the shape is lost, and quads that follow nothing but the
# surface are better.
OFF, LOST = 1e-6, 1.0


@dataclass(frozen=True)
class Finished:
    """The quads of a piece in their places on the mapped surface, how many of them are folded and
    bad, the least scaled Jacobian, how many of the vertices are off the surface so that none is
    folded, and how far at most."""

    laid: LaidOut
    grid: Grids
    placed: Placement
    position: np.ndarray
    triangle: np.ndarray
    surface: ClosestPoints
    folded: int
    bad: int
    least: float
    left: int = 0
    farthest: float = 0.0


def filled(
    parts: list[LaidOut],
    grids: list[Grids],
    steps: int,
    effort: Effort,
    own: OwnCrossings,
    asked: int,
    progress: Progress,
) -> tuple[list[Finished], list[Unlaid]]:
    """All pieces, evened out in so many steps, and those whose quads do not join up; `own` are the
    crossings of the input, and `asked` quads are wanted of all pieces together."""
    done, unlaid = [], []
    total = sum(len(grid.quads) for grid in grids)
    for number, (laid, grid) in enumerate(zip(parts, grids, strict=True)):
        share = number / len(parts), (number + 1) / len(parts)
        part = progress.part("Evening out", *share)
        fewest, most = (round((1.0 + off) * asked) for off in (-OTHER_COUNT, OTHER_COUNT))
        others = total - len(grid.quads)
        room = fewest - others, most - others
        found = finished(laid, grid, steps, effort, own, room, part)
        if found is None:
            unlaid.append(Unlaid(laid.working, laid.wishes))
        else:
            done.append(found)
    return done, unlaid


def finished(
    laid: LaidOut,
    grid: Grids,
    steps: int,
    effort: Effort,
    own: OwnCrossings,
    room: tuple[int, int],
    progress: Progress,
) -> Finished | None:
    """A piece evened out; where quads stay folded or bad it is laid out anew with fewer wishes, and
    the best of the layouts is kept, also by whether the number of its quads is within `room`. None
    where quads do not join up: nothing torn is ever returned."""
    tries: list[Finished] = []
    for attempt in range(ATTEMPTS):
        placed = place(laid.map_, laid.layout, grid)
        if not _joins_up(placed, laid):
            break
        one, quality, to_mend = _evened(laid, grid, placed, steps, True, progress)
        size = len(laid.working.surface.triangles)
        effort.spend(EVENING * size if attempt else 0)
        if to_mend.min() < POOR and effort.left:
            effort.spend(EVENING * size)
            other, also, other_to_mend = _evened(laid, grid, placed, steps, False, progress)
            tries += [one, other]
            if (other.folded, other.bad, -other.least) < (one.folded, one.bad, -one.least):
                one, quality, to_mend = other, also, other_to_mend
        else:
            tries.append(one)
        folded, bad, triangle = one.folded, one.bad, one.triangle
        if not bad and not attempt:
            return one
        if not bad or attempt == ATTEMPTS - 1 or not effort.left:
            break
        if folded > HOPELESS * len(quality):
            break
        working, at = laid.working, triangle[placed.quads]
        if folded:
            near = _corners(working, at[quality <= 0.0])
            wishes = gentler(working, laid.wishes, near, None, attempt)
        else:
            # Of all wishes creases that end in the open are the least sure.
            near = _corners(working, at[quality <= BAD])
            wishes = without_open_creases(working, laid.wishes, near)
        if wishes is laid.wishes:
            near = _corners(working, at[to_mend <= BAD])
            if not near.any():
                break
            wishes = gentler(working, laid.wishes, near, None, attempt)
        again = laid_out(working, wishes, progress, effort, LAST_LOCAL)
        if again is None:
            break
        try:
            grid = grids_of_about([again], len(grid.quads), progress)[0]
        except RemeshError:
            break
        laid = again
    return _best(tries, own, room, progress)


def _corners(working: WorkingSurface, at: np.ndarray) -> np.ndarray:
    """(n,) bool corners of the triangles that quads (q, 4) have theirs on."""
    near = np.zeros(len(working.surface.vertices), bool)
    near[working.surface.triangles[at].ravel()] = True
    return near


def _best(
    tries: list[Finished], own: OwnCrossings, room: tuple[int, int], progress: Progress
) -> Finished | None:
    """The try that, unfolded, breaks the least of what all quads are to hold, and of equals the one
    with the largest least scaled Jacobian. None where no try has quads that may be left."""
    best: Finished | None = None
    least: tuple[float, ...] = ()
    for one in sorted(tries, key=lambda one: (one.folded, one.bad)):
        if one.folded and best is not None and not least[0]:
            break
        done = (_unfolded(one, progress) if one.folded else one) or one
        # Quads along the curvature with few folds are better than none along it.
        if done is one and one.folded > HOPELESS * len(one.placed.quads):
            continue
        worth = _worth(done, own, room)
        if best is None or worth < least:
            best, least = done, worth
    return best


def _worth(one: Finished, own: OwnCrossings, room: tuple[int, int]) -> tuple[float, ...]:
    """Less is better: how many guarantees are broken, by how much each, what quads are worth."""
    surface, quads = one.laid.working.surface, one.placed.quads
    place = one.position * surface.unit + surface.origin
    crossing = len(made_crossings(place, quads, own))
    other = not room[0] <= len(quads) <= room[1]
    broken = (one.folded > 0) + (crossing > 0) + (one.left > 0)
    farthest = one.farthest if one.left else 0.0
    return broken, one.folded, crossing, farthest, other, -one.least, one.bad


def _evened(
    laid: LaidOut, grid: Grids, placed: Placement, steps: int, thin: bool, progress: Progress
) -> tuple[Finished, np.ndarray, np.ndarray]:
    """The quads in their places, what (q,) each is worth, and the same of those that could be
    better; see `quality_to_mend` and `Guides.thin`."""
    guides = replace(guides_of(placed, laid), thin=thin)
    quads = placed.quads
    crossed = laid.map_.crosses
    weight = direction_weights(laid.working, laid.wishes, laid.planned, crossed)
    mapped = replace(guides, weight=weight)
    position, triangle = relaxed(placed.position, quads, guides, steps, progress)
    if laid.working.fine is not None:
        position, guides = _on_fine(position, quads, guides, laid.working.fine, progress)
    moved = worst_opened(position, quads, guides, progress)
    if steps:
        moved = np.union1d(moved, squared(position, quads, guides, mapped, progress))
    normals = vertex_normals(position, quads)[moved]
    triangle[moved] = mapped.surface(position[moved], normals)[0]
    quality = oriented_quality(position, quads, guides)
    folded, bad = (int(np.count_nonzero(quality <= least)) for least in (0.0, BAD))
    to_mend = quality
    if quality.min() < POOR:
        to_mend = quality_to_mend(position, quads, guides)
    least = float(quality.min())
    one = Finished(laid, grid, placed, position, triangle, mapped.surface, folded, bad, least)
    return one, quality, to_mend


def _unfolded(one: Finished, progress: Progress) -> Finished | None:
    """Without folded quads, vertices off the surface where it leaves no room; None where that was
    not found. Those that still face against the surface are told as folded."""
    guides, quads = guides_of(one.placed, one.laid), one.placed.quads
    fine = one.laid.working.fine
    if fine is not None:
        guides = replace(guides, surface=ClosestPoints(fine.vertices, fine.triangles, fine.twin))
    position = unfolded(one.position, quads, guides, progress)
    quality = own_quality(position, quads)
    if (quality <= 0.0).any():
        return None
    normals = vertex_normals(position, quads)
    off = np.linalg.norm(guides.surface(position, normals)[1] - position, axis=1)
    side = np.linalg.norm(position[quads] - position[np.roll(quads, -1, axis=1)], axis=2).mean()
    if off.max() > LOST * side:
        return None
    return replace(
        one,
        position=position,
        triangle=one.surface(position, normals)[0],
        folded=int(np.count_nonzero(against(position, quads, guides.surface))),
        bad=int(np.count_nonzero(quality <= BAD)),
        least=float(quality.min()),
        left=int(np.count_nonzero(off > OFF * side)),
        farthest=float(off.max()) * one.laid.working.surface.unit,
    )


def _on_fine(
    position: np.ndarray, quads: np.ndarray, guides: Guides, fine: Surface, progress: Progress
) -> tuple[np.ndarray, Guides]:
    """Positions (n, 3) on the surface that the mapped one was coarsened from."""
    surface = ClosestPoints(fine.vertices, fine.triangles, fine.twin)
    progress.ask()
    guides = replace(guides, surface=surface)
    free = ~guides.fixed & (guides.curve < 0)
    position = position.copy()
    position[free] = surface(position[free], vertex_normals(position, quads)[free])[1]
    mend(position, quads, guides, progress)
    return position, guides


def _joins_up(placed: Placement, laid: LaidOut) -> bool:
    found = conformity(placed.quads, len(placed.position))
    return found.manifold and found.characteristic == characteristic(laid)


def guides_of(placed: Placement, laid: LaidOut) -> Guides:
    """What holds the quads of a piece: poles and loose ends of creases are free, other ends and
    corners of features are not."""
    surface = laid.working.surface
    crossed = laid.map_.crosses
    held = placed.vertex >= 0
    on = held & (crossed.on_feature & ~laid.loose_end)[np.maximum(placed.vertex, 0)]
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
        guiding_directions(laid.working, laid.wishes, laid.planned, crossed),
        crossed.size,
        # Poles that were moved out of a zone do not slide back, those that a user placed stay.
        on | (held & (laid.wishes.avoided.any() or laid.wishes.wanted is not None)),
        np.where(held, -1, placed.track),
        placed.beside,
        curves,
    )
