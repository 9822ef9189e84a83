"""Maps of curvature: right colours, and all put back exactly."""

import bpy
import numpy as np
import pytest
from scene_building import add_ellipsoid, values


def colours(obj):
    layer = obj.data.color_attributes["umbilics_map"]
    found = np.empty(4 * len(layer.data), np.float32)
    layer.data.foreach_get("color_srgb", found)
    return found.reshape(-1, 4)[:, :3]


@pytest.fixture
def obj():
    made = add_ellipsoid(subdivisions=4)
    bpy.ops.umbilics.detect()
    return made


def show(name):
    bpy.context.scene.umbilics_display.map = name
    assert bpy.ops.umbilics.show_map() == {"FINISHED"}


def test_gap_is_dark_at_umbilics_and_light_where_it_is_large(obj):
    show("gap")
    gap, light = values(obj, "umbilics_gap"), colours(obj).sum(axis=1)
    order = np.argsort(gap)
    assert light[order[:20]].max() < light[order[-20:]].min()


def test_signed_map_is_symmetric_about_zero(obj):
    show("gauss")
    display = bpy.context.scene.umbilics_display
    assert display.range_low == -display.range_high
    red, _, blue = colours(obj).T
    assert (red >= blue - 0.02).all(), "an ellipsoid is positively curved everywhere"


def test_every_map_can_be_shown_and_all_is_put_back(obj):
    mine = obj.data.color_attributes.new("Mine", "BYTE_COLOR", "POINT")
    obj.data.color_attributes.active_color = mine
    for name in ("k1", "k2", "mean", "gauss", "gap", "type", "region"):
        show(name)
        assert obj.data.color_attributes.active_color.name == "umbilics_map"
    assert bpy.ops.umbilics.hide_map() == {"FINISHED"}
    assert [layer.name for layer in obj.data.color_attributes] == ["Mine"]
    assert obj.data.color_attributes.active_color.name == "Mine"
    left = [key for key in obj.data.keys() if key.startswith("umbilics")]  # noqa: SIM118
    assert left == ["umbilics_stamp"]


def test_locked_range_stays(obj):
    show("k1")
    display = bpy.context.scene.umbilics_display
    display.lock_range = True
    display.range_high = 10.0
    display.percentile = 20.0
    assert display.range_high == 10.0
    display.lock_range = False
    assert display.range_high != 10.0


def test_legend_knows_the_units_of_the_scene(addon, obj):
    show("gauss")
    legend = addon.operators.scene.view.maps.legend
    scene = bpy.context.scene
    scene.unit_settings.system = "METRIC"
    assert "1/m²" in legend(scene, obj).title
    metre = legend(scene, obj).high
    scene.unit_settings.scale_length = 0.01
    assert legend(scene, obj).high == pytest.approx(1e4 * metre)
    scene.umbilics_display.map = "type"
    assert legend(scene, obj).names[0] == "Peak"


def two_sizes():
    """Two detected ellipsoids, one three times as curved as the other; both are selected."""
    small, large = add_ellipsoid(subdivisions=4), add_ellipsoid(subdivisions=4)
    small.scale = (1.0 / 3.0,) * 3
    small.select_set(True)
    bpy.ops.umbilics.detect()
    return small, large


def test_objects_share_a_range_so_that_one_legend_is_true_for_all(addon):
    small, large = two_sizes()
    show("k1")
    ours = addon.operators.scene.view.maps.legend
    scene = bpy.context.scene
    assert ours(scene, small).high == pytest.approx(ours(scene, large).high)
    both = np.concatenate([values(obj, "umbilics_k1") for obj in (small, large)])
    assert ours(scene, large).high == pytest.approx(np.percentile(both, 98.0), rel=1e-5)
    # The same value has the same colour on both.
    curved = [values(obj, "umbilics_k1") for obj in (small, large)]
    wanted = curved[0].min()
    assert wanted < curved[1].max()
    places = [int(np.abs(k1 - wanted).argmin()) for k1 in curved]
    first, second = (colours(obj)[at] for obj, at in zip((small, large), places, strict=True))
    assert np.abs(first - second).max() < 0.03


def test_a_map_that_is_chosen_later_is_shown_wherever_a_map_was(addon):
    small, large = two_sizes()
    show("k1")
    small.select_set(False)
    bpy.context.scene.umbilics_display.map = "gauss"
    for obj in (small, large):
        assert "K" in addon.operators.scene.view.maps.legend(bpy.context.scene, obj).title
        red, _, blue = colours(obj).T
        assert (red >= blue - 0.02).all()


def test_in_edit_mode_the_legend_stays_that_of_the_colours_shown(addon, obj):
    show("k1")
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.context.scene.umbilics_display.map = "gap"
    legend = addon.operators.scene.view.maps.legend
    assert "κ₁ −" not in legend(bpy.context.scene, obj).title
    assert bpy.ops.umbilics.show_map() == {"FINISHED"}
    assert obj.mode == "EDIT"
    assert "κ₁ −" in legend(bpy.context.scene, obj).title


