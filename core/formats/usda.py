"""`.usda`: meshes, their curvatures as primvars and their umbilics as points, as USD in text.

Any program that reads USD reads it; primvars become attributes there. See
https://openusd.org/release/api/class_usd_geom_primvars_a_p_i.html
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..base.errors import FormatError
from ..umbilics.result import Detection, Umbilics
from .text import ROWS, write_text


@dataclass(frozen=True)
class UsdMesh:
    """A mesh with its detection, both in the coordinates of the file.

    Attributes
    ----------
    name:
        As people know it; in the file it is changed to what USD allows.
    vertices, triangles:
        (n, 3) float64 and (m, 3) int.
    detection:
        Of this mesh.
    turn:
        (3, 3) rotation from the coordinates of the mesh and its detection to those of the file.
    """

    name: str
    vertices: np.ndarray
    triangles: np.ndarray
    detection: Detection
    turn: np.ndarray


def write_usda(path: Path | str, meshes: list[UsdMesh], up: str, frame: int | None = None) -> None:
    """Write all meshes; `up` is the axis that points up, "Y" or "Z". The file appears whole or
    not at all.

    Every vertex has `k1`, `k2`, `d1`, `d2` and `surface_type`, every triangle the `index` of the
    directions and the number of its `region`, every umbilic its `kind`, `index`, `persistence`
    (inf for one that nothing cancels) and `uncertainty`.

    Raises
    ------
    FormatError
        The file cannot be written.

    Examples
    --------
    On an ellipsoid of `vertices` and `triangles`, as in `detect`:

    >>> import numpy as np
    >>> detection = core.detect(vertices, triangles)
    >>> mesh = core.UsdMesh("Egg", vertices, triangles, detection, np.eye(3))
    >>> core.write_usda("egg.usda", [mesh], "Z")
    >>> core.up_axis("egg.usda")
    'Z'
    """
    write_text(path, _document(meshes, up, frame), "utf-8")


def _document(meshes: list[UsdMesh], up: str, frame: int | None) -> Iterator[str]:
    yield f'#usda 1.0\n(\n    defaultPrim = "Umbilics"\n    upAxis = "{up}"\n'
    if frame is not None:
        yield f"    startTimeCode = {frame}\n    endTimeCode = {frame}\n"
    yield ')\n\ndef Xform "Umbilics"\n{\n'
    taken: set[str] = set()
    for mesh in meshes:
        name = _prim_name(mesh.name, taken)
        yield from _mesh(name, mesh)
        yield from _points(_prim_name(f"{name}_umbilics", taken), mesh)
    yield "}\n"


def _prim_name(name: str, taken: set[str]) -> str:
    """A name that USD allows and that is still free."""
    base = re.sub(r"\W", "_", name, flags=re.ASCII) or "Mesh"
    base = f"_{base}" if base[0].isdigit() else base
    found, number = base, 1
    while found in taken:
        found, number = f"{base}_{number}", number + 1
    taken.add(found)
    return found


def _mesh(name: str, mesh: UsdMesh) -> Iterator[str]:
    detection, field = mesh.detection, mesh.detection.curvature
    points = mesh.vertices @ mesh.turn.T
    region = np.zeros(len(mesh.triangles), np.int64)
    for number, found in enumerate(detection.regions, start=1):
        region[found.triangles] = number
    label = json.dumps(mesh.name, ensure_ascii=False)
    yield f'    def Mesh "{name}" (\n        displayName = {label}\n    )\n    {{\n'
    yield '        uniform token subdivisionScheme = "none"\n'
    finite = points[np.isfinite(points).all(axis=1)]
    if len(finite):
        yield from _array("float3[] extent", np.stack([finite.min(axis=0), finite.max(axis=0)]))
    yield from _array("int[] faceVertexCounts", np.full(len(mesh.triangles), 3))
    yield from _array("int[] faceVertexIndices", mesh.triangles.ravel())
    yield from _array("point3f[] points", np.nan_to_num(points))
    yield from _array("float[] primvars:k1", field.k1, "vertex")
    yield from _array("float[] primvars:k2", field.k2, "vertex")
    yield from _array("vector3f[] primvars:d1", field.d1 @ mesh.turn.T, "vertex")
    yield from _array("vector3f[] primvars:d2", field.d2 @ mesh.turn.T, "vertex")
    yield from _array("int[] primvars:surface_type", detection.surface_type, "vertex")
    yield from _array("float[] primvars:index", detection.triangle_index, "uniform")
    yield from _array("int[] primvars:region", region, "uniform")
    yield "    }\n\n"


def _points(name: str, mesh: UsdMesh) -> Iterator[str]:
    umbilics: Umbilics = mesh.detection.umbilics
    yield f'    def Points "{name}"\n    {{\n'
    places = umbilics.position @ mesh.turn.T
    yield from _array("point3f[] points", places)
    # Large enough to be seen: a hundredth of the mesh.
    spread = np.ptp(mesh.vertices[np.isfinite(mesh.vertices).all(axis=1)], axis=0)
    width = 0.01 * float(np.linalg.norm(spread))
    yield from _array("float[] widths", np.full(len(places), width), "vertex")
    yield from _array("normal3f[] normals", umbilics.normal @ mesh.turn.T, "vertex")
    kinds = ", ".join(f'"{kind}"' for kind in umbilics.kind.tolist())
    yield f'        token[] primvars:kind = [{kinds}] (\n            interpolation = "vertex"\n'
    yield "        )\n"
    for column in ("index", "persistence", "uncertainty"):
        yield from _array(f"float[] primvars:{column}", getattr(umbilics, column), "vertex")
    yield "    }\n\n"


def _array(declared: str, values: np.ndarray, interpolation: str = "") -> Iterator[str]:
    """An attribute; of (r, c) values each row is a tuple."""
    values = np.asarray(values)
    if values.dtype.kind == "f":
        # Single precision is what USD keeps: more digits would say nothing.
        with np.errstate(over="raise"):
            try:
                values = values.astype(np.float32)
            except FloatingPointError as error:
                raise FormatError(
                    "A number is too large for USD, which keeps single precision. Scale the mesh."
                ) from error
    number = "%d" if values.dtype.kind in "iub" else "%.9g"
    item = number if values.ndim == 1 else f"({', '.join([number] * values.shape[1])})"
    yield f"        {declared} = ["
    for first in range(0, len(values), ROWS):
        piece = values[first : first + ROWS]
        yield (", " if first else "") + ", ".join([item] * len(piece)) % tuple(
            piece.ravel().tolist()
        )
    meant = f' (\n            interpolation = "{interpolation}"\n        )' if interpolation else ""
    yield f"]{meant}\n"
