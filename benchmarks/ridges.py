"""Crest lines against surfaces whose crests are known: docs/ridges.md.

    benchmarks/ridges [--surfaces N] [--out FILE]

Marching cubes need scikit-image, decimated meshes fast-simplification; what is missing is left
out. CGAL's Ridges_3 is built and run on the same meshes where it and a C++ compiler are installed.
"""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

import core

from . import ROOT
from .pages import machine, publish, table
from .peers.cgal import RIDGES, Cgal, CgalError
from .ridge_surfaces import CELLS, COUNT, MESHES, Implicit, meshed, surfaces, with_end

NOISES = (0.0, 0.02, 0.05)
# A point of a line within this many edges of a true one has found it.
REACH = 1.0
# True lines shorter than so many edges are none that a mesh could show: what is missed is told
# without them and with them.
SHOWN = 3.0
# Lines are measured at points so many to an edge.
SAMPLES = 4

PAGE = """# Ridges

Crest lines found on surfaces whose crests are known, with the default settings. Written by
`benchmarks/ridges` on {machine}.

- **Meshes**: about {count:,} vertices. *icosphere*: subdivided and turned (the torus: a grid).
  *random*: uniformly random points, Delaunay triangles. *marching cubes*: scikit-image, {cells}
  cells along the longest side. *decimated*: a mesh four times as large, fast-simplification.{left}
- **Noise**: standard deviation of each coordinate, in percent of the mean edge around the vertex.
- **Truth**: the zeros of the derivative of a principal curvature along its own line, by exact
  second derivatives, drawn on a mesh of 327,680 triangles.
- **Distance**: mean distance from the true crests, in edges, of what lies within {reach:g} edge.
  **Missed**: share of the true length with no line within {reach:g} edge, of lines longer than
  {shown:g} edges (x⁴ + y⁴ + z⁴ = 1 has 24 shorter ones beside its corners); **of all**: of every
  true line. **False**: length of
  lines farther than that from every true one, in percent of the true length (on the torus, which
  has no crest, in lengths of its equator).
- **Time**: of the ridges, in times of the whole detection of umbilics on the same mesh.
- **CGAL**: {cgal}.

{table}
"""
CGAL_RAN = (
    "version {version}, `compute_crest_ridges` with jets of degree 4 over as few whole rings as "
    "hold their 15 coefficients, lines as they come: it has no measure of noise to filter them by"
)
COLUMNS = (
    "Surface", "Mesh", "Noise %", "Lines", "Distance", "Missed %", "of all %", "False %", "Time",
    "CGAL distance", "CGAL missed %", "CGAL false %",
)  # fmt: skip


@dataclass(frozen=True)
class Score:
    """Mean distance in edges of what is near, and shares of the true length: missed of lines that a
    mesh could show, missed of all, and false."""

    distance: float
    missed: float
    missed_of_all: float
    false: float

    def cells(self) -> tuple[str, str, str, str]:
        distance = "" if np.isnan(self.distance) else f"{self.distance:.2f}"
        missed, of_all = (
            "" if np.isnan(share) else f"{100 * share:.1f}"
            for share in (self.missed, self.missed_of_all)
        )
        return distance, missed, of_all, f"{100 * self.false:.1f}"


def sampled(lines: list[np.ndarray], step: float) -> tuple[np.ndarray, np.ndarray]:
    """Points (p, 3) at most a step apart on lines, and the length (p,) that each stands for."""
    points, lengths = [np.zeros((0, 3))], [np.zeros(0)]
    for line in lines:
        chord = np.diff(line, axis=0)
        length = np.linalg.norm(chord, axis=1)
        count = np.maximum(np.ceil(length / step).astype(int), 1)
        row = np.repeat(np.arange(len(count)), count)
        within = np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count)
        share = (within + 0.5) / count[row]
        points.append(line[row] + share[:, None] * chord[row])
        lengths.append((length / count)[row])
    return np.concatenate(points), np.concatenate(lengths)


