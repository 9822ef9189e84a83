"""Right-click, Online Manual: where each setting and button is described.

The manual are two pages of docs/ that come with the extension: they are there without a network,
and always of the version that runs.
"""

from pathlib import Path

import bpy

_MANUAL = Path(__file__).parent / "help"

# Of each page the chapters and what they are about: operators, and properties of a group, which is
# named before the point; a star stands for all that no other chapter has.
_CHAPTERS = {
    "guide": {
        "thinning-out": (
            "apply_filters", "settings.persistence", "settings.persistence_auto",
            "settings.opening", "settings.at_most", "settings.flatness", "display.strength",
            "display.opened", "display.kinds", "display.empties", "display.dropped",
            "summary.noise_multiple", "summary.candidates",
        ),
        "the-list": (
            "frame_umbilic", "copy_coordinates", "pin", "delete_umbilic", "restore_deleted",
            "summary.active", "display.sort", "display.descending",
        ),
        "maps": (
            "show_map", "hide_map", "display.map", "display.percentile", "display.lock_range",
            "display.range_low", "display.range_high", "display.legend",
        ),
        "first-detection": ("display.source", "display.scope", "display.scope_group"),
        "reading-the-picture": ("add_arrows", "display.*"),
        "statistics": ("summary.*",),
        "choosing-in-the-view": ("pick",),
        "settings": ("compare", "settings.*"),
    },
    "retopology": {
        "by-hand": ("add_pole", "guidance.strokes", "guidance.influence"),
        "plan-poles": ("guide", "plan.*", "guidance.*", "display.field", "display.crosses",
                       "display.poles"),
        "lines": (
            "lines", "separatrices", "draw_guides", "mark_seams", "guidance.families",
            "guidance.spacing", "guidance.spacing_auto", "guidance.closest", "guidance.shortest",
            "guidance.line_smoothness", "guidance.line_smoothness_auto", "guidance.length_limit",
            "guidance.length_limit_auto",
        ),
        "ridges": ("ridges", "guidance.least_bend", "guidance.ridge_kinds"),
        "how-the-quads-are-made": (
            "remesh.adaptivity", "remesh.symmetry", "remesh.mirror_single",
        ),
        "quads": ("preview_layout", "remesh_to_quads", "export_field", "write_files", "remesh.*"),
        "check-topology": (
            "new_retopology", "check_topology", "show_check", "check.*", "display.checks",
        ),
        "symmetry": ("symmetry", "align_to_x", "align_to_other", "rotation_symmetry"),
    },
}  # fmt: skip
# Detect, Clear and what belongs to them.
_OTHERS = tuple(f"bpy.{kind}.umbilics*" for kind in ("ops", "types"))


def pages() -> tuple[str, tuple[tuple[str, str], ...]]:
    """What Blender asks for: the start of all addresses, and patterns with the rest of theirs, of
    which the first that fits is taken."""
    found = [
        (pattern, f"/{page}.html#{chapter}")
        for page, chapters in _CHAPTERS.items()
        for chapter, names in chapters.items()
        for name in names
        for pattern in _patterns(name)
    ]
    found.sort(key=lambda entry: ".*" in entry[0])
    others = [(pattern, "/guide.html#first-detection") for pattern in _OTHERS]
    return _MANUAL.as_uri(), (*found, *others)


def _patterns(name: str) -> tuple[str, ...]:
    """What Blender calls an operator with its properties, or a property of a group."""
    group, _, of_group = name.partition(".")
    if of_group:
        return (f"bpy.types.umbilics_pg_{group}.{of_group}",)
    return f"bpy.ops.umbilics.{name}", f"bpy.ops.umbilics.{name}.*"


def register() -> None:
    bpy.utils.register_manual_map(pages)


def unregister() -> None:
    bpy.utils.unregister_manual_map(pages)
