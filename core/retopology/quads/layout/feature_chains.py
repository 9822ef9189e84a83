"""Features around their vertices, and the chains of them between nodes of a layout."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....mesh.half_edges import previous
from ..field.crosses import QUARTER, Crosses, fans

# A sector between features must make whole right angles within this.
WHOLE = 1e-3


@dataclass(frozen=True)
class Sector:
    """What lies between two features at a vertex: the half-edge that it starts with
    anticlockwise, its corners (c,) and the right angles it makes in the map."""

    edge: int
    corners: np.ndarray
    turns: int

    @property
    def last(self) -> int:
        """The half-edge towards the vertex that the sector ends with."""
        return int(previous(self.corners[-1]))


@dataclass(frozen=True)
class Around:
    """The sectors of a vertex, anticlockwise; `opened` where the last ends on a border."""

    sectors: list[Sector]
    opened: bool

    @property
    def straight(self) -> bool:
        """Whether one feature only passes here, without a corner."""
        return len(self.sectors) + self.opened == 2 and all(
            sector.turns == 2 for sector in self.sectors
        )


class FeatureChains:
    """The features of crosses in a map.

    Parameters
    ----------
    angle:
        (3 m,) float64 angles of the corners in the map.

    Attributes
    ----------
    around:
        For each vertex on a feature what is around it.
    sound:
        False where sectors do not make whole right angles.
    """

    def __init__(self, crosses: Crosses, angle: np.ndarray) -> None:
        self._crosses = crosses
        self._twin = crosses.twin.tolist()
        self._first = np.flatnonzero(crosses.feature)
        self.around, self.sound = self._arounds(angle)

    def _arounds(self, angle: np.ndarray) -> tuple[dict[int, Around], bool]:
        if not len(self._first):
            return {}, True
        crosses = self._crosses
        corner, start = fans(crosses.twin, crosses.feature, self._first)
        total = np.add.reduceat(angle[corner], start[:-1]) / QUARTER
        turns = np.rint(total).astype(np.int64)
        sound = bool((np.abs(total - turns) <= WHOLE).all() and (turns >= 1).all())
        sector = {
            edge: Sector(edge, corner[start[i] : start[i + 1]], int(turns[i]))
            for i, edge in enumerate(self._first.tolist())
        }
        leaving: dict[int, list[int]] = {}
        for edge in self._first.tolist():
            leaving.setdefault(int(crosses.tail[edge]), []).append(edge)
        result = {}
        for vertex, edges in leaving.items():
            # A border's own half-edge is the first anticlockwise.
            begin = next((edge for edge in edges if self._twin[edge] < 0), edges[0])
            sectors = [sector[begin]]
            onward = self._twin[sectors[-1].last]
            while onward >= 0 and onward != begin and len(sectors) < len(edges):
                sectors.append(sector[onward])
                onward = self._twin[sectors[-1].last]
            result[vertex] = Around(sectors, onward < 0)
        return result, sound

    def closed(self, nodes: set[int]) -> set[int]:
        """One vertex of each closed feature without any of the nodes."""
        seen: set[int] = set()
        for vertex in nodes:
            for sector in self.around[vertex].sectors:
                seen.update(self.chain(sector.edge, nodes))
        loops: set[int] = set()
        for edge in self._first.tolist():
            if edge not in seen and self._twin[edge] not in seen:
                loops.add(int(self._crosses.tail[edge]))
                seen.update(self.chain(edge, nodes | loops))
        return loops

    def chain(self, edge: int, nodes: set[int]) -> list[int]:
        """Feature half-edges from one on, up to a node."""
        chain = [edge]
        while (vertex := int(self._crosses.head[edge])) not in nodes:
            sectors = self.around[vertex].sectors
            edge = next(item.edge for item in sectors if item.edge != self._twin[edge])
            chain.append(edge)
        return chain
