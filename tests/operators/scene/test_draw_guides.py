"""Lines as Grease Pencil strokes, which the user may draw over."""

import bpy
import numpy as np
import pytest
from scene_building import add_ellipsoid, census, moved

AXES = np.array([3.0, 2.0, 1.0])
LAYERS = ["Smaller Curvature", "Larger Curvature", "Separatrices", "Ridges"]


def guides(obj):
    return [child for child in obj.children if child.get("umbilics_guidance") == "guides"]


def title(layer):
    return layer.name if hasattr(layer, "name") else layer.info


def strokes(layer):
    """Points (p, 3) in the object's space, whether closed, and material of each stroke."""
    key = layer.frames[0]
    if hasattr(key, "drawing"):
        return [
            (np.array([point.position for point in one.points]), one.cyclic, one.material_index)
            for one in key.drawing.strokes
        ]
    return [
        (np.array([point.co for point in one.points]), one.use_cyclic, one.material_index)
        for one in key.strokes
    ]


def test_layers_hold_the_lines_and_separatrices():
    obj = add_ellipsoid()
    obj.matrix_world = moved(x=5.0)
    bpy.ops.umbilics.lines()
    bpy.ops.umbilics.separatrices()
    assert bpy.ops.umbilics.draw_guides() == {"FINISHED"}
    (made,) = guides(obj)
    bpy.context.view_layer.update()
    assert np.array(made.matrix_world) == pytest.approx(np.array(obj.matrix_world))
    assert [title(layer) for layer in made.data.layers] == LAYERS
    assert [material.name for material in made.data.materials] == LAYERS
    curves = {
        (child["umbilics_guidance"], child.get("umbilics_family")): child for child in obj.children
        if child.type == "CURVE"
    }  # fmt: skip
    for number, key in ((0, ("lines", 1)), (1, ("lines", 0))):
        drawn, splines = strokes(made.data.layers[number]), curves[key].data.splines
        assert len(drawn) == len(splines)
        for (points, closed, material), spline in zip(drawn, splines, strict=True):
            same = np.array([point.co[:3] for point in spline.points])
            assert points == pytest.approx(same, abs=1e-5)
            assert (closed, material) == (spline.use_cyclic_u, number)
    for points, _, material in strokes(made.data.layers[2]):
        assert material == 2
        assert np.abs(points[:, 1]).max() < 0.05
        assert np.abs(((points / AXES) ** 2).sum(axis=1) - 1.0).max() < 0.02


def radius_of(layer):
    key = layer.frames[0]
    if hasattr(key, "drawing"):
        return key.drawing.strokes[0].points[0].radius
    stroke = key.strokes[0]
    # 4.2 has the width in thousandths of a unit across.
    return stroke.line_width * stroke.points[0].pressure / 2000.0


@pytest.mark.parametrize("size", [0.01, 1.0, 100.0])
def test_strokes_are_as_thick_as_the_curves(size):
    obj = add_ellipsoid(tuple(size * AXES), subdivisions=4)
    bpy.ops.umbilics.lines()
    bpy.ops.umbilics.draw_guides()
    curve = next(child for child in obj.children if child.type == "CURVE")
    (made,) = guides(obj)
    assert radius_of(made.data.layers[0]) == pytest.approx(curve.data.bevel_depth, rel=1e-3)


def test_strokes_are_seen_from_the_first_frame_on():
    obj = add_ellipsoid(subdivisions=4)
    bpy.context.scene.frame_start = 10
    bpy.context.scene.frame_set(25)
    bpy.ops.umbilics.draw_guides()
    assert guides(obj)[0].data.layers[0].frames[0].frame_number == 10


def test_again_replaces_and_clear_leaves_nothing():
    obj = add_ellipsoid(subdivisions=4)
    before = census()
    for _ in range(2):
        bpy.ops.umbilics.draw_guides()
    assert len(guides(obj)) == 1
    assert len(bpy.data.materials) == len(LAYERS)
    bpy.ops.umbilics.clear()
    assert census() == before
    assert not len(bpy.data.materials)


def test_what_the_user_draws_on_a_layer_of_his_own_stays():
    obj = add_ellipsoid(subdivisions=4)
    bpy.ops.umbilics.draw_guides()
    (made,) = guides(obj)
    made.data.layers.new("My Loops").frames.new(1)
    bpy.ops.umbilics.draw_guides()
    assert [title(layer) for layer in made.data.layers] == ["My Loops"]
    (fresh,) = guides(obj)
    assert fresh != made
    bpy.ops.umbilics.clear()
    assert not guides(obj)
    assert made.name in bpy.context.scene.objects


def test_a_sphere_says_why_it_has_no_guides():
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32)
    obj = bpy.context.object
    with pytest.raises(RuntimeError, match="no preferred direction"):
        bpy.ops.umbilics.draw_guides()
    assert not guides(obj)
