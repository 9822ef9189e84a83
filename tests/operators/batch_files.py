"""Meshes in files, the command that starts a batch of them, and its tables."""

import csv

import bpy
import pytest
import surfaces
from mesh_files import write_obj

BLENDER = bpy.app.binary_path

needs_program = pytest.mark.skipif(
    not BLENDER, reason="Blender as a module has no program to start for a file"
)


def write_ellipsoid(path, third=1.0):
    surface = surfaces.ellipsoid((3.0, 2.0, third), 2)
    write_obj(path, surface.vertices, surface.triangles)


def command(*arguments):
    return [BLENDER, "-b", "--command", "umbilics", *map(str, arguments)]


def rows_of(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))
