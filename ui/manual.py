"""Right-click, Online Manual: where each setting and button is described.

The manual is the guide of docs/, which comes with the extension as one page: it is there without
a network, and always of the version that runs.
"""

from pathlib import Path

import bpy

_MANUAL = Path(__file__).parent / "help" / "guide.html"

_RETOPOLOGY = (
    "guide", "add_pole", "preview_layout", "remesh_to_quads", "lines", "separatrices", "ridges",
    "draw_guides", "mark_seams", "new_retopology", "check_topology", "show_check", "symmetry",
    "align_to_x", "align_to_other", "rotation_symmetry", "export_field",
)  # fmt: skip

# From what Blender calls it to the chapter of the guide; the first that fits is taken.
_PAGES = (
    ("bpy.types.umbilics_pg_settings.persistence*", "#thinning-out"),
    ("bpy.types.umbilics_pg_settings.opening*", "#thinning-out"),
    ("bpy.types.umbilics_pg_settings.*", "#settings"),
    ("bpy.types.umbilics_pg_display.map*", "#maps"),
    ("bpy.types.umbilics_pg_display.range*", "#maps"),
    ("bpy.types.umbilics_pg_display.*", "#reading-the-picture"),
    ("bpy.types.umbilics_pg_summary.active*", "#the-list"),
    ("bpy.types.umbilics_pg_summary.noise_multiple*", "#thinning-out"),
    ("bpy.types.umbilics_pg_summary.*", "#statistics"),
    ("bpy.types.umbilics_pg_guidance.*", "#retopology"),
    ("bpy.types.umbilics_pg_remesh.*", "#retopology"),
    ("bpy.types.umbilics_pg_plan.*", "#retopology"),
    ("bpy.types.umbilics_pg_check.*", "#retopology"),
    *((f"bpy.ops.umbilics.{name}*", "#retopology") for name in _RETOPOLOGY),
    ("bpy.ops.umbilics.show_map*", "#maps"),
    ("bpy.ops.umbilics.hide_map*", "#maps"),
    ("bpy.ops.umbilics.*", "#first-detection"),
)


def pages() -> tuple[str, tuple[tuple[str, str], ...]]:
    """What Blender asks for."""
    return _MANUAL.as_uri(), _PAGES


def register() -> None:
    bpy.utils.register_manual_map(pages)


def unregister() -> None:
    bpy.utils.unregister_manual_map(pages)
