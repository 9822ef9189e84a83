"""Bringing one mesh onto another, like a detection in `detect`: gather, compute, and moving it."""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np
from mathutils import Matrix

from ... import core
from ..base.errors import ObjectError
from ..data import properties, reading, record
from ..mesh.scope import scope_in_file
from ..scene import display_objects, selection, targets
from . import detect


@dataclass(frozen=True)
class BestAlignment:
    """The best motion, and the mesh that it leads to."""

    alignment: core.Alignment
    other: detect.Inputs


@dataclass(frozen=True)
class Job:
    """A mesh and those that it could be, read from the scene.

    Attributes
    ----------
    inputs:
        The mesh that is to be moved.
    others:
        The meshes that it could be.
    scaled:
        Whether its size may change.
    """

    inputs: detect.Inputs
    others: tuple[detect.Inputs, ...]
    scaled: bool
    notes: tuple[str, ...] = ()

    @property
    def object_name(self) -> str:
        return self.inputs.object_name

    def compute(self, progress: core.Progress | None = None) -> BestAlignment:
        """The alignment with the other mesh that it fits best; any thread may run it."""
        progress = progress or core.Progress()
        read = (self.inputs, *self.others)
        shapes = []
        for number, inputs in enumerate(read):
            share = 0.5 / len(read)
            part = progress.part("Detecting", share * number, share * (number + 1))
            shapes.append(shape_of(inputs, detect.known_or_computed(inputs, part)))
        one, others = shapes[0], shapes[1:]
        matching = progress.part("Matching", 0.5, 1.0)
        if len(others) == 1:
            return BestAlignment(
                core.align(one, others[0], matching, scaled=self.scaled), self.others[0]
            )
        found = core.identify(one, others, matching, scaled=self.scaled)
        best = max(
            ((item, other) for item, other in zip(found, self.others, strict=True) if item),
            key=lambda pair: pair[0].score,
            default=None,
        )
        if best is None:
            raise core.MatchError(f"{self.object_name} is none of the other selected meshes.")
        return BestAlignment(*best)


def shape_of(inputs: detect.Inputs, detection: core.Detection) -> core.Shape:
    """What matching goes by of a mesh."""
    return core.Shape.of(inputs.arrays.vertices, inputs.arrays.triangles, detection)


def gather(context: bpy.types.Context, scaled: bool) -> Job:
    """Read the active mesh and the other selected ones; the scene is not changed.

    Raises
    ------
    core.UmbilicsError
        One cannot be read, or there is no other.
    """
    active = selection.active(context)
    if not targets.is_local(active):
        raise ObjectError(f"{active.name} is linked from another file and cannot be moved here.")
    others = [
        obj
        for obj in context.selected_objects
        if obj.type == "MESH" and obj != active and not display_objects.is_ours(obj)
    ]
    if not others:
        raise ObjectError(
            "Select the mesh that the active one is to be brought onto as well, or several to "
            "find out which of them it is."
        )
    return Job(_read(context, active), tuple(_read(context, obj) for obj in others), scaled)


def _read(context: bpy.types.Context, obj: bpy.types.Object) -> detect.Inputs:
    scene = context.scene
    known = record.of(obj)
    if known is not None:
        settings, names = known.settings, known.given_names
        evaluated = obj.umbilics.source == "EVALUATED"
        scope = scope_in_file(obj.umbilics.scope, obj.umbilics.group)
    else:
        settings = properties.to_settings(scene.umbilics)
        names = properties.given_names(scene.umbilics)
        evaluated = scene.umbilics_display.source == "EVALUATED"
        scope = reading.scope_of(scene.umbilics_display)
    depsgraph = context.evaluated_depsgraph_get() if evaluated else None
    return detect.gather(obj, settings, names, depsgraph=depsgraph, scope=scope)


def move(context: bpy.types.Context, job: Job, found: BestAlignment) -> None:
    """Put the mesh where the motion leads it.

    Raises
    ------
    core.UmbilicsError
        It or the mesh that it is to lie on is gone, or was changed or moved since `gather`.
    """
    with (
        detect.unchanged(context, found.other) as (other, _, _),
        detect.unchanged(context, job.inputs) as (obj, _, transaction),
    ):
        _check_unmoved(other, found.other)
        _check_unmoved(obj, job.inputs)
        place = Matrix(found.alignment.matrix.tolist()) @ obj.matrix_world
        transaction.at_end(setattr, obj, "matrix_world", place)
    context.view_layer.update()


def _check_unmoved(obj: bpy.types.Object, inputs: detect.Inputs) -> None:
    if not np.allclose(np.array(obj.matrix_world), inputs.arrays.matrix, atol=1e-6):
        raise ObjectError(f"{obj.name} was moved meanwhile. Try again.")
