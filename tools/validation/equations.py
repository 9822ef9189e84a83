"""Equations that the paper prints wrongly, each with a number that shows it."""

from __future__ import annotations

import numpy as np
from surfaces import graph_surface, grid_points, saddle

import core

from .page import Page
from .surfaces_found import raw


def write(page: Page) -> None:
    page.heading("Equations that read otherwise here")
    page.items(statements())


def statements() -> list[str]:
    """The three corrections, with their numbers."""
    return [" ".join(text.split()) for text in (_corollary(), _jacobian(), _genericity())]


def _corollary() -> str:
    mesh = saddle(cells=40)
    middle = np.linalg.norm(mesh.vertices, axis=1).argmin()
    # At the origin of z = xy: E = G = 1, F = 0, L = N = 0, M = 1.
    E, G, L, N = 1.0, 1.0, 0.0, 0.0
    found = core.detect(mesh.vertices, mesh.triangles, raw("S"), given=mesh.curvature)
    return f"""Corollary 3.2, “umbilic if and only if V = 0”: at the origin of z = xy,
        V = EN − GL = {E * N - G * L:g}, but the principal curvatures are {mesh.k1[middle]:+.3f}
        and {mesh.k2[middle]:+.3f}. Lemma 3.4 (t = 0) is right and is what everything rests on;
        S finds {len(found.candidates)} points there."""


def _jacobian() -> str:
    right, printed = 0.0, 0.0
    random = np.random.default_rng(0)
    for _ in range(100):
        K = np.diag(np.sort(random.normal(size=2))[::-1])
        frame = np.linalg.qr(random.normal(size=(3, 3)))[0]
        frame *= np.sign(np.linalg.det(frame))
        tilt = random.uniform(0.1, 1.0)
        turned = _rotation(random.normal(size=3), tilt) @ frame
        B = (turned.T @ frame)[:2, :2]
        true = _operator_of_graph(K, turned.T @ frame)
        scale = np.abs(K).max()
        right = max(right, np.abs(B @ K @ np.linalg.inv(B) - true).max() / scale)
        printed = max(printed, np.abs(np.linalg.inv(B) @ K @ B - true).max() / scale)
    return f"""Equations 8 to 12, the Jacobian of the projection: it is B⁻¹, not B, so that
        S = B K B⁻¹. Against the operator of the height function itself, differenced in 100
        random tilted frames, this is right to {right:.0e} of the curvature (the error of the
        differences); with the printed B it is off by up to {printed:.1f} times the curvature."""


def _operator_of_graph(K: np.ndarray, frame: np.ndarray) -> np.ndarray:
    """(2, 2) shape operator, in the coordinates of a tilted plane, of w = ½ (k1 u² + k2 v²)
    seen as a graph over that plane; `frame` (3, 3) takes u, v, w to x, y, z."""
    step = 1e-3

    def height(x: float, y: float) -> float:
        # Newton's method for (u, v) with the wanted x and y.
        u = np.zeros(2)
        for _ in range(30):
            point = np.array([u[0], u[1], 0.5 * u @ K @ u])
            slope = frame @ np.vstack([np.eye(2), K @ u])
            u = u - np.linalg.solve(slope[:2], (frame @ point)[:2] - (x, y))
        return float((frame @ [u[0], u[1], 0.5 * u @ K @ u])[2])

    x, y = (step, 0.0), (0.0, step)
    z = {(i, j): height(i * x[0], j * y[1]) for i in (-1, 0, 1) for j in (-1, 0, 1)}
    zx, zy = (z[1, 0] - z[-1, 0]) / (2 * step), (z[0, 1] - z[0, -1]) / (2 * step)
    zxx = (z[1, 0] - 2 * z[0, 0] + z[-1, 0]) / step**2
    zyy = (z[0, 1] - 2 * z[0, 0] + z[0, -1]) / step**2
    zxy = (z[1, 1] - z[1, -1] - z[-1, 1] + z[-1, -1]) / (4 * step**2)
    first = np.array([[1 + zx * zx, zx * zy], [zx * zy, 1 + zy * zy]])
    second = np.array([[zxx, zxy], [zxy, zyy]]) / np.sqrt(1 + zx * zx + zy * zy)
    return np.linalg.solve(first, second)


def _rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    x, y, z = axis / np.linalg.norm(axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross


def _genericity() -> str:
    b0, b2 = 3.0, 1.0  # and b1 = b3 = 0
    points, triangles = grid_points(41, 41, (-0.3, -0.3), (0.3, 0.3))
    mesh = graph_surface(
        "cubic",
        lambda x, y: (
            0.5 * (x * x + y * y) + (b0 * x**3 + 3 * b2 * x * y * y) / 6,
            x + 0.5 * (b0 * x * x + b2 * y * y),
            y + b2 * x * y,
            1 + b0 * x,
            b2 * y,
            1 + b2 * x,
        ),
        points,
        triangles,
    )
    found = core.detect(mesh.vertices, mesh.triangles, raw("S"), given=mesh.curvature).candidates
    near = np.linalg.norm(found.position, axis=1) < 0.02
    index = ", ".join(f"{value:+g}" for value in found.index[near])
    return f"""Equation 18, when an umbilic is generic: b2 (b0 − b2) − b1 (b1 − b3) ≠ 0. The printed
        products with b1 vanish for b0 = 3, b2 = 1, b1 = b3 = 0, where the right expression is
        {b2 * (b0 - b2):g} and S finds an isolated umbilic of index {index} at the origin."""
