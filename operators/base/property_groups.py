"""Groups of properties of ours on Blender's data-blocks, as long as the add-on is on."""

from __future__ import annotations

from collections.abc import Callable

import bpy


def factory(
    classes: tuple[type, ...], *pointers: tuple[type, str, type]
) -> tuple[Callable[[], None], Callable[[], None]]:
    """`register` and `unregister` for classes and for pointers to some of them.

    Parameters
    ----------
    classes:
        In an order in which a group comes after those that it holds.
    pointers:
        For each the kind of data-block that gets it, its name there, and the class of the group.
    """
    register_classes, unregister_classes = bpy.utils.register_classes_factory(classes)

    def register() -> None:
        register_classes()
        for owner, name, group in pointers:
            setattr(owner, name, bpy.props.PointerProperty(type=group))

    def unregister() -> None:
        for owner, name, _ in reversed(pointers):
            delattr(owner, name)
        unregister_classes()

    return register, unregister
