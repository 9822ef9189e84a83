"""One detection in three steps, so that it can block in background and run beside the window.

`gather` reads the scene, `compute` and `results_of` touch arrays only (any thread may run them),
`write` changes the scene, once, at the end: all of it or nothing.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np

from ... import core
from ..base import caches
from ..data import pins, record, summary
from ..mesh import fingerprint
from ..mesh.attributes import RESULTS, write_results
from ..mesh.evaluated import works_on
from ..mesh.fetch import unit_vectors
from ..mesh.read import MeshArrays, check_unchanged, read_mesh
from ..mesh.scope import KEPT, WHOLE, Scope
from ..scene import display_objects, empties, filters, homes, old_copies, targets
from ..scene.modes import object_mode
from ..scene.retopology import checks, guidance_objects
from ..scene.transaction import Transaction, part_of
from ..scene.view import dashed_lines, maps
from . import refusals


@dataclass(frozen=True)
class Inputs:
    """What a detection needs, read from the scene; holds no reference to Blender's data."""

    object_name: str  # the full name, which tells a linked object from one of this file
    arrays: MeshArrays
    settings: core.Settings
    evaluated: bool = False
    scope: Scope = WHOLE
    analysed: str = ""  # source and scope in words

    def compute(self, progress: core.Progress | None = None) -> Results:
        """The detection and all that `write` wants; any thread may run it."""
        return results_of(self, compute(self, progress))


@dataclass(frozen=True)
class Results:
    """A detection, and what of it goes to the mesh and into the file."""

    detection: core.Detection
    attributes: dict[str, np.ndarray]
    record: record.RecordText
    suitability: core.Suitability


def gather(
    obj: bpy.types.Object,
    settings: core.Settings,
    given_names: tuple[str, ...] | None = None,
    all_methods: bool = False,
    depsgraph: bpy.types.Depsgraph | None = None,
    scope: Scope = WHOLE,
) -> Inputs:
    """Read an object; the scene is not changed. `all_methods`: also what only method C needs.

    With a `depsgraph` the mesh is read as modifiers and shape keys make it in Object Mode. Faces
    outside the `scope` are left out.

    Raises
    ------
    core.UmbilicsError
        The object cannot be analysed, or its results could not be stored; the text says why.
    """
    refusals.check_object(obj, with_modifiers=depsgraph is not None)
    homes.check_names(obj, RESULTS, homes.DETECTION)
    evaluated = depsgraph is not None
    leaving = object_mode(bpy.context, obj, push=False) if evaluated else nullcontext()
    with leaving:
        if evaluated:
            # What a script did to the mesh is evaluated only when it is told of.
            obj.data.update_tag()
            bpy.context.view_layer.update()
        parts = fingerprint.read_by(settings, all_methods)
        arrays = read_mesh(
            obj,
            given_names if fingerprint.GIVEN in parts else None,
            with_uv=fingerprint.UV in parts,
            depsgraph=depsgraph,
            scope=scope,
        )
    analysed = in_words(works_on(obj) if evaluated else (), scope, arrays)
    return Inputs(obj.name_full, arrays, settings, evaluated, scope, analysed)


def compute(inputs: Inputs, progress: core.Progress | None = None) -> core.Detection:
    """The detection itself; NumPy arrays in and out, nothing of Blender is touched."""
    arrays = inputs.arrays
    detection = core.detect(
        arrays.vertices, arrays.triangles, inputs.settings, progress, **_extra(arrays)
    )
    caches.DETECTIONS.put(content(inputs), detection)
    return detection


def known_or_computed(inputs: Inputs, progress: core.Progress | None = None) -> core.Detection:
    """As `compute`; the last detection is taken again if it was of the very same input.

    What a mesh keeps is not enough to go on from: its attributes are of single precision, and a
    plan must be the same whether or not a detection came before it.
    """
    return caches.DETECTIONS.of(content(inputs), lambda: compute(inputs, progress))


