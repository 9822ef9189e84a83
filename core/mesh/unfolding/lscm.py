"""Least squares conformal maps of a disk into the plane (Lévy et al. 2002)."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from ...base.errors import ChartError
from ...base.factors import definite_factors

# A triangle thinner than this (height over longest side) is treated as if it were that thick:
# it would otherwise dominate the energy through its own round-off.
_LEAST_HEIGHT = 1e-8


def conformal_map(
    vertices: np.ndarray, triangles: np.ndarray, pins: np.ndarray, pinned: np.ndarray
) -> np.ndarray:
    """Unfold disks with the least violation of the Cauchy-Riemann equations.

    In each triangle with corners z_j, in its own plane as complex numbers, the map U is
    conformal where sum W_j U_j = 0 with W_j the side opposite to corner j. The squares of
    these sums over twice the triangles' areas are made least while the pins are held. The
    system is Hermitian, of half the size of the real one, and is factorised as it is.

    Parameters
    ----------
    vertices:
        (n, 3) float64 positions, all of them used by the triangles.
    triangles:
        (m, 3) corners; one disk or several that share no vertex.
    pins, pinned:
        (p,) vertices to hold and (p,) complex places for them, at least two in each disk.

    Returns
    -------
    (n,) complex128 places u + iv.

    Raises
    ------
    ChartError
        The triangles do not determine a map.
    """
    place = np.zeros(len(vertices), dtype=complex)
    place[pins] = pinned
    held = np.zeros(len(vertices), dtype=bool)
    held[pins] = True
    free = np.flatnonzero(~held)
    if not len(free):
        return place
    rows = conformal_energy(vertices, triangles)[free]
    right = -(rows @ place)
    inner = rows[:, free].tocsc()
    del rows
    try:
        factor = definite_factors(inner)
    except RuntimeError as error:
        raise ChartError(
            "A chart cannot be unfolded: its triangles do not determine a conformal map. Merge "
            "doubled vertices and remove faces without area, or use method S."
        ) from error
    solution = factor.solve(right)
    # One step of refinement: the squares cost half the digits where the map shrinks much.
    solution += factor.solve(right - inner @ solution)
    if not np.isfinite(solution).all():
        raise ChartError("A chart cannot be unfolded: the map is not finite. Use method S.")
    place[free] = solution
    return place


def conformal_energy(vertices: np.ndarray, triangles: np.ndarray) -> sparse.csr_array:
    """(n, n) Hermitian matrix M with U* M U = sum |sum W_j U_j|^2 / 2A."""
    flat = flattened(vertices, triangles)
    # The side opposite to a corner, anticlockwise.
    side = np.roll(flat, -2, axis=1) - np.roll(flat, -1, axis=1)
    longest = (side.real**2 + side.imag**2).max(axis=1)
    doubled = (np.conj(side[:, 0]) * side[:, 1]).imag
    least = np.maximum(_LEAST_HEIGHT * longest, np.finfo(float).tiny)
    weight = 1.0 / np.maximum(doubled, least)
    # Over the whole chart sum conj(W_i) W_j; for i != j its imaginary part is the area term.
    entries = weight[:, None, None] * np.conj(side)[:, :, None] * side[:, None, :]
    rows = np.repeat(triangles, 3, axis=1).ravel()
    columns = np.tile(triangles, (1, 3)).ravel()
    shape = (len(vertices), len(vertices))
    return sparse.coo_array((entries.ravel(), (rows, columns)), shape=shape).tocsr()


def flattened(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(m, 3) complex: each triangle in its own plane, first corner at 0, second on the real
    axis, anticlockwise seen from its outer side."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    ab, ac = b - a, c - a
    length = np.linalg.norm(ab, axis=1)
    safe = np.where(length > 0, length, 1.0)
    along = np.einsum("ij,ij->i", ab, ac) / safe
    height = np.linalg.norm(np.cross(ab, ac), axis=1) / safe
    return np.stack([np.zeros_like(length), length, along + 1j * height], axis=1)
