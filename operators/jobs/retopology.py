"""Guidance in three steps, like a detection in `engine`: gather, compute, write.

The detection that it builds on is computed again where it is not at hand; the umbilics that the
user keeps, by filters, pins and deletions, are taken from the object's record.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ... import core
from ..base.errors import ObjectError
from ..data import plans, properties, reading, record, summary
from ..mesh.attributes import check_result_names
from ..mesh.read import check_unchanged, current_mesh, edge_vertices
from ..mesh.scope import Scope, in_vertex_group
from ..scene import display_objects, filters, guidance_objects, homes, targets
from ..scene.modes import object_mode
from . import detect

# The last mesh that was prepared, with its key: the steps of one plan follow each other.
_latest: tuple[tuple, core.Guide] | None = None


@dataclass(frozen=True)
class Job:
    """What a step of the guidance needs, read from the scene; no reference to Blender's data.

    Attributes
    ----------
    inputs:
        The mesh and the settings of the detection.
    settings:
        Those of the guidance.
    kept:
        Rows of the candidates that the user keeps, or None for what the filters keep.
    candidates:
        How many candidates the record has, to know that the rows mean the same.
    zone:
        Vertices where no pole is wanted, or None.
    edges:
        (e, 2) vertices of the mesh's edges, if they are wanted.
    work:
        What is to be made of a `core.Guide`; touches arrays only.
    """

    inputs: detect.Inputs
    settings: core.GuidanceSettings
    kept: np.ndarray | None
    candidates: int
    zone: np.ndarray | None
    edges: np.ndarray | None
    work: Callable[[Job, core.Guide, core.Progress], Any] = field(repr=False)

    @property
    def object_name(self) -> str:
        return self.inputs.object_name

    def compute(self, progress: core.Progress | None = None) -> Any:
        """The work; any thread may run it."""
        progress = progress or core.Progress()
        guide = _prepared(self, progress.part("Detecting", 0.0, 0.5))
        return self.work(self, guide, progress.part("Planning", 0.5, 1.0))


def gather(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    work: Callable[[Job, core.Guide, core.Progress], Any],
    with_edges: bool = False,
) -> Job:
    """Read an object; the scene is not changed.

    Raises
    ------
    core.UmbilicsError
        The object cannot be read, or results could not be stored; the text says why.
    """
    scene = context.scene
    settings = plans.to_guidance_settings(scene.umbilics_guidance)
    known = record.of(obj)
    kept = None
    if known is not None:
        detecting = core.Settings(**known.settings)
        by_hand = (summary.rows_of(obj.umbilics.pinned), summary.rows_of(obj.umbilics.deleted))
        kept = core.kept_rows(known.detection, filters.used_filters(obj), *by_hand)
    else:
        detecting = properties.to_settings(scene.umbilics)
    obj, evaluated, scope = _to_read(scene, obj)
    detect.check_object(obj, evaluated)
    for layouts in (guidance_objects.ATTRIBUTES, guidance_objects.MARKS):
        check_result_names(obj, layouts)
    depsgraph = context.evaluated_depsgraph_get() if evaluated else None
    names = properties.given_names(scene.umbilics)
    inputs = detect.gather(obj, detecting, names, depsgraph=depsgraph, scope=scope)
    edges = zone = None
    with object_mode(context, obj, push=False), current_mesh(obj, depsgraph) as mesh:
        if with_edges:
            _check_marks(obj, mesh)
            edges = edge_vertices(mesh)
        if scene.umbilics_guidance.zone:
            zone = in_vertex_group(obj, mesh, scene.umbilics_guidance.zone)
    return Job(
        inputs=inputs,
        settings=settings,
        kept=kept,
        candidates=-1 if known is None else len(known.detection.candidates),
        zone=zone,
        edges=edges,
        work=work,
    )


def _to_read(scene: bpy.types.Scene, obj: bpy.types.Object) -> tuple[bpy.types.Object, bool, Scope]:
    """The object, form and part that the object's detection was made of, else the scene's."""
    if obj.umbilics.detected:
        kept = obj.umbilics
        found = kept.source == "EVALUATED", Scope(kept.scope or "WHOLE", kept.group)
    else:
        display = scene.umbilics_display
        found = display.source == "EVALUATED", reading.scope_of(display)
    return display_objects.source_of(obj), *found


def _check_marks(obj: bpy.types.Object, mesh: bpy.types.Mesh) -> None:
    """Raise `ObjectError` where edges of `mesh` are none of the object's own."""
    if not targets.is_own(obj) or not homes.same_faces(mesh, obj.data):
        raise ObjectError(
            f"The edges that are seen are not those of {obj.name}'s own mesh, which marks are "
            "kept with. Apply its modifiers, or detect with Source: Base Mesh."
        )


