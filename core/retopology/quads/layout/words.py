"""What is said about a layout: what gave way, and what was wanted and is not there."""

from __future__ import annotations

import numpy as np

from ....base.words import counted
from ...by_hand import FAR, WantedPoles, first_said
from .laying_out import LaidOut

# Numbers of quads count as met within this part.
MET = 0.03
# A wanted pole is there if one of its valence is this near, in lengths of quads.
NEAR = 1.5


def words_of_unlaid(count: int, scraps: int = 0) -> list[str]:
    """What is said of so many pieces without a layout, of which so many are too small for one."""
    said = []
    if scraps:
        whose = "its" if scraps == 1 else "their"
        said.append(
            f"{counted(scraps, 'piece')} of the mesh smaller than a quad: "
            f"{whose} triangles were cut into three quads each. "
            "Remesh small pieces by themselves, or ask for more quads."
        )
    count -= scraps
    if not count:
        return said
    whose = "its" if count == 1 else "their"
    return [
        *said,
        f"No layout along the curvature was found for {counted(count, 'piece')} of the mesh: "
        f"{whose} triangles were cut into three quads each. "
        "Raise the smoothness, leave creases out or repair the mesh around its folds and slivers.",
    ]


def words_of_outnumbered(count: int) -> list[str]:
    """What is said of so many pieces whose layout has more rectangles than there are to be
    quads, so that these do not fill it."""
    if not count:
        return []
    whose = "its" if count == 1 else "their"
    return [
        f"The layout of {counted(count, 'piece')} of the mesh has more patches than quads: "
        f"{whose} triangles are cut into three quads each. "
        "Ask for more quads, or raise the smoothness."
    ]


def words_of_count(made: int, asked: int, poles: int, cut: int) -> list[str]:
    """What is said of `made` quads where `asked` were wanted, with so many poles and pieces that
    were cut; nothing where they are about as many."""
    if abs(made - asked) <= MET * asked:
        return []
    if made < asked:
        return [
            f"{made} quads instead of {asked}: the whole numbers that poles, borders and creases "
            "allow are no nearer."
        ]
    if cut:
        return [
            f"{made} quads instead of {asked}: pieces without a layout have as many as the "
            "vertices of their borders and creases need."
        ]
    if poles:
        return [
            f"{made} quads instead of {asked}: the {poles} poles, borders and creases need as many "
            "to stay apart."
        ]
    return [
        f"{made} quads instead of {asked}: borders, creases and closed rings of quads need as many "
        "to stay apart."
    ]


def words(parts: list[LaidOut], smoothness: float, wanted: WantedPoles | None) -> list[str]:
    """Sentences about what gave way, over all pieces.

    Parameters
    ----------
    smoothness, wanted:
        What was asked for.
    """
    found = []
    wishes = [laid.wishes for laid in parts]
    smoothed = sum(one.smoothed for one in wishes)
    dropped = sum(one.dropped for one in wishes)
    if smoothed:
        found.append(
            f"The directions were smoothed in {counted(smoothed, 'place')} where quads along the "
            "curvature would fold."
        )
    if dropped:
        found.append(
            f"{counted(dropped, 'crease')} left out: no quads fit between "
            f"{'it' if dropped == 1 else 'them'} and what is around."
        )
    unmarked = sum(one.unmarked for one in wishes)
    if unmarked:
        found.append(
            f"{counted(unmarked, 'marked line')} of edges could not be followed: no quads fit "
            "there. Take marks away where they meet at small angles, or ask for more quads."
        )
    if any(one.smoothness > smoothness for one in wishes):
        found.append(
            "The directions were smoothed more than asked for: no quads follow the curvature "
            "everywhere."
        )
    found += _strokes(parts)
    if wanted is not None:
        found += _wanted(parts, wanted)
    return found


def _strokes(parts: list[LaidOut]) -> list[str]:
    """What is said of strokes; that one is too far away only where it is from every piece."""
    every = [set(laid.planned.not_held) for laid in parts]
    common = set.intersection(*every) if every else set()
    said = {sentence for some in every for sentence in some if FAR not in sentence}
    return list(first_said(sorted(said | common)))


def _wanted(parts: list[LaidOut], wanted: WantedPoles) -> list[str]:
    """What is said of wanted poles that are not there, and of others that are."""
    places, valences, reach = [np.zeros((0, 3))], [np.zeros(0, np.int64)], [np.zeros(0)]
    for laid in parts:
        crosses, surface = laid.map_.crosses, laid.working.surface
        vertex = np.flatnonzero(crosses.singular)
        places.append(crosses.vertices[vertex] * surface.unit + surface.origin)
        valences.append(crosses.quarter_turns[vertex])
        reach.append(np.full(len(vertex), NEAR * float(np.median(crosses.size)) * surface.unit))
    place, valence, near = np.concatenate(places), np.concatenate(valences), np.concatenate(reach)
    free = np.ones(len(place), bool)
    missing = 0
    for position, kind in zip(np.asarray(wanted.position), np.asarray(wanted.valence), strict=True):
        distance = np.linalg.norm(place - position, axis=1)
        fits = free & (valence == kind) & (distance <= near)
        if fits.any():
            free[np.where(fits, distance, np.inf).argmin()] = False
        else:
            missing += 1
    found = []
    if missing:
        found.append(
            f"{missing} of the {len(wanted.valence)} wanted poles could not be made: an opposite "
            "one or a feature is too near, or they do not sum up to what the surface asks for."
        )
    if free.any():
        found.append(
            f"{counted(int(free.sum()), 'more pole')} than wanted: the surface and its features "
            "ask for them."
        )
    return found
