"""What the command is asked to do, once its arguments are read."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

from .... import core
from ...data.properties import GIVEN_NAMES
from .. import guidance, matching, steering
from ..batch import Plan
from ..files.guard import Guard
from ..stopping import Stop
from . import source as source_arguments


@dataclasses.dataclass(frozen=True)
class Limits:
    """What one file may take: seconds and bytes, None for no bound."""

    seconds: float | None = None
    memory: int | None = None

    def __bool__(self) -> bool:
        return self.seconds is not None or self.memory is not None


@dataclasses.dataclass(frozen=True)
class Request:
    """What the command is asked to do.

    Attributes
    ----------
    files:
        The files, None for the one that Blender has open.
    objects:
        Names of the meshes to take, or none for all.
    frames:
        Frames of the animation, or none for the one that the file has.
    source:
        What of each object is analysed.
    outputs:
        For each file where its JSON, .blend, PNG, PLY and USD go.
    planning:
        How poles are planned.
    guidance:
        Files for remeshers.
    check:
        File or folder of the mesh that is held against the surface, or its name in the open
        scene; None without.
    steering:
        What plans are steered by, None without.
    events:
        Tell of the progress in JSON lines on standard output, instead of in sentences.
    limits:
        Of each file.
    stop:
        Hears that the command is to end before it is done.
    worker_arguments:
        What gives another process the same settings.
    is_worker:
        This process belongs to another one, and ends with it.
    guard:
        Holds the paths of all inputs and results.
    matching:
        What the meshes are to be brought onto, and whether their symmetry is asked for.
    batch:
        With one other processes do the files.
    summary:
        With one nothing is done but the summary of the batches in that folder.
    """

    files: tuple[str | None, ...]
    objects: tuple[str, ...]
    frames: tuple[int, ...]
    source: source_arguments.Source
    settings: core.Settings
    given_names: tuple[str, ...]
    per_vertex: bool
    compare: bool
    outputs: tuple[dict[str, Path], ...]
    guard: Guard
    events: bool = False
    limits: Limits = Limits()
    stop: Stop = dataclasses.field(default_factory=Stop)
    worker_arguments: tuple[str, ...] = ()
    is_worker: bool = False
    planning: core.GuidanceSettings = dataclasses.field(default_factory=core.GuidanceSettings)
    guidance: guidance.GuidanceRequest | None = None
    matching: matching.MatchingRequest | None = None
    check: str | None = None
    steering: steering.SteeringRequest | None = None
    batch: Plan | None = None
    summary: tuple[Path, Path | None] | None = None

    def every_setting(self) -> dict[str, Any]:
        """All settings that count for the results, by their names as options of the command; those
        of what was not asked for are left out."""
        found = {
            **dataclasses.asdict(self.settings),
            "source": self.source.reading.source.lower(),
            "scope": self.source.scope.kind.lower(),
        }
        if self.source.scope.group:
            found["scope_group"] = self.source.scope.group
        if self.settings.curvature == "given":
            found |= dict(zip(GIVEN_NAMES, self.given_names, strict=True))
        if self.guidance is not None or self.check is not None:
            found |= dataclasses.asdict(self.planning)
        if self.guidance is not None and self.guidance.makes_quads:
            remeshing = dataclasses.asdict(self.guidance.remeshing)
            found |= {guidance.quad_setting(name): value for name, value in remeshing.items()}
        if self.steering is not None:
            strokes = dataclasses.asdict(self.steering.settings)
            found |= {steering.setting_name(name): value for name, value in strokes.items()}
        if self.matching is not None and self.matching.files:
            found["align_scaled"] = self.matching.scaled
        return found
