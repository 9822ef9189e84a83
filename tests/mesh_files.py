"""OBJ, STL, PLY and GIFTI files, read plainly for the tests, and OBJ files written."""

from __future__ import annotations

import base64
import gzip
import importlib.util
import zlib
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

# Real meshes that come with Python packages of the tests, so that a newcomer has some too.
PACKAGED = {
    "cortex": ("nilearn", "datasets/data/fsaverage5/pial.left.gii.gz"),
    "inflated cortex": ("nilearn", "datasets/data/fsaverage5/infl_right.gii.gz"),
    "airplane": ("pyvista", "examples/airplane.ply"),
    "ant": ("pyvista", "examples/ant.ply"),
    "nut": ("pyvista", "examples/nut.ply"),
}


def packaged_path(name: str) -> Path | None:
    """The file of one of PACKAGED; None where its package is not installed."""
    package, place = PACKAGED[name]
    # Found without importing it: what it depends on is not there.
    found = importlib.util.find_spec(package)
    if found is None or not found.submodule_search_locations:
        return None
    return Path(found.submodule_search_locations[0]) / place


def read_mesh(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (n, 3) and triangles (m, 3) of a file; polygons are cut into fans."""
    readers = {".obj": _read_obj, ".stl": _read_stl, ".ply": _read_ply, ".gz": _read_gifti}
    return readers[path.suffix.lower()](path)


def write_obj(path: Path, vertices: np.ndarray, faces: np.ndarray) -> None:
    """Vertices (n, 3) and faces (m, k) as an OBJ file; its folder is made if it is missing."""
    lines = ["v " + " ".join(map(repr, row)) for row in np.asarray(vertices, float).tolist()]
    lines += ["f " + " ".join(map(str, row)) for row in (np.asarray(faces) + 1).tolist()]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(lines) + "\n")


def _fans(polygons: list[list[int]]) -> np.ndarray:
    triangles = [
        (polygon[0], polygon[k], polygon[k + 1])
        for polygon in polygons
        for k in range(1, len(polygon) - 1)
    ]
    return np.array(triangles, dtype=np.int64).reshape(-1, 3)


def _read_obj(path: Path) -> tuple[np.ndarray, np.ndarray]:
    vertices, polygons = [], []
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            vertices.append([float(word) for word in words[1:4]])
        elif words[:1] == ["f"]:
            corners = [int(word.split("/")[0]) for word in words[1:]]
            # Negative numbers count back from the last vertex so far.
            polygons.append([i - 1 if i > 0 else len(vertices) + i for i in corners])
    return np.array(vertices), _fans(polygons)


def _read_stl(path: Path) -> tuple[np.ndarray, np.ndarray]:
    data = path.read_bytes()
    count = int.from_bytes(data[80:84], "little")
    if len(data) == 84 + 50 * count:
        record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
        corners = np.frombuffer(data, record, count, 84)["corners"].reshape(-1, 3)
    else:
        words = [line.split() for line in data.decode("ascii", "replace").splitlines()]
        corners = np.array([word[1:4] for word in words if word[:1] == ["vertex"]], np.float32)
    vertices, place = np.unique(corners, axis=0, return_inverse=True)
    return vertices.astype(float), place.reshape(-1, 3).astype(np.int64)


_PLY_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2",
    "ushort": "u2", "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip


def _read_ply(path: Path) -> tuple[np.ndarray, np.ndarray]:
    data = path.read_bytes()
    end = data.index(b"end_header")
    start = data.index(b"\n", end) + 1
    header = [line.split() for line in data[:end].decode("ascii").splitlines()]
    form = next(words[1] for words in header if words[0] == "format")
    if form == "ascii":
        return _ply_words(data[start:].split(), header)
    order = "<" if "little" in form else ">"
    vertices, polygons, position = np.zeros((0, 3)), [], start
    for name, count, properties in _elements(header):
        if name != "face":
            kind = np.dtype([(words[2], order + _PLY_TYPES[words[1]]) for words in properties])
            rows = np.frombuffer(data, kind, count, position)
            position += count * kind.itemsize
            if name == "vertex":
                vertices = np.stack([rows[axis].astype(float) for axis in "xyz"], axis=1)
            continue
        for _ in range(count):
            for words in properties:
                if words[1] != "list":
                    position += np.dtype(_PLY_TYPES[words[1]]).itemsize
                    continue
                size, item = (np.dtype(order + _PLY_TYPES[word]) for word in words[2:4])
                corners = int(np.frombuffer(data, size, 1, position)[0])
                position += size.itemsize
                polygons.append(np.frombuffer(data, item, corners, position).tolist())
                position += corners * item.itemsize
    return vertices, _fans(polygons)


def _elements(header: list[list[str]]) -> list[tuple[str, int, list[list[str]]]]:
    elements: list[tuple[str, int, list[list[str]]]] = []
    for words in header:
        if words[0] == "element":
            elements.append((words[1], int(words[2]), []))
        elif words[0] == "property":
            elements[-1][2].append(words)
    return elements


def _ply_words(words: list[bytes], header: list[list[str]]) -> tuple[np.ndarray, np.ndarray]:
    vertices, polygons, position = [], [], 0
    for name, count, properties in _elements(header):
        for _ in range(count):
            if name == "face":
                corners = int(words[position])
                polygons.append([int(w) for w in words[position + 1 : position + 1 + corners]])
                position += 1 + corners
            else:
                if name == "vertex":
                    vertices.append([float(word) for word in words[position : position + 3]])
                position += len(properties)
    return np.array(vertices), _fans(polygons)


def _read_gifti(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Points and triangles of a surface whose arrays are compressed, as FreeSurfer's are."""
    arrays = {}
    for array in ElementTree.fromstring(gzip.decompress(path.read_bytes())).iter("DataArray"):
        kind = {"NIFTI_TYPE_FLOAT32": "f4", "NIFTI_TYPE_INT32": "i4"}[array.get("DataType")]
        order = "<" if array.get("Endian") == "LittleEndian" else ">"
        data = zlib.decompress(base64.b64decode(array.find("Data").text))
        arrays[array.get("Intent")] = np.frombuffer(data, order + kind).reshape(-1, 3)
    points = arrays["NIFTI_INTENT_POINTSET"].astype(float)
    return points, arrays["NIFTI_INTENT_TRIANGLE"].astype(np.int64)
