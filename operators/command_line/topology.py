"""`--check-topology`: a mesh of the user's held against the surface; and what is said of that, as
of the quads that `--quads` makes."""

from __future__ import annotations

import dataclasses
from typing import Any

import bpy
import numpy as np

from ... import core
from ..base.errors import FileError
from ..base.words import TopologyFigures
from ..mesh.read import polygons_in_world
from .files import companions, importers
from .files.file_kinds import UPRIGHT
from .files.guard import shown
from .steering import ByHand


@dataclasses.dataclass(frozen=True)
class Checked:
    """A mesh that is to be checked.

    Attributes
    ----------
    label:
        What it is called in sentences and reports.
    vertices:
        (n, 3) places in the coordinates of the file.
    corners, start:
        (c,) vertices of the faces one behind the other, and (f + 1,) where each begins.
    """

    label: str
    vertices: np.ndarray
    corners: np.ndarray
    start: np.ndarray


def from_file(path: str, file: str) -> Checked:
    """The meshes of a file, taken together, or of the one in a folder that is called like `file`.

    Blender is left with them open.

    Raises
    ------
    FileError
        There is no such file, or nothing with faces in it.
    """
    words = "mesh", "meshes"
    chosen = companions.companion_of(file, path, importers.SUFFIXES, "--check-topology", words)
    opened = importers.open_file(str(chosen), "")
    return _joined(shown(chosen), opened.objects, opened.to_file)


def from_object(name: str) -> Checked:
    """An object of the scene that is open.

    Raises
    ------
    FileError
        There is no such mesh, or it has no faces.
    """
    obj = bpy.context.scene.objects.get(name)
    if obj is None or obj.type != "MESH":
        raise FileError(
            f"--check-topology {name}: there is no mesh called so in the open file. Without FILE "
            "it names an object."
        )
    return _joined(name, [obj], UPRIGHT)


def _joined(label: str, objects: list[bpy.types.Object], to_file: np.ndarray) -> Checked:
    """Several meshes as one."""
    bpy.context.view_layer.update()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    vertices: list[np.ndarray] = []
    corners: list[np.ndarray] = []
    sizes: list[np.ndarray] = []
    count = 0
    for obj in objects:
        places, mine, start = polygons_in_world(obj, depsgraph)
        vertices.append(places @ to_file.T)
        corners.append(mine + count)
        sizes.append(np.diff(start))
        count += len(places)
    if not sum(map(len, corners)):
        raise FileError(f"{label}: it has no faces to check.")
    start = np.concatenate([[0], np.cumsum(np.concatenate(sizes))])
    return Checked(label, np.concatenate(vertices), np.concatenate(corners), start)


def check(
    checked: Checked,
    guide: core.Guide,
    settings: core.GuidanceSettings,
    sharp: np.ndarray | None,
    by_hand: ByHand,
    to_file: np.ndarray,
    progress: core.Progress,
) -> tuple[list[str], dict[str, Any]]:
    """Hold the mesh against a surface, whose world `to_file` (3, 3) turns into file coordinates;
    sentences on it, and what the report says."""
    guidance = guide.guidance(
        settings,
        progress.part("Planning", 0.0, 0.7),
        sharp=sharp,
        strokes=by_hand.strokes,
        wanted=by_hand.wanted,
    )
    poles = guidance.poles
    # A turn back is its transpose.
    places = checked.vertices @ to_file
    part = progress.part("Checking", 0.7, 1.0)
    found = core.check_topology(places, checked.corners, checked.start, guide, poles, part)
    missing = found.missing
    entry = {
        "checked": checked.label,
        "vertices": len(checked.vertices),
        **figures(found),
        "irregular_vertices": [
            {"vertex": vertex, "valence": valence, "position": place, "planned": pole >= 0}
            for vertex, valence, place, pole in zip(
                found.irregular.tolist(),
                found.valence.tolist(),
                checked.vertices[found.irregular].tolist(),
                found.pole.tolist(),
                strict=True,
            )
        ],
        "missing_poles": [
            {"valence": valence, "position": place}
            for valence, place in zip(
                poles.valence[missing].tolist(),
                (poles.position[missing] @ to_file.T).tolist(),
                strict=True,
            )
        ],
    }
    return [f"Topology of {checked.label}: {in_words(found)}"], {"topology": entry}


def of_quads(
    made: core.QuadMesh, check: core.TopologyCheck, settings: core.RemeshSettings
) -> dict[str, Any]:
    """What the report says of a mesh that was remeshed."""
    by_number = settings.edge_length == core.AUTO
    return {
        "asked": settings.quads if by_number else None,
        "vertices": len(made.vertices),
        "patches": len(np.unique(made.patch)),
        **figures(check),
        "warnings": list(made.warnings),
        "timings": made.timings,
    }


def figures(check: core.TopologyCheck) -> dict[str, Any]:
    """How well a mesh follows surface and plan, in numbers; lengths as in the file."""
    jacobian = check.jacobian[np.isfinite(check.jacobian)]
    return {
        "faces": len(check.angle),
        "quads": check.quads,
        "irregular": len(check.irregular),
        "matched": check.matched,
        "missing": len(check.missing),
        "extra": check.extra,
        "angle": check.mean_angle,
        "jacobian": {
            "least": check.least_jacobian,
            "mean": float(jacobian.mean()) if len(jacobian) else None,
        },
        "folded": int(check.folded.sum()),
        "distance": {
            "mean": float(check.distance.mean()) if len(check.distance) else None,
            "largest": float(check.distance.max(initial=0.0)),
            "from_surface": check.farthest,
        },
        "covered": check.covered,
        "edge": check.edge,
    }


def in_words(check: core.TopologyCheck) -> str:
    """The same in a sentence."""
    return f"{'. '.join(TopologyFigures.of(check).lines())}."
