"""Shape keys of a mesh on another one that lies on its surface: each vertex moves as the place
of the surface that it lies on."""

from __future__ import annotations

import bpy
import numpy as np
from mathutils.bvhtree import BVHTree

from ...mesh.fetch import fetch
from ...mesh.read import MeshArrays
from ...mesh.scope import weights_in


def carry_over(source: bpy.types.Object, made: bpy.types.Object, arrays: MeshArrays) -> bool:
    """Give `made` the relative shape keys of `source`, which `arrays` was read of; whether it had
    any that could be.

    What the keys do to the surface as it is seen they do to the new mesh, which looks the same
    with the values that they have. Deformation by modifiers is not undone: the keys are those of
    the mesh as it is before them.
    """
    keys = source.data.shape_keys
    if keys is None or not keys.use_relative or len(arrays.vertices) != len(source.data.vertices):
        return False
    if arrays.polygon_count != len(source.data.polygons):
        return False
    on = _NearestPoints(arrays, _in_world(made))
    turn = np.linalg.inv(np.array(made.matrix_world)[:3, :3]) @ arrays.matrix[:3, :3]
    blocks = list(keys.key_blocks)
    basis = made.shape_key_add(name=blocks[0].name, from_mix=False)
    moves = {block.name: on.carried(_move(block)) @ turn.T for block in blocks[1:]}
    places = fetch(basis.data, "co", 3, np.float32)
    # What is seen has the keys in it: they are taken out, to be put in again by their values.
    for block in blocks[1:]:
        places -= on.carried(_share(source, block)[:, None]) * moves[block.name]
    basis.data.foreach_set("co", places.astype(np.float32).ravel())
    made.data.attributes["position"].data.foreach_set("vector", places.astype(np.float32).ravel())
    for block in blocks[1:]:
        made.shape_key_add(name=block.name, from_mix=False)
    ours = made.data.shape_keys.key_blocks
    # A key is relative to another one, which moves with its own.
    absolute = {blocks[0].name: places}
    for block in _in_order(blocks[1:]):
        start = absolute.get(block.relative_key.name, places)
        absolute[block.name] = start + moves[block.name]
    for block in blocks[1:]:
        key = ours[block.name]
        key.data.foreach_set("co", absolute[block.name].astype(np.float32).ravel())
        key.relative_key = ours[block.relative_key.name]
        key.slider_min, key.slider_max = block.slider_min, block.slider_max
        key.value, key.mute = block.value, block.mute
        if block.vertex_group in made.vertex_groups:
            key.vertex_group = block.vertex_group
    made.show_only_shape_key = source.show_only_shape_key
    made.active_shape_key_index = source.active_shape_key_index
    made.data.update()
    return True


class _NearestPoints:
    """Where on the triangles of a surface some points (n, 3) are nearest."""

    def __init__(self, arrays: MeshArrays, points: np.ndarray) -> None:
        tree = BVHTree.FromPolygons(arrays.vertices.tolist(), arrays.triangles.tolist())
        nearest = [tree.find_nearest(point) for point in points.tolist()]
        triangle = arrays.triangles[[row for _, _, row, _ in nearest]]
        place = np.array([place[:] for place, _, _, _ in nearest])
        a, b, c = (arrays.vertices[triangle[:, k]] for k in range(3))
        u, v, w = b - a, c - a, place - a
        uu, uv, vv = (np.einsum("nc,nc->n", *pair) for pair in ((u, u), (u, v), (v, v)))
        wu, wv = np.einsum("nc,nc->n", w, u), np.einsum("nc,nc->n", w, v)
        size = np.maximum(uu * vv - uv * uv, np.finfo(float).tiny)
        second, third = (vv * wu - uv * wv) / size, (uu * wv - uv * wu) / size
        self._triangle = triangle
        self._weight = np.column_stack([1.0 - second - third, second, third])

    def carried(self, values: np.ndarray) -> np.ndarray:
        """(n, c) values at the points of values (m, c) at the surface's vertices."""
        return np.einsum("nk,nkc->nc", self._weight, values[self._triangle])


def _in_world(obj: bpy.types.Object) -> np.ndarray:
    """(n, 3) vertices of an object without shape keys."""
    matrix = np.array(obj.matrix_world)
    places = fetch(obj.data.vertices, "co", 3, np.float32).astype(float)
    return places @ matrix[:3, :3].T + matrix[:3, 3]


def _move(block: bpy.types.ShapeKey) -> np.ndarray:
    """(m, 3) how far a key moves each vertex of its mesh."""
    one, other = (fetch(key.data, "co", 3, np.float32) for key in (block, block.relative_key))
    return (one - other).astype(float)


def _share(obj: bpy.types.Object, block: bpy.types.ShapeKey) -> np.ndarray:
    """(m,) how much of a key is seen at each vertex of its mesh."""
    value = 0.0 if block.mute else block.value
    if obj.show_only_shape_key:
        value = float(obj.active_shape_key == block)
    share = np.full(len(block.data), value)
    group = obj.vertex_groups.get(block.vertex_group)
    if group is not None:
        share *= weights_in(obj.data, group.index)
    return share


def _in_order(blocks: list[bpy.types.ShapeKey]) -> list[bpy.types.ShapeKey]:
    """Each key after the one that it is relative to; of a ring of keys as far as can be."""
    left, ordered = list(blocks), []
    known = {block.relative_key.name for block in blocks} - {block.name for block in blocks}
    while left:
        ready = [block for block in left if block.relative_key.name in known] or left[:1]
        for block in ready:
            left.remove(block)
            ordered.append(block)
            known.add(block.name)
    return ordered
