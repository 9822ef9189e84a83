"""Closed pieces of so few vertices that no fit tells one of their umbilics from another."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...mesh.surface import Surface
from .region_map import RegionMap

# Vertices within two rings of one on an even mesh: the narrowest fits hold these.
NARROWEST = 19


def pieces_of_few_fits(surface: Surface) -> np.ndarray:
    """(c,) bool, closed components on which there is no room for as many fits side by side as they
    must have umbilics.

    Indices of generic umbilics are one half and sum up to the Euler characteristic. Two of them
    that one fit holds are not told apart; where it holds more than its share of all, none is.
    """
    least = 2 * np.abs(surface.euler_characteristic)
    vertices = np.bincount(surface.component, minlength=surface.component_count)
    return np.asarray(surface.closed & (vertices < NARROWEST * least))


def with_too_few(surface: Surface, regions: RegionMap) -> RegionMap:
    """The regions, and beside them the pieces of few fits that have none."""
    few = pieces_of_few_fits(surface)
    if not few.any():
        return regions
    of = surface.component[surface.triangles[:, 0]]
    few[of[regions.label >= 0]] = False
    if not few.any():
        return regions
    number = np.where(few, regions.count + np.cumsum(few) - 1, -1)[of]
    labels = np.where(number >= 0, number, regions.label).astype(np.int32)
    return replace(regions, label=labels, count=regions.count + int(few.sum()), few=int(few.sum()))


def too_few_words(pieces: int, all_pieces: int) -> str:
    """The sentence for the user."""
    if all_pieces == 1:
        return (
            "The mesh has too few vertices to tell one umbilic from another: only the sum of their "
            "indices is known, and reported as a region. Subdivide smoothly, or take a finer mesh."
        )
    return (
        f"{pieces} of {all_pieces} pieces have too few vertices to tell one umbilic from another: "
        "only the sums of their indices are known, and reported as regions. Subdivide smoothly, or "
        "take a finer mesh."
    )
