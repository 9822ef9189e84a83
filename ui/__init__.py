"""What the user sees: panels that draw what they are given and compute nothing."""

from importlib import import_module

_MODULES = (
    "overlay",
    "kind_icons",
    "presets",
    "panel",
    "retopology",
    "list_panel",
    "display_panel",
    "statistics_panel",
    "menus",
    "keymap",
    "manual",
)


def register() -> None:
    for name in _MODULES:
        import_module(f".{name}", __package__).register()


def unregister() -> None:
    for name in reversed(_MODULES):
        import_module(f".{name}", __package__).unregister()