def scored(lines: list[np.ndarray], truth: list[np.ndarray], edge: float, whole: float) -> Score:
    """Lines against true ones; `whole` is the length that stands for the truth where it is none."""
    found, length = sampled(lines, edge / SAMPLES)
    true, true_length = sampled(truth, edge / SAMPLES)
    if not len(true):
        return Score(np.nan, np.nan, np.nan, length.sum() / whole)
    if not len(found):
        return Score(np.nan, 1.0, 1.0, 0.0)
    away = cKDTree(true).query(found)[0] / edge
    near = away <= REACH
    shown, shown_length = sampled([line for line in truth if _long(line, edge)], edge / SAMPLES)
    tree = cKDTree(found)
    missed, missed_of_all = (tree.query(points)[0] > REACH * edge for points in (shown, true))
    return Score(
        float(np.average(away[near], weights=length[near])) if near.any() else np.nan,
        shown_length[missed].sum() / max(shown_length.sum(), np.finfo(float).tiny),
        true_length[missed_of_all].sum() / true_length.sum(),
        length[~near].sum() / true_length.sum(),
    )


def _long(line: np.ndarray, edge: float) -> bool:
    return bool(np.linalg.norm(np.diff(line, axis=0), axis=1).sum() >= SHOWN * edge)


def with_noise(
    vertices: np.ndarray, triangles: np.ndarray, noise: float, seed: int = 1
) -> np.ndarray:
    """Every coordinate moved by normal deviates of `noise` times the edges around it."""
    sides = np.linalg.norm(vertices[triangles] - vertices[triangles[:, [1, 2, 0]]], axis=2)
    both = 0.5 * (sides + np.roll(sides, 1, axis=1)).ravel()
    count = np.bincount(triangles.ravel(), minlength=len(vertices))
    around = np.bincount(triangles.ravel(), both, len(vertices)) / np.maximum(count, 1)
    shift = np.random.default_rng(seed).normal(size=vertices.shape)
    return vertices + noise * around[:, None] * shift


def measured(
    surface: Implicit,
    truth: list[np.ndarray],
    vertices: np.ndarray,
    triangles: np.ndarray,
    cgal: Cgal | None,
) -> tuple[int, Score, float, Score | None]:
    """How many lines, their score, the time in detections, and CGAL's score."""
    sides = vertices[triangles] - vertices[triangles[:, [1, 2, 0]]]
    edge = float(np.linalg.norm(sides, axis=2).mean())
    whole = 2 * np.pi * float(surface.half[0])
    begin = time.process_time()
    detection = core.detect(vertices, triangles)
    middle = time.process_time()
    guide = core.Guide(vertices, triangles, detection)
    lines = guide.ridges()
    end = time.process_time()
    points = [
        with_end(lines.points(number), bool(lines.closed[number])) for number in range(len(lines))
    ]
    peer = None if cgal is None else scored(cgal.ridges(vertices, triangles), truth, edge, whole)
    ours = scored(points, truth, edge, whole)
    return len(lines), ours, (end - middle) / (middle - begin), peer


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="benchmarks.ridges", description=__doc__)
    parser.add_argument("--surfaces", type=int, default=6, help="the first so many (6)")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "ridges.md")
    options = parser.parse_args(arguments)
    where = machine()
    try:
        cgal: Cgal | None = Cgal(RIDGES)
        about = CGAL_RAN.format(version=cgal.version)
    except CgalError as error:
        cgal, about = None, f"left out of this run, because {error}"
    rows, left = [], set()
    for surface in surfaces()[: options.surfaces]:
        truth = surface.crests()
        for mesh in MESHES:
            made = meshed(surface, mesh)
            if made is None:
                if surface.round_:
                    left.add(mesh)
                continue
            for noise in NOISES:
                print(f"{surface.name}, {mesh}, {100 * noise:g} %", file=sys.stderr)
                moved = with_noise(*made, noise)
                count, ours, ratio, peer = measured(surface, truth, moved, made[1], cgal)
                cells = (surface.name, mesh, f"{100 * noise:g}", str(count))
                # What a mesh could show is all that counts of the other's lines, too.
                theirs = tuple(np.delete(peer.cells(), 2).tolist()) if peer else ("", "", "")
                rows.append((*cells, *ours.cells(), f"{ratio:.1f}", *theirs))
    missing = f" Left out for want of a package: {', '.join(sorted(left))}." if left else ""
    text = PAGE.format(
        machine=where,
        count=COUNT,
        cells=CELLS,
        left=missing,
        reach=REACH,
        shown=SHOWN,
        cgal=about,
        table=table(COLUMNS, rows),
    )
    return publish(text, options.out)


if __name__ == "__main__":
    raise SystemExit(main())
