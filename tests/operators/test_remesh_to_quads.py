"""Remesh to Quads: a new object beside the user's, and nothing of the user's is changed."""

import bmesh
import bpy
import numpy as np
import pytest
from scene_building import add_ellipsoid


@pytest.fixture
def obj():
    return add_ellipsoid((1.5, 1.0, 0.7), subdivisions=4)


def remesh(**options):
    assert bpy.ops.umbilics.remesh_to_quads(quads=300, relaxation=5, **options) == {"FINISHED"}
    return bpy.context.view_layer.objects.active


def is_closed(mesh) -> bool:
    made = bmesh.new()
    made.from_mesh(mesh)
    closed = all(edge.is_manifold for edge in made.edges)
    made.free()
    return closed


def test_quads_alone_closed_beside_the_original(obj):
    before = [vertex.co.copy() for vertex in obj.data.vertices]
    made = remesh()
    assert made is not obj and made.name == f"{obj.name} Quads"
    assert {len(polygon.vertices) for polygon in made.data.polygons} == {4}
    assert is_closed(made.data)
    assert abs(len(made.data.polygons) - 300) < 60
    valence = made.data.attributes["umbilics_valence"].data
    assert sum(item.value == 3 for item in valence) == 8
    patches = {item.value for item in made.data.attributes[".sculpt_face_set"].data}
    assert patches == set(range(1, len(patches) + 1)) and len(patches) > 4
    assert obj.hide_get() and not made.hide_get() and made.select_get() and not obj.select_get()
    assert [vertex.co for vertex in obj.data.vertices] == before


def test_what_stands_on_the_original_is_hidden_with_it(obj):
    bpy.ops.umbilics.detect()
    bpy.ops.umbilics.guide()
    bpy.ops.umbilics.lines()
    bpy.ops.umbilics.preview_layout(quads=300)
    others = {child.name for child in obj.children}
    (layout,) = (child for child in obj.children if "layout" in child.name.lower())
    # The user steers by it.
    bpy.context.scene.umbilics_guidance.strokes = layout

    def seen():
        return {child.name for child in obj.children if not child.hide_get()}

    made = remesh(hide_original=False)
    assert seen() == others
    bpy.data.objects.remove(made)
    bpy.context.view_layer.objects.active = obj
    remesh(hide_original=True)
    assert obj.hide_get() and seen() == {layout.name}


def test_outwards_and_in_place_under_a_mirrored_stretched_object(obj):
    obj.scale = (-1.0, 2.0, 1.0)
    obj.location = (3.0, 0.0, 0.0)
    made = remesh(hide_original=False)
    assert not obj.hide_get()
    normal = np.array([polygon.normal for polygon in made.data.polygons])
    centre = np.array([polygon.center for polygon in made.data.polygons])
    assert (np.einsum("ij,ij->i", normal, centre) > 0).all()
    bpy.context.view_layer.update()
    assert np.allclose(made.matrix_world, obj.matrix_world, atol=1e-6)
    size = np.abs(np.array([vertex.co for vertex in made.data.vertices])).max(axis=0)
    assert size == pytest.approx([1.5, 1.0, 0.7], rel=0.05)


def test_what_was_seen_is_remeshed_and_clear_leaves_it(obj):
    obj.modifiers.new("Scale", "CAST").factor = 0.5
    made = remesh()
    bpy.context.view_layer.objects.active = obj
    obj.hide_set(False)
    bpy.ops.umbilics.clear()
    assert made.name in bpy.data.objects


def test_shrinkwrap_materials_and_groups_on_request(obj):
    for name in ("one", "two"):
        obj.data.materials.append(bpy.data.materials.new(name))
    for polygon in obj.data.polygons:
        polygon.material_index = int(polygon.center.x > 0)
    obj.vertex_groups.new(name="right").add(
        [vertex.index for vertex in obj.data.vertices if vertex.co.x > 0], 1.0, "REPLACE"
    )
    plain = remesh(hide_original=False)
    assert not plain.modifiers and not plain.data.materials
    bpy.context.view_layer.objects.active = obj
    made = remesh(shrinkwrap=True, transfer=True)
    assert [modifier.target for modifier in made.modifiers] == [obj]
    assert [material.name for material in made.data.materials] == ["one", "two"]
    wrong = [
        polygon.index
        for polygon in made.data.polygons
        if abs(polygon.center.x) > 0.2 and polygon.material_index != int(polygon.center.x > 0)
    ]
    assert not wrong
    group = made.vertex_groups["right"].index
    inside = {
        vertex.index
        for vertex in made.data.vertices
        if any(one.group == group and one.weight > 0.5 for one in vertex.groups)
    }
    right = {vertex.index for vertex in made.data.vertices if vertex.co.x > 0.2}
    left = {vertex.index for vertex in made.data.vertices if vertex.co.x < -0.2}
    assert right <= inside and not inside & left


