"""One conformal unfolding solved in three ways, and what method C makes of each."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, cg, splu

import core
from core.mesh.mending.repair import clean
from core.mesh.surface import Surface
from core.mesh.unfolding.charts import Charts, border_pins, charts_from_seams
from core.mesh.unfolding.lscm import conformal_energy, conformal_map
from core.umbilics.compare import within_edges

from .model import Model
from .page import Page
from .surfaces_found import RAW

# Where the iterative solver stops: of the right hand side, as solvers for such maps usually do.
_TOLERANCE = 1e-6
_MOST_STEPS = 20_000


def write(
    page: Page, model: Model, by_shape: core.Detection, seam: np.ndarray, fingers: np.ndarray
) -> dict[str, int]:
    """A table of how C fares on the fingers, the triangles (m,) that the unfolding shrinks, by each
    solver; how many of its points there are false."""
    arrays = model.arrays
    surface, _ = clean(arrays.vertices, arrays.triangles)
    charts = charts_from_seams(surface, seam)
    true = by_shape.umbilics
    wanted = fingers[true.triangle]
    rows, false = [], {}
    for name, place in _solutions(surface, charts).items():
        corner = place[charts.corners]
        uv = np.zeros((len(arrays.triangles), 3, 2))
        uv[surface.source_triangle] = np.stack([corner.real, corner.imag], axis=-1)
        settings = replace(RAW, method="C", charts="uv")
        found = model.detect(settings, given=by_shape.curvature, uv=uv).umbilics
        here = fingers[found.triangle]
        good = within_edges(
            arrays.vertices, arrays.triangles, found.triangle, found.position, true.position
        )
        missed = wanted & ~within_edges(
            arrays.vertices, arrays.triangles, true.triangle, true.position, found.position
        )
        false[name] = int(np.count_nonzero(here & ~good))
        rows.append(
            [name, np.count_nonzero(here), false[name],
             f"{np.count_nonzero(missed)} of {np.count_nonzero(wanted)}"]
        )  # fmt: skip
    page.text(
        f"""The same unfolding by other solvers, and what C finds where it shrinks lengths below a
        tenth: factorised in double precision with a step of refinement, as the extension does;
        factorised in single precision; by conjugate gradients until the residual is {_TOLERANCE:g}
        of the right hand side."""
    )
    page.table(
        ["solver", "points of C there", "farther than two edges from S", "umbilics of S missed"],
        rows,
    )
    return false


def _solutions(surface: Surface, charts: Charts) -> dict[str, np.ndarray]:
    points = surface.vertices[charts.vertex]
    pins = border_pins(charts, points)
    distance = np.linalg.norm(points[pins[:, 1]] - points[pins[:, 0]], axis=1)
    held, places = pins.ravel(), np.stack([np.zeros(len(pins)), distance], axis=1).ravel()
    start = np.zeros(len(points), complex)
    start[held] = places
    free = np.setdiff1d(np.arange(len(points)), held)
    rows = conformal_energy(points, charts.corners)[free]
    matrix, right = sparse.csc_array(rows[:, free]), -(rows @ start)

    def with_free(values: np.ndarray) -> np.ndarray:
        place = start.copy()
        place[free] = values
        return place

    single = splu(
        matrix.astype(np.complex64),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    diagonal = matrix.diagonal()
    jacobi = LinearOperator(matrix.shape, lambda x: x / diagonal, dtype=complex)
    iterated, _ = cg(matrix, right, rtol=_TOLERANCE, maxiter=_MOST_STEPS, M=jacobi)
    return {
        "converged": conformal_map(points, charts.corners, held, places),
        "single precision": with_free(single.solve(right.astype(np.complex64)).astype(complex)),
        "iterative": with_free(iterated),
    }
