"""What is kept of a check: how well a mesh of the user's follows a surface."""

from __future__ import annotations

import math

import bpy
from bpy.props import BoolProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from ... import core
from ..base import property_groups
from ..base.words import topology_in_words

# Stands for none: no sine is as large.
_NO_JACOBIAN = 2.0


def _is_mesh(_: bpy.types.Object, obj: bpy.types.Object) -> bool:
    return obj.type == "MESH"


class UMBILICS_PG_check(bpy.types.PropertyGroup):
    """The last check of an object, in numbers."""

    surface: PointerProperty(
        type=bpy.types.Object,
        poll=_is_mesh,
        name="Surface",
        description="The mesh whose shape the active one should follow; empty takes the other "
        "selected one",
    )
    checked: BoolProperty(description="The object was checked")
    against: StringProperty(description="Name of the surface that it was held against")
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
    distance: FloatProperty(description="Largest distance from a vertex to the surface")
    edges: FloatProperty(description="The same in mean edges")


def store(obj: bpy.types.Object, against: str, found: core.TopologyCheck) -> None:
    """Put the numbers of a check away with the object, in place of earlier ones."""
    kept = obj.umbilics_check
    kept.checked, kept.against = True, against
    kept.matched, kept.missing, kept.extra = found.matched, len(found.missing), found.extra
    kept.quads, kept.faces = found.quads, len(found.angle)
    kept.angle = found.mean_angle if math.isfinite(found.mean_angle) else -1.0
    kept.jacobian = found.least_jacobian if found.quads else _NO_JACOBIAN
    kept.distance = float(found.distance.max(initial=0.0))
    kept.edges = found.edges_away


def sentences(kept: UMBILICS_PG_check) -> list[str]:
    """The check in lines for the panel and for reports."""
    return topology_in_words(
        matched=kept.matched,
        missing=kept.missing,
        extra=kept.extra,
        faces=kept.faces,
        quads=kept.quads,
        angle=kept.angle if kept.angle >= 0.0 else math.nan,
        jacobian=kept.jacobian if kept.jacobian < _NO_JACOBIAN else math.nan,
        edges=kept.edges,
    )


register, unregister = property_groups.factory(
    (UMBILICS_PG_check,), (bpy.types.Object, "umbilics_check", UMBILICS_PG_check)
)