def content(inputs: Inputs) -> str:
    """A digest of all that a detection reads, to the last digit."""
    arrays = inputs.arrays
    values = (arrays.vertices, arrays.triangles, arrays.seams, arrays.sharp, arrays.uv)
    return fingerprint.digest(*values, *(arrays.given or ())) + repr(inputs.settings)


def results_of(inputs: Inputs, detection: core.Detection) -> Results:
    """What `write` wants: packing takes seconds where umbilics are many, and any thread will do."""
    packed = record.pack(inputs.arrays, inputs.settings, detection)
    arrays = inputs.arrays
    marked = arrays.sharp if inputs.settings.crease_marks else None
    suitability = core.suitability(arrays.vertices, arrays.triangles, detection, marked)
    return Results(detection, _attributes(detection, inputs.arrays), packed, suitability)


def compare(inputs: Inputs, progress: core.Progress | None = None) -> tuple[core.MethodResult, ...]:
    """All three methods on the same operators; otherwise as `compute`."""
    arrays = inputs.arrays
    return core.compare(
        arrays.vertices, arrays.triangles, inputs.settings, progress, **_extra(arrays)
    )


def _extra(arrays: MeshArrays) -> dict[str, Any]:
    """What the core takes besides vertices and triangles."""
    given = None
    if arrays.given is not None:
        k1, k2, d1, d2 = arrays.given
        given = core.CurvatureField(k1, k2, d1, d2, np.cross(d1, d2), np.full(len(k1), np.nan))
    return {"given": given, "seams": arrays.seams, "uv": arrays.uv, "sharp": arrays.sharp}


@contextmanager
def unchanged(
    context: bpy.types.Context, inputs: Inputs, whole: Transaction | None = None
) -> Iterator[tuple[bpy.types.Object, bpy.types.Depsgraph | None, Transaction]]:
    """The object that was read, out of Edit Mode, if it is still there and what was read of it is
    the same; with what it was evaluated by, if it was.

    What is written within the block is written as a whole or not at all; with a `whole` it is a
    part of it, which must be taken back in Object Mode.

    Raises
    ------
    core.UmbilicsError
        The object is gone or was changed since `gather`; then nothing is written.
    """
    obj = targets.still_there(inputs.object_name)
    refusals.check_object(obj, inputs.evaluated)
    with object_mode(context, obj), part_of(whole) as transaction:
        depsgraph = context.evaluated_depsgraph_get() if inputs.evaluated else None
        check_unchanged(obj, inputs.arrays, depsgraph)
        # At the end it comes before what cannot be taken back.
        dashed_lines.settle(transaction)
        yield obj, depsgraph, transaction


def write(
    context: bpy.types.Context,
    inputs: Inputs,
    results: Results,
    whole: Transaction | None = None,
) -> int:
    """Store attributes, empties and summary, in place of those of an earlier detection.

    With a `whole` they are a part of it, which must be taken back in Object Mode. Pins and
    deletions stay with their umbilics; how many have none any more is the answer.

    Raises
    ------
    core.UmbilicsError
        The object is gone or was changed since `gather`; then nothing is written.
    """
    with unchanged(context, inputs, whole) as (obj, depsgraph, transaction):
        homes.check_names(obj, RESULTS, homes.DETECTION)
        home = homes.home_for(context, obj, depsgraph, transaction)
        obj = home.owner
        was_shown = maps.is_shown_on(obj)
        maps.hide(context, obj, transaction)
        homes.leave(obj, RESULTS, homes.DETECTION, transaction, home.mesh)
        transaction.keep_attributes(home.mesh, tuple(RESULTS))
        write_results(home.mesh, results.attributes)
        lost = _describe(obj, inputs, results, transaction)
        homes.settle(home, homes.DETECTION, transaction)
        filters.write(context, obj, inputs.settings, transaction, fresh=True)
        if was_shown:
            maps.write(context, [obj], transaction)
    return lost


