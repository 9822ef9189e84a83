"""Guidance in three steps, like a detection in `detect`: gather, compute, write; what can be made
in the second is in `works`.

The detection that it builds on is the object's as it is now: the last one is taken again where it
was of the very same input, else it is made anew. The umbilics that the user keeps, by filters,
pins and deletions, are taken from the object's record, and found again by their places if the
record is of something older.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any

import bpy
import numpy as np

from ... import core
from ..base import caches
from ..base.errors import ObjectError
from ..data import pins, plans, properties, reading, record, topology
from ..mesh import fingerprint
from ..mesh.attributes import check_result_names, is_whole
from ..mesh.read import current_mesh, edge_vertices
from ..mesh.scope import Scope, in_vertex_group, scope_in_file
from ..scene import display_objects, filters, homes, targets
from ..scene.modes import object_mode
from ..scene.retopology import by_hand, guidance_objects, marked_edges
from ..scene.transaction import Transaction
from . import detect, refusals


@dataclass(frozen=True)
class Choice:
    """The umbilics that the user keeps.

    Attributes
    ----------
    record:
        Of the detection that the user chose among.
    filters:
        What its results went through.
    by_hand:
        Rows pinned and rows deleted.
    """

    record: record.Record
    filters: core.Settings
    by_hand: tuple[list[int], list[int]]

    def rows_in(self, inputs: detect.Inputs, detection: core.Detection) -> np.ndarray:
        """(k,) rows of the candidates of a detection that are kept."""
        after = record.of_detection(inputs.arrays, inputs.settings, detection)
        then, now = self.record.detection.candidates, after.detection.candidates
        by_hand = self.by_hand
        if not (
            np.array_equal(then.triangle, now.triangle)
            and np.array_equal(then.barycentric, now.barycentric, equal_nan=True)
        ):
            by_hand, _ = pins.counterparts(by_hand, self.record, after)
        return core.kept_rows(detection, self.filters, *by_hand)


@dataclass(frozen=True)
class Job:
    """What a step of the guidance needs, read from the scene; no reference to Blender's data.

    Attributes
    ----------
    inputs:
        The mesh and the settings of the detection.
    settings:
        Those of the guidance.
    choice:
        The umbilics that the user keeps, or None for what the detection's own filters keep.
    zone, zone_name:
        Vertices where no pole is wanted, or None; and the vertex group that they come from.
    edges:
        (e, 2) vertices of the mesh's edges, if they are wanted.
    work:
        What is to be made of a `core.Guide`; touches arrays only.
    steering:
        What the user drew and moved.
    notes:
        Sentences for the user, beside what comes of it.
    """

    inputs: detect.Inputs
    settings: core.GuidanceSettings
    choice: Choice | None
    zone: np.ndarray | None
    zone_name: str
    edges: np.ndarray | None
    work: Callable[[Job, core.Guide, core.Progress], Any] = field(repr=False)
    steering: by_hand.ByHand = field(default_factory=by_hand.ByHand)
    notes: tuple[str, ...] = ()

    @property
    def object_name(self) -> str:
        return self.inputs.object_name

    def compute(self, progress: core.Progress | None = None) -> Any:
        """The work; any thread may run it."""
        progress = progress or core.Progress()
        guide = self._prepared(progress.part("Detecting", 0.0, 0.5))
        return self.work(self, guide, progress.part("Planning", 0.5, 1.0))

    def origin(self, umbilics: core.Umbilics) -> plans.Origin:
        """What a plan from these umbilics is made of."""
        arrays = self.inputs.arrays
        read = arrays.fingerprint
        return plans.Origin(
            fingerprint=read.plus(fingerprint.ZONE, self.zone) if self.zone_name else read,
            detecting=self.inputs.settings,
            given_names=arrays.given_names,
            scope=self.inputs.scope,
            settings=self.settings,
            zone=self.zone_name,
            kept=filters.digest_of(umbilics),
            strokes=self.steering.digest,
        )

    def kept_rows(self, detection: core.Detection) -> np.ndarray:
        """(k,) rows of the candidates of a detection of the inputs that are kept."""
        if self.choice is None:
            return core.kept_rows(detection, self.inputs.settings)
        return self.choice.rows_in(self.inputs, detection)

    def _prepared(self, progress: core.Progress) -> core.Guide:
        """The mesh with its detection and the umbilics that are kept; that of the step before if
        it is the very same."""
        arrays = self.inputs.arrays
        detection = detect.known_or_computed(self.inputs, progress)
        rows = self.kept_rows(detection)
        return caches.GUIDES.of(
            (detect.content(self.inputs), rows.tobytes()),
            lambda: core.Guide(arrays.vertices, arrays.triangles, detection, rows),
        )


def gather(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    work: Callable[[Job, core.Guide, core.Progress], Any],
    with_edges: bool = False,
    *,
    own_edges: bool = False,
    settings: core.GuidanceSettings | None = None,
    steered: bool = False,
    with_poles: bool = True,
) -> Job:
    """Read an object; the scene is not changed.

    Without `settings` they are those of the scene. `with_edges` reads the edges of the object's own
    mesh, `own_edges` only where they are those that are seen. `steered` says that guide strokes
    count, and `with_poles` that poles which the user moved, added or deleted are to stay so.

    Raises
    ------
    core.UmbilicsError
        The object cannot be read, or results could not be stored; the text says why.
    """
    scene = context.scene
    settings = settings or plans.to_guidance_settings(scene.umbilics_guidance)
    known, choice = record.of(obj), None
    if known is not None:
        detecting, names = known.settings, known.given_names
        choice = Choice(known, filters.used_filters(obj), pins.rows(obj))
    else:
        detecting = properties.to_settings(scene.umbilics)
        names = properties.given_names(scene.umbilics)
    obj, evaluated, scope = _to_read(scene, obj)
    refusals.check_object(obj, evaluated)
    homes.check_names(obj, guidance_objects.ATTRIBUTES, homes.PLAN)
    for layouts in (marked_edges.MARKS, marked_edges.RIDGE_EDGES):
        check_result_names(obj, layouts, is_whole(obj.data, layouts))
    depsgraph = context.evaluated_depsgraph_get() if evaluated else None
    inputs = detect.gather(obj, detecting, names, depsgraph=depsgraph, scope=scope)
    zone_name = scene.umbilics_guidance.zone
    edges = zone = None
    with object_mode(context, obj, push=False), current_mesh(obj, depsgraph) as mesh:
        if with_edges:
            _check_marks(obj, mesh)
        if with_edges or (own_edges and _has_edges_of(obj, mesh)):
            edges = edge_vertices(mesh)
        if zone_name:
            zone = in_vertex_group(obj, mesh, zone_name)
    notes = () if known is None else _outdated(known, inputs)
    steering = by_hand.ByHand()
    if steered:
        steering = by_hand.read(scene, homes.owner_of(obj), inputs.arrays, with_poles)
    return Job(inputs, settings, choice, zone, zone_name, edges, work, steering, notes)


def _outdated(known: record.Record, inputs: detect.Inputs) -> tuple[str, ...]:
    """A sentence if the umbilics that are shown are of something older than what was read."""
    parts = fingerprint.read_by(known.settings)
    changed = known.fingerprint.changed(inputs.arrays.fingerprint, parts)
    if not changed:
        return ()
    what = " ".join(fingerprint.WORDS[part] for part in changed)
    return (
        f"The umbilics that are shown are out of date. {what} This was made from the mesh as it "
        "is now; detect again to see its umbilics.",
    )


def _to_read(scene: bpy.types.Scene, obj: bpy.types.Object) -> tuple[bpy.types.Object, bool, Scope]:
    """The object, form and part that the object's detection was made of, else the scene's."""
    if obj.umbilics.detected:
        kept = obj.umbilics
        found = kept.source == "EVALUATED", scope_in_file(kept.scope, kept.group)
    else:
        display = scene.umbilics_display
        found = display.source == "EVALUATED", reading.scope_of(display)
    return display_objects.source_of(obj), *found


def _check_marks(obj: bpy.types.Object, mesh: bpy.types.Mesh) -> None:
    """Raise `ObjectError` where edges of `mesh` are none of the object's own."""
    if not targets.is_own(obj):
        raise ObjectError(
            f"{obj.name} is linked from another file and its edges cannot be marked here. Make it "
            "and its mesh local: Object > Relations > Make Local."
        )
    if not _has_edges_of(obj, mesh):
        raise ObjectError(
            f"The edges that are seen are not those of {obj.name}'s own mesh, which marks are "
            "kept with. Apply its modifiers, or detect with Source: Base Mesh."
        )


