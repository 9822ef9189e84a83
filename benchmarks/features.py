"""What the features and the smoothness of the cross field do to the poles: docs/features.md.

    benchmarks/features [MESH ...] [--out FILE]

Without names, some of the meshes in $UMBILICS_MESHES or ../shared/meshes, which are no part of the
repository, and some that are made here.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mesh_files import read_mesh
from scipy.sparse import csgraph
from scipy.spatial import cKDTree
from surfaces import ellipsoid, noisy, quartic, random_ellipsoid

import core
from core.fields.transport import carried
from core.mesh.creases import bent_half_edges
from core.mesh.input_map import places_on_surface
from core.mesh.rings import adjacency
from core.mesh.surface import Surface
from core.retopology.field.near_pairs import DETOUR
from core.retopology.poles import Poles

from . import ROOT
from .loop_subdivision import loop_subdivided
from .pages import machine, publish, table
from .random_surfaces import largest

SHAPES = (
    "spot_os.obj", "hand_closed_os.obj", "rocker-arm.obj", "suzanne.obj", "bunny_hr_os.obj",
    "skull_os.obj", "makehuman_hm08_base.obj", "fandisk.obj", "wingnut_os.obj",
    "plane_holes_os.obj", "cad_tray_tm.stl", "beetle_bff.obj", "double-torus_gpjs.obj",
)  # fmt: skip
# The automatic smoothness was chosen on the shapes above and on those made here, and confirmed on
# these.
CONFIRMED = ("face_gpjs.obj", "boat_os.obj", "sword_quaddom_os.obj", "stanford-bunny.obj")
# Levels by which a cage is subdivided first, as it is meant to be; and files of many pieces, of
# which the largest is the body.
SUBDIVIDED = {"suzanne.obj": 2}
BODIES = ("makehuman_hm08_base.obj",)
QUADS = 2000
"""Poles are too near each other within an edge of a mesh of so many quads."""

SMOOTHNESS = (0.3, 0.4, 0.5, 0.65)
TENTH = 1.1
# Degrees that can be seen.
SEEN = 0.5

PAGE = """# Features and smoothness

Written by `benchmarks/features` on {machine}.

Features are what the cross field runs along: creases, borders, marks. A crease is a chain of edges
that bend more than {angle:g} degrees, goes on, stands out of what noise and chance bend, and does
not swerve; a single edge of a rounded or rough surface is none
(`core/retopology/crease_chains.py`).

- **Bent**: edges that bend more than {angle:g} degrees. **Features**: those that are in creases,
  and borders.
- Each cell says **poles / angle / near**: how many poles; the mean angle in degrees between the
  cross field and the principal directions, by area and by how much these mean; and how many pairs
  of opposite poles stand nearer than an edge of a mesh of {quads:,} quads, and no farther than
  {detour:g} times that along the surface, over its edges: the two sides of a thin sheet are not
  near. A part of flat and round faces alone has no angle (nan).
- **Every bent edge**: all of them as features at smoothness 0.65, as it was before.
- **Default**: automatic smoothness, with creases only; then the same creases at fixed smoothness.
  Automatic is 0.45 or, of each connected part, the least of three below it (0.31, 0.36, 0.4) that
  has no more poles, within a tenth and those too near to an opposite one counted twice, and an
  angle that is half a degree better (`core/retopology/crosses/least_smoothing.py`). What these may
  cost was chosen on the other shapes, and confirmed on {confirmed}.
- **Beaten by**: fixed smoothness with no more poles and no larger angle than the default, and one
  of them better by more than a tenth (the angle by more than half a degree, too).

{subdivided}

{table}

## Before and after

By `python3 -m benchmarks.field_pictures --before CHECKOUT`: the default plan before the cross
field went by the measured directions and their errors (left) and now. Crosses, features in black,
poles of valence 3 in orange, of valence 5 in green. (Spot: Keenan Crane, CC0. Bunny: Stanford 3D
Scanning Repository. The skull is a CC BY work by an author whom its source does not name with it.)

