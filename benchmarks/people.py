"""The meshes that people have: known surfaces without symmetry, meshed badly.

Used by `benchmarks.accuracy --meshes`, which needs tools/benchmark_requirements.txt.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from surfaces import (
    ImplicitSurface,
    cayley,
    cosines,
    genus_five,
    genus_two,
    metaballs,
    random_field,
    random_harmonics,
    superquadric,
)

import core

from .cages import BLIND
from .cages import cases_of as cage_cases
from .cases import Case
from .ceiling import DEGREES, WINDOWS, determined
from .meshes import DENSE, KINDS, projected_voxels
from .peers.cgal import Cgal
from .peers.quadric import quadric_umbilics
from .scoring import RESOLVED, Tally, tally

NOISES = (0.005, 0.02, 0.05)
NOISY_KINDS = ("regular", "random")

HEADER = """# Accuracy on the meshes that people have

{count} surfaces without symmetry, or with all of it, whose umbilics are known to 1e-9: random
harmonics of a sphere, random fields and metaballs (seeds {seeds}), x² + y² + z² + xyz = 1 (8 stars,
12 monstars), cos x + cos y + cos z = 3/2, a superquadric, surfaces of genus 2 and 5. Default
settings. Written by `benchmarks/accuracy --meshes`.

Cages: closed ones of 62 quads, drawn at random (seeds {seeds}), after Catmull and Clark; the limit
surface is exact, its umbilics are read off a mesh of a quarter of a million vertices.

- **Mesh**: *regular* and *random* on the surface with 10,000 vertices, and with *noise*: standard
  deviation of each coordinate in percent of the edges around the vertex; *coarse*: 640 and 1,500
  vertices; *marching cubes* (scikit-image) with so many cells along a side; *decimated* by quadrics
  (fast-simplification) to so many triangles; *cage*: subdivided so often, on the limit surface.
  Within {blind:g} edges of its extraordinary vertices, where curvature is not continuous,
  nothing counts.
- **True**: umbilics that the mesh can resolve, {resolved:g} local edges or more from the next.
- **Determined**: of these, the ones whose place the mesh determines to an edge: at their places the
  best of {fits} windows and degrees has the deviator less wrong, in the median of the mesh, than it
  changes by over one edge. It takes the truth to choose so (`benchmarks/ceiling.py`).
- **Found**, of all and of these: with the right index within 2 edges; in brackets within 5.
  **False**: those that no true one, resolved or not, has the index of within 5 edges (16 around one
  of index +1).
  **Certain, false**: of these, marked certain. **Kind**: right, "uncertain", wrong.
- **Quadric**: degree two over five rings, every umbilic that results, found and false.
- **CGAL**: {cgal}.

"""
COLUMNS = (
    "Mesh", "True", "Found", "Determined", "Found of these", "False", "Certain, false", "Kind",
    "Σ = χ", "Quadric found", "Quadric false", "CGAL found", "CGAL false",
)  # fmt: skip


@dataclass(frozen=True)
class Row:
    """One mesh: what was found by us, by the plain quadric, and by CGAL if there is one."""

    label: str
    ours: Tally
    sum_is_right: bool
    quadric: Tally
    cgal: Tally | None


def surfaces_of(seeds: Iterable[int]) -> list[ImplicitSurface]:
    """The surfaces; the named ones come with seed 0."""
    found: list[ImplicitSurface] = []
    for seed in seeds:
        if seed == 0:
            found += [cayley(), cosines(), superquadric(), genus_two(), genus_five()]
        found += [random_harmonics(seed), random_field(seed), metaballs(seed)]
    return found


def cases_of(surface: ImplicitSurface, seed: int) -> Iterator[Case]:
    """All meshes of a surface."""
    dense = None if surface.round else projected_voxels(surface, DENSE)
    truth = surface.umbilics(dense)
    for kind, make in KINDS.items():
        vertices, triangles = make(surface, seed)
        case = Case(surface.name, kind, 0.0, vertices, triangles, truth, euler=surface.euler)
        yield case
        for noise in NOISES if kind in NOISY_KINDS else ():
            yield case.with_noise(noise, seed)


def measure(case: Case, cgal: Cgal | None, surface: ImplicitSurface | None = None) -> Row:
    """Run the default detection and the others on a case, of which the `surface` tells what the
    mesh determines."""
    detection = core.detect(case.vertices, case.triangles)
    kept = detection.umbilics
    position, index = quadric_umbilics(case.vertices, case.triangles)
    peer = None
    if cgal is not None:
        vertex, peer_index = cgal.umbilics(case.vertices, case.triangles)
        peer = tally(case, case.vertices[vertex], peer_index)
    return Row(
        label=f"{case.mesh}, noise {100 * case.noise:g} %" if case.noise else case.mesh,
        ours=tally(
            case,
            kept.position,
            kept.index,
            kept.kind,
            kept.certain,
            None if surface is None else determined(case, surface),
        ),
        sum_is_right=detection.index_sum == case.euler,
        quadric=tally(case, position, index),
        cgal=peer,
    )


def table(rows: list[Row]) -> str:
    """Markdown, one line a kind of mesh."""
    lines = ["| " + " | ".join(COLUMNS) + " |", "|" + "---|" * len(COLUMNS)]
    for label in dict.fromkeys(row.label for row in rows):
        some = [row for row in rows if row.label == label]
        ours = Tally.sum([row.ours for row in some])
        quadric = Tally.sum([row.quadric for row in some])
        peers = [row.cgal for row in some if row.cgal is not None]
        peer = Tally.sum(peers)
        cells = [
            label,
            str(ours.true),
            f"{ours.found} ({ours.near})",
            str(ours.determined or ""),
            str(ours.determined_found) if ours.determined else "",
            str(ours.false),
            str(ours.certain_false),
            f"{ours.kinds_right}, {ours.kinds_uncertain}, {ours.kinds_wrong}",
            "✓" if all(row.sum_is_right for row in some) else "**✗**",
            str(quadric.found),
            str(quadric.false),
            str(peer.found) if peers else "",
            str(peer.false) if peers else "",
        ]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def page(seeds: Iterable[int], cgal: Cgal | None, about: str, say) -> str:
    """The page of the benchmark; `say` is told each surface as it begins."""
    seeds = list(seeds)
    rows: list[Row] = []
    surfaces = surfaces_of(seeds)
    for number, surface in enumerate(surfaces):
        say(surface.name)
        rows += [measure(case, cgal, surface) for case in cases_of(surface, seeds[0] + number)]
    for seed in seeds:
        say(f"cage {seed}")
        rows += [measure(case, cgal) for case in cage_cases(seed)]
    header = HEADER.format(
        count=len(surfaces),
        seeds=", ".join(map(str, seeds)),
        resolved=RESOLVED,
        blind=BLIND,
        fits=len(WINDOWS) * len(DEGREES),
        cgal=about,
    )
    return header + table(rows)
