"""The beginning and the end of the page."""

from __future__ import annotations

import platform

import bpy
import numpy as np
import scipy

from .page import Page


def write(page: Page) -> None:
    page.heading("Validation: the paper's experiments, repeated", 1)
    page.text(
        """This page is written by `tools/validate MESH_FOLDER`. Every number and figure on it
        was computed by that run; only the sentences were written beforehand, and those that
        judge an outcome are chosen by the numbers. The paper is *Linear Interpolation of Shape
        Operators for Umbilical Points via Local Parameterization*; its tables and figures are
        named where they are repeated. S, I and C are its methods: interpolation of shape
        operators in each triangle, index around each vertex, and interpolation of the curvature
        tensor over a conformal unfolding."""
    )
    page.text(
        f"""Run in Blender {bpy.app.version_string} with Python {platform.python_version()},
        NumPy {np.__version__} and SciPy {scipy.__version__}. Errors are distances in space;
        "edges" are mean edge lengths of the mesh. "Normals" are shape operators from vertex
        normals (Rusinkiewicz 2004), as trivially estimated as the paper's; "jets" are cubic
        osculating jets (Cazals & Pouget 2005), the extension's default."""
    )


def close(page: Page) -> None:
    page.heading("Where this differs from the paper")
    page.items(page.differences or ["Nothing was compared in this run."])
    if page.left_out:
        page.heading("Left out")
        page.items(page.left_out)
