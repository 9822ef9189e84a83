"""Draw the diagrams of docs/how_it_works.md as SVG, from the core's own functions.

    python3 tools/make_diagrams.py

Needs NumPy and SciPy. What is drawn is computed: the lines around an umbilic are integral lines of
its linear form, the triangle's zero is found as method S finds it.
"""

import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from core.umbilics.kind import separatrix_angles  # noqa: E402
from core.umbilics.methods.shape_operators import zero_weights  # noqa: E402

FOLDER = ROOT / "docs" / "figures" / "how"
RED, BLUE, INK, GREY, GOLD = "#c8321e", "#1f5fbf", "#222222", "#9a9a9a", "#d99a00"


class Drawing:
    """An SVG of some size, with y upwards and a scale in pixels per unit."""

    def __init__(self, width: int, height: int, scale: float) -> None:
        self._size, self._scale = (width, height), scale
        self._parts: list[str] = []

    def _place(self, point: complex) -> str:
        width, height = self._size
        x = 0.5 * width + self._scale * point.real
        y = 0.5 * height - self._scale * point.imag
        return f"{x:.1f},{y:.1f}"

    def line(self, points, colour: str = INK, width: float = 1.5, dash: str = "") -> None:
        path = " ".join(self._place(point) for point in points)
        self._parts.append(
            f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="{width}"'
            f' stroke-linecap="round" stroke-dasharray="{dash}"/>'
        )

    def polygon(self, points, fill: str, colour: str = "none") -> None:
        path = " ".join(self._place(point) for point in points)
        self._parts.append(f'<polygon points="{path}" fill="{fill}" stroke="{colour}"/>')

    def dot(self, point: complex, radius: float = 4.0, colour: str = INK) -> None:
        x, y = self._place(point).split(",")
        self._parts.append(f'<circle cx="{x}" cy="{y}" r="{radius}" fill="{colour}"/>')

    def text(self, point: complex, words: str, size: int = 15, colour: str = INK) -> None:
        x, y = self._place(point).split(",")
        self._parts.append(
            f'<text x="{x}" y="{y}" font-family="sans-serif" font-size="{size}" fill="{colour}"'
            f' text-anchor="middle">{words}</text>'
        )

    def save(self, name: str) -> None:
        width, height = self._size
        body = "\n".join(self._parts)
        (FOLDER / f"{name}.svg").write_text(
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}"'
            f' viewBox="0 0 {width} {height}">\n<rect width="100%" height="100%" fill="white"/>\n'
            f"{body}\n</svg>\n"
        )


def integral_line(field, start: complex, reach: float, step: float = 0.02) -> list[complex]:
    """The line of the direction field through a point, both ways, within a square."""
    halves = []
    for sign in (1.0, -1.0):
        point, along, points = start, None, []
        for _ in range(400):
            deviator = field(point)
            if abs(deviator) < 0.02:
                break
            direction = np.sqrt(deviator / abs(deviator))
            if along is None:
                along = sign * direction
            along = direction if (direction * along.conjugate()).real > 0 else -direction
            point += step * along
            if max(abs(point.real), abs(point.imag)) > reach:
                break
            points.append(point)
        halves.append(points)
    return [*reversed(halves[1]), start, *halves[0]]


def kinds() -> None:
    """Lines of curvature around a star, a lemon and a monstar, with their separatrices."""
    drawing = Drawing(930, 330, 130)
    forms = (
        ("star, index −½", 0.0, 1.0),
        ("lemon, index +½", 1.0, 0.25j),
        ("monstar, index +½", 1.0, -0.65),
    )
    for place, (name, p, q) in zip((-2.35, 0.0, 2.35), forms, strict=True):

        def field(z: complex, p: complex = p, q: complex = q) -> complex:
            return p * z + q * z.conjugate()

        for start in np.linspace(-1.0, 1.0, 15):
            for first in (start + 0.55j, start - 0.55j, 1j * start + 0.6, 1j * start - 0.6):
                points = [place + 0.1j + z for z in integral_line(field, first, 1.0)]
                drawing.line(points, GREY, 0.8)
        for angle in separatrix_angles(np.array([p], complex), np.array([q], complex))[0]:
            if np.isfinite(angle):
                ray = np.exp(1j * angle) * np.linspace(0.0, 1.0, 2)
                drawing.line(place + 0.1j + ray, RED, 2.5)
        drawing.dot(place + 0.1j)
        drawing.text(place - 1.12j, name)
    drawing.save("kinds")


