"""Taking the connected pieces of a surface apart."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...mesh.repair import clean
from ...mesh.surface import Surface


def pieces(surface: Surface) -> list[Surface]:
    """A surface of its own for each connected component, its sources those of the input."""
    if surface.component_count == 1:
        return [surface]
    owner = surface.component[surface.triangles[:, 0]]
    order = np.argsort(owner, kind="stable")
    starts = np.searchsorted(owner[order], np.arange(surface.component_count + 1))
    return [
        _piece(surface, order[start:end])
        for start, end in zip(starts, starts[1:], strict=False)
    ]


def _piece(surface: Surface, rows: np.ndarray) -> Surface:
    used, corners = np.unique(surface.triangles[rows], return_inverse=True)
    piece, _ = clean(surface.vertices[used], corners.reshape(-1, 3))
    return replace(
        piece,
        source_vertex=surface.source_vertex[used[piece.source_vertex]],
        source_triangle=surface.source_triangle[rows[piece.source_triangle]],
        origin=piece.origin * surface.unit + surface.origin,
        unit=piece.unit * surface.unit,
    )
