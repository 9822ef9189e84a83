"""What the user can do: operators, the data they keep in the file, and the command line."""

from importlib import import_module

# Registered in this order and unregistered in the reverse of it.
_MODULES = (
    "preferences",
    "properties",
    "display",
    "summary",
    "live",
    "stale",
    "running",
    "detect",
    "cancel",
    "clear",
    "command_line",
)


def register() -> None:
    for name in _MODULES:
        import_module(f".{name}", __package__).register()


def unregister() -> None:
    for name in reversed(_MODULES):
        import_module(f".{name}", __package__).unregister()
