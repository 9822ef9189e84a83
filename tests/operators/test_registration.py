"""Switching the add-on off leaves nothing behind, and on again brings all back."""

import sys

import bpy

NAME = "bl_ext.user_default.umbilics"


def residue() -> list[str]:
    ours = [name for name in dir(bpy.types) if name.startswith("UMBILICS_")]
    ours += [t.__name__ for t in (bpy.types.Scene, bpy.types.Object) if hasattr(t, "umbilics")]
    ours += list(dir(bpy.ops.umbilics))
    return ours


def test_off_and_on_twice(addon):
    for _ in range(2):
        addon.unregister()
        try:
            assert residue() == []
        finally:
            addon.register()
        assert hasattr(bpy.types, "UMBILICS_PT_main")
        assert bpy.context.scene.umbilics.method == "S"


def test_core_knows_no_blender(addon):
    for name, module in list(sys.modules.items()):
        if name.startswith(f"{NAME}.core"):
            assert not hasattr(module, "bpy"), name
