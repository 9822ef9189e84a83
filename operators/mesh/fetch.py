"""Values of Blender's collections as arrays."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np
from mathutils import Matrix

# Kind of attribute: values per element, their NumPy type, the name foreach_get reads, and
# what the user reads when it is the wrong one.
LAYOUT = {
    "FLOAT": (1, np.float32, "value", "Float"),
    "FLOAT_VECTOR": (3, np.float32, "vector", "Vector"),
    "INT": (1, np.int32, "value", "Integer"),
}
DOMAIN_LABEL = {
    "POINT": "Vertex",
    "EDGE": "Edge",
    "FACE": "Face",
    "CORNER": "Face Corner",
}


def fetch(
    collection: bpy.types.bpy_prop_collection, key: str, width: int, dtype: type
) -> np.ndarray:
    """All values of one property of a collection: (count,) or (count, width)."""
    values: np.ndarray = np.empty(len(collection) * width, dtype=dtype)
    if len(values):
        collection.foreach_get(key, values)
    return values if width == 1 else values.reshape(-1, width)


def unit_vectors(vectors: np.ndarray) -> np.ndarray:
    """(..., 3) vectors made one long; zero vectors stay zero, and NaN, no direction, stays NaN."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0.0, length, 1.0)


def inverse(matrix: np.ndarray | Sequence[Sequence[float]]) -> Matrix:
    """The inverse of a (4, 4) matrix, in double precision: Blender's own finds none for an object
    whose scale is 1e-15, as the product of three such numbers is none in single precision."""
    return Matrix(np.linalg.inv(np.array(matrix, np.float64)))