def test_a_new_detection_colours_the_map_anew(addon, obj):
    show("k1")
    before = addon.operators.scene.view.maps.legend(bpy.context.scene, obj).high
    obj.scale = (0.5, 0.5, 0.5)
    bpy.ops.umbilics.detect()
    after = addon.operators.scene.view.maps.legend(bpy.context.scene, obj).high
    assert after == pytest.approx(2.0 * before, rel=0.01)


def test_overlay_has_something_to_draw(addon, obj):
    scene = addon.operators.scene
    found = addon.operators.drawing.strokes.arranged(*scene.view.direction_fields.read_field(obj))
    assert sum(end - first for first, end, _ in found.blocks) == len(obj.data.vertices)
    assert ((found.weight >= 0.0) & (found.weight <= 1.0)).all()
    gap = values(obj, "umbilics_gap")
    faint = np.linalg.norm(found.places - np.array(obj.data.vertices[gap.argmin()].co), axis=1)
    assert found.weight[faint.argmin()] < 0.1
    bpy.context.scene.umbilics_display.discs = True
    obj.umbilics.active = 0
    shapes = scene.view.umbilic_shapes.shapes_of(bpy.context, obj, faint=False)
    # Discs and rays lie on the surface; the ring around the chosen umbilic is seen through it.
    assert [shape.on_top for shape in shapes].count(True) == 1
    assert shapes[-1].on_top
    for shape in shapes:
        assert shape.triangles.max() < len(shape.centre) == len(shape.colour)
        assert np.isfinite(shape.centre).all()


def test_a_crowd_is_drawn_as_diamonds_in_the_colours_of_its_kinds(addon, obj, monkeypatch):
    umbilics, drawing = addon.operators.scene.view.umbilic_shapes, addon.operators.drawing.umbilics
    # Without a window an empty shows its glyph itself.
    bpy.context.scene.umbilics_display.empties = False
    glyphs = umbilics.shapes_of(bpy.context, obj, faint=False)
    assert umbilics.crowds(bpy.context, obj, faint=False) == []
    monkeypatch.setattr(umbilics, "CROWD", 3)
    assert umbilics.shapes_of(bpy.context, obj, faint=False) == []
    ((shown, opacity),) = umbilics.crowds(bpy.context, obj, faint=False)
    ((_, fainter),) = umbilics.crowds(bpy.context, obj, faint=True)
    assert fainter < opacity == 1.0
    kept = addon.operators.data.record.of(obj)
    look = addon.operators.data.preferences.Appearance(bpy.context)
    diamonds = drawing.diamonds(
        kept.detection.candidates, kept.kind_codes, np.linalg.inv(kept.matrix), look
    )
    assert len(diamonds.centre) < sum(len(shape.centre) for shape in glyphs) / 20
    lemon = addon.operators.data.preferences.KIND_COLOURS["lemon"]
    assert np.allclose(diamonds.colour, lemon)
    # Two triangles for each that is chosen, all of whose corners are at its place.
    some = shown[1:3]
    triangles = drawing.diamonds_of(some)
    assert triangles.shape == (2 * len(some), 3)
    places = kept.detection.candidates.position[some]
    assert np.allclose(diamonds.centre[triangles].reshape(len(some), -1, 3), places[:, None])
    bpy.context.scene.umbilics_display.glyphs = False
    assert umbilics.crowds(bpy.context, obj, faint=False) == []


def test_a_crowd_that_the_opening_leaves_out_is_drawn_faintly(addon, obj, monkeypatch):
    umbilics, scene = addon.operators.scene.view.umbilic_shapes, bpy.context.scene
    monkeypatch.setattr(umbilics, "CROWD", 3)
    everything = addon.operators.scene.filters.shown_rows(obj, scene)
    monkeypatch.setattr(addon.operators.scene.filters, "left_out_rows", lambda *_: everything)
    scene.umbilics_display.empties = False
    scene.umbilics_display.dropped = True
    hollow, shown = umbilics.crowds(bpy.context, obj, faint=False)
    assert hollow[0].tolist() == shown[0].tolist() == everything.tolist()
    assert hollow[1] < shown[1]
    assert umbilics.shapes_of(bpy.context, obj, faint=False) == []


def test_a_mesh_that_is_sculpted_is_left_alone():
    obj = add_ellipsoid(subdivisions=3)
    bpy.ops.umbilics.detect()
    bpy.ops.umbilics.show_map()
    display = bpy.context.scene.umbilics_display
    bpy.ops.object.mode_set(mode="SCULPT")
    with pytest.raises(RuntimeError, match="Leave Sculpt Mode"):
        bpy.ops.umbilics.show_map()
    before = [item.color[:] for item in obj.data.color_attributes["umbilics_map"].data]
    display.map = "k1"
    assert [item.color[:] for item in obj.data.color_attributes["umbilics_map"].data] == before
    bpy.ops.object.mode_set(mode="OBJECT")
