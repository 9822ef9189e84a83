"""What the user drew and moved for the next plan: guide strokes, and the poles as they are now."""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np

from .... import core
from ...base.errors import ObjectError
from ...data import plans
from ...mesh import fingerprint
from ...mesh.read import MeshArrays
from ..transaction import Transaction
from . import drawn, guidance_objects


@dataclass(frozen=True)
class ByHand:
    """What a plan is steered by.

    Attributes
    ----------
    strokes:
        Lines for the cross field to run along, or None.
    wanted:
        All the poles that there are to be, or None where they are to be planned.
    digest:
        Tells the strokes from others, see `digest_of`.
    digest_of_poles:
        The same of the poles, see there.
    """

    strokes: core.Strokes | None = None
    wanted: core.WantedPoles | None = None
    digest: str = ""
    digest_of_poles: str = ""


def read(
    scene: bpy.types.Scene, obj: bpy.types.Object, arrays: MeshArrays, with_poles: bool
) -> ByHand:
    """What the user drew for the scene, and moved of the plan of `obj`.

    Raises
    ------
    ObjectError
        The chosen strokes are none, or a pole has a valence that no pole has.
    """
    wanted, poles = None, ""
    if with_poles and is_steered(obj):
        wanted, poles = wanted_poles(obj), digest_of_poles(obj)
    group = scene.umbilics_guidance
    if group.strokes is None:
        return ByHand(wanted=wanted, digest_of_poles=poles)
    lines = drawn.polylines(group.strokes, scene)
    if not lines:
        raise ObjectError(
            f"{group.strokes.name} has no stroke that could guide: draw on it, show its layers, or "
            "choose no Guide Strokes."
        )
    size = float(np.ptp(arrays.vertices, axis=0).max())
    strokes = core.Strokes(
        start=np.concatenate([[0], np.cumsum([len(line) for line in lines])]),
        position=np.concatenate(lines),
        influence=np.full(len(lines), group.influence * size),
    )
    return ByHand(strokes, wanted, digest_of(scene), poles)


def digest_of(scene: bpy.types.Scene) -> str:
    """What tells the strokes that are chosen from others; nothing without any."""
    group = scene.umbilics_guidance
    if group.strokes is None:
        return ""
    parts = drawn.raw_parts(group.strokes, scene)
    return fingerprint.digest(*parts, np.array([group.influence]))


def poles_there(obj: bpy.types.Object) -> list[bpy.types.Object]:
    """The poles of the object's plan that are in a scene, those that were added included."""
    found = guidance_objects.parts_of(obj, guidance_objects.POLES)
    return [one for one in found if one.users_scene]


def added(obj: bpy.types.Object) -> int:
    """How many poles there are that the plan has not put there."""
    known = [plans.empty_of(pole) for pole in obj.umbilics_plan.poles]
    return sum(one not in known for one in poles_there(obj))


def is_changed(obj: bpy.types.Object) -> bool:
    """Whether poles of the object's plan were moved, changed, added or deleted since."""
    return any(map(plans.change_of, obj.umbilics_plan.poles)) or added(obj) > 0


def is_steered(obj: bpy.types.Object) -> bool:
    """Whether the next plan goes by the poles that are there: they are changed, or were before
    the plan that is there."""
    plan = obj.umbilics_plan
    # Without any pole left there is nothing to go by, as in a copy of the mesh alone.
    return plan.planned and bool(poles_there(obj)) and (plan.by_hand or is_changed(obj))


def digest_of_poles(obj: bpy.types.Object) -> str:
    """What tells the poles that the next plan goes by from others; nothing where it plans them."""
    if not is_steered(obj):
        return ""
    there = poles_there(obj)
    values = [(*one.location, float(one.get("umbilics_valence") or 0)) for one in there]
    return fingerprint.digest(np.array(sorted(values), np.float32))


def wanted_poles(obj: bpy.types.Object) -> core.WantedPoles:
    """The poles of the object's plan as they are now.

    Raises
    ------
    ObjectError
        One has a valence that no pole has.
    """
    there = poles_there(obj)
    valence = [one.get("umbilics_valence") for one in there]
    for one, value in zip(there, valence, strict=True):
        if value not in (3, 5):
            raise ObjectError(
                f"{one.name} has the custom property umbilics_valence {value}: a pole has 3 or 5."
            )
    places = [one.matrix_world.translation for one in there]
    return core.WantedPoles(np.array(places, float).reshape(-1, 3), np.array(valence, np.int64))


def add_pole(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    place: np.ndarray,
    normal: np.ndarray,
    valence: int,
    transaction: Transaction,
) -> bpy.types.Object:
    """A pole of the user's at a place (3,) of the world, beside those of the object's plan."""
    size = max(obj.dimensions)
    pole = guidance_objects.new_pole(context, valence, size, 1.0, transaction)
    guidance_objects.put_pole(context, obj, pole, place, normal, transaction)
    return pole
