"""Results as sentences, the same in the window and on the command line."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ... import core
from ...core.base.words import counted

# A surface is covered by a mesh above this share; a line says less in tenths of a percent.
_WHOLE = 0.9995


def counts_in_words(counts: dict[str, int]) -> str:
    """For example "4 lemons and 2 stars"; "no umbilics" if all are zero."""
    parts = []
    for kind, count in sorted(counts.items(), key=lambda item: -item[1]):
        if kind == core.KINDS[-1] and count:
            parts.append(f"{count} of uncertain kind")
        elif count:
            parts.append(counted(count, kind))
    if not parts:
        return "no umbilics"
    several, last = ", ".join(parts[:-1]), parts[-1]
    return f"{several} and {last}" if several else last


def is_balanced(index_sum: float, expected: float) -> bool:
    """Whether the indices of a closed surface sum up to its Euler characteristic."""
    return math.isclose(index_sum, expected, abs_tol=1e-6)


def outcome(detection: core.Detection) -> str:
    """One sentence: what was found, and whether the indices sum up as they must."""
    found = counts_in_words(detection.umbilics.counts())
    if detection.regions:
        found += f", {counted(len(detection.regions), 'umbilical region')}"
    total = f"index sum {detection.index_sum:g}"
    if not math.isfinite(detection.expected_index_sum):
        return f"{found}; {total} on an open surface"
    if is_balanced(detection.index_sum, detection.expected_index_sum):
        return f"{found}; {total}, as the Euler characteristic wants"
    return f"{found}; {total}, but the Euler characteristic is {detection.expected_index_sum:g}"


def pins_lost(count: int) -> str:
    """That pinned or deleted umbilics were not found again by a new detection."""
    if count == 1:
        return "One pinned or deleted umbilic has no umbilic of its index near it any more."
    return f"{count} pinned or deleted umbilics have none of their index near them any more."


@dataclass(frozen=True)
class TopologyFigures:
    """How well a mesh follows a surface and its plan, as it is said; what there is not is NaN.

    Attributes
    ----------
    matched, missing, extra:
        Numbers of irregular vertices and planned poles, see `core.TopologyCheck`.
    faces, quads:
        How many faces there are, and how many of them have four corners.
    angle:
        Degrees from the directions of curvature.
    jacobian:
        The least scaled Jacobian.
    folded:
        How many quads are folded or face against the surface.
    edges:
        The largest distance from the surface, in edges.
    from_surface:
        The largest distance of the surface from the mesh, in edges.
    covered:
        Share of the surface near the mesh.
    """

    matched: int
    missing: int
    extra: int
    faces: int
    quads: int
    angle: float
    jacobian: float
    folded: int
    edges: float
    from_surface: float
    covered: float

    @classmethod
    def of(cls, check: core.TopologyCheck) -> TopologyFigures:
        return cls(
            matched=check.matched,
            missing=len(check.missing),
            extra=check.extra,
            faces=len(check.angle),
            quads=check.quads,
            angle=check.mean_angle,
            jacobian=check.least_jacobian,
            folded=int(check.folded.sum()),
            edges=check.edges_away,
            from_surface=check.surface_edges_away,
            covered=check.covered,
        )

    def lines(self) -> list[str]:
        """In words, a line each."""
        lines = [
            f"{self.matched} of {self.matched + self.missing} planned poles, "
            f"{self.missing} missing, {self.extra} extra"
        ]
        if self.quads < self.faces:
            lines.append(f"{self.faces - self.quads} of {self.faces} faces are no quads")
        if math.isfinite(self.angle):
            lines.append(f"{self.angle:.1f}\N{DEGREE SIGN} from the directions of curvature")
        if math.isfinite(self.jacobian):
            lines.append(f"Least scaled Jacobian {self.jacobian:.2f}")
        if self.folded:
            lines.append(f"{counted(self.folded, 'quad')} folded or facing against the surface")
        lines.append(f"Within {max(self.edges, 0.001):.2g} edges of the surface")
        if math.isfinite(self.from_surface):
            lines.append(f"Surface within {max(self.from_surface, 0.001):.2g} edges of the mesh")
        if self.covered < _WHOLE:
            # Never rounded up to all of it.
            lines.append(f"Covers {math.floor(1000.0 * self.covered) / 10.0:.1f} % of the surface")
        return lines
