"""The kinds of files that a guidance can be written to, and what writes each."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

import numpy as np

from ..base.errors import FormatError
from ..base.progress import Progress
from ..base.unit import unit
from ..retopology.guidance import Guidance
from ..retopology.lines.polylines import Lines
from ..retopology.planner import Guide
from ..retopology.poles import Poles
from ..retopology.quads.result import QuadMesh
from ..retopology.ridges.ridge_lines import RidgeLines
from ..umbilics.result import Umbilics
from .curves import write_curves
from .fields.dmat import write_dmat
from .fields.rawfield import write_rawfield
from .fields.rosy import write_rosy
from .fields.sharp import write_sharp
from .fields.sing import write_sing
from .mesh import write_mesh
from .points import (
    Table,
    poles_table,
    ridges_table,
    umbilics_table,
    write_points_csv,
    write_points_json,
)
from .quads import write_quads


@dataclass(frozen=True)
class FileKind:
    """One kind of file: its ending after the common name, what it is for, further endings."""

    ending: str
    label: str
    help: str
    more: tuple[str, ...] = ()


FILE_KINDS = {
    "mesh": FileKind(".obj", "Triangles (OBJ)", "The triangles that the field files belong to"),
    "rosy": FileKind(".rosy", "RoSy (QuadWild)", "One direction of each face's cross (.rosy)"),
    "rawfield": FileKind(
        ".rawfield", "Raw Field (Directional)", "All four directions of each face's cross"
    ),
    "sing": FileKind(".sing", "Singularities (Directional)", "Singular vertices of the field"),
    "dmat": FileKind(".dmat", "DMAT (libigl)", "One direction of each face's cross"),
    "sharp": FileKind(".sharp", "Sharp Features (QuadWild)", "Creases and borders (.sharp)"),
    "lines": FileKind("-lines.obj", "Lines (OBJ)", "Lines of curvature as polylines"),
    "separatrices": FileKind("-separatrices.obj", "Separatrices (OBJ)", "As polylines"),
    "ridges": FileKind("-ridges.obj", "Ridges (OBJ)", "Ridges and ravines as polylines"),
    "ridge_figures": FileKind(
        "-ridges.csv",
        "Ridge Figures (CSV, JSON)",
        "Kind, strength and bend of every point of the ridges",
        ("-ridges.json",),
    ),
    "csv": FileKind(
        "-poles.csv", "Tables (CSV)", "Poles and umbilics as two tables", ("-umbilics.csv",)
    ),
    "json": FileKind("-poles.json", "JSON", "Poles and umbilics in one file (.json)"),
    "quads": FileKind("-quads.obj", "Quads (OBJ)", "The mesh remeshed to quads"),
    "quads_ply": FileKind(
        "-quads.ply", "Quads with Figures (PLY)", "The same with valence, patch and angle"
    ),
}
QUAD_KINDS = ("quads", "quads_ply")


@dataclass(frozen=True)
class Exported:
    """What there is to write: a mesh, the plan for it and what was made by it.

    Attributes
    ----------
    vertices, triangles:
        (n, 3) float64 and (m, 3) integer, those of `guide`: rows and coordinates of the files.
    guide, guidance:
        What was prepared for planning, and the plan.
    lines, separatrices, ridges, quads:
        None where their kind is not asked for.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    guide: Guide
    guidance: Guidance
    lines: Lines | None = None
    separatrices: Lines | None = None
    ridges: RidgeLines | None = None
    quads: QuadMesh | None = None


def guidance_paths(stem: Path, kinds: Iterable[str]) -> list[Path]:
    """The files that `write_guidance` makes.

    Examples
    --------
    >>> from pathlib import Path
    >>> [path.name for path in core.guidance_paths(Path("cup"), ["rosy", "sharp"])]
    ['cup.rosy', 'cup.sharp']
    """
    about = []
    for kind in kinds:
        if kind not in FILE_KINDS:
            raise FormatError(f"There is no kind of file {kind}: {', '.join(FILE_KINDS)}.")
        about.append(FILE_KINDS[kind])
    return [
        stem.with_name(stem.name + ending) for kind in about for ending in (kind.ending, *kind.more)
    ]


def write_guidance(
    stem: Path,
    kinds: list[str],
    data: Exported,
    to_file: np.ndarray | None = None,
    progress: Progress | None = None,
) -> list[Path]:
    """Write the files of the given kinds, named after `stem`; their paths.

    Parameters
    ----------
    stem:
        Path without ending; its folder is made if it is missing.
    kinds:
        Keys of `FILE_KINDS`.
    to_file:
        (3, 3) float64 rotation from the coordinates of the mesh to those of the file.
    progress:
        Told before each file; files that were written before it is cancelled stay.

    Raises
    ------
    FormatError
        There is no such kind, or a file cannot be written.

    Examples
    --------
    Of an ellipsoid of `vertices` and `triangles`, as in `detect`, the creases of its plan:

    >>> from pathlib import Path
    >>> guide = core.Guide(vertices, triangles, core.detect(vertices, triangles))
    >>> data = core.Exported(vertices, triangles, guide, guide.guidance())
    >>> [path.name for path in core.write_guidance(Path("egg"), ["mesh", "sharp"], data)]
    ['egg.obj', 'egg.sharp']
    """
    progress = progress or Progress()
    turn = np.eye(3) if to_file is None else np.asarray(to_file, float)
    stem = Path(stem)
    try:
        stem.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FormatError(f"{stem.parent}: cannot be made ({error.strerror}).") from error
    for number, kind in enumerate(kinds):
        progress.step(number / len(kinds))
        _WRITERS[kind](*guidance_paths(stem, [kind]), data, turn)
    progress.step(1.0)
    return guidance_paths(stem, kinds)