{pictures}
"""
PICTURES = "\n\n".join(
    f"![{name} before and after](figures/field-{name}.png)"
    for name in ("rocker-arm", "spot_os", "bunny_hr_os", "skull_os")
)


@dataclass(frozen=True)
class Figures:
    """Poles, mean angle to the curvature in degrees, opposite poles that are too near."""

    poles: int
    angle: float
    near: int

    def __str__(self) -> str:
        return f"{self.poles} / {self.angle:.1f} / {self.near}"

    def beats(self, other: Figures) -> bool:
        """Whether this is better in one by more than a tenth, and in the other no worse."""
        if self.poles > other.poles or self.angle > other.angle:
            return False
        by_angle = self.angle < other.angle / TENTH and other.angle - self.angle > SEEN
        return self.poles < other.poles / TENTH or by_angle


def figures(
    guide: core.Guide, settings: core.GuidanceSettings, sharp: np.ndarray | None = None
) -> Figures:
    """Those of a plan with the given settings."""
    guidance = guide.guidance(settings, sharp=sharp)
    surface, field = guide.surface, guide.detection.curvature
    rows = surface.source_vertex
    normal, gap = guidance.normal[rows], field.gap[rows]
    along = carried(field.d1[rows], field.normal[rows], normal)
    cosine = np.abs(np.einsum("nc,nc->n", guidance.direction[rows], along)).clip(0.0, 1.0)
    angle = np.degrees(np.arccos(cosine))
    angle = np.minimum(angle, 90.0 - angle)
    area = np.bincount(
        surface.triangles.ravel(), np.repeat(surface.face_normal_area[1] / 3, 3), len(rows)
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        doubt = (4.0 * field.noise[rows] / gap) ** 2 + (0.15 * np.median(gap) / gap) ** 2
    weight = area * np.nan_to_num(1.0 / (1.0 + doubt))
    weight[surface.triangles[guide.undirected].ravel()] = 0.0
    edge = np.sqrt(surface.face_normal_area[1].sum() / QUADS) * surface.unit
    poles = guidance.poles
    near = near_pairs(surface, poles, edge) if len(poles) else 0
    mean = float(np.average(angle, weights=weight)) if weight.sum() else float("nan")
    return Figures(len(poles), mean, near)


def near_pairs(surface: Surface, poles: Poles, edge: float) -> int:
    """How many pairs of opposite poles are nearer than an edge, in the coordinates of the input,
    and joined by a way of up to `DETOUR` times that over the edges of the surface, or over the one
    edge between their triangles, which may be needles longer than that."""
    one, two = cKDTree(poles.position).query_pairs(edge, output_type="ndarray").T
    opposite = poles.valence[one] != poles.valence[two]
    one, two = one[opposite], two[opposite]
    triangle, _ = places_on_surface(surface, poles.triangle, poles.barycentric)
    corner = surface.triangles[triangle]
    place = (poles.position - surface.origin) / surface.unit
    offset = np.linalg.norm(surface.vertices[corner] - place[:, None], axis=2)
    graph = adjacency(surface, surface.ring_lengths)
    most, count = DETOUR * edge / surface.unit, 0
    for pole in np.unique(one):
        others = two[one == pole]
        away = csgraph.dijkstra(graph, indices=corner[pole], limit=most)
        away = (away + offset[pole][:, None]).min(axis=0)
        way = (away[corner[others]] + offset[others]).min(axis=1)
        near = (way <= most) | (triangle[others] == triangle[pole])
        for side in range(3):
            beyond = surface.twin[3 * triangle[pole] + side] // 3 == triangle[others]
            ends = surface.vertices[corner[pole, [side, (side + 1) % 3]]]
            near |= beyond & (_unfolded(place[pole], place[others], *ends) <= most)
        count += int(np.count_nonzero(near))
    return count


def _unfolded(
    one: np.ndarray, others: np.ndarray, tail: np.ndarray, head: np.ndarray
) -> np.ndarray:
    """(q,) distances of a point to others (q, 3) beyond an edge, both sides laid into a plane."""
    along = (head - tail) / max(float(np.linalg.norm(head - tail)), np.finfo(float).tiny)
    points = np.vstack([one[None], others]) - tail
    shift = points @ along
    height = np.linalg.norm(points - shift[:, None] * along, axis=1)
    return np.hypot(shift[1:] - shift[0], height[1:] + height[0])


def row_of(name: str, vertices: np.ndarray, triangles: np.ndarray) -> tuple[str, ...]:
    """The cells of one shape."""
    guide = core.Guide(vertices, triangles, core.detect(vertices, triangles))
    surface, default = guide.surface, core.GuidanceSettings()
    bent = bent_half_edges(surface, default.feature_angle)
    corners, following = surface.triangles.ravel(), surface.triangles[:, [1, 2, 0]].ravel()
    pairs = surface.source_vertex[np.stack([corners[bent], following[bent]], axis=1)]
    every = figures(guide, core.GuidanceSettings(smoothness=0.65, feature_angle=180.0), pairs)
    fixed = [figures(guide, core.GuidanceSettings(smoothness=value)) for value in SMOOTHNESS]
    count = len(guide.features(default).half_edge)
    usual = figures(guide, default)
    beaten = [f"{at:g}" for at, one in zip(SMOOTHNESS, fixed, strict=True) if one.beats(usual)]
    plans = (every, usual, *fixed)
    cells = (name, f"{len(triangles):,}", str(len(bent)), str(count), *map(str, plans))
    return (*cells, ", ".join(beaten))


def shapes(named: list[Path]) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Name, vertices and triangles of each."""
    if named:
        for path in named:
            yield path.stem, *read_mesh(path)
        return
    folder = Path(os.environ.get("UMBILICS_MESHES") or ROOT.parent / "shared" / "meshes")
    for name in (*SHAPES, *CONFIRMED):
        if (folder / name).is_file():
            mesh = read_mesh(folder / name)
            if name in BODIES:
                mesh = largest(*mesh)
            for _ in range(SUBDIVIDED.get(name, 0)):
                mesh = loop_subdivided(*mesh)
            yield Path(name).stem, *mesh
        else:
            print(f"{name} is not in {folder}: left out.", file=sys.stderr)
    made = {
        "ellipsoid 3 2 1": ellipsoid(),
        "ellipsoid 1.3 1 0.8, random": random_ellipsoid(5000, (1.3, 1.0, 0.8)),
        "ellipsoid 3 2 1, 5 % noise": noisy(ellipsoid(), 0.05),
        "x⁴ + y⁴ + z⁴ = 1": quartic(),
    }
    for name, mesh in made.items():
        yield name, mesh.vertices, mesh.triangles


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="benchmarks/features", description=__doc__)
    parser.add_argument("meshes", type=Path, nargs="*", help="OBJ, PLY or STL files")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "features.md")
    options = parser.parse_args(arguments)
    rows = []
    for name, vertices, triangles in shapes(options.meshes):
        print(name, file=sys.stderr)
        rows.append(row_of(name, vertices, triangles))
    names = ("Shape", "Triangles", "Bent", "Features", "Every bent edge", "Default")
    default = core.GuidanceSettings()
    levels = [f"{Path(name).stem} by {count}" for name, count in SUBDIVIDED.items()]
    bodies = ", ".join(Path(name).stem for name in BODIES)
    text = PAGE.format(
        subdivided=f"Levels of Loop's subdivision first: {', '.join(levels)}. The largest piece "
        f"only: {bodies}.",
        angle=default.feature_angle,
        quads=QUADS,
        detour=DETOUR,
        machine=machine(),
        pictures=PICTURES,
        confirmed=", ".join(Path(name).stem for name in CONFIRMED),
        table=table((*names, *(f"{value:g}" for value in SMOOTHNESS), "Beaten by"), rows),
    )
    return publish(text, options.out)


if __name__ == "__main__":
    raise SystemExit(main())
