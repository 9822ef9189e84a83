"""Closed pieces of so few vertices that no fit tells one of their umbilics from another."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...mesh.surface import Surface
from .region_map import RegionMap

# Vertices within two rings of one on an even mesh: the narrowest fits hold these.
NARROWEST = 19


def untold_pieces(surface: Surface, regions: RegionMap, component: np.ndarray) -> np.ndarray:
    """(c,) bool, closed components without a region that have no room for as many fits side by
    side as they must have umbilics, and are left with a single one.

    Indices of generic umbilics are one half and sum up to the Euler characteristic. Two of them
    that one fit holds are not told apart; where it holds more than its share of all, and all became
    one, that has the sum which every field on such a piece has, and no place.

    Parameters
    ----------
    component:
        (k,) component that each of the umbilics that are told from their errors lies on.
    """
    count = surface.component_count
    least = 2 * np.abs(surface.euler_characteristic)
    few = surface.closed & (np.bincount(surface.component, minlength=count) < NARROWEST * least)
    few[surface.component[surface.triangles[regions.label >= 0, 0]]] = False
    return np.asarray(few & (np.bincount(component, minlength=count) == 1))


def with_pieces(surface: Surface, regions: RegionMap, pieces: np.ndarray) -> RegionMap:
    """The regions, and behind them the components `pieces` (c,), which have none."""
    number = np.where(pieces, regions.count + np.cumsum(pieces) - 1, -1)
    number = number[surface.component[surface.triangles[:, 0]]]
    labels = np.where(number >= 0, number, regions.label).astype(np.int32)
    few = int(pieces.sum())
    return replace(regions, label=labels, count=regions.count + few, few=few)


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
