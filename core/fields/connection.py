"""Sparse operators of direction fields: the Laplacian over a connection, and its weights."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from ..base.parallel import run
from ..base.progress import Progress
from ..mesh.half_edges import all_edges, ends_of
from ..mesh.surface import NO_AREA, Surface
from .transport import rotation

# Cotangent weights outside these bounds come from slivers and would spoil the solver.
LEAST_WEIGHT, LARGEST_WEIGHT = 0.05, 20.0
BLOCK = 1 << 16


def weights_and_areas(surface: Surface) -> tuple[np.ndarray, np.ndarray]:
    """(3 m,) half the cotangent across from each half-edge; (n,) a third of the areas around."""
    _, area = surface.face_normal_area
    weights = np.empty((len(area), 3))

    def block(first: int) -> None:
        rows = slice(first, first + BLOCK)
        a, b, c = (surface.vertices.take(of, axis=0) for of in surface.triangles[rows].T)
        sides = b - a, c - b, a - c
        quarter = 0.25 / np.maximum(area[rows], NO_AREA)
        for k in range(3):
            # The sides that meet across from side k run in opposite senses there.
            product = np.einsum("mc,mc->m", sides[(k + 1) % 3], sides[(k + 2) % 3])
            weights[rows, k] = -quarter * product

    run(block, range(0, len(area), BLOCK), Progress())
    around = np.bincount(
        surface.triangles.ravel(), weights=np.repeat(area / 3.0, 3), minlength=len(surface.vertices)
    )
    return weights.ravel(), np.maximum(around, NO_AREA)


def connection_laplacian(
    surface: Surface, weights: np.ndarray, axis: np.ndarray, symmetry: int
) -> tuple[sparse.csr_array, np.ndarray]:
    """Connection Laplacian of powers `symmetry`, (n, n), and its diagonal (n,)."""
    n = len(surface.vertices)
    # One entry for each edge: the first of its half-edges carries both cotangents.
    twin = surface.twin
    first = all_edges(twin)
    tail, head = ends_of(surface.triangles, first)
    both = weights[first] + np.where(twin[first] >= 0, weights[twin[first]], 0.0)
    both = np.clip(both, LEAST_WEIGHT, LARGEST_WEIGHT)
    transport = np.empty(len(first), complex)
    for start in range(0, len(first), BLOCK):
        part = slice(start, start + BLOCK)
        turn = rotation(axis[:, head[part]], axis[:, tail[part]])
        transport[part] = turn**symmetry
    entry = -both * transport
    upper = sparse.coo_array((entry, (tail, head)), shape=(n, n)).tocsr()
    diagonal = np.bincount(tail, weights=both, minlength=n)
    diagonal += np.bincount(head, weights=both, minlength=n)
    matrix = upper + upper.conj().T.tocsr() + sparse.diags_array(diagonal.astype(complex))
    return matrix.tocsr(), diagonal
