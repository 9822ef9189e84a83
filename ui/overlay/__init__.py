"""What is drawn over the 3D views: nothing of it is in the scene."""

from . import handlers


def register() -> None:
    handlers.register()


def unregister() -> None:
    handlers.unregister()