def _crosses(data: Exported) -> tuple[np.ndarray, np.ndarray]:
    """(m, 3) direction of every triangle, also of those that were left out, and normals."""
    a, b, c = (data.vertices[data.triangles[:, k]] for k in range(3))
    normal = unit(np.cross(b - a, c - a))
    known = np.isfinite(data.guidance.face_direction).all(axis=1, keepdims=True)
    edge = unit(b - a)
    # A reader stops at a NaN; a triangle that was left out gets the direction of its side.
    edge[~(np.linalg.norm(edge, axis=1) > 0.5)] = (1.0, 0.0, 0.0)
    direction = np.where(known, np.nan_to_num(data.guidance.face_direction), edge)
    return direction, normal


def _mesh(path: Path, data: Exported, turn: np.ndarray) -> None:
    write_mesh(path, data.vertices @ turn.T, data.triangles)


def _rosy(path: Path, data: Exported, turn: np.ndarray) -> None:
    write_rosy(path, _crosses(data)[0] @ turn.T)


def _dmat(path: Path, data: Exported, turn: np.ndarray) -> None:
    write_dmat(path, _crosses(data)[0] @ turn.T)


def _rawfield(path: Path, data: Exported, turn: np.ndarray) -> None:
    one, normal = _crosses(data)
    two = np.cross(normal, one)
    write_rawfield(path, np.stack([one, two, -one, -two], axis=1) @ turn.T)


def _sing(path: Path, data: Exported, _turn: np.ndarray) -> None:
    write_sing(path, *data.guide.singular_vertices(data.guidance))


def _sharp(path: Path, data: Exported, _turn: np.ndarray) -> None:
    guidance = data.guidance
    write_sharp(path, guidance.feature_convex, guidance.feature_triangle, guidance.feature_side)


_Placed = TypeVar("_Placed", Lines, RidgeLines, Poles, Umbilics)


def _turned(rows: _Placed | None, turn: np.ndarray) -> _Placed:
    """Lines or points in the coordinates of the file."""
    if rows is None:
        raise FormatError("There are no lines to write.")
    return replace(rows, position=rows.position @ turn.T, normal=rows.normal @ turn.T)


def _lines(path: Path, data: Exported, turn: np.ndarray) -> None:
    write_curves(path, _turned(data.lines, turn))


def _separatrices(path: Path, data: Exported, turn: np.ndarray) -> None:
    write_curves(path, _turned(data.separatrices, turn))


def _ridges(path: Path, data: Exported, turn: np.ndarray) -> None:
    write_curves(path, _turned(data.ridges, turn))


def _ridge_figures(rows: Path, same: Path, data: Exported, turn: np.ndarray) -> None:
    if data.ridges is None:
        raise FormatError("There are no ridges to write.")
    table = ridges_table(_turned(data.ridges, turn))
    write_points_csv(rows, table)
    write_points_json(same, {"ridges": table})


def _tables(data: Exported, turn: np.ndarray) -> dict[str, Table]:
    return {
        "poles": poles_table(_turned(data.guidance.poles, turn)),
        "umbilics": umbilics_table(_turned(data.guide.detection.umbilics, turn)),
    }


def _csv(poles: Path, umbilics: Path, data: Exported, turn: np.ndarray) -> None:
    tables = _tables(data, turn)
    write_points_csv(poles, tables["poles"])
    write_points_csv(umbilics, tables["umbilics"])


def _json(path: Path, data: Exported, turn: np.ndarray) -> None:
    write_points_json(path, _tables(data, turn))


def _turned_quads(data: Exported, turn: np.ndarray) -> QuadMesh:
    if data.quads is None:
        raise FormatError("There are no quads to write.")
    return replace(data.quads, vertices=data.quads.vertices @ turn.T)


def _quads(path: Path, data: Exported, turn: np.ndarray) -> None:
    made = _turned_quads(data, turn)
    write_mesh(path, made.vertices, made.quads)


def _quads_ply(path: Path, data: Exported, turn: np.ndarray) -> None:
    write_quads(path, _turned_quads(data, turn))


_WRITERS: dict[str, Callable[..., None]] = {
    "mesh": _mesh,
    "rosy": _rosy,
    "rawfield": _rawfield,
    "sing": _sing,
    "dmat": _dmat,
    "sharp": _sharp,
    "lines": _lines,
    "separatrices": _separatrices,
    "ridges": _ridges,
    "ridge_figures": _ridge_figures,
    "csv": _csv,
    "json": _json,
    "quads": _quads,
    "quads_ply": _quads_ply,
}
