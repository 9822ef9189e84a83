"""What a detection returns: plain dataclasses of arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ..base.errors import InvalidMeshError
from ..base.rows import column
from ..curvature.field import CurvatureField
from ..mesh.exact_shapes import CONICAL, CYLINDRICAL, PLANAR, SPHERICAL

STAR = "star"
LEMON = "lemon"
MONSTAR = "monstar"
COMPOUND = "compound"
UNCERTAIN = "uncertain"
KINDS = (STAR, LEMON, MONSTAR, COMPOUND, UNCERTAIN)
CURVE, UNRESOLVED = "curve", "unresolved"
REGION_KINDS = (SPHERICAL, PLANAR, CYLINDRICAL, CONICAL, CURVE, UNRESOLVED)
# Blender's whole numbers and its meshes have no more.
_LARGEST = 2**31 - 1


@dataclass(frozen=True)
class Umbilics:
    """Umbilical points, one row each.

    Beside each field is what is kept of it in a file (a kind as its place in `KINDS`), and the
    bounds that what is read from one must lie in.

    Attributes
    ----------
    position, normal:
        (k, 3) float64 point on the mesh, in the mesh's own coordinates, and unit normal there.
    triangle:
        (k,) int64 row of the input triangles that holds the point.
    barycentric:
        (k, 3) float64 weights of that triangle's corners.
    vertex:
        (k,) int64 vertex for method I, which reports vertices; -1 otherwise.
    index:
        (k,) float64 index of the principal direction field, +0.5 or -0.5; other multiples of one
        half at compound ones.
    kind:
        (k,) str: "star", "lemon", "monstar"; "compound" where the index is another, be it of one
        point or of several that their errors do not tell from each other; "uncertain" where cubic
        form and index disagree or the form is within its error of another kind.
    curvature:
        (k,) float64 mean curvature at the point, in 1 / length.
    persistence:
        (k,) float64 gap at which the point cancels with its partner, in 1 / length; infinite
        where topology keeps it.
    partner:
        (k,) int64 row of the umbilic it cancels with, -1 where there is none. In a filtered
        set the rows are those of the full set, `Detection.candidates`.
    uncertainty:
        (k,) float64 standard error of the position along the surface, per axis, in length: one,
        two and three of it hold 39, 86 and 99 % if errors are Gaussian; of a compound how far its
        parts lie from it.
    noise:
        (k,) float64 standard error of the gap around the point, in 1 / length; NaN where unknown.
    separatrix:
        (k, 3, 3) float64 unit tangents along which a line of the larger curvature runs into the
        point, NaN-filled to three; the smaller curvature's run in from the opposite sides.
    at_border:
        (k,) bool, True next to an open border, where the neighbourhoods are one-sided: such
        points stay among the candidates but are not reported.
    certain:
        (k,) bool, True where a fit of higher degree shows the zero so clearly above its error
        that noise alone cannot have made it; False at a border and where the neighbourhood is
        damaged.
    resolved:
        (k,) bool, False for the pairs that do not rise above the error of the fits, which the
        automatic persistence drops.
    importance:
        (k,) float64 persistence over the standard error of the gap, the lesser one of those that
        cancel together: how far above the error the surface has to be flattened until the point
        is gone. Where topology keeps it, the largest gap of the surface stands for the
        persistence; where no error is known, the median gap for the error.
    elliptic:
        (k,) bool, True inside the opened elliptic part (of strength 2 where opening is off).
    """

    position: np.ndarray = field(metadata=column(np.float64, 3))
    normal: np.ndarray = field(metadata=column(np.float64, 3, unknown=True))
    triangle: np.ndarray = field(metadata=column(np.int64, low=0, high=_LARGEST))
    barycentric: np.ndarray = field(metadata=column(np.float64, 3, unknown=True))
    vertex: np.ndarray = field(metadata=column(np.int64, low=-1, high=_LARGEST))
    index: np.ndarray = field(metadata=column(np.float64, low=-_LARGEST, high=_LARGEST))
    kind: np.ndarray = field(metadata=column(np.int8, low=0, high=len(KINDS) - 1))
    curvature: np.ndarray = field(
        metadata=column(np.float64, low=-np.inf, high=np.inf, unknown=True)
    )
    persistence: np.ndarray = field(metadata=column(np.float64, low=0.0, high=np.inf, unknown=True))
    partner: np.ndarray = field(metadata=column(np.int64, low=-1, high=_LARGEST))
    uncertainty: np.ndarray = field(metadata=column(np.float64, low=0.0, high=np.inf, unknown=True))
    noise: np.ndarray = field(metadata=column(np.float64, low=0.0, high=np.inf, unknown=True))
    separatrix: np.ndarray = field(metadata=column(np.float64, 3, 3, unknown=True))
    at_border: np.ndarray = field(metadata=column(bool))
    certain: np.ndarray = field(metadata=column(bool))
    resolved: np.ndarray = field(metadata=column(bool))
    importance: np.ndarray = field(metadata=column(np.float64, low=0.0, high=np.inf))
    elliptic: np.ndarray = field(metadata=column(bool))

    def __len__(self) -> int:
        return len(self.index)

    def select(self, rows: np.ndarray) -> Umbilics:
        """The given rows (a mask or indices) of every array."""
        return Umbilics(**{name: value[rows] for name, value in vars(self).items()})

    def counts(self) -> dict[str, int]:
        """How many there are of each kind."""
        return {kind: int(np.count_nonzero(self.kind == kind)) for kind in KINDS}


@dataclass(frozen=True)
class Region:
    """An area or a curve where the principal curvatures are equal within the estimator's noise, an
    exact face of a tessellated part, or a piece of so few vertices that its umbilics are not told
    from each other.

    Attributes
    ----------
    triangles:
        (r,) int64 rows of the input triangles.
    area:
        Its area, in length squared.
    index:
        Index of the direction field around its border: a multiple of one half, the sum of the
        indices that it replaces.
    kind:
        "spherical" or "planar"; of the exact faces also "cylindrical" or "conical"; "curve" for
        the strip along a curve of umbilics, as surfaces of revolution have them in circles;
        "unresolved" for a whole piece of too few vertices.
    curvature:
        Mean curvature over the region, in 1 / length.
    """

    triangles: np.ndarray
    area: float
    index: float
    kind: str
    curvature: float

    @property
    def has_directions(self) -> bool:
        """Whether directions mean something within: those of cylinders and cones are exact, and
        across a curve of umbilics they go on."""
        return self.kind in (CYLINDRICAL, CONICAL, CURVE)


@dataclass(frozen=True)
class Detection:
    """The result of `core.detect`.

    Attributes
    ----------
    umbilics:
        The umbilics that the filters of the settings kept.
    candidates:
        All umbilics before persistence and opening; filtering again needs no new detection.
    curvature:
        Shape operators at every input vertex.
    regions:
        Spherical and planar regions, and strips along curves of umbilics.
    triangle_index:
        (m,) float64 index found in each input triangle, before filtering.
    surface_type:
        (n,) int8 codes of `core.SURFACE_TYPES` at every input vertex, -1 where unknown.
    conformal_scale:
        (n,) float64 length in the plane per length on the mesh, method C only; else NaN.
    euler_characteristic:
        V - E + F of the surface as analysed (without isolated vertices and dropped faces).
    index_sum:
        Sum of the indices of the kept umbilics and the regions.
    expected_index_sum:
        What the sum must be: the Euler characteristic on closed surfaces; NaN where an open
        border leaves it free.
    persistence_level:
        The persistence below which pairs were dropped, in 1 / length.
    trust_ratio:
        The gap at which noise makes umbilics cancel (a multiple of its median error) over the
        median gap: up to about 0.5 the survivors sit where the surface has them, above 0.7 they
        may not. 0 where the noise is not known.
    noise:
        Estimated standard deviation of the positions, in length; NaN where unknown.
    scale:
        Median radius of the fitted neighbourhoods, in length; NaN where nothing was fitted.
    borders_joined:
        Whether borders that lie on each other were joined for the analysis.
    crease_angle:
        Degrees from which edges were not fitted across, the automatic choice included; 180 where
        all were.
    warnings:
        Sentences for the user, each saying what was met and what to do.
    timings:
        Seconds spent in each stage, by name.
    """

    umbilics: Umbilics
    candidates: Umbilics
    curvature: CurvatureField
    regions: Sequence[Region]
    triangle_index: np.ndarray
    surface_type: np.ndarray
    conformal_scale: np.ndarray
    euler_characteristic: int
    index_sum: float
    expected_index_sum: float
    persistence_level: float
    trust_ratio: float
    noise: float
    scale: float
    borders_joined: bool = True
    crease_angle: float = 180.0
    warnings: tuple[str, ...] = ()
    timings: dict[str, float] = field(default_factory=dict)

    def check_mesh(self, vertices: int, triangles: int | None = None) -> None:
        """Raise `InvalidMeshError` if it is not of a mesh with so many vertices and triangles; None
        where only vertices matter."""
        mine = len(self.curvature.k1), len(self.triangle_index)
        triangles = mine[1] if triangles is None else triangles
        if mine != (vertices, triangles):
            raise InvalidMeshError(
                f"The detection is of another mesh: of {mine[0]} vertices and {mine[1]} triangles, "
                f"not {vertices} and {triangles}. Detect on the very mesh."
            )
