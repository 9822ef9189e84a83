"""Everything that can be exported of a guidance, in one call, for front ends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..base.errors import GuidanceError
from ..base.progress import Progress
from ..retopology.by_hand import Strokes, WantedPoles
from ..retopology.guidance import Guidance
from ..retopology.planner import Guide
from ..retopology.quads.remesh import remesh
from ..retopology.quads.result import QuadMesh
from ..retopology.quads.settings import RemeshSettings
from ..retopology.settings import GuidanceSettings
from ..retopology.topology_check import TopologyCheck, check_quads
from .guidance import QUAD_KINDS, Exported, guidance_paths, write_guidance


@dataclass(frozen=True)
class Written:
    """What `export_guidance` has written.

    Attributes
    ----------
    paths:
        The files.
    guidance:
        The plan that they hold.
    left_out:
        Sentences on what was asked for and is not there.
    quads, check:
        The quad mesh, and how it follows surface and plan; None where it was not asked for.
    """

    paths: list[Path]
    guidance: Guidance
    left_out: tuple[str, ...]
    quads: QuadMesh | None = None
    check: TopologyCheck | None = None


def export_guidance(
    stem: Path,
    kinds: Sequence[str],
    guide: Guide,
    settings: GuidanceSettings,
    *,
    mesh: tuple[np.ndarray, np.ndarray],
    sharp: np.ndarray | None = None,
    zone: np.ndarray | None = None,
    strokes: Strokes | None = None,
    wanted: WantedPoles | None = None,
    to_file: np.ndarray | None = None,
    remeshing: RemeshSettings | None = None,
    progress: Progress | None = None,
) -> Written:
    """Plan, trace and remesh as is asked for, and write the files of the given kinds.

    A surface without lines of curvature has no file of them; the others are written.

    Parameters
    ----------
    stem, kinds, to_file:
        As for `write_guidance`.
    mesh:
        (n, 3) float64 vertices and (m, 3) int triangles, those of `guide`.
    sharp, zone, strokes, wanted:
        As for `Guide.guidance`.
    remeshing:
        How the quads are made, if their kinds are asked for.

    Raises
    ------
    GuidanceError
        Nothing but lines is asked for, and there are none.
    RemeshError
        The surface cannot be covered with quads.
    FormatError
        There is no such kind, or a file cannot be written.

    Examples
    --------
    The poles and the field of an ellipsoid of `vertices` and `triangles`, as in `detect`:

    >>> from pathlib import Path
    >>> guide = core.Guide(vertices, triangles, core.detect(vertices, triangles))
    >>> written = core.export_guidance(
    ...     Path("ellipsoid"),
    ...     ["rosy", "sing"],
    ...     guide,
    ...     core.GuidanceSettings(),
    ...     mesh=(vertices, triangles),
    ... )
    >>> [path.name for path in written.paths]
    ['ellipsoid.rosy', 'ellipsoid.sing']
    """
    progress = progress or Progress()
    # A kind that there is not is told before the work.
    guidance_paths(Path(stem), kinds)
    # Quads take as long as all the rest.
    with_quads = any(kind in QUAD_KINDS for kind in kinds)
    rest = progress.part("Planning", 0.0, 0.4 if with_quads else 0.8)
    guidance = guide.guidance(
        settings,
        rest.part("Planning", 0.0, 0.5),
        sharp=sharp,
        zone=zone,
        strokes=strokes,
        wanted=wanted,
    )
    kinds, left_out, lines = list(kinds), [], None
    if "lines" in kinds:
        try:
            lines = guide.lines(settings, rest.part("Lines", 0.5, 0.85))
        except GuidanceError as error:
            kinds.remove("lines")
            left_out.append(str(error))
            if not kinds:
                raise
    arcs = None
    if "separatrices" in kinds:
        arcs = guide.separatrices(settings, rest.part("Separatrices", 0.85, 0.93))
    ridges = None
    if "ridges" in kinds or "ridge_figures" in kinds:
        ridges = guide.ridges(settings, rest.part("Ridges", 0.93, 1.0))
    made = check = None
    if with_quads:
        part = progress.part("Remeshing", 0.4, 0.75)
        made = remesh(
            *mesh,
            remeshing,
            part,
            detection=guide.detection,
            sharp=sharp,
            zone=zone,
            strokes=strokes,
            wanted=wanted,
        )
        check = check_quads(made, guide, progress.part("Checking", 0.75, 0.8))
    data = Exported(*mesh, guide, guidance, lines, arcs, ridges, made)
    paths = write_guidance(stem, kinds, data, to_file, progress.part("Writing files", 0.8, 1.0))
    return Written(paths, guidance, tuple(left_out), made, check)
