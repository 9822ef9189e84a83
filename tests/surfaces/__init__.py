"""Analytic test surfaces: meshes whose shape operators and umbilics are known exactly.

Signs follow the project: with outward normals a sphere of radius R has both principal
curvatures +1/R. Graph patches z = f(x, y) are wound upwards, so a bowl (f convex) has
negative curvatures.
"""

from .analytic import AnalyticSurface, UmbilicPoints
from .closed import ellipsoid, quartic, random_ellipsoid, sphere, torus
from .graphs import (
    cylinder,
    graph_surface,
    monkey_saddle,
    paraboloid,
    plane,
    saddle,
    seed_patch,
)
from .images import inverted, noisy, renumbered, similar
from .implicit import (
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
from .sampling import grid_points, icosphere, random_points
from .voxels import marching_tetrahedra

__all__ = [
    "AnalyticSurface",
    "ImplicitSurface",
    "UmbilicPoints",
    "cayley",
    "cosines",
    "cylinder",
    "ellipsoid",
    "genus_five",
    "genus_two",
    "graph_surface",
    "grid_points",
    "icosphere",
    "inverted",
    "marching_tetrahedra",
    "metaballs",
    "monkey_saddle",
    "noisy",
    "paraboloid",
    "plane",
    "quartic",
    "random_ellipsoid",
    "random_field",
    "random_harmonics",
    "random_points",
    "renumbered",
    "saddle",
    "seed_patch",
    "similar",
    "sphere",
    "superquadric",
    "torus",
]
