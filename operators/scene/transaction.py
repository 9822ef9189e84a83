"""Changes to the file that all happen or none.

What goes wrong half way must not leave half of the results. So whoever writes makes what is new
first and says so, says beforehand what it is about to change, and leaves to the end what is to
go: until then everything can be taken back.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from typing import Any

import bpy
import numpy as np

from ..base import changes
from ..data.belonging import mesh_behind
from ..mesh.fetch import LAYOUT, fetch

# The colours of a map, beside the types that results are of.
_VALUES = LAYOUT | {
    "BYTE_COLOR": (4, np.float32, "color_srgb", "Colour"),
    "BOOLEAN": (1, bool, "value", "Boolean"),
}
# What is to go makes room for new names until it does.
_GOING = "umbilics, going"


class Transaction:
    """What has been changed so far, and how to take it back; see `all_or_nothing`."""

    def __init__(self, back: ExitStack) -> None:
        self._back = back
        self._unwanted: list[bpy.types.ID] = []
        self._last: list[Callable[[], Any]] = []
        self.going: set[bpy.types.ID] = set()
        """At the end, what goes; nothing before."""
        self._sweeps: list[Callable[[set[bpy.types.ID]], Sequence[bpy.types.ID]]] = []

    def on_failure(self, back: Callable[..., Any], *arguments: Any) -> None:
        """Call this if anything fails from here on, the last that was said first."""
        self._back.callback(back, *arguments)

    def at_end(self, work: Callable[..., Any], *arguments: Any) -> None:
        """Call this when all else is done: for what cannot be taken back."""
        self._last.append(lambda: work(*arguments))

    def made(self, data: bpy.types.ID) -> Any:
        """A data-block that was just made, which goes if anything fails; it is the answer too."""
        self.on_failure(_remove_if_there, data)
        return data

    def discard(self, unwanted: Sequence[bpy.types.ID]) -> None:
        """Data-blocks that go at the end, in one stroke; their names are free at once."""
        for data in unwanted:
            self.on_failure(setattr, data, "name", data.name)
            data.name = _GOING
        self._unwanted += unwanted

    def sweep(self, find: Callable[[set[bpy.types.ID]], Sequence[bpy.types.ID]]) -> None:
        """At the end ask which data-blocks nothing needs without those that go; they go too."""
        self._sweeps.append(find)

    @contextmanager
    def part(self) -> Iterator[Transaction]:
        """A transaction within this one: what fails in it is taken back alone, and what it leaves
        to the end waits for the end of all."""
        with ExitStack() as back:
            part = Transaction(back)
            part.going = self.going
            yield part
            self._back.callback(back.pop_all().close)
        # What it does at the end is taken back with the rest.
        part._back = self._back
        self._unwanted += part._unwanted
        self._last += part._last
        self._sweeps += part._sweeps

    def take_back(self) -> None:
        """Take everything back here and now, though nothing has failed."""
        self._back.close()
        self._unwanted, self._last, self._sweeps = [], [], []

    def keep(self, owner: bpy.types.bpy_struct, *names: str) -> None:
        """Remember properties of Blender's or of ours, in an order in which they can be put."""
        for name in reversed(names):
            self.on_failure(setattr, owner, name, getattr(owner, name))

    def keep_selection(self, layer: bpy.types.ViewLayer) -> None:
        """Remember which objects are selected, and which one is active."""
        self.on_failure(_select, layer, set(layer.objects.selected), layer.objects.active)

    def keep_properties(self, owner: bpy.types.ID, name: str, but: Collection[str] = ()) -> None:
        """Remember a group of properties of ours, to put its values back; `but` not these."""
        if not owner.is_property_set(name):
            self.on_failure(owner.property_unset, name)
            return
        values = _values_of(getattr(owner, name), but)
        self.on_failure(_put_properties_back, owner, name, values)

    def keep_custom(self, owner: bpy.types.ID, names: Collection[str]) -> None:
        """Remember custom properties, or that there are none."""
        for name in names:
            found = owner.get(name)
            value = found.to_dict() if hasattr(found, "to_dict") else found
            self.on_failure(_put_custom_back, owner, name, value)

    def keep_attributes(self, mesh: bpy.types.Mesh, names: Collection[str]) -> None:
        """Remember attributes of a mesh that is not in Edit Mode, or that there are none; and
        which one and which colours are active."""
        colours = mesh.color_attributes.active_color
        active = mesh.attributes.active
        self.on_failure(_activate, mesh, active and active.name, colours and colours.name)
        for name in names:
            found = mesh.attributes.get(name)
            if found is None:
                self.on_failure(_remove_attribute, mesh, name)
                continue
            if found.data_type not in _VALUES:
                # None of ours has such a type: it is the user's, whatever its name, and stays.
                continue
            width, dtype, key, _ = _VALUES[found.data_type]
            values = fetch(found.data, key, width, dtype)
            layout = found.data_type, found.domain
            self.on_failure(_put_attribute_back, mesh, name, *layout, values)

    def finish(self) -> None:
        """Do what was left to the end."""
        going = set(self._unwanted)
        for find in self._sweeps:
            going |= set(find(going))
        self.going |= going
        if going:
            self._leave()
        for work in self._last:
            work()
        if going:
            bpy.data.batch_remove(going)

    def _leave(self) -> None:
        """Make the mesh behind the active object active where that goes."""
        layer, going = bpy.context.view_layer, self.going
        objects = layer.objects
        behind = mesh_behind(objects.active)
        if behind is None or objects.active not in going or behind in going:
            return
        if behind.name in objects:
            self.keep_selection(layer)
            behind.select_set(True)
            objects.active = behind


