"""What the user can do: operators, the data they keep in the file, and the command line."""

from importlib import import_module

# Registered in this order and unregistered in the reverse of it.
_MODULES = (
    "base.translation",
    "base.caches",
    "data.preferences",
    "data.properties",
    "data.display",
    "data.summary",
    "data.clicks",
    "scene.filters",
    "scene.choosing",
    "scene.dressing",
    "scene.view.dashed_lines",
    "scene.view.maps",
    "scene.view.view_shading",
    "scene.staleness",
    "jobs.worker",
    "detect",
    "compare",
    "cancel",
    "clear",
    "clear_file",
    "mend",
    "add_arrows",
    "apply_filters",
    "explain",
    "pin",
    "delete_umbilic",
    "restore_deleted",
    "frame_umbilic",
    "pick",
    "copy_coordinates",
    "show_map",
    "hide_map",
    "data.plans",
    "data.remeshing",
    "data.topology",
    "guide",
    "add_pole",
    "preview_layout",
    "remesh_to_quads",
    "new_retopology",
    "check_topology",
    "show_check",
    "lines",
    "separatrices",
    "ridges",
    "mark_seams",
    "symmetry",
    "align_to_x",
    "rotation_symmetry",
    "align_to_other",
    "draw_guides",
    "write_files",
    "export_field",
    "command_line",
)


def register() -> None:
    for name in _MODULES:
        import_module(f".{name}", __package__).register()


def unregister() -> None:
    for name in reversed(_MODULES):
        import_module(f".{name}", __package__).unregister()