def _describe(
    obj: bpy.types.Object, inputs: Inputs, results: Results, transaction: Transaction
) -> int:
    """The record and what stands beside it; how many pins and deletions are lost."""
    before, chosen = record.of(obj), pins.rows(obj)
    transaction.keep_properties(obj, "umbilics")
    summary.forget(obj)
    kept = obj.umbilics
    kept.detected = True
    kept.method = inputs.settings.method
    kept.scope, kept.group = inputs.scope.kind, inputs.scope.group
    kept.analysed = inputs.analysed
    suits = results.suitability
    kept.is_coarse, kept.is_hard = suits.is_coarse, suits.is_smeared
    angle = results.detection.crease_angle
    if inputs.settings.crease_angle == core.AUTO and angle < 180.0:
        kept.analysed = f"{inputs.analysed}; creases of more than {angle:.0f}\N{DEGREE SIGN}"
    record.store(obj, results.record)
    return pins.carry_over(obj, chosen, before, results.record.record)


def remove(context: bpy.types.Context, analysed: bpy.types.Object, whole: Transaction) -> bool:
    """Remove everything a detection left on the object, which is in Object Mode; says whether
    there was anything."""
    obj = homes.owner_of(analysed)
    with whole.part() as transaction:
        maps.hide(context, obj, transaction)
        coloured = maps.remove_left(obj.data, transaction)
        values = homes.leave(obj, RESULTS, homes.DETECTION, transaction)
        emptied = empties.remove(obj, transaction)
        guided = guidance_objects.remove_all(obj, transaction)
        checked = checks.remove(obj, transaction)
        transaction.keep_properties(obj, "umbilics")
        described = summary.forget(obj)
        stands_in = display_objects.is_ours(obj)
        if stands_in:
            display_objects.remove(context, obj, transaction)
        copied = old_copies.let_go(context, analysed, transaction)
        dashed_lines.settle(transaction)
    return any((values, coloured, emptied, described, guided, checked, stands_in, copied))


def in_words(works: tuple[str, ...], scope: Scope, arrays: MeshArrays) -> str:
    """What was analysed and what was left out, in a line for the panel."""
    names = ", ".join(works)
    source = f"With {names}" if works else "The mesh itself"
    wanted = len(np.unique(arrays.polygon))
    where = {
        "WHOLE": "whole object",
        "VISIBLE": "visible faces",
        "SELECTED": "selected faces",
        "GROUP": f"group {scope.group}",
    }[scope.kind]
    left_out = 0 if scope.kind == "WHOLE" else arrays.polygon_count - wanted
    count = arrays.polygon_count
    ignored = [f"{left_out} of {count} faces left out"] if left_out else []
    return "; ".join((f"{source}, {where}", *ignored))


def _attributes(detection: core.Detection, arrays: MeshArrays) -> dict[str, np.ndarray]:
    """The arrays of `RESULTS`, from a detection."""
    field = detection.curvature
    # A direction is stored so that it is right when drawn under the object's transform.
    to_object = np.linalg.inv(arrays.matrix[:3, :3]).T
    region = np.zeros(arrays.polygon_count, dtype=np.int32)
    for number, found in enumerate(detection.regions, start=1):
        region[arrays.polygon[found.triangles]] = number
    values = {
        "umbilics_k1": field.k1,
        "umbilics_k2": field.k2,
        "umbilics_gap": field.gap,
        "umbilics_d1": unit_vectors(field.d1 @ to_object),
        "umbilics_d2": unit_vectors(field.d2 @ to_object),
        "umbilics_surface_type": detection.surface_type,
        "umbilics_index": np.bincount(
            arrays.polygon, weights=detection.triangle_index, minlength=arrays.polygon_count
        ),
        "umbilics_region": region,
    }
    if np.isfinite(detection.conformal_scale).any():
        values["umbilics_conformal_scale"] = detection.conformal_scale
    if arrays.scope.is_momentary:
        inside = np.zeros(arrays.polygon_count, dtype=np.int32)
        inside[arrays.polygon] = 1
        values[KEPT] = inside
    return values
