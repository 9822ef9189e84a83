"""Presets of the settings, in Blender's own menu; those shipped lie in presets/umbilics."""

from pathlib import Path

import bpy
from bl_operators.presets import AddPresetBase
from bl_ui.utils import PresetPanel

from .. import core
from .parts import Tab

_FOLDER = "umbilics"


class UMBILICS_OT_add_preset(AddPresetBase, bpy.types.Operator):
    bl_idname = "umbilics.add_preset"
    bl_label = "Add Umbilics Preset"
    bl_description = "Save the settings of the detection under a name, or remove a saved preset"
    preset_menu = "UMBILICS_PT_presets"
    preset_subdir = _FOLDER
    preset_defines = ["settings = bpy.context.scene.umbilics"]
    preset_values = [
        f"settings.{name}{suffix}"
        for name, option in core.options().items()
        for suffix in (("_auto", "") if option.automatic else ("",))
    ]


class UMBILICS_PT_presets(PresetPanel, bpy.types.Panel):
    bl_label = "Umbilics Presets"
    bl_space_type = Tab.bl_space_type
    bl_region_type = "HEADER"
    preset_subdir = _FOLDER
    preset_operator = "script.execute_preset"
    preset_add_operator = UMBILICS_OT_add_preset.bl_idname


_CLASSES = (UMBILICS_OT_add_preset, UMBILICS_PT_presets)


def register() -> None:
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    bpy.utils.register_preset_path(str(Path(__file__).parent))


def unregister() -> None:
    bpy.utils.unregister_preset_path(str(Path(__file__).parent))
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