def test_what_modifiers_make_has_its_materials_and_keys_that_cannot_follow_are_said(obj, capfd):
    for name in ("one", "two"):
        obj.data.materials.append(bpy.data.materials.new(name))
    for polygon in obj.data.polygons:
        polygon.material_index = int(polygon.center.x > 0)
    obj.shape_key_add(name="Basis")
    obj.shape_key_add(name="Other")
    obj.modifiers.new("Subdivision", "SUBSURF").levels = 1
    capfd.readouterr()
    made = remesh(transfer=True)
    assert "Shape keys were not carried over" in capfd.readouterr().out
    assert {polygon.material_index for polygon in made.data.polygons} == {0, 1}
    for polygon in made.data.polygons:
        if abs(polygon.center.x) > 0.2:
            assert polygon.material_index == int(polygon.center.x > 0)
    assert made.data.shape_keys is None


def test_shape_keys_move_the_quads_as_the_surface_below(obj):
    """A key that scales, one relative to it, one through a group: seen, and each alone."""
    points = np.array([vertex.co for vertex in obj.data.vertices])
    obj.shape_key_add(name="Basis")
    moves = {"wide": (0.5, 0.0, 0.0), "wider": (0.25, 0.0, 0.0), "high": (0.0, 0.0, 0.4)}
    for name, by in moves.items():
        block = obj.shape_key_add(name=name, from_mix=False)
        start = points * (1.0 + np.array(moves["wide"])) if name == "wider" else points
        block.data.foreach_set("co", (start + points * by).astype(np.float32).ravel())
    blocks = obj.data.shape_keys.key_blocks
    blocks["wider"].relative_key = blocks["wide"]
    for name, value in (("wide", 0.5), ("wider", 0.0), ("high", 1.0)):
        blocks[name].value = value
    blocks["high"].slider_max = 2.0
    obj.vertex_groups.new(name="right").add(
        [vertex.index for vertex in obj.data.vertices if vertex.co.x > 0], 1.0, "REPLACE"
    )
    blocks["high"].vertex_group = "right"
    obj.scale = (1.0, 1.0, 2.0)
    made = remesh(transfer=True)
    ours = made.data.shape_keys.key_blocks
    assert [block.name for block in ours] == ["Basis", *moves]
    assert [block.value for block in ours][1:] == [0.5, 0.0, 1.0]
    assert ours["wider"].relative_key == ours["wide"]
    assert ours["high"].vertex_group == "right" and ours["high"].slider_max == 2.0

    def places(block):
        return np.array([point.co for point in block.data])

    basis = places(ours["Basis"])
    inner = np.abs(basis[:, 0]) > 0.2
    # On the ellipsoid as it is without keys.
    level = ((basis / (1.5, 1.0, 0.7)) ** 2).sum(axis=1)
    assert np.abs(level[inner] - 1.0).max() < 0.02
    assert places(ours["wide"]) - basis == pytest.approx(basis * moves["wide"], abs=0.02)
    wider = places(ours["wider"]) - places(ours["wide"])
    assert wider == pytest.approx(basis * moves["wider"], abs=0.02)
    bpy.context.view_layer.update()
    shown = made.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    seen = np.array([vertex.co for vertex in shown.vertices])
    wide = 1.25 * basis[:, 0]
    assert seen[inner, 0] == pytest.approx(wide[inner], abs=0.02)
    tall = np.where(basis[:, 0] > 0, 1.4, 1.0) * basis[:, 2]
    assert seen[inner, 2] == pytest.approx(tall[inner], abs=0.02)


def test_a_failure_leaves_the_scene_as_it_was(addon, obj, monkeypatch):
    def fails(*_):
        raise addon.core.UmbilicsError("No quads today.")

    before = set(bpy.data.objects), set(bpy.data.meshes)
    monkeypatch.setattr(addon.operators.scene.retopology.quad_meshes, "_come_forward", fails)
    with pytest.raises(RuntimeError, match="No quads today"):
        remesh()
    assert (set(bpy.data.objects), set(bpy.data.meshes)) == before
    assert bpy.context.view_layer.objects.active is obj and not obj.hide_get()


@pytest.mark.parametrize("mode", ["EDIT", "WEIGHT_PAINT"])
def test_who_works_on_the_mesh_goes_on_working_on_it(obj, mode):
    bpy.ops.object.mode_set(mode=mode)
    assert remesh() == obj
    assert obj.mode == mode and not obj.hide_get() and obj.select_get()
    made = bpy.data.objects[f"{obj.name} Quads"]
    assert not made.select_get() and made.umbilics_check.checked
    bpy.ops.object.mode_set(mode="OBJECT")
