"""What the simplest estimator sees: polynomials of degree two over five rings."""

from __future__ import annotations

import numpy as np

import core
from core.base.progress import Progress
from core.curvature.field import CurvatureField
from core.curvature.fits.jets import fit_jets
from core.mesh.mending.repair import clean
from core.mesh.neighbourhoods import Neighbourhood
from core.mesh.normals import vertex_normals
from core.mesh.rings import adjacency

RINGS = 5


def quadric_umbilics(vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(k, 3) positions and (k,) indices of all umbilics of the fitted field, none dropped."""
    surface, _ = clean(vertices, triangles)
    around = Neighbourhood(surface, adjacency(surface), rings=RINGS, focused=False)
    jets = fit_jets(surface, vertex_normals(surface), around, Progress(), degree=2)
    settings = core.Settings(curvature="given", persistence=0.0, regions=False)
    field = CurvatureField(jets.k1, jets.k2, jets.d1, jets.d2, jets.normal, jets.noise)
    found = core.detect(surface.vertices, surface.triangles, settings, given=field).candidates
    return found.position * surface.unit + surface.origin, found.index
