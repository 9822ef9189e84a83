"""Meshes in files, the command that starts a batch of them, and its tables."""

import csv

import bpy
import pytest
import surfaces

BLENDER = bpy.app.binary_path

needs_program = pytest.mark.skipif(
    not BLENDER, reason="Blender as a module has no program to start for a file"
)


def write_obj(path, third=1.0):
    surface = surfaces.ellipsoid((3.0, 2.0, third), 2)
    lines = [f"v {x} {y} {z}" for x, y, z in surface.vertices]
    lines += [f"f {a} {b} {c}" for a, b, c in surface.triangles + 1]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(lines) + "\n")


def command(*arguments):
    return [BLENDER, "-b", "--command", "umbilics", *map(str, arguments)]


def rows_of(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))
