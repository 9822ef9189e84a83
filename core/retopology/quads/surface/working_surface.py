"""The surface that is mapped: the cleaned input with features, refined where it is coarse."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ....base.progress import Progress
from ....curvature.field import CurvatureField, field_from_deviators
from ....fields.transport import tangents
from ....mesh.mending.repair import clean
from ....mesh.normals import vertex_normals
from ....mesh.surface import Surface
from ...features import CREASE, MARK, Features
from .chains import long_chains
from .decimation import SHARE, coarsened
from .flipping import flipped
from .needles import without_needles
from .subdivision import CREASE_BIT, MARK_BIT, Triangles, freed, refined

# Edges are at most so many lengths of quads, and at least so many triangles are wanted: no more
# than the second for each quad, but the third. Thin rods may take the fourth times that.
LONGEST, FEWEST, EACH, LEAST, THIN = 1.0, 3000, 30.0, 400, 5.0
# Triangles wanted for each quad, between these bounds, and how many more are coarsened away.
PER_QUAD, MOST, LIMIT, SLACK = 8.0, 20_000, 60_000, 1.3
# Pieces of less area, in quads, are scraps: they are not refined, and no layout is sought for them.
SCRAP = 0.5
# Rounds of splitting: each halves the longest edges. Where too many triangles came of it edges may
# be so many times longer.
ROUNDS, LONGER = 12, 1.5
# Features are at least this long, in lengths of quads.
LEAST_FEATURE = 2.0
# Degrees that the normal of a fit may be off the surface's. Chosen on one solid with large faces,
# 1,204 of whose poles it leaves 111, and not confirmed on others.
ASTRAY = 20.0
# A crease that ends in the open bends so many times the angle that makes one. Chosen on rings of
# few triangles around (their chance creases reach 1.0 to 1.45, fandisk's and the wingnut's that
# end so 1.9 to 2.5) and on metaballs; confirmed on the plates, the beetle and the rocker arm.
LOOSE = 1.5


@dataclass(frozen=True)
class WorkingSurface:
    """What is mapped.

    Attributes
    ----------
    surface:
        Its `source_vertex` are its own rows, its `source_triangle` those of the input; origin
        and unit lead to the input's coordinates.
    field:
        Shape operators at its vertices, in its coordinates.
    feature:
        (3 m,) int8 half-edges on features as in `Triangles`, borders not among them.
    fine:
        What it was coarsened from, in its coordinates; None where it was not.
    unrefined:
        The triangles before they were refined, in its coordinates.
    """

    surface: Surface
    field: CurvatureField
    feature: np.ndarray
    fine: Surface | None
    unrefined: Triangles


def prepared(
    whole: Surface, curvature: CurvatureField, found: Features, size: float, angle: float
) -> tuple[Triangles, int]:
    """A surface as triangles with its curvature at the vertices and its features.

    Parameters
    ----------
    curvature:
        At the vertices of `whole`, in its coordinates.
    size:
        Length of a quad's edge, in the coordinates of `whole`.
    angle:
        Degrees by which a crease bends.

    Returns
    -------
    mesh, short:
        The triangles, and how many creases are too short for edges of quads, or end in the open
        and bend little; they are left out.
    """
    inner = whole.twin[found.half_edge] >= 0
    mark = found.half_edge[inner & (found.kind == MARK)]
    crease = found.half_edge[inner & (found.kind == CREASE)]
    kept = long_chains(whole, crease, LEAST_FEATURE * size, LOOSE * angle)
    short = len(np.unique(found.chain[np.isin(found.half_edge, crease[~np.isin(crease, kept)])]))
    feature = np.zeros(3 * len(whole.triangles), np.int8)
    for edges, kind in ((kept, CREASE_BIT), (mark, MARK_BIT)):
        feature[edges] = feature[whole.twin[edges]] = kind
    values = _values(curvature, whole.triangles.ravel()[feature > 0])
    triangles = whole.triangles.astype(np.int64)
    return Triangles(whole.vertices, triangles, values, whole.source_triangle, feature), short


def working_surface(
    mesh: Triangles, whole: Surface, size: float, progress: Progress
) -> WorkingSurface:
    """The surface to map, of a connected piece of what was prepared: coarser where that is finer
    than a map needs, finer where it is coarser.

    Parameters
    ----------
    size:
        Length of a quad's edge, in the coordinates of `whole`.
    """
    mesh = without_needles(mesh)
    area = mesh.area
    most = int(np.clip(PER_QUAD * area / size**2, MOST, LIMIT))
    fine = None
    if len(mesh.triangles) > SLACK * most:
        fine = mesh
        mesh = coarsened(mesh, most, progress)
    unrefined = mesh = flipped(mesh)
    quads = area / size**2
    fewest = np.clip(EACH * quads, LEAST, FEWEST)
    coarsest, finest = (1.5 * float(np.sqrt(area / SHARE / count)) for count in (fewest, LIMIT))
    longest = max(min(LONGEST * size, coarsest), finest)
    finest = SLACK * np.clip(THIN * EACH * quads, THIN * LEAST, most) if quads >= SCRAP else 0
    mesh = _refined(mesh, longest, int(finest))
    surface, _ = clean(mesh.vertices, mesh.triangles, join_borders=False)
    bordered = np.where(surface.twin < 0, CREASE_BIT, mesh.feature).astype(np.int8)
    mesh = freed(replace(mesh, feature=bordered), surface.border)
    return _assembled(mesh, whole, fine, unrefined)


def _refined(mesh: Triangles, longest: float, most: int) -> Triangles:
    """The mesh with edges of at most `longest`, or longer ones where that took too many triangles:
    along thin rods and strips edges are many that are no longer than their quads."""
    most = max(most, len(mesh.triangles))
    # At least a triangle for each such part of a triangle's longest side comes of it.
    longest = max(longest, float(mesh.lengths.reshape(-1, 3).max(axis=1).sum()) / most)
    while True:
        finer = refined(mesh, longest, ROUNDS, most)
        if len(finer.triangles) <= most:
            return finer
        longest *= LONGER


def _assembled(
    mesh: Triangles, whole: Surface, fine: Triangles | None, unrefined: Triangles
) -> WorkingSurface:
    surface, _ = clean(mesh.vertices, mesh.triangles, join_borders=False)
    values = mesh.values[surface.source_vertex]
    feature = np.where(surface.twin >= 0, mesh.feature, 0).astype(np.int8)
    # The coordinates of the input: those of `whole` first, then its own.
    surface = replace(
        surface,
        source_vertex=np.arange(len(surface.vertices)),
        source_triangle=mesh.source[surface.source_triangle],
        origin=surface.origin * whole.unit + whole.origin,
        unit=surface.unit * whole.unit,
    )
    field = _field(_believed(values, surface), surface.unit / whole.unit)
    place = _mapped(unrefined.vertices, surface, whole)
    unrefined = replace(unrefined, vertices=place)
    return WorkingSurface(surface, field, feature, _fine(fine, surface, whole), unrefined)


def _mapped(place: np.ndarray, surface: Surface, whole: Surface) -> np.ndarray:
    """Places (n, 3) in the coordinates of `whole`, in those of the surface that is mapped."""
    origin = (surface.origin - whole.origin) / whole.unit
    return np.asarray((place - origin) / (surface.unit / whole.unit))


def _fine(mesh: Triangles | None, surface: Surface, whole: Surface) -> Surface | None:
    """The finer surface in the coordinates of the one that is mapped."""
    if mesh is None:
        return None
    fine, _ = clean(mesh.vertices, mesh.triangles, join_borders=False)
    return replace(
        fine,
        vertices=_mapped(fine.vertices * fine.unit + fine.origin, surface, whole),
        source_triangle=mesh.source[fine.source_triangle],
        origin=surface.origin,
        unit=surface.unit,
    )


def _values(curvature: CurvatureField, crease: np.ndarray) -> np.ndarray:
    """(n, 13) normals, shape operators and noise at vertices; those on creases have none, what was
    fitted across a crease says nothing."""
    tensor = sum(
        np.nan_to_num(k)[:, None, None]
        * np.nan_to_num(d)[:, :, None]
        * np.nan_to_num(d)[:, None, :]
        for k, d in ((curvature.k1, curvature.d1), (curvature.k2, curvature.d2))
    )
    tensor[crease] = 0.0
    normal = np.nan_to_num(curvature.normal)
    return np.hstack([normal, tensor.reshape(-1, 9), curvature.noise[:, None]])


def _believed(values: np.ndarray, surface: Surface) -> np.ndarray:
    """The `_values` without fits that do not touch the surface: of few large faces a fit sees
    several at once, and between two of those a mean has a normal that no face has. Crosses that
    are carried by such normals turn where faces are flat."""
    normal = vertex_normals(surface)
    fitted = values[:, :3]
    length = np.linalg.norm(fitted, axis=1)
    touching = np.einsum("nc,nc->n", fitted, normal) >= np.cos(np.radians(ASTRAY)) * length
    values = values.copy()
    values[~touching, :3] = normal[~touching]
    values[~touching, 3:12] = 0.0
    return values


def _field(values: np.ndarray, unit: float) -> CurvatureField:
    """The shape operators that `_values` holds, in a unit so much longer."""
    normal = values[:, :3]
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    normal = np.where(length > 1e-9, normal / np.maximum(length, 1e-9), [0.0, 0.0, 1.0])
    tensor = values[:, 3:12].reshape(-1, 3, 3) * unit
    e1, e2 = tangents(normal)
    s11 = np.einsum("ni,nij,nj->n", e1, tensor, e1)
    s22 = np.einsum("ni,nij,nj->n", e2, tensor, e2)
    s12 = np.einsum("ni,nij,nj->n", e1, tensor, e2)
    deviator = (s11 - s22) + 2j * s12
    return field_from_deviators(0.5 * (s11 + s22), deviator, normal, values[:, 12] * unit)