@contextmanager
def written(context: bpy.types.Context, job: Job) -> Iterator[bpy.types.Object]:
    """The object that keeps the results, out of Edit Mode, if what was read is still the same.

    Raises
    ------
    core.UmbilicsError
        The object is gone or was changed since `gather`; then nothing is written.
    """
    obj = targets.named(job.object_name)
    if obj is None:
        raise ObjectError(f"{job.object_name} is no longer there. Try again.")
    detect.check_object(obj, job.inputs.evaluated)
    with object_mode(context, obj):
        depsgraph = context.evaluated_depsgraph_get() if job.inputs.evaluated else None
        check_unchanged(obj, job.inputs.arrays, depsgraph)
        if not (targets.is_local(obj) or homes.owner_of(obj) != obj):
            homes.home_for(context, obj, depsgraph)
        yield homes.owner_of(obj)


def home_of_plan(context: bpy.types.Context, job: Job) -> homes.Home:
    """Where a plan goes, within the block of `written`."""
    depsgraph = context.evaluated_depsgraph_get() if job.inputs.evaluated else None
    return homes.home_for(context, targets.named(job.object_name), depsgraph, homes.PLAN)


def plan(job: Job, guide: core.Guide, progress: core.Progress) -> tuple:
    """Cross field and poles, and the umbilics they come from."""
    guidance = guide.guidance(job.settings, progress, sharp=job.inputs.arrays.sharp, zone=job.zone)
    return guidance, guide.detection.umbilics


def lines(job: Job, guide: core.Guide, progress: core.Progress) -> core.Lines:
    """Evenly spaced lines of curvature."""
    return guide.lines(job.settings, progress)


def separatrices(job: Job, guide: core.Guide, progress: core.Progress) -> core.Lines:
    """Separatrices of the kept umbilics, each arc once."""
    return guide.separatrices(job.settings, progress)


def ridges(job: Job, guide: core.Guide, progress: core.Progress) -> core.RidgeLines:
    """Ridges, ravines and crest lines."""
    return guide.ridges(job.settings, progress)


def guides(
    job: Job, guide: core.Guide, progress: core.Progress
) -> tuple[core.Lines, core.Lines, core.RidgeLines]:
    """Lines of curvature, separatrices and ridges."""
    return (
        lines(job, guide, progress.part("Lines", 0.0, 0.6)),
        separatrices(job, guide, progress.part("Separatrices", 0.6, 0.8)),
        ridges(job, guide, progress.part("Ridges", 0.8, 1.0)),
    )


def mirror(job: Job, guide: core.Guide, progress: core.Progress) -> core.MirrorPlane:
    """The mirror plane."""
    return guide.symmetry(progress)


def edges_along(traced: Callable[..., core.Lines]) -> Callable[..., np.ndarray]:
    """Work that traces lines and answers with the (e,) bool edges nearest to them."""

    def work(job: Job, guide: core.Guide, progress: core.Progress) -> np.ndarray:
        found = traced(job, guide, progress)
        return core.edge_paths(job.inputs.arrays.vertices, job.edges, found)

    return work


def exported(stem: Path, kinds: list[str]) -> Callable[..., list[Path]]:
    """Work that writes files of the given kinds, named after `stem`; their paths."""

    def work(job: Job, guide: core.Guide, progress: core.Progress) -> list[Path]:
        guidance, _ = plan(job, guide, progress.part("Planning", 0.0, 0.4))
        arrays = job.inputs.arrays
        data = core.Exported(
            arrays.vertices,
            arrays.triangles,
            guide,
            guidance,
            lines(job, guide, progress.part("Lines", 0.4, 0.7)) if "lines" in kinds else None,
            separatrices(job, guide, progress.part("Separatrices", 0.7, 0.75))
            if "separatrices" in kinds
            else None,
            ridges(job, guide, progress.part("Ridges", 0.75, 0.8))
            if {"ridges", "ridge_figures"} & set(kinds)
            else None,
        )
        part = progress.part("Writing files", 0.8, 1.0)
        return core.write_guidance(stem, kinds, data, progress=part)

    return work


def _prepared(job: Job, progress: core.Progress) -> core.Guide:
    """The mesh with its detection; that of the step before if it is still the same."""
    global _latest
    arrays = job.inputs.arrays
    key = (
        job.object_name,
        arrays.signature,
        repr(job.inputs.settings),
        arrays.matrix.tobytes(),
        zlib.crc32(arrays.loop_triangle),
    )
    if _latest is None or _latest[0] != key:
        detection = detect.compute(job.inputs, progress)
        _latest = key, core.Guide(arrays.vertices, arrays.triangles, detection)
    guide = _latest[1]
    if job.kept is not None and job.candidates == len(guide.detection.candidates):
        guide.keep(job.kept)
    return guide


def forget() -> None:
    """Let go of the mesh that was prepared last."""
    global _latest
    _latest = None
