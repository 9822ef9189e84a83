"""Blender's menus have everything, and the manual and F9 know it."""

from types import SimpleNamespace

import bpy
import pytest

# What belongs to one row, to a file browser or to the mouse is no menu's.
NOT_IN_MENUS = {
    "add_preset", "cancel", "explain", "mend", "pick", "write_files",
}  # fmt: skip


class Menu:
    """Stands for a menu's layout and remembers what is in it."""

    def __init__(self):
        self.operators, self.menus = [], []

    def separator(self):
        pass

    def operator(self, name, **_):
        self.operators.append(name.partition(".")[2])

    def operator_menu_enum(self, name, _property, **_):
        self.operator(name)
        return SimpleNamespace()

    def menu(self, name):
        self.menus.append(name)


def drawn(cls):
    layout = Menu()
    cls.draw(SimpleNamespace(layout=layout), bpy.context)
    return layout


def operators():
    return {name for name in dir(bpy.ops.umbilics) if not name.startswith("_")}


def test_every_operator_is_in_the_object_menu_or_its_submenu(addon):
    menus = addon.ui.menus
    first = drawn(menus.UMBILICS_MT_object)
    assert first.menus == ["UMBILICS_MT_retopology"]
    found = {*first.operators, *drawn(menus.UMBILICS_MT_retopology).operators}
    assert operators() - found <= NOT_IN_MENUS
    assert found <= operators()


@pytest.mark.parametrize("place", ["object", "edit_mesh"])
def test_a_right_click_has_one_entry(addon, place):
    for menu in (f"VIEW3D_MT_{place}", f"VIEW3D_MT_{place}_context_menu"):
        ours = [
            one
            for one in getattr(bpy.types, menu)._dyn_ui_initialize()
            if one.__module__.startswith(addon.__name__)
        ]
        assert len(ours) == 1
        layout = Menu()
        ours[0](SimpleNamespace(layout=layout), bpy.context)
        assert layout.menus == ["UMBILICS_MT_object"] and not layout.operators


def test_the_manual_knows_the_retopology(addon):
    _, pages = addon.ui.manual.pages()
    known = dict(pages)
    assert known["bpy.types.umbilics_pg_guidance.*"] == "#retopology"
    for name in drawn(addon.ui.menus.UMBILICS_MT_retopology).operators:
        assert known[f"bpy.ops.umbilics.{name}*"] == "#retopology"


def test_lengths_and_curvatures_have_the_units_of_the_scene(addon):
    units, scene = addon.operators.base.units, bpy.context.scene
    scene.unit_settings.system = "METRIC"
    assert units.length(scene, 0.0012) == "1.2 mm"
    assert units.curvature(scene, 0.12) == "0.12 1/m"
    scene.unit_settings.scale_length = 0.001
    assert units.length(scene, 1.2) == "1.2 mm"
    scene.unit_settings.system = "NONE"
    assert units.length(scene, 0.0012) == "0.0012"
    assert units.curvature(scene, 0.12) == "0.12 1/unit"


def test_strength_names_one_thing(addon):
    """No two settings have the same name where that would be taken for the same."""
    groups = bpy.context.scene.umbilics, bpy.context.scene.umbilics_display
    labels = [item.name for group in groups for item in group.bl_rna.properties]
    assert labels.count("Strength") == 1
