"""What is kept of a check: how well a mesh of the user's follows a surface."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass

import bpy
import numpy as np
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from ... import core
from ..base import property_groups
from ..base.changes import notify, silence
from ..base.words import TopologyFigures
from . import plans

STATES = ("matched", "extra", "missing")
MATCHED, EXTRA, MISSING = range(3)
# A mesh of triangles is irregular nearly everywhere: more are no help to anybody.
MOST_MARKS = 2000
# Stands for none: no sine is as large.
_NO_JACOBIAN = 2.0


def _is_mesh(_: bpy.types.Object, obj: bpy.types.Object) -> bool:
    return obj.type == "MESH"


class UMBILICS_PG_mark(bpy.types.PropertyGroup):
    """An irregular vertex, or a planned pole without one."""

    state: IntProperty(description="Row of `STATES`")
    valence: IntProperty(description="Edges that meet there, or that should")
    place: FloatVectorProperty(description="In the space of the object", size=3)


def _mark_chosen(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    notify("mark", context)


class UMBILICS_PG_check(bpy.types.PropertyGroup):
    """The last check of an object, in numbers."""

    surface: PointerProperty(
        type=bpy.types.Object,
        poll=_is_mesh,
        name="Surface",
        description="The mesh whose shape the active one should follow; empty takes the other "
        "selected one",
    )
    planned: StringProperty(
        description="The poles that the quads were laid out with, see `to_text`; nothing for a "
        "mesh that was made otherwise"
    )
    own_plan: BoolProperty(
        name="Plan of the Quads",
        description="Compare with the poles that these quads were laid out with, in place of those "
        "of a plan with the settings under Retopology",
        default=True,
    )
    checked: BoolProperty(description="The object was checked")
    by_own_plan: BoolProperty(description="It was compared with the plan of the quads")
    against: StringProperty(description="Name of the surface that it was held against")
    source: StringProperty(description="Which form of the surface: BASE or EVALUATED")
    origin: StringProperty(description="What the plan was made of, see data/plans.py")
    steered: StringProperty(description="Digest of the poles that were set by hand, or nothing")
    apart: FloatVectorProperty(description="From the space of the mesh to the surface's", size=16)
    matched: IntProperty(description="Irregular vertices that stand where the plan has a pole")
    missing: IntProperty(description="Poles of the plan without an irregular vertex near them")
    extra: IntProperty(description="Irregular vertices that the plan has no pole for")
    quads: IntProperty(description="Faces of four corners")
    faces: IntProperty(description="All faces")
    angle: FloatProperty(
        description="Mean angle between the quads and the directions of curvature, in degrees; "
        "negative where there is none"
    )
    jacobian: FloatProperty(
        description="Least scaled Jacobian of the quads: the least sine at a corner, 1 for "
        "rectangles, 0 or less where one is folded; above 1 where there are no quads"
    )
    folded: IntProperty(description="Quads that are folded or face against the surface")
    distance: FloatProperty(description="Largest distance from a vertex to the surface")
    edges: FloatProperty(description="The same in mean edges")
    from_surface: FloatProperty(
        description="Largest distance from the surface to the mesh, in mean edges; negative in "
        "checks of earlier versions, which did not measure it",
        default=-1.0,
    )
    covered: FloatProperty(
        description="Share of the surface within a mean edge of the mesh, 0 to 1", default=1.0
    )
    warnings: StringProperty(
        description="Sentences on what the remesher could not have, one a line; none of a mesh "
        "that was made by hand or checked again"
    )
    stamp: StringProperty(description="What tells the mesh that was checked from another")
    marks: CollectionProperty(type=UMBILICS_PG_mark)
    active: IntProperty(
        description="The irregular vertex or pole that is chosen in the table",
        default=-1,
        update=_mark_chosen,
    )


@dataclass(frozen=True)
class Against:
    """What a mesh is held against.

    Attributes
    ----------
    surface:
        The object whose shape it should follow, as it was then.
    evaluated:
        Whether modifiers and shape keys of it counted.
    origin:
        What the plan was made of.
    steered:
        Digest of the poles that were set by hand, or nothing.
    own_plan:
        Whether the poles are those that the mesh was laid out with, whatever that origin says.
    """

    surface: bpy.types.Object
    evaluated: bool
    origin: plans.Origin
    steered: str
    own_plan: bool = False


@dataclass(frozen=True)
class OwnPlan:
    """The poles that quads were laid out with, on a surface of so many triangles.

    Attributes
    ----------
    triangle, barycentric, valence:
        As of `core.Poles`.
    """

    triangles: int
    triangle: np.ndarray
    barycentric: np.ndarray
    valence: np.ndarray

    @classmethod
    def of(cls, poles: core.Poles, triangles: int) -> OwnPlan:
        return cls(triangles, poles.triangle, poles.barycentric, poles.valence)

    def poles(self, vertices: np.ndarray, triangles: np.ndarray) -> core.Poles:
        """They on the surface as it is now, of as many triangles."""
        here = self.triangle, self.barycentric, self.valence
        return core.Poles.placed(vertices, triangles, *here)

    def to_text(self) -> str:
        """It as it is kept with the mesh: the surface may be moved and deformed meanwhile."""
        rows = self.triangle, self.barycentric, self.valence
        return json.dumps([self.triangles, *(row.tolist() for row in rows)])

    @classmethod
    def from_text(cls, text: str) -> OwnPlan | None:
        """What `to_text` has written; None for any other text."""
        try:
            triangles, triangle, barycentric, valence = json.loads(text)
            found = cls(
                int(triangles),
                np.array(triangle, np.int64).reshape(-1),
                np.array(barycentric, float).reshape(-1, 3),
                np.array(valence, np.int64).reshape(-1),
            )
        except (ValueError, TypeError, OverflowError, RecursionError):
            return None
        fits = len(found.triangle) == len(found.barycentric) == len(found.valence)
        inside = ((found.triangle >= 0) & (found.triangle < found.triangles)).all()
        return found if fits and inside else None


def own_plan(kept: UMBILICS_PG_check) -> OwnPlan | None:
    """The poles that a mesh was laid out with, if it is to be compared with these."""
    return OwnPlan.from_text(kept.planned) if kept.planned and kept.own_plan else None


def apart(obj: bpy.types.Object, surface: bpy.types.Object) -> tuple[float, ...]:
    """The sixteen numbers of the transform from an object's space to a surface's."""
    between = surface.matrix_world.inverted_safe() @ obj.matrix_world
    return tuple(value for row in between for value in row)


def origin_of(kept: UMBILICS_PG_check) -> plans.Origin | None:
    """What the plan of a check was made of; None where that cannot be read, or of older files."""
    return plans.read_origin(kept.origin) if kept.checked and kept.origin else None


def store(
    obj: bpy.types.Object,
    against: Against,
    stamp: str,
    found: core.TopologyCheck,
    irregular: np.ndarray,
    missing_valence: np.ndarray,
    missing: np.ndarray,
) -> None:
    """Put a check away with the object, in place of an earlier one: its numbers, and a table of at
    most `MOST_MARKS` vertices and poles, the missing first, then the extra ones.

    `irregular` (k, 3) and `missing` (r, 3) are places in the object's space.
    """
    kept = obj.umbilics_check
    kept.checked, kept.against, kept.stamp = True, against.surface.name_full, stamp
    kept.source = "EVALUATED" if against.evaluated else "BASE"
    kept.by_own_plan = against.own_plan
    kept.origin, kept.steered = against.origin.to_text(), against.steered
    kept.apart = apart(obj, against.surface)
    kept.matched, kept.missing, kept.extra = found.matched, len(found.missing), found.extra
    kept.quads, kept.faces = found.quads, len(found.angle)
    kept.angle = found.mean_angle if math.isfinite(found.mean_angle) else -1.0
    kept.jacobian = found.least_jacobian if found.quads else _NO_JACOBIAN
    kept.folded = int(found.folded.sum())
    kept.distance = float(found.distance.max(initial=0.0))
    kept.edges, kept.from_surface = found.edges_away, found.surface_edges_away
    kept.covered = found.covered
    kept.warnings = ""
    extra, matched = np.flatnonzero(found.pole < 0), np.flatnonzero(found.pole >= 0)
    rows = [(MISSING, *one) for one in zip(missing_valence, missing, strict=True)]
    for state, mine in ((EXTRA, extra), (MATCHED, matched)):
        rows += [(state, found.valence[row], irregular[row]) for row in mine]
    kept.marks.clear()
    with silence("mark"):
        kept.active = -1
    for state, valence, place in rows[:MOST_MARKS]:
        mark = kept.marks.add()
        mark.state, mark.valence, mark.place = state, int(valence), place


def forget(obj: bpy.types.Object) -> None:
    """Clear the object's check; what the next one is to be held against stays."""
    kept = obj.umbilics_check
    surface, planned, own = kept.surface, kept.planned, kept.own_plan
    obj.property_unset("umbilics_check")
    if surface is not None:
        obj.umbilics_check.surface = surface
    if planned:
        obj.umbilics_check.planned, obj.umbilics_check.own_plan = planned, own


def sentences(kept: UMBILICS_PG_check) -> list[str]:
    """The check in lines for the panel and for reports."""
    figures = TopologyFigures(
        matched=kept.matched,
        missing=kept.missing,
        extra=kept.extra,
        faces=kept.faces,
        quads=kept.quads,
        angle=kept.angle if kept.angle >= 0.0 else math.nan,
        jacobian=kept.jacobian if kept.jacobian < _NO_JACOBIAN else math.nan,
        folded=kept.folded,
        edges=kept.edges,
        from_surface=kept.from_surface if kept.from_surface >= 0.0 else math.nan,
        covered=kept.covered,
    )
    return figures.lines()


register, unregister = property_groups.factory(
    (UMBILICS_PG_mark, UMBILICS_PG_check), (bpy.types.Object, "umbilics_check", UMBILICS_PG_check)
)