def deviator() -> None:
    """A triangle of the surface with its corners' directions, and the triangle of deviators."""
    drawing = Drawing(820, 340, 120)
    left = np.array([-2.9 - 0.9j, -0.7 - 1.0j, -1.9 + 1.0j])
    values = 0.9 * np.exp(1j * np.radians([200.0, 330.0, 80.0])) * np.array([0.7, 1.0, 1.1])
    drawing.polygon(left, "#f2efe6", INK)
    for corner, value in zip(left, values, strict=True):
        half = 0.32 * np.sqrt(value / abs(value))
        drawing.line([corner - half, corner + half], RED, 3.0)
        drawing.dot(corner)
    weights, _ = zero_weights(values[None])
    zero = (weights[0] * left).sum()
    drawing.dot(zero, 6.0, GOLD)
    drawing.text(zero - 0.28j, "umbilic")
    right = 1.8 + values
    drawing.polygon(right, "#eaf0f8", INK)
    drawing.line([0.5, 3.1], GREY, 0.8)
    drawing.line([1.8 - 1.2j, 1.8 + 1.2j], GREY, 0.8)
    for corner, name in zip(right, "abc", strict=True):
        drawing.line([1.8, corner], BLUE, 1.5)
        drawing.dot(corner, 4.0, BLUE)
        drawing.text(corner + 0.16 * (corner - 1.8) / abs(corner - 1.8), f"D_{name}")
    drawing.dot(1.8, 6.0, GOLD)
    drawing.text(-1.8 - 1.35j, "principal directions at the corners")
    drawing.text(1.8 - 1.35j, "their deviators: the triangle holds 0")
    drawing.save("deviator")


def winding() -> None:
    """How the certified index counts: turns along edges that two triangles share."""
    drawing = Drawing(520, 330, 115)
    points = np.array([-1.4 + 0j, 0.0 - 0.9j, 1.4 + 0.1j, 0.1 + 0.95j])
    drawing.polygon(points[[0, 1, 3]], "#f2efe6", INK)
    drawing.polygon(points[[1, 2, 3]], "#eaf0f8", INK)
    for corner, angle in zip(points, np.radians([10.0, 70.0, 125.0, 40.0]), strict=True):
        half = 0.26 * np.exp(1j * angle)
        drawing.line([corner - half, corner + half], RED, 3.0)
    middle = 0.5 * (points[1] + points[3])
    drawing.text(middle - 0.42, "+δ")
    drawing.text(middle + 0.42, "−δ")
    drawing.text(-1.36j, "one turn δ for each edge: what one triangle adds the other takes", 14)
    drawing.save("winding")


def persistence() -> None:
    """Level sets of a gap with three zeros: the shallow pair cancels, one umbilic stays."""
    drawing = Drawing(640, 300, 100)
    x = np.linspace(-3.0, 3.0, 601)
    gap = np.minimum.reduce(
        [np.abs(x + 1.9), np.abs(x + 0.2) * 0.9, np.abs(x - 0.35) * 0.9, 0.4 + 0.35 * np.abs(x)]
    )
    gap = np.where((x > -0.3) & (x < 0.45), np.minimum(gap, 0.25), gap)
    base = -1.0
    drawing.line([complex(a, base + 1.2 * b) for a, b in zip(x, gap, strict=True)], INK, 2.0)
    drawing.line([-3.0 + 1j * base, 3.0 + 1j * base], GREY, 0.8)
    for place, index in ((-1.9, "+½"), (-0.2, "−½"), (0.35, "+½")):
        drawing.dot(complex(place, base), 5.0, GOLD)
        drawing.text(complex(place, base - 0.3), index)
    level = base + 1.2 * 0.2475
    drawing.line([-0.2 + 1j * level, 0.35 + 1j * level], RED, 2.5, "6 4")
    drawing.text(1.45 + 1j * (level - 0.16), "persistence of the pair", 13, RED)
    drawing.text(1.15j, "the gap along a path: indices that cancel below the error go", 14)
    drawing.save("persistence")


def poles() -> None:
    """What an umbilic becomes in a quad mesh."""
    drawing = Drawing(620, 280, 110)
    for place, name, valence, colour in (
        (-1.4, "lemon: two 3-poles", 3, GOLD),
        (1.4, "star: two 5-poles", 5, BLUE),
    ):
        for side in (-0.35, 0.35):
            centre = place + 1j * side + 0.15j
            turn = 0.5 * np.pi if side > 0 else -0.5 * np.pi
            for k in range(valence):
                angle = turn + 2.0 * np.pi * k / valence
                drawing.line([centre, centre + 0.33 * np.exp(1j * angle)], INK, 1.6)
            drawing.dot(centre, 6.0, colour)
        drawing.text(place - 1.1j, name)
    drawing.save("poles")


def main() -> None:
    FOLDER.mkdir(parents=True, exist_ok=True)
    for draw in (kinds, deviator, winding, persistence, poles):
        draw()


if __name__ == "__main__":
    main()
