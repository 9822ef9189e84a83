"""Whether what is kept of a scan is kept again of the same scan with more noise, half the
triangles, or other triangles between the same points: one page.

    benchmarks/stability [--meshes FOLDER] [--out FILE]

Writes docs/stability.md. The scans are looked for in $UMBILICS_MESHES or ../shared/meshes.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator
from pathlib import Path

import fast_simplification
import numpy as np
from mesh_files import read_mesh

import core

from . import ROOT
from .pages import publish

SCANS = ("torso_vtk.obj", "bunny_hr_os.obj", "skull_os.obj")
# Passes over the edges, of which each turns as many as do not share a triangle.
TURNS = 3
# Cosine between the normals of the triangles before and after an edge is turned, at least, and the
# smaller area after over that before.
FLAT, FAT = 0.8, 0.4
# Within so many standard errors of both places, but within no fewer and no more edges than these,
# an umbilic of the same index is the same.
ERRORS, NEAREST, FARTHEST = 3.0, 2.0, 6.0
# The most important ones that are told beside all.
FEW = 10

HEADER = """# Stability on scans

What is kept of a scan by default, and how much of it is kept again after the scan was changed in a
way that leaves its shape as it is. Written by `benchmarks/stability`.

- **Noise**: normal deviates of the standard deviation that the detection estimates for the scan's
  own noise, added to every coordinate. **Half**: decimated by quadrics (fast-simplification) to
  half the triangles. **Turned**: edges turned at random wherever the two triangles allow it, the
  points as they were.
- **Again**: percent of the kept ones for which one of the same index is kept of the changed scan,
  within {errors:g} standard errors of both places, at least {nearest:g} and at most {farthest:g}
  edges; behind the stroke the same of the {few} most important. **Scale**: radius of the fits in
  edges of the scan, as it is and of the three.

| Scan | Vertices | Kept | Noise: again | Half: again | Turned: again | Scale |
|---|---|---|---|---|---|---|
"""


def turned(vertices: np.ndarray, triangles: np.ndarray, seed: int) -> np.ndarray:
    """The triangles (m, 3) with edges turned at random."""
    random, triangles = np.random.default_rng(seed), triangles.copy()
    n = len(vertices)
    for _ in range(TURNS):
        tail, head = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
        over = np.roll(triangles, -2, axis=1).ravel()
        # The half-edge that comes back: the same two ends the other way round.
        forward, back = tail * n + head, head * n + tail
        order = np.argsort(forward)
        place = np.minimum(np.searchsorted(forward[order], back), len(order) - 1)
        twin = np.where(forward[order[place]] == back, order[place], -1)
        one = np.flatnonzero((twin >= 0) & (tail < head))
        two = twin[one]
        p, q, c, d = tail[one], head[one], over[one], over[two]
        edge = np.minimum(c, d) * n + np.maximum(c, d)
        _, first, number = np.unique(edge, return_index=True, return_counts=True)
        fresh = np.zeros(len(one), bool)
        fresh[first[number == 1]] = True
        fresh &= ~np.isin(c * n + d, forward) & ~np.isin(d * n + c, forward)
        before = [_normal(vertices, p, q, c), _normal(vertices, q, p, d)]
        after = [_normal(vertices, d, q, c), _normal(vertices, c, p, d)]
        mean = _unit(_unit(before[0]) + _unit(before[1]))
        fits = fresh
        for normal in after:
            fits = fits & (np.einsum("ij,ij->i", _unit(normal), mean) > FLAT)
        least = [np.minimum(*(np.linalg.norm(x, axis=1) for x in some)) for some in (before, after)]
        fits &= least[1] > FAT * least[0]
        # Those whose lot is the highest in both their triangles touch no others.
        lot = np.where(fits, random.random(len(one)), 0.0)
        highest = np.zeros(len(triangles))
        np.maximum.at(highest, one // 3, lot)
        np.maximum.at(highest, two // 3, lot)
        chosen = np.flatnonzero((lot > 0) & (lot == highest[one // 3]) & (lot == highest[two // 3]))
        triangles[one[chosen] // 3] = np.column_stack([d, q, c])[chosen]
        triangles[two[chosen] // 3] = np.column_stack([c, p, d])[chosen]
    return triangles


def _normal(vertices: np.ndarray, a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    return np.cross(vertices[b] - vertices[a], vertices[c] - vertices[a])


def _unit(vectors: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / np.maximum(length, np.finfo(float).tiny)


def changed(
    vertices: np.ndarray, triangles: np.ndarray, noise: float, seed: int = 0
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """The scan with noise, with half the triangles, and with turned edges."""
    yield vertices + noise * np.random.default_rng(seed).normal(size=vertices.shape), triangles
    fewer, left = fast_simplification.simplify(
        vertices.astype(np.float32), triangles.astype(np.int32), 0.5
    )
    yield fewer.astype(float), left.astype(np.int64)
    yield vertices, turned(vertices, triangles, seed)


def kept_again(umbilics: core.Umbilics, others: core.Umbilics, edge: float) -> np.ndarray:
    """(k,) bool, umbilics for which one of the same index is among the others."""
    if not len(others):
        return np.zeros(len(umbilics), bool)
    away = np.linalg.norm(umbilics.position[:, None] - others.position, axis=2)
    error = np.hypot(umbilics.uncertainty[:, None], others.uncertainty)
    reach = np.clip(ERRORS * error, NEAREST * edge, FARTHEST * edge)
    same = umbilics.index[:, None] == others.index
    return np.asarray((same & (away <= reach)).any(axis=1))


def row(name: str, vertices: np.ndarray, triangles: np.ndarray) -> str:
    """A line of the page."""
    detection = core.detect(vertices, triangles)
    kept = detection.umbilics
    sides = vertices[triangles] - vertices[np.roll(triangles, 1, axis=1)]
    edge = float(np.linalg.norm(sides, axis=2).mean())
    best = np.argsort(-kept.importance, kind="stable")[:FEW]
    cells, scales = [], [detection.scale / edge]
    for other, faces in changed(vertices, triangles, detection.noise):
        found = core.detect(other, faces)
        again = kept_again(kept, found.umbilics, edge)
        cells.append(f"{100 * again.mean():.0f} / {100 * again[best].mean():.0f}")
        scales.append(found.scale / edge)
    reach = ", ".join(f"{scale:.1f}" for scale in scales)
    return f"| {name} | {len(vertices)} | {len(kept)} | {' | '.join(cells)} | {reach} |\n"


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="benchmarks.stability", description=__doc__)
    beside = ROOT.parent / "shared" / "meshes"
    parser.add_argument(
        "--meshes", type=Path, default=Path(os.environ.get("UMBILICS_MESHES", beside))
    )
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "stability.md")
    options = parser.parse_args(arguments)
    text = HEADER.format(errors=ERRORS, nearest=NEAREST, farthest=FARTHEST, few=FEW)
    for name in SCANS:
        print(name, file=sys.stderr)
        vertices, triangles = read_mesh(options.meshes / name)
        used, place = np.unique(triangles, return_inverse=True)
        text += row(name, vertices[used], place.reshape(triangles.shape))
    return publish(text, options.out)


if __name__ == "__main__":
    sys.exit(main())
