"""Where separatrices end and how lines of curvature turn, on real meshes: docs/lines.md.

    benchmarks/lines [MESH ...] [--out FILE]

Without names, some of the meshes in $UMBILICS_MESHES or ../shared/meshes, which are no part of the
repository, and a vase whose waist and belly are circles of umbilics.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
from mesh_files import read_mesh
from scipy import sparse
from scipy.sparse import csgraph
from scipy.spatial import cKDTree
from surfaces.revolution import revolved, vase

import core
from core.base.unit import unit
from core.retopology.lines.polylines import Lines
from core.retopology.lines.separatrices import BUNDLED, ENDS, RUN
from core.retopology.lines.streamlines import spacing_of

from . import ROOT
from .pages import machine, publish, table

SHAPES = (
    "spot_os.obj", "hand_closed_os.obj", "rocker-arm.obj", "bunny_hr_os.obj", "stanford-bunny.obj",
    "face_gpjs.obj", "torso_vtk.obj", "boat_os.obj", "goblet_vtk.stl", "wingnut_os.obj",
    "fandisk.obj", "double-torus_gpjs.obj", "sword_quaddom_os.obj", "beetle_bff.obj",
    "makehuman_hm08_base.obj", "plane_holes_os.obj", "dragon_vrip_res4.ply",
)  # fmt: skip
# Degrees by which no last chord of a separatrix, and no line of curvature at a point, should turn.
LAST, TURN = 60.0, 80.0
ARRIVED = ("umbilic", "region", "border", "feature")

PAGE = """# Lines

Written by `benchmarks/lines` on {machine}, with the default settings.

- **Separatrices**: how many, each arc once. **Arrive**: the share of them that end at an umbilic, a
  region, a border or a feature, and how many end at each. The others come to the **limit** of
  their length, a **turn** that is too sharp, or to **themselves**.
- **Last**: of those that end at an umbilic, how many turn to it by more than {last:g} degrees at
  the last point before it.
- **Beside**: share of their length along which two of one family run beside each other, nearer
  than a quarter of the spacing of lines of curvature for longer than {run:g} times that.
- **Lines**: lines of curvature, and how many of them **turn** somewhere by more than {turn:g}
  degrees. Those are measured from triangle to triangle, laid side by side, last turns seen along
  the normal.
- **Poles**: of the plan, and in how many the field of the faces (the file `.sing`) differs from it:
  each pole has a singular vertex of its own kind and its own for a corner of its triangle.

{table}

