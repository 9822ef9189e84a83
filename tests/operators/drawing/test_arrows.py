"""The arrows are instances along the principal directions, at the vertices that have them."""

import bpy
import numpy as np
import pytest
from scene_building import add_ellipsoid, add_mesh


def instances(obj):
    """(k, 4, 4) world matrices of the object's instances."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    return np.array(
        [
            np.array(instance.matrix_world)  # the iteration uses its memory again
            for instance in depsgraph.object_instances
            if instance.is_instance and instance.parent and instance.parent.original == obj
        ]
    )


def attribute(obj, name):
    values = np.empty(3 * len(obj.data.vertices), np.float32)
    obj.data.attributes[name].data.foreach_get("vector", values)
    return values.reshape(-1, 3)


@pytest.fixture
def arrows():
    obj = add_ellipsoid(subdivisions=3)
    bpy.ops.umbilics.detect()
    assert bpy.ops.umbilics.add_arrows() == {"FINISHED"}
    bpy.context.view_layer.update()
    return obj


def test_arrows_lie_along_both_directions_at_every_vertex(arrows):
    found = instances(arrows)
    count = len(arrows.data.vertices)
    assert len(found) == 2 * count
    places = np.array([vertex.co for vertex in arrows.data.vertices])
    directions = {name: attribute(arrows, name) for name in ("umbilics_d1", "umbilics_d2")}
    drawn = set()
    for half in (found[:count], found[count:]):
        assert np.allclose(half[:, :3, 3], places, atol=1e-5)
        along = half[:, :3, 2] / np.linalg.norm(half[:, :3, 2], axis=1, keepdims=True)
        for name, direction in directions.items():
            if np.abs((along * direction).sum(axis=1)).min() > 0.9999:
                drawn.add(name)
    assert drawn == set(directions)


def test_arrows_are_as_long_as_the_edges(arrows):
    mesh = arrows.data
    ends = np.array([[mesh.vertices[i].co for i in edge.vertices] for edge in mesh.edges])
    edge = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).mean()
    length = np.linalg.norm(instances(arrows)[:, :3, 2], axis=1)
    assert np.allclose(length, 0.8 * edge, rtol=1e-4)


def test_a_second_time_changes_nothing_and_the_group_is_shared(arrows):
    assert bpy.ops.umbilics.add_arrows() == {"CANCELLED"}
    assert len(arrows.modifiers) == 1
    other = add_ellipsoid(subdivisions=2)
    bpy.ops.umbilics.detect()
    bpy.ops.umbilics.add_arrows()
    assert other.modifiers[0].node_group == arrows.modifiers[0].node_group


def test_detecting_again_is_not_disturbed_by_the_arrows(arrows):
    bpy.ops.umbilics.detect()
    assert len(arrows.umbilics.items) == arrows.umbilics.lemon == 4
    assert len(instances(arrows)) == 2 * len(arrows.data.vertices)


def test_without_results_there_are_no_arrows_to_add():
    add_mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    assert not bpy.ops.umbilics.add_arrows.poll()