def _has_edges_of(obj: bpy.types.Object, mesh: bpy.types.Mesh) -> bool:
    """Whether edges of `mesh`, as it is seen, are those of the object's own mesh."""
    return targets.is_own(obj) and homes.same_faces(mesh, obj.data)


@contextmanager
def written(context: bpy.types.Context, job: Job) -> Iterator[tuple[bpy.types.Object, Transaction]]:
    """The object that keeps the results, out of Edit Mode, if what was read is still the same;
    what is written within the block is written as a whole or not at all.

    Raises
    ------
    core.UmbilicsError
        The object is gone or was changed since `gather`; then nothing is written.
    """
    with detect.unchanged(context, job.inputs) as (obj, depsgraph, transaction):
        if not (targets.is_local(obj) or homes.owner_of(obj) != obj):
            homes.home_for(context, obj, depsgraph, transaction)
        yield homes.owner_of(obj), transaction


def home_of_plan(context: bpy.types.Context, job: Job, transaction: Transaction) -> homes.Home:
    """Where a plan goes, within the block of `written`."""
    depsgraph = context.evaluated_depsgraph_get() if job.inputs.evaluated else None
    obj = targets.still_there(job.object_name)
    return homes.home_for(context, obj, depsgraph, transaction, homes.PLAN)


def against(job: Job, umbilics: core.Umbilics, own_plan: bool = False) -> topology.Against:
    """What a check by a plan from these umbilics holds a mesh against, or by the plan that it was
    laid out with: then nothing hangs on what else a plan is made of.

    Raises
    ------
    core.UmbilicsError
        The surface is gone.
    """
    surface = targets.still_there(job.object_name)
    origin, steered = job.origin(umbilics), job.steering.digest_of_poles
    if own_plan:
        settings = replace(origin.settings, align_sharp=False)
        origin, steered = replace(origin, settings=settings, zone="", strokes=""), ""
    return topology.Against(surface, job.inputs.evaluated, origin, steered, own_plan)
