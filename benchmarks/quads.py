"""Quad meshes beside those of other programs: docs/quads.md.

    benchmarks/quads [--quads N ...] [--meshes FOLDER] [--only NAME ...] [--out FILE]
    benchmarks/quads --speed [--quads N] [--only NAME ...] [--alone]
    benchmarks/quads --random FIRST LAST

The tables of other numbers of quads stay in the page. The second writes only the page's section on
speed: seconds by stage and memory, up to more than a million triangles, without the other programs
if asked for alone. The third remeshes random closed surfaces, numbered from 0, and prints every
guarantee that is not held; its exit status is how many surfaces have one.

Analytic and random surfaces are always there; real ones are read from the folder where it exists.
"""

from __future__ import annotations

import argparse
import itertools
import re
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from mesh_files import read_mesh
from quad_guarantees import broken_guarantees
from surfaces import cylinder, ellipsoid, quartic, sphere, torus

import core
from core.base.progress import Progress
from core.base.unit import unit
from core.retopology.quads.conformity import Conformity, conformity, scaled_jacobian
from core.retopology.quads.finishing.projection import ClosestPoints

from . import ROOT
from .loop_subdivision import loop_subdivided
from .pages import machine, table
from .peers.quad_meshers import PeerError, instant_meshes, quadriflow, run
from .quad_speed import Asked, speed_of, speed_section, with_speed
from .random_surfaces import random_surface

# Real surfaces: organic, scans, CAD, open, of genus 1 and 2.
FILES = (
    "spot_os.obj",
    "hand_closed_os.obj",
    "rocker-arm.obj",
    "bunny_hr_os.obj",
    "double-torus_gpjs.obj",
    "fandisk.obj",
    "wingnut_os.obj",
    "face_gpjs.obj",
    "suzanne.obj",
    "beetle_bff.obj",
    "skull_os.obj",
)
# Control cages, and levels of subdivision after which the directions are those of the surface.
CAGES = {"suzanne.obj": 3}
OURS = "Umbilics"
# Numbers of quads, few to many, that one surface is remeshed to where speed is measured.
MANY = (300, 20_000, 100_000)

PAGE = """# Quads beside those of other programs

Written by `benchmarks/quads`, each table by a run of its own.

*Angle*: degrees between the quads' directions and the principal directions of the input, weighed
with area and with the gap of the curvatures (the largest twentieth of it counting like the next).
Suzanne is a control cage of 500 faces: its angles are to the directions of its subdivision, the
surface that it stands for; those of its own triangles hang on how its faces were cut in two.
*Jacobian*: least and mean scaled Jacobian, and the mean that the irregular vertices leave at most:
where n sides meet the corners have 360°/n as a mean. *Off*: root mean square distance of the
vertices from the surface, in thousandths of its size. *Whole*: all quads, manifold, with the Euler
characteristic and the number of borders of the input. *Seconds* are by the clock, ours with the
detection.

{tables}
"""
_COLUMNS = (
    "Surface",
    "Program",
    "Quads",
    "Irregular",
    "Angle",
    "Jacobian",
    "Off",
    "Whole",
    "Seconds",
)


def surfaces(folder: Path) -> list[tuple[str, np.ndarray, np.ndarray]]:
    """Name, vertices and triangles of everything that is remeshed."""
    analytic = {
        "sphere": sphere(),
        "ellipsoid 3:2:1": ellipsoid(),
        "x⁴+y⁴+z⁴=1": quartic(),
        "torus": torus(),
        "cylinder": cylinder(),
    }
    found = [(name, mesh.vertices, mesh.triangles) for name, mesh in analytic.items()]
    found += [(f"bumps {seed}", *bumpy(seed)) for seed in range(4)]
    for name in FILES:
        if (folder / name).exists():
            found.append((name, *read_mesh(folder / name)))
    return found


def large_surfaces(folder: Path, quads: int) -> list[Asked]:
    """What speed is measured on: many at the same number of quads, one at very few and very many,
    and a scan made finer."""
    even = sphere()
    found = [Asked("sphere", even.vertices, even.triangles, quads)]
    found.append(Asked("bumps 2", *bumpy(2), quads))
    names = ("spot_os", "hand_closed_os", "rocker-arm", "face_gpjs", "bunny_hr_os", "skull_os")
    files = {name: folder / f"{name}.obj" for name in names}
    meshes = {name: read_mesh(path) for name, path in files.items() if path.exists()}
    found += [Asked(name, *mesh, quads) for name, mesh in meshes.items()]
    levels = {"bumps 0": 5, "bumps 0, finer": 6, "bumps 0, finest": 8}
    found += [Asked(name, *bumpy(0, level), quads) for name, level in levels.items()]
    if "skull_os" in meshes:
        found += [Asked("skull_os", *meshes["skull_os"], many) for many in MANY]
    if "bunny_hr_os" in meshes:
        finer = loop_subdivided(*loop_subdivided(*meshes["bunny_hr_os"]))
        found += [Asked("bunny_hr_os, finest", *finer, many) for many in (quads, 10 * quads)]
    return found


