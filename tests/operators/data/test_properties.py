"""Settings as Blender properties: the same names, defaults and bounds as the core's."""

import dataclasses

import bpy
import pytest


def test_untouched_properties_are_the_cores_defaults(addon):
    group = bpy.context.scene.umbilics
    assert addon.operators.data.properties.to_settings(group) == addon.core.Settings()


def test_every_setting_is_a_property_with_its_words(addon):
    properties = bpy.context.scene.umbilics.bl_rna.properties
    for name, option in addon.core.options().items():
        assert properties[name].name == option.label
        assert properties[name].description == option.help
        assert (f"{name}_auto" in properties) == option.automatic


def changed(core):
    """Settings that differ from the defaults in every field."""
    values = {}
    for name, option in core.options().items():
        default = core.defaults()[name]
        if option.kind == "choice":
            values[name] = next(c.value for c in option.choices if c.value != default)
        elif option.kind == "flag":
            values[name] = not default
        elif option.kind == "count":
            values[name] = 3
        else:
            values[name] = 0.5 if default != 0.5 else 0.25
    return core.Settings(**values)


def test_settings_survive_the_way_to_blender_and_back(addon):
    group = bpy.context.scene.umbilics
    settings = changed(addon.core)
    addon.operators.data.properties.from_settings(group, settings)
    found = addon.operators.data.properties.to_settings(group)
    for name, value in dataclasses.asdict(settings).items():
        assert getattr(found, name) == pytest.approx(value)
    addon.operators.data.properties.from_settings(group, addon.core.Settings())
    assert addon.operators.data.properties.to_settings(group) == addon.core.Settings()


def test_properties_are_clamped_to_the_cores_bounds(addon):
    group = bpy.context.scene.umbilics
    for name, option in addon.core.options().items():
        if option.kind in ("count", "number"):
            setattr(group, name, -1e6 if option.kind == "number" else -1000)
            if option.automatic:
                setattr(group, f"{name}_auto", False)
    addon.operators.data.properties.to_settings(group)
