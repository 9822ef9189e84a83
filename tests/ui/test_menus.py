"""Blender's menus have everything, and the manual and F9 know it."""

from fnmatch import fnmatchcase
from pathlib import Path
from types import SimpleNamespace
from urllib.parse import urlparse
from urllib.request import url2pathname

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


def page_of(addon, name):
    """Where the manual leads from what Blender calls an operator or a property."""
    start, pages = addon.ui.manual.pages()
    return start + next(page for pattern, page in pages if fnmatchcase(name.lower(), pattern))


def shown_properties():
    """Names of all properties of the groups that scenes and objects have."""
    groups = [
        item.fixed_type
        for owner in (bpy.types.Scene, bpy.types.Object)
        for item in owner.bl_rna.properties
        if item.identifier.startswith("umbilics") and item.type == "POINTER"
    ]
    assert len(groups) >= 6
    return [
        f"bpy.types.{group.identifier}.{item.identifier}"
        for group in groups
        for item in group.properties
        if item.identifier not in ("rna_type", "name")
    ]


def test_every_operator_and_property_has_a_chapter_of_the_manual(addon):
    names = [f"bpy.ops.umbilics.{name}" for name in operators()] + shown_properties()
    names += [
        f"bpy.ops.umbilics.{name}.{item.identifier}"
        for name in operators()
        for item in getattr(bpy.ops.umbilics, name).get_rna_type().properties
    ]
    for name in names:
        url = urlparse(page_of(addon, name))
        page = Path(url2pathname(url.path)).read_text("utf-8")
        assert f'id="{url.fragment}"' in page, name


def test_chapters_are_about_what_leads_to_them(addon):
    for name, chapter in (
        ("bpy.ops.umbilics.detect", "guide.html#first-detection"),
        ("bpy.ops.umbilics.pin", "guide.html#the-list"),
        ("bpy.ops.umbilics.guide", "retopology.html#plan-poles"),
        ("bpy.ops.umbilics.guide.smoothness", "retopology.html#plan-poles"),
        ("bpy.ops.umbilics.remesh_to_quads.quads", "retopology.html#quads"),
        ("bpy.ops.umbilics.symmetry", "retopology.html#symmetry"),
        ("bpy.types.UMBILICS_PG_guidance.smoothness", "retopology.html#plan-poles"),
        ("bpy.types.UMBILICS_PG_guidance.spacing", "retopology.html#lines"),
        ("bpy.types.UMBILICS_PG_remesh.adaptivity", "retopology.html#how-the-quads-are-made"),
        ("bpy.types.UMBILICS_PG_check.surface", "retopology.html#check-topology"),
        ("bpy.types.UMBILICS_PG_display.source", "guide.html#first-detection"),
        ("bpy.types.UMBILICS_PG_settings.scale", "guide.html#settings"),
    ):
        assert page_of(addon, name).endswith(f"/{chapter}"), name


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
