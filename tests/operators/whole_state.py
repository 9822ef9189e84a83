"""All that an operator of ours may write, read to the last value, and where two of these differ."""

import bpy
import numpy as np

# Groups of properties of objects and of the scene, and kinds of data of which names are enough.
OURS = ("umbilics", "umbilics_plan", "umbilics_check")
SETTINGS = ("umbilics", "umbilics_display", "umbilics_guidance", "umbilics_remesh")
OTHERS = tuple(
    kind
    for kind in ("images", "curves", "materials", "node_groups", "grease_pencils_v3", "shape_keys")
    if hasattr(bpy.data, kind)
)


def everything():
    """All that writing may touch, to the last value."""
    layer = bpy.context.view_layer
    return {
        "objects": {obj.name: _of_object(obj) for obj in bpy.data.objects},
        "meshes": {mesh.name: _of_mesh(mesh) for mesh in bpy.data.meshes},
        "collections": {
            one.name: (
                sorted(obj.name for obj in one.objects),
                sorted(child.name for child in one.children),
            )
            for one in (*bpy.data.collections, bpy.context.scene.collection)
        },
        "others": {kind: sorted(one.name for one in getattr(bpy.data, kind)) for kind in OTHERS},
        "settings": {name: _of_group(getattr(bpy.context.scene, name)) for name in SETTINGS},
        "snapping": [
            str(getattr(bpy.context.scene.tool_settings, name))
            for name in ("use_snap", "snap_elements")
        ],
        "views": {screen.name: _of_screen(screen) for screen in bpy.data.screens},
        "selected": sorted(obj.name for obj in layer.objects if obj.select_get()),
        "active": layer.objects.active.name if layer.objects.active else "",
        "mode": bpy.context.mode,
    }


def differences(before, after, path=""):
    """Where two answers of `everything` differ."""
    if before == after:
        return []
    if isinstance(before, dict) and isinstance(after, dict):
        keys = {**before, **after}
        parts = [(before.get(key), after.get(key), f"{path}/{key}") for key in keys]
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        parts = [(*pair, f"{path}/{at}") for at, pair in enumerate(zip(before, after, strict=True))]
    else:
        return [f"{path}: {str(before)[:80]} became {str(after)[:80]}"]
    return [found for one in parts for found in differences(*one)]


def _of_object(obj):
    found = {
        "data": obj.data.name if obj.data else "",
        "parent": obj.parent.name if obj.parent else "",
        "place": [tuple(row) for row in obj.matrix_world],
        "hidden": obj.hide_get(),
        "modifiers": [(one.name, one.type, one.show_viewport) for one in obj.modifiers],
        "tags": {
            key: str(obj[key].to_list() if hasattr(obj[key], "to_list") else obj[key])
            for key in obj.keys()  # noqa: SIM118
            if key not in obj.bl_rna.properties
        },
    }
    return found | {name: _of_group(getattr(obj, name)) for name in OURS}


def _of_group(group):
    found = {}
    for item in group.bl_rna.properties:
        value = getattr(group, item.identifier)
        if item.type == "COLLECTION":
            found[item.identifier] = [_of_group(one) for one in value]
        elif item.type == "POINTER" and item.identifier != "rna_type":
            found[item.identifier] = value.name if value else ""
        elif item.identifier != "rna_type":
            found[item.identifier] = str(tuple(value) if getattr(item, "is_array", 0) else value)
    return found


def _of_screen(screen):
    views = [area.spaces.active for area in screen.areas if area.type == "VIEW_3D"]
    return {
        "tags": {key: str(screen[key]) for key in screen.keys()},  # noqa: SIM118
        "views": [
            (
                *(getattr(view.shading, name) for name in ("type", "color_type", "light")),
                view.overlay.show_relationship_lines,
            )
            for view in views
        ],
    }


def _of_mesh(mesh):
    colours = mesh.color_attributes.active_color
    return {
        "attributes": {
            one.name: (one.domain, one.data_type, _bytes(one)) for one in mesh.attributes
        },
        "colours": colours.name if colours else "",
        "tags": {key: str(mesh[key]) for key in mesh.keys() if isinstance(mesh[key], str)},  # noqa: SIM118
    }


def _bytes(attribute):
    kinds = {
        "FLOAT": ("value", 1, np.float32),
        "INT": ("value", 1, np.int32),
        "BOOLEAN": ("value", 1, bool),
        "FLOAT_VECTOR": ("vector", 3, np.float32),
        "BYTE_COLOR": ("color", 4, np.float32),
    }
    if attribute.data_type not in kinds:
        return b""
    key, width, dtype = kinds[attribute.data_type]
    values = np.empty(width * len(attribute.data), dtype)
    attribute.data.foreach_get(key, values)
    return values.tobytes()
