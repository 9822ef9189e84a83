"""What is made of a mesh that is ready for guidance: work for a `retopology.Job`.

Each takes the job, its `core.Guide` and whom to tell, and touches arrays only.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from ... import core
from ..scene.retopology import guidance_objects
from .retopology import Job


def plan(
    job: Job, guide: core.Guide, progress: core.Progress
) -> tuple[core.Guidance, guidance_objects.Kept]:
    """Cross field and poles, and the umbilics they come from."""
    guidance = guide.guidance(
        job.settings,
        progress,
        sharp=job.inputs.arrays.sharp,
        zone=job.zone,
        strokes=job.steering.strokes,
        wanted=job.steering.wanted,
    )
    found = guide.detection
    numbers = core.numbers(found.candidates)[job.kept_rows(found)]
    return guidance, guidance_objects.Kept(found.umbilics, numbers)


def lines(job: Job, guide: core.Guide, progress: core.Progress) -> core.Lines:
    """Evenly spaced lines of curvature."""
    return guide.lines(job.settings, progress)


def separatrices(job: Job, guide: core.Guide, progress: core.Progress) -> core.Lines:
    """Separatrices of the kept umbilics, each arc once."""
    return guide.separatrices(job.settings, progress)


def ridges(job: Job, guide: core.Guide, progress: core.Progress) -> core.RidgeLines:
    """Ridges, ravines and crest lines."""
    return guide.ridges(job.settings, progress)


def ridges_on_edges(
    job: Job, guide: core.Guide, progress: core.Progress
) -> tuple[core.RidgeLines, core.RidgeEdges | None]:
    """Ridges, and what the mesh's edges have of them, if there are edges."""
    found = ridges(job, guide, progress)
    if job.edges is None:
        return found, None
    return found, core.ridge_edges(job.inputs.arrays.vertices, job.edges, found)


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


def rotation(job: Job, guide: core.Guide, progress: core.Progress) -> core.RotationSymmetry:
    """The rotation symmetry."""
    arrays = job.inputs.arrays
    shape = core.Shape.of(arrays.vertices, arrays.triangles, guide.detection)
    return core.find_rotation(shape, progress)


def edges_along(traced: Callable[..., core.Lines]) -> Callable[..., np.ndarray]:
    """Work that traces lines and answers with the (e,) bool edges nearest to them."""

    def work(job: Job, guide: core.Guide, progress: core.Progress) -> np.ndarray:
        found = traced(job, guide, progress)
        assert job.edges is not None, "gathered with edges"
        return core.edge_paths(job.inputs.arrays.vertices, job.edges, found)

    return work


def exported(
    stem: Path, kinds: list[str], remeshing: core.RemeshSettings
) -> Callable[..., core.Written]:
    """Work that writes files of the given kinds, named after `stem`."""

    def work(job: Job, guide: core.Guide, progress: core.Progress) -> core.Written:
        arrays = job.inputs.arrays
        return core.export_guidance(
            stem,
            kinds,
            guide,
            job.settings,
            mesh=(arrays.vertices, arrays.triangles),
            sharp=arrays.sharp,
            zone=job.zone,
            remeshing=remeshing,
            strokes=job.steering.strokes,
            wanted=job.steering.wanted,
            progress=progress,
        )

    return work
