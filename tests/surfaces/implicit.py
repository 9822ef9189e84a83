"""Closed surfaces f(x, y, z) = 0 with exact derivatives, and their umbilics to round-off.

The umbilics are searched for in the zeros that the exact deviators have over a dense mesh of
the surface, whose indices must sum to the Euler characteristic, and placed by Newton's method.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

import core

from .analytic import AnalyticSurface, UmbilicPoints, operators, tangent_frame
from .sampling import icosphere

# Newton's method halves the distance to a zero of second order; this reaches round-off there.
_STEPS = 60
# Step of central differences, for surfaces of size 1.
_STEP = 1e-5


class Jet:
    """A function of x, y, z at n points with its gradient (n, 3) and Hessian (n, 3, 3)."""

    def __init__(self, value: np.ndarray, gradient: np.ndarray, hessian: np.ndarray) -> None:
        self.value, self.gradient, self.hessian = value, gradient, hessian

    @classmethod
    def coordinates(cls, points: np.ndarray) -> list[Jet]:
        """x, y and z at points (n, 3)."""
        zero = np.zeros((len(points), 3, 3))
        return [cls(points[:, k], zero[:, k] + np.eye(3)[k], zero) for k in range(3)]

    def of(self, value: np.ndarray, first: np.ndarray, second: np.ndarray) -> Jet:
        """A function of this one, from its value and two derivatives at each point."""
        outer = self.gradient[:, :, None] * self.gradient[:, None]
        hessian = first[:, None, None] * self.hessian + second[:, None, None] * outer
        return Jet(value, first[:, None] * self.gradient, hessian)

    def __add__(self, other: Jet | float) -> Jet:
        if not isinstance(other, Jet):
            return Jet(self.value + other, self.gradient, self.hessian)
        return Jet(
            self.value + other.value,
            self.gradient + other.gradient,
            self.hessian + other.hessian,
        )

    def __mul__(self, other: Jet | float) -> Jet:
        if not isinstance(other, Jet):
            return Jet(other * self.value, other * self.gradient, other * self.hessian)
        f, g = self.value[:, None], other.value[:, None]
        cross = self.gradient[:, :, None] * other.gradient[:, None]
        hessian = f[:, None] * other.hessian + g[:, None] * self.hessian
        return Jet(
            self.value * other.value,
            f * other.gradient + g * self.gradient,
            hessian + cross + np.swapaxes(cross, 1, 2),
        )

    def __sub__(self, other: Jet | float) -> Jet:
        return self + other * -1.0

    def __pow__(self, power: float) -> Jet:
        x = self.value
        return self.of(x**power, power * x ** (power - 1), power * (power - 1) * x ** (power - 2))

    __radd__, __rmul__ = __add__, __mul__

    def exp(self) -> Jet:
        value = np.exp(self.value)
        return self.of(value, value, value)

    def cos(self) -> Jet:
        cosine = np.cos(self.value)
        return self.of(cosine, -np.sin(self.value), -cosine)


@dataclass(frozen=True)
class ImplicitSurface:
    """A closed surface f = 0, with f < 0 inside.

    Attributes
    ----------
    name:
        What reports call it.
    function:
        f of the jets of x, y, z.
    half:
        It lies in the cube [-half, half]^3.
    euler:
        Its Euler characteristic.
    round:
        Every ray from the origin meets it once.
    """

    name: str
    function: Callable[[Jet, Jet, Jet], Jet]
    half: float
    euler: int = 2
    round: bool = True

    def jet(self, points: np.ndarray) -> Jet:
        """f at points (n, 3)."""
        return self.function(*Jet.coordinates(points))

    def values(self, points: np.ndarray) -> np.ndarray:
        """(n,) f at points (n, 3), by blocks: a grid has millions."""
        return np.concatenate(
            [self.jet(block).value for block in np.array_split(points, len(points) // 50_000 + 1)]
        )

    def on_rays(self, directions: np.ndarray) -> np.ndarray:
        """(n, 3) points of the surface where rays from the origin meet it, to 1e-6."""
        low, high = np.zeros(len(directions)), np.full(len(directions), 2.0 * self.half)
        for _ in range(20):
            middle = 0.5 * (low + high)
            inside = self.values(middle[:, None] * directions) < 0
            low, high = np.where(inside, middle, low), np.where(inside, high, middle)
        return self.projected(0.5 * (low + high)[:, None] * directions)

    def projected(self, points: np.ndarray) -> np.ndarray:
        """(n, 3) points of the surface near others, by Newton's method along the gradient."""
        for _ in range(6):
            jet = self.jet(points)
            square = np.einsum("ni,ni->n", jet.gradient, jet.gradient)
            shift = jet.value / np.maximum(square, 1e-12)
            length = np.abs(shift) * np.sqrt(square)
            shift *= np.minimum(1.0, 0.1 * self.half / np.maximum(length, 1e-300))
            points = points - shift[:, None] * jet.gradient
        return points

    def meshed(self, vertices: np.ndarray, triangles: np.ndarray) -> AnalyticSurface:
        """The exact operators at vertices (n, 3) on the surface; no umbilics are looked for."""
        jet = self.jet(vertices)
        return AnalyticSurface(
            self.name,
            vertices,
            triangles,
            *operators(jet.gradient, jet.hessian),
            UmbilicPoints.none(),
        )

    def umbilics(
        self, dense: tuple[np.ndarray, np.ndarray] | None = None, tolerance: float = 1e-9
    ) -> UmbilicPoints:
        """All umbilics, searched for on a dense mesh (vertices, triangles) of the surface.

        Raises
        ------
        ValueError
            They are not isolated, or the indices of those found do not sum to the Euler
            characteristic.
        """
        if dense is None:
            points, triangles = icosphere(5)
            dense = self.on_rays(points), triangles
        mesh = self.meshed(self.projected(dense[0]), dense[1])
        settings = core.Settings(curvature="given", persistence=0.0, regions=False)
        seeds = core.detect(
            mesh.vertices, mesh.triangles, settings, given=mesh.curvature
        ).candidates.position
        found = self._newton(self.projected(seeds))
        residual = np.abs(self._deviator(found, *self._frames(found)))
        found = found[residual < 1e-6]
        found = found[_first_of_each(found, 1e-5 * self.half)]
        index, kind = self._index_kind(found)
        if index.sum() != self.euler:
            raise ValueError(f"{self.name}: indices sum to {index.sum():g}, not {self.euler}")
        worst = np.abs(self._deviator(found, *self._frames(found))).max(initial=0.0)
        if worst > tolerance:
            raise ValueError(f"{self.name}: deviator {worst:.1e} at an umbilic")
        return UmbilicPoints(found, index, kind)

    def normals(self, points: np.ndarray) -> np.ndarray:
        """(n, 3) unit normals at points of the surface."""
        gradient = self.jet(points).gradient
        return np.asarray(gradient / np.linalg.norm(gradient, axis=1)[:, None])

    def slopes(self, points: np.ndarray) -> np.ndarray:
        """(n,) least change of the deviator by length at points, in 1 / length^2."""
        e1, e2 = self._frames(points)
        ahead, left = (
            (
                self._deviator(self.projected(points + _STEP * e), e1, e2)
                - self._deviator(self.projected(points - _STEP * e), e1, e2)
            )
            / (2 * _STEP)
            for e in (e1, e2)
        )
        return np.asarray(np.abs(np.abs(ahead - 1j * left) - np.abs(ahead + 1j * left)) / 2)

    def _frames(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        gradient = self.jet(points).gradient
        return tangent_frame(gradient / np.linalg.norm(gradient, axis=1)[:, None])

    def _deviator(self, points: np.ndarray, e1: np.ndarray, e2: np.ndarray) -> np.ndarray:
        """(n,) deviators at points, in frames near by carried to them."""
        jet = self.jet(points)
        k1, k2, d1, _, _ = operators(jet.gradient, jet.hessian)
        turn = np.einsum("ni,ni->n", d1, e1) + 1j * np.einsum("ni,ni->n", d1, e2)
        return (k1 - k2) * (turn / np.abs(turn)) ** 2

    def _newton(self, points: np.ndarray) -> np.ndarray:
        for _ in range(_STEPS):
            e1, e2 = self._frames(points)
            here = self._deviator(points, e1, e2)
            along = [
                (
                    self._deviator(self.projected(points + _STEP * e), e1, e2)
                    - self._deviator(self.projected(points - _STEP * e), e1, e2)
                )
                / (2 * _STEP)
                for e in (e1, e2)
            ]
            determinant = (np.conj(along[0]) * along[1]).imag
            safe = np.where(np.abs(determinant) < 1e-300, np.inf, determinant)
            u = -(np.conj(here) * along[1]).imag / safe
            v = -(np.conj(along[0]) * here).imag / safe
            length = np.hypot(u, v)
            short = np.minimum(1.0, 0.02 * self.half / np.maximum(length, 1e-300))
            points = self.projected(points + (short * u)[:, None] * e1 + (short * v)[:, None] * e2)
            if length.max(initial=0.0) < 1e-13 * self.half:
                break
        return points

    def _index_kind(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Index by the turn of the deviator on a small circle, kind by its linear part there."""
        e1, e2 = self._frames(points)
        angle = 2 * np.pi * np.arange(64) / 64
        radius = 1e-4 * self.half
        around = np.stack(
            [
                self._deviator(
                    self.projected(points + radius * (np.cos(a) * e1 + np.sin(a) * e2)), e1, e2
                )
                for a in angle
            ]
        )
        turn = np.angle(np.roll(around, -1, axis=0) * around.conj()).sum(axis=0)
        index = np.rint(turn / (2 * np.pi)) / 2
        p, q = ((around * np.exp(sign * angle)[:, None]).mean(axis=0) for sign in (-1j, 1j))
        kind = np.where(index < 0, "star", np.where(_three_rays(p, q), "monstar", "lemon"))
        return index, np.where(np.abs(index) == 0.5, kind, "flat")


def _three_rays(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """(k,) whether Im(p e^(-i a) + q e^(-3 i a)) changes its sign six times around."""
    angle = 2 * np.pi * (np.arange(3600) + 0.5) / 3600
    value = (p[:, None] * np.exp(-1j * angle) + q[:, None] * np.exp(-3j * angle)).imag
    return (np.sign(value) != np.sign(np.roll(value, 1, axis=1))).sum(axis=1) == 6


def _first_of_each(points: np.ndarray, reach: float) -> np.ndarray:
    """Rows of one point of each cluster."""
    kept: list[int] = []
    for row, point in enumerate(points):
        if not kept or np.linalg.norm(points[kept] - point, axis=1).min() > reach:
            kept.append(row)
    return np.array(kept, dtype=int)


def random_harmonics(seed: int, size: float = 0.25, degree: int = 4) -> ImplicitSurface:
    """|x| = 1 + a random polynomial of a degree in the direction of x."""
    random = np.random.default_rng(seed)
    terms = [
        (a, b, total - a - b)
        for total in range(2, degree + 1)
        for a in range(total + 1)
        for b in range(total + 1 - a)
    ]
    factor = size * random.normal(size=len(terms)) / np.sqrt(len(terms))

    def function(x: Jet, y: Jet, z: Jet) -> Jet:
        length = (x * x + y * y + z * z) ** 0.5
        shrink = length**-1
        u, v, w = x * shrink, y * shrink, z * shrink
        powers = [[None, axis, axis * axis] for axis in (u, v, w)]
        for some in powers:
            for _ in range(3, degree + 1):
                some.append(some[-1] * some[1])
        result = length - 1.0
        for weight, exponents in zip(factor, terms, strict=True):
            parts = [some[n] for some, n in zip(powers, exponents, strict=True) if n]
            term = parts[0]
            for part in parts[1:]:
                term = term * part
            result = result - float(weight) * term
        return result

    return ImplicitSurface(f"harmonics {seed}", function, 2.0)


def random_field(seed: int, size: float = 0.25, frequency: float = 2.2) -> ImplicitSurface:
    """x^2 + y^2 + z^2 = 1 with random waves added."""
    random = np.random.default_rng(seed)
    waves = frequency * random.normal(size=(8, 3)) / np.sqrt(3)
    phase, weight = random.uniform(0, 2 * np.pi, 8), size * random.normal(size=8) / np.sqrt(8)

    def function(x: Jet, y: Jet, z: Jet) -> Jet:
        result = x * x + y * y + z * z - 1.0
        for (a, b, c), p, w in zip(waves.tolist(), phase.tolist(), weight.tolist(), strict=True):
            result = result + w * (a * x + b * y + c * z + p).cos()
        return result

    return ImplicitSurface(f"field {seed}", function, 1.8)


def metaballs(seed: int, count: int = 4) -> ImplicitSurface:
    """A blob: Gaussians at random places, at one level."""
    random = np.random.default_rng(seed)
    centre = 0.38 * random.normal(size=(count, 3))
    centre -= centre.mean(axis=0)
    spread = random.uniform(0.55, 0.75, count)

    def function(x: Jet, y: Jet, z: Jet) -> Jet:
        total = None
        for (a, b, c), s in zip(centre.tolist(), spread.tolist(), strict=True):
            square = (x - a) ** 2 + (y - b) ** 2 + (z - c) ** 2
            ball = (-1.0 / (s * s) * square).exp()
            total = ball if total is None else total + ball
        # The logarithm keeps the gradient from vanishing far away.
        return -1.0 * total.of(np.log(total.value / 0.6), 1.0 / total.value, -1.0 / total.value**2)

    return ImplicitSurface(f"metaballs {seed}", function, 2.0)


def cayley() -> ImplicitSurface:
    """x^2 + y^2 + z^2 + xyz = 1: eight stars and twelve monstars."""
    return ImplicitSurface(
        "x² + y² + z² + xyz = 1", lambda x, y, z: x * x + y * y + z * z + x * y * z - 1.0, 1.3
    )


def cosines() -> ImplicitSurface:
    """cos x + cos y + cos z = 3/2 around the origin: eight stars and six flat points."""
    return ImplicitSurface(
        "cos x + cos y + cos z = 3/2",
        lambda x, y, z: -1.0 * (x.cos() + y.cos() + z.cos()) + 1.5,
        2.2,
    )


def superquadric(axes: tuple[float, float, float] = (1.2, 1.0, 0.8)) -> ImplicitSurface:
    """(x/a)^4 + (y/b)^4 + (z/c)^4 and a little of an ellipsoid: a rounded box."""
    a, b, c = axes

    def function(x: Jet, y: Jet, z: Jet) -> Jet:
        x, y, z = (1.0 / a) * x, (1.0 / b) * y, (1.0 / c) * z
        return x**4 + y**4 + z**4 + 0.3 * (x * x + y * y + z * z) + 0.05 * x * y - 1.0

    return ImplicitSurface("superquadric", function, 1.3)


def genus_two() -> ImplicitSurface:
    """A double torus, made lopsided so that no umbilic is forced by symmetry."""

    def function(x: Jet, y: Jet, z: Jet) -> Jet:
        square = x * x
        eight = square - square * square - y * y
        return eight * eight + z * z + 0.03 * x * z + 0.02 * y * z - 0.03

    return ImplicitSurface("genus 2", function, 1.3, euler=-2, round=False)


def genus_five() -> ImplicitSurface:
    """The tangle cube, x^4 - 5x^2 + ... = -11.8, in a cube of half size 1 and made lopsided."""

    def function(x: Jet, y: Jet, z: Jet) -> Jet:
        x, y, z = 2.6 * x, 2.5 * y, 2.4 * z
        result = None
        for axis in (x, y, z):
            square = axis * axis
            part = square * square - 5.0 * square
            result = part if result is None else result + part
        return result + 0.15 * x * y + 0.1 * y * z + 0.1 * x + 11.6

    return ImplicitSurface("genus 5", function, 1.2, euler=-8, round=False)