The vase is r = 2 + cos z, whose lines cross two circles of umbilics.
"""
COLUMNS = (
    "Shape", "Separatrices", "Arrive %", *ARRIVED, "limit", "turn", "itself", "Last", "Beside %",
    "Lines", "Turn", "Poles", "Differ",
)  # fmt: skip


def turns(lines: Lines) -> np.ndarray:
    """(l,) the largest turn of each line from one chord to the next, in degrees between planes laid
    side by side.

    The plane of a chord is that of its triangle; where it does not lie in it, since points were
    left out, that plane turned about the chord's foot until it does.
    """
    found = np.zeros(len(lines))
    for number in range(len(lines)):
        begin, end = lines.start[number : number + 2]
        points, across = lines.position[begin:end], lines.normal[begin:end]
        if lines.closed[number]:
            points, across = np.vstack([points, points[:2]]), np.vstack([across, across[:2]])
        chord, across = np.diff(points, axis=0), across[1:]
        size = np.linalg.norm(chord, axis=1)
        chord, across = chord[size > 0.0] / size[size > 0.0, None], across[size > 0.0]
        across = unit(across - np.einsum("qc,qc->q", chord, across)[:, None] * chord)
        one, two, here, there = chord[:-1], chord[1:], across[:-1], across[1:]
        axis, cosine = np.cross(there, here), np.einsum("qc,qc->q", there, here)
        along = np.einsum("qc,qc->q", axis, two) / np.maximum(1.0 + cosine, 1e-9)
        two = cosine[:, None] * two + np.cross(axis, two) + along[:, None] * axis
        found[number] = _angle(one, two, here).max(initial=0.0)
    return found


def last_turns(lines: Lines) -> np.ndarray:
    """(l,) degrees between the last chord of each line and the one before, seen along the normal at
    the point between; 0 where there is none."""
    found = np.zeros(len(lines))
    for number in np.flatnonzero(np.diff(lines.start) > 2):
        end = lines.start[number + 1]
        one, two = np.diff(lines.position[end - 3 : end], axis=0)
        found[number] = _angle(one[None], two[None], lines.normal[end - 2][None])[0]
    return found


def _angle(one: np.ndarray, two: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """(q,) degrees between chords (q, 3) in the planes of normals."""
    one, two = (
        some - np.einsum("qc,qc->q", some, normal)[:, None] * normal for some in (one, two)
    )
    sine = np.einsum("qc,qc->q", np.cross(one, two), normal)
    return np.degrees(np.abs(np.arctan2(sine, np.einsum("qc,qc->q", one, two))))


def beside(lines: Lines, apart: float) -> float:
    """Share of the length of lines along which another of the same family runs beside them, nearer
    than `apart` for longer than `RUN` times that."""
    place, line, step, seen = [np.zeros((0, 3))], [np.zeros(0, int)], 0.25 * apart, set()
    for number in range(len(lines)):
        points = lines.points(number)
        for one, two in pairwise(points):
            # What lines that go on as one have in common is one.
            ends = frozenset((one.tobytes(), two.tobytes()))
            if ends in seen:
                continue
            seen.add(ends)
            count = int(np.ceil(np.linalg.norm(two - one) / step))
            place.append(one + (np.arange(count)[:, None] + 0.5) / max(count, 1) * (two - one))
            line.append(np.full(count, number))
    points, owner = np.concatenate(place), np.concatenate(line)
    near = np.zeros(len(points), bool)
    pairs = cKDTree(points).query_pairs(apart, output_type="ndarray")
    one, two = owner[pairs].T
    pairs = pairs[(one != two) & (lines.family[one] == lines.family[two])]
    near[pairs] = True
    # Runs of points in a row.
    long = np.zeros(len(points), bool)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], near.astype(int), [0]])))
    for begin, end in edges.reshape(-1, 2):
        for number in np.unique(owner[begin:end]):
            rows = begin + np.flatnonzero(owner[begin:end] == number)
            long[rows] = len(rows) * step > RUN * apart
    return float(long.mean()) if len(long) else 0.0


def differing(guide: core.Guide, guidance: core.Guidance, triangles: np.ndarray) -> int:
    """Quarters of index that the field of the faces has and the plan has not, or the other way: a
    singular vertex is that of a pole of its kind that has it for a corner of its triangle."""
    vertex, quarters = guide.singular_vertices(guidance)
    poles = guidance.poles
    count = 0
    for sign in (1, -1):
        mine = np.repeat(vertex, np.maximum(sign * quarters, 0))
        planned = np.repeat(poles.triangle, np.maximum(sign * (4 - poles.valence), 0))
        reach = (triangles[planned][:, :, None] == mine).any(axis=1)
        own = csgraph.maximum_bipartite_matching(sparse.csr_array(reach), perm_type="column") >= 0
        count += len(mine) + len(planned) - 2 * int(np.count_nonzero(own))
    return count


def row_of(name: str, vertices: np.ndarray, triangles: np.ndarray) -> tuple[str, ...]:
    """The cells of one shape."""
    guide = core.Guide(vertices, triangles, core.detect(vertices, triangles))
    settings = core.GuidanceSettings()
    found = guide.separatrices()
    ends = [int((found.end == ENDS.index(kind)).sum()) for kind in (*ARRIVED, "limit", "turn")]
    ends.append(int((found.end == ENDS.index("itself")).sum()))
    arrive = sum(ends[: len(ARRIVED)]) / max(len(found), 1)
    reached = found.target >= 0
    late = last_turns(found)[reached] > LAST
    apart = BUNDLED * spacing_of(guide.surface, settings) * guide.surface.unit
    try:
        lines = guide.lines()
        drawn = (str(len(lines)), str(int((turns(lines) > TURN).sum())))
    except core.UmbilicsError:
        drawn = ("0", "")
    guidance = guide.guidance()
    return (
        name,
        str(len(found)),
        f"{100 * arrive:.1f}" if len(found) else "",
        *map(str, ends),
        str(int(late.sum())),
        f"{100 * beside(found, apart):.1f}" if len(found) else "",
        *drawn,
        str(len(guidance.poles)),
        str(differing(guide, guidance, triangles)),
    )


def shapes(named: list[Path]) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Name, vertices and triangles of each."""
    if named:
        for path in named:
            yield path.stem, *read_mesh(path)
        return
    folder = Path(os.environ.get("UMBILICS_MESHES") or ROOT.parent / "shared" / "meshes")
    for name in SHAPES:
        if (folder / name).is_file():
            yield Path(name).stem, *read_mesh(folder / name)
        else:
            print(f"{name} is not in {folder}: left out.", file=sys.stderr)
    yield "vase", *revolved(vase, 2.0 * np.pi, 128, 256)


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="benchmarks/lines", description=__doc__)
    parser.add_argument("meshes", type=Path, nargs="*", help="OBJ, PLY or STL files")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "lines.md")
    options = parser.parse_args(arguments)
    where, rows = machine(), []
    for name, vertices, triangles in shapes(options.meshes):
        print(name, file=sys.stderr)
        rows.append(row_of(name, vertices, triangles))
    text = PAGE.format(machine=where, last=LAST, turn=TURN, run=RUN, table=table(COLUMNS, rows))
    return publish(text, options.out)


if __name__ == "__main__":
    raise SystemExit(main())