def empty_without(
    collections: Collection[bpy.types.Collection], going: set[bpy.types.ID]
) -> list[bpy.types.Collection]:
    """Those of the collections in which nothing is left without what goes."""
    return [
        one for one in collections if not one.children and all(obj in going for obj in one.objects)
    ]


@contextmanager
def all_or_nothing() -> Iterator[Transaction]:
    """Whatever fails within the block, or in what it leaves to the end, takes all of it back."""
    with ExitStack() as back:
        transaction = Transaction(back)
        yield transaction
        transaction.finish()
        back.pop_all()


def part_of(whole: Transaction | None) -> AbstractContextManager[Transaction]:
    """A part of the whole if there is one, else `all_or_nothing`."""
    return all_or_nothing() if whole is None else whole.part()


def _remove_if_there(data: bpy.types.ID) -> None:
    try:
        known = data.name_full
    except ReferenceError:
        return
    if known is not None:
        bpy.data.batch_remove([data])


def _select(
    layer: bpy.types.ViewLayer, selected: set[bpy.types.Object], active: bpy.types.Object | None
) -> None:
    for obj in layer.objects:
        if obj.select_get() != (obj in selected):
            obj.select_set(obj in selected)
    layer.objects.active = active


def _values_of(group: bpy.types.PropertyGroup, but: Collection[str] = ()) -> dict[str, Any]:
    """All values of a group `but` these, those of the groups in it included."""
    values: dict[str, Any] = {}
    for item in group.bl_rna.properties:
        if item.identifier == "rna_type" or item.identifier in but:
            continue
        value = getattr(group, item.identifier)
        if item.type == "COLLECTION":
            values[item.identifier] = [_values_of(one) for one in value]
        elif not item.is_readonly:
            values[item.identifier] = tuple(value) if getattr(item, "is_array", False) else value
    return values


def _put_properties_back(owner: bpy.types.ID, name: str, values: dict[str, Any]) -> None:
    with changes.silence("active"):
        _set_values(getattr(owner, name), values)


def _set_values(group: bpy.types.PropertyGroup, values: dict[str, Any]) -> None:
    for name, value in values.items():
        if isinstance(value, list):
            items = getattr(group, name)
            items.clear()
            for one in value:
                _set_values(items.add(), one)
            continue
        now = getattr(group, name)
        # Others may be told of a value that is set.
        if (tuple(now) if isinstance(value, tuple) else now) != value:
            setattr(group, name, value)


def _put_custom_back(owner: bpy.types.ID, name: str, value: Any) -> None:
    if value is not None:
        owner[name] = value
    elif name in owner:
        del owner[name]


def _remove_attribute(mesh: bpy.types.Mesh, name: str) -> None:
    found = mesh.attributes.get(name)
    if found is not None:
        mesh.attributes.remove(found)


def _put_attribute_back(
    mesh: bpy.types.Mesh, name: str, data_type: str, domain: str, values: np.ndarray
) -> None:
    found = mesh.attributes.get(name)
    if found is not None and (found.data_type, found.domain) != (data_type, domain):
        mesh.attributes.remove(found)
        found = None
    if found is None:
        found = mesh.attributes.new(name, data_type, domain)
        found = mesh.attributes[name]
    found.data.foreach_set(_VALUES[data_type][2], values.ravel())
    mesh.update()


def _activate(mesh: bpy.types.Mesh, name: str | None, colours: str | None) -> None:
    for collection, wanted, index in (
        (mesh.attributes, name, "active_index"),
        (mesh.color_attributes, colours, "active_color_index"),
    ):
        place = collection.find(wanted) if wanted else -1
        if getattr(collection, index) != place:
            setattr(collection, index, place)