def bumpy(seed: int, subdivisions: int = 5) -> tuple[np.ndarray, np.ndarray]:
    """A random smooth closed surface, of 20,480 triangles if not said otherwise."""
    mesh, random = sphere(subdivisions=subdivisions), np.random.default_rng(seed)
    direction = random.normal(size=(14, 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    height = sum(
        0.12 * random.normal() * np.cos(3.0 * mesh.vertices @ axis + random.uniform(0, 6))
        for axis in direction
    )
    return mesh.vertices * np.maximum(1.0 + height, 0.3)[:, None], mesh.triangles


class Directions:
    """The principal directions of a surface, for quads to be measured against."""

    def __init__(self, vertices: np.ndarray, triangles: np.ndarray) -> None:
        self.detection = core.detect(vertices, triangles)
        guide = core.Guide(vertices, triangles, self.detection)
        self.surface = guide.surface
        self.frames = guide.planes(Progress())
        self.closest = ClosestPoints(
            self.surface.vertices, self.surface.triangles, self.surface.twin
        )

    def angle(self, vertices: np.ndarray, quads: np.ndarray) -> float:
        """Mean angle in degrees to the principal directions, weighed with area and gap."""
        at = ((vertices - self.surface.origin) / self.surface.unit)[quads]
        normal = np.cross(at[:, 2] - at[:, 0], at[:, 3] - at[:, 1])
        row, _ = self.closest(at.mean(axis=1))
        deviator = self.frames.deviator(row, self.frames.corner[row].mean(axis=1))
        corner = self.surface.vertices[self.surface.triangles[row]]
        x = unit(corner[:, 1] - corner[:, 0])
        y = np.cross(self.closest.normal[row], x)
        axis = np.zeros(len(quads), complex)
        for turn, along in (
            (1.0, at[:, 1] - at[:, 0] + at[:, 2] - at[:, 3]),
            (-1j, at[:, 3] - at[:, 0] + at[:, 2] - at[:, 1]),
        ):
            value = np.einsum("qc,qc->q", along, x) + 1j * np.einsum("qc,qc->q", along, y)
            axis += turn * value / np.maximum(np.abs(value), np.finfo(float).tiny)
        off = np.angle(axis) - 0.5 * np.angle(deviator)
        off = np.degrees(np.abs(off - 0.5 * np.pi * np.rint(off / (0.5 * np.pi))))
        gap = np.minimum(np.abs(deviator), np.quantile(np.abs(deviator), 0.95))
        weight = np.linalg.norm(normal, axis=1) * gap
        return float((weight * off).sum() / weight.sum()) if weight.sum() > 0 else float("nan")


class Judge:
    """What quads are measured against: an input surface and its curvature.

    The directions of a control cage are those of the surface that it stands for, its subdivision
    by so many `levels`: those of its own triangles hang on how its quads were cut.
    """

    def __init__(self, vertices: np.ndarray, triangles: np.ndarray, levels: int = 0) -> None:
        self.directions = Directions(vertices, triangles)
        surface = self.surface = self.directions.surface
        self.closest = self.directions.closest
        if levels:
            place, cage = surface.vertices * surface.unit + surface.origin, surface.triangles
            for _ in range(levels):
                place, cage = loop_subdivided(place, cage)
            self.directions = Directions(place, cage)

    def row(self, vertices: np.ndarray, quads: np.ndarray) -> list[str]:
        """Cells of the table from the number of quads to whether they are whole."""
        surface = self.surface
        place = (vertices - surface.origin) / surface.unit
        topology = conformity(quads, len(place))
        irregular = (topology.valence != 4) & (topology.valence > 0) & ~topology.border
        whole = (
            topology.manifold
            and topology.characteristic == surface.euler_characteristic.sum()
            and surface.closed.all() == (not topology.border.any())
        )
        jacobian = scaled_jacobian(place, quads)
        _, on = self.closest(place)
        off = np.sqrt(((place - on) ** 2).sum(axis=1).mean())
        return [
            f"{len(quads):,}",
            f"{np.count_nonzero(irregular)}",
            f"{self.directions.angle(vertices, quads):.1f}",
            f"{jacobian.min():.2f} / {jacobian.mean():.3f} of {most_jacobian(quads, topology):.3f}",
            f"{1000 * off / np.ptp(surface.vertices, axis=0).max():.2f}",
            "yes" if whole else "no",
        ]


def most_jacobian(quads: np.ndarray, topology: Conformity) -> float:
    """The mean scaled Jacobian that quads could have but for their irregular vertices.

    The sine is concave, so that equal corners have the largest sum of sines.
    """
    sine = np.sin(2.0 * np.pi / np.maximum(topology.valence, 3))
    sine[topology.border | (topology.valence == 4)] = 1.0
    return float(sine[quads].min(axis=1).mean())


def ours(vertices: np.ndarray, triangles: np.ndarray, quads: int) -> tuple:
    """Vertices, quads and seconds of this project's remeshing, the detection included."""
    start = time.perf_counter()
    made = core.remesh(vertices, triangles, core.RemeshSettings(quads=quads))
    return made.vertices, made.quads, time.perf_counter() - start


def programs(cache: Path) -> tuple[dict[str, Callable], str]:
    """What makes quads here, by name, and a word on each program."""
    found: dict[str, Callable] = {OURS: ours}
    words = []
    for name, make in (
        ("Instant Meshes", lambda: instant_meshes(cache)),
        ("QuadriFlow", quadriflow),
    ):
        try:
            command = make()
        except PeerError as error:
            words.append(f"{name} was left out of this run: {error}.")
            continue
        found[name] = lambda v, t, q, command=command: run(command, v, t, q)
        words.append(f"{name} runs with creases over 40° and borders kept.")
    return found, " ".join(words)


def guarantees(seeds: range) -> int:
    """Remesh random surfaces; how many of them break a guarantee."""
    count = 0
    for seed in seeds:
        try:
            name, vertices, triangles, quads = random_surface(seed)
        except ImportError as error:
            print(f"{seed}: left out, {error}", flush=True)
            continue
        start = time.perf_counter()
        try:
            made = core.remesh(vertices, triangles, core.RemeshSettings(quads=quads))
        except core.UmbilicsError as error:
            broken = [str(error)]
            words = f"{len(triangles)} triangles"
        else:
            broken = broken_guarantees(vertices, triangles, made, quads)
            jacobian = scaled_jacobian(made.vertices, made.quads)
            most = most_jacobian(made.quads, conformity(made.quads, len(made.vertices)))
            words = (
                f"{len(triangles)} triangles, {len(made.quads)} of {quads} quads, "
                f"{len(made.pole_valence)} poles, Jacobian {jacobian.min():.2f} / "
                f"{jacobian.mean():.3f} of {most:.3f}, {np.nanmean(made.angle):.1f} degrees"
            )
        count += bool(broken)
        seconds = time.perf_counter() - start
        print(f"{seed}: {name}, {words}, {seconds:.1f} s", *broken, sep="\n    ", flush=True)
    print(f"{count} of {len(seeds)} surfaces break a guarantee")
    return min(count, 100)


def kept_tables(page: Path) -> dict[int, str]:
    """What stands in a page under each number of quads."""
    text = page.read_text(encoding="utf-8") if page.exists() else ""
    text = text.removesuffix(speed_of(text))
    found = re.split(r"^## ([\d,]+) quads asked for$", text, flags=re.MULTILINE)[1:]
    pairs = zip(found[::2], found[1::2], strict=True)
    return {int(count.replace(",", "")): words for count, words in pairs}


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="benchmarks/quads", description=__doc__)
    parser.add_argument("--quads", type=int, nargs="+", default=[2000, 5000])
    parser.add_argument("--meshes", type=Path, default=ROOT.parent / "shared" / "meshes")
    parser.add_argument("--only", nargs="+", help="names of surfaces")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "quads.md")
    parser.add_argument("--cache", type=Path, default=Path.home() / ".cache" / "umbilics" / "peers")
    parser.add_argument("--speed", action="store_true")
    parser.add_argument("--alone", action="store_true", help="without the other programs")
    parser.add_argument("--random", type=int, nargs=2, metavar=("FIRST", "LAST"))
    options = parser.parse_args(arguments)
    if options.random:
        return guarantees(range(*options.random))
    where = machine()
    known, words = ({OURS: ours}, "") if options.alone else programs(options.cache)
    page = options.out.read_text(encoding="utf-8") if options.out.exists() else ""
    if options.speed:
        large = [
            item
            for item in large_surfaces(options.meshes, options.quads[0])
            if not options.only or item.name in options.only
        ]
        others = {name: make for name, make in known.items() if name != OURS}
        section = speed_section(large, others, words)
        options.out.write_text(with_speed(page, section), encoding="utf-8")
        return 0
    chosen = [
        item for item in surfaces(options.meshes) if not options.only or item[0] in options.only
    ]
    rows: dict[int, list[list[str]]] = {count: [] for count in options.quads}
    for name, vertices, triangles in chosen:
        judge = Judge(vertices, triangles, CAGES.get(name, 0))
        for count, program in itertools.product(options.quads, known):
            try:
                made, quads, seconds = known[program](vertices, triangles, count)
            except (PeerError, core.UmbilicsError) as error:
                row = [name, program, str(error), *[""] * 6]
            else:
                row = [name, program, *judge.row(made, quads), f"{seconds:.1f}"]
            rows[count].append(row)
            print(" | ".join(row), flush=True)
    tables = kept_tables(options.out)
    for count in options.quads:
        tables[count] = f"Taken on {where}.\n\n{words}\n\n{table(_COLUMNS, rows[count])}"
    sections = [
        f"## {count:,} quads asked for\n\n{tables[count].strip()}" for count in sorted(tables)
    ]
    text = PAGE.format(tables="\n\n".join(sections))
    if speed := speed_of(page):
        text = with_speed(text, speed)
    options.out.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
