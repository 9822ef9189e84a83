"""Colours that show curvature, in a colour attribute of ours.

The mesh is the one that holds the results. Where that is not the object's own, an object of
ours shows it in the same place.

The attribute `umbilics_map` is on vertices for values and surface types, on face corners for
regions and the angles of a check. The mesh remembers in `umbilics_colour_before` which colour
attribute was active, and in `umbilics_map_shown` what its colours mean. One range serves all the
meshes that show a map, so that a colour means the same everywhere and one legend is true for all.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np

from .... import core
from ...base import changes, units
from ...base.errors import AttributeNameError
from ...drawing import colour_maps
from ...mesh.attributes import RESULTS, read_result, to_corners
from ...mesh.fetch import fetch
from .. import display_objects
from ..homes import mesh_of, move_out
from ..retopology.checks import ATTRIBUTES
from ..targets import is_local
from ..transaction import Transaction, all_or_nothing

NAME = "umbilics_map"
BEFORE = "umbilics_colour_before"
SHOWN = "umbilics_map_shown"

# Where zero parts the values in two, and which power of 1 / length they are.
_SIGNED = {"k1": True, "k2": True, "mean": True, "gauss": True, "gap": False}
# Maps whose low values are dark, so that what is drawn over them has to be light.
_DARK = ("gap", "check_angle")
POWER = {"k1": 1, "k2": 1, "mean": 1, "gauss": 2, "gap": 1}
TITLES = {
    "k1": "Curvature κ₁",
    "k2": "Curvature κ₂",
    "mean": "Mean curvature H",
    "gauss": "Gaussian curvature K",
    "gap": "Gap κ₁ − κ₂",
    "type": "Surface type",
    "region": "Umbilical regions",
    "check_angle": "Angle to the curvature  [°]",
}
# The largest angle between two crosses, in degrees.
_LARGEST_ANGLE = 45.0
_FROM_CURVATURES: dict[str, Callable[[np.ndarray, np.ndarray], np.ndarray]] = {
    "k1": lambda k1, k2: k1,
    "k2": lambda k1, k2: k2,
    "mean": lambda k1, k2: 0.5 * (k1 + k2),
    "gauss": lambda k1, k2: k1 * k2,
    "gap": lambda k1, k2: k1 - k2,
}
# With as many regions the colours are not told apart by a legend any more.
_MOST_NAMED = 8


@dataclass(frozen=True)
class Legend:
    """What the colours of a map mean.

    Attributes
    ----------
    title:
        Above the colours, with the unit.
    colours:
        (s, 3) sRGB from low to high, or one for each name.
    low, high:
        Range of the values; not read where there are names.
    names:
        Of the colours one by one; empty for a scale.
    """

    title: str
    colours: np.ndarray
    low: float
    high: float
    names: tuple[str, ...] = ()


def is_shown_on(obj: bpy.types.Object | None) -> bool:
    """Whether the object's mesh carries a map of ours."""
    return _shown(mesh_of(obj)) is not None


def is_dark(obj: bpy.types.Object) -> bool:
    """Whether the object shows a map on which only light strokes are seen."""
    shown = _shown(mesh_of(obj))
    return shown is not None and shown["map"] in _DARK


def _shown(mesh: bpy.types.Mesh | None) -> dict[str, Any] | None:
    """What the mesh says of its colours; None where it says nothing, or nothing that can be, in
    a damaged file."""
    kept: Any = None if mesh is None else mesh.get(SHOWN)
    if not hasattr(kept, "to_dict"):
        return None
    found: dict[str, Any] = kept.to_dict()
    numbers = [found.get(name) for name in ("low", "high")]
    if found.get("map") not in TITLES or not all(isinstance(one, float) for one in numbers):
        return None
    return found


def show(context: bpy.types.Context, objects: Sequence[bpy.types.Object]) -> int:
    """Colour objects by the scene's choice, and those anew that show a map already.

    The answer is how many of `objects` have values to show.
    """
    with all_or_nothing() as transaction:
        return write(context, objects, transaction)


def write(
    context: bpy.types.Context, objects: Sequence[bpy.types.Object], transaction: Transaction
) -> int:
    """As `show`, in a transaction.

    Raises
    ------
    AttributeNameError
        The name is taken by what is not a map of ours.
    """
    display = context.scene.umbilics_display
    meshes, values = {}, {}
    for obj in dict.fromkeys((*objects, *_shown_in(context.scene))):
        mesh = move_out(obj, RESULTS, transaction)
        if mesh is None:
            continue
        found = _values(mesh, display.map)
        if found is not None:
            meshes[obj], values[obj] = mesh, found
    low = high = 0.0
    if display.map in POWER and values:
        transaction.on_failure(_set_range, display, display.range_low, display.range_high)
        low, high = _range(display, np.concatenate(list(values.values())))
    for obj, mesh in meshes.items():
        _check_name(mesh)
        transaction.keep_attributes(mesh, (NAME,))
        transaction.keep_custom(mesh, (BEFORE, SHOWN))
        _store(mesh, *_coloured(obj, display.map, values[obj], low, high))
        mesh[SHOWN] = {"map": display.map, "low": low, "high": high}
        if mesh != obj.data:
            display_objects.place(context, obj, mesh, True, transaction)
    return sum(obj in values for obj in objects)


def write_check(obj: bpy.types.Object, transaction: Transaction) -> bool:
    """Colour a mesh that was checked, in Object Mode, by the angle between its quads and the
    directions of curvature; False where it has none. Raises as `write`."""
    mesh = obj.data
    angle = read_result(mesh, "umbilics_check_angle", ATTRIBUTES)
    if angle is None:
        return False
    # Faces without an angle are stored as zero, like those that follow the curvature exactly.
    quad = fetch(mesh.polygons, "loop_total", 1, np.int32) == 4
    angle = np.where(quad, angle, np.nan)
    colours = colour_maps.coloured(angle, 0.0, _LARGEST_ANGLE, colour_maps.sequential())
    corners = np.repeat(colours, fetch(mesh.polygons, "loop_total", 1, np.int32), axis=0)
    _check_name(mesh)
    transaction.keep_attributes(mesh, (NAME,))
    transaction.keep_custom(mesh, (BEFORE, SHOWN))
    _store(mesh, corners, "CORNER")
    mesh[SHOWN] = {"map": "check_angle", "low": 0.0, "high": _LARGEST_ANGLE}
    return True


def _is_ours(attribute: bpy.types.Attribute) -> bool:
    """Whether an attribute of the name is like the colours that we write. A mesh that others were
    joined to or parted from has them without saying what they mean."""
    return attribute.data_type == "BYTE_COLOR" and attribute.domain in ("POINT", "CORNER")


def _check_name(mesh: bpy.types.Mesh) -> None:
    """Raise `AttributeNameError` if the name of the colours is taken by what is not ours."""
    found = mesh.attributes.get(NAME)
    if found is not None and not _is_ours(found):
        raise AttributeNameError(
            f"{mesh.name} has an attribute {NAME} that is not a result of Umbilics. "
            "Rename it in the mesh's properties, under Attributes."
        )


def _shown_in(scene: bpy.types.Scene) -> list[bpy.types.Object]:
    """The objects that show a map and can be coloured now; while a mesh is edited or sculpted its
    attributes cannot be written."""
    return [
        obj
        for obj in scene.objects
        if is_shown_on(obj) and obj.mode not in ("EDIT", "SCULPT") and is_local(obj)
    ]


def _coloured(
    obj: bpy.types.Object, name: str, values: np.ndarray, low: float, high: float
) -> tuple[np.ndarray, str]:
    """(n, 3) sRGB colours of the values, and the domain that they are on."""
    if name == "region":
        colours = _region_colours(obj.umbilics.regions)
        return colours[np.clip(values, 0, len(colours) - 1)], "CORNER"
    if name == "type":
        colours = np.vstack([colour_maps.TYPE_COLOURS, colour_maps.UNKNOWN_COLOUR])
        return colours[np.clip(values, -1, len(colours) - 1)], "POINT"
    return colour_maps.coloured(values, low, high, _scale(name)), "POINT"


def hide(context: bpy.types.Context, obj: bpy.types.Object, transaction: Transaction) -> bool:
    """Remove the colours and make the attribute active that was; whether there were any."""
    mesh = mesh_of(obj)
    if mesh is None or _shown(mesh) is None:
        return False
    if mesh != obj.data:
        display = display_objects.display_of(obj)
        if display is not None:
            display_objects.remove(context, display, transaction)
    transaction.keep_attributes(mesh, (NAME,))
    transaction.keep_custom(mesh, (BEFORE, SHOWN))
    colours = mesh.color_attributes
    if NAME in colours:
        colours.remove(colours[NAME])
    before = colours.find(str(mesh.get(BEFORE, "")))
    if before >= 0:
        colours.active_color_index = before
    for name in (BEFORE, SHOWN):
        if name in mesh:
            del mesh[name]
    return True


def remove_left(mesh: bpy.types.Mesh, transaction: Transaction) -> bool:
    """Remove colours of ours of which the mesh does not say what they mean; whether there were
    any."""
    found = mesh.attributes.get(NAME)
    if not is_local(mesh) or found is None or not _is_ours(found) or _shown(mesh) is not None:
        return False
    transaction.keep_attributes(mesh, (NAME,))
    mesh.attributes.remove(found)
    return True


def legend(scene: bpy.types.Scene, obj: bpy.types.Object | None) -> Legend | None:
    """What the colours that `show` gave the object mean; None if it shows none."""
    shown = _shown(mesh_of(obj))
    if obj is None or shown is None:
        return None
    name = shown["map"]
    title = TITLES[name]
    if name == "type":
        names = tuple(kind.capitalize() for kind in core.SURFACE_TYPES)
        return Legend(title, colour_maps.TYPE_COLOURS, 0.0, 0.0, names)
    if name == "region":
        count = max(other.umbilics.regions for other in (obj, *_shown_in(scene)))
        count = min(count, _MOST_NAMED)
        names = ("None", *(f"Region {number + 1}" for number in range(count)))
        return Legend(title, _region_colours(count), 0.0, 0.0, names)
    if name == "check_angle":
        return Legend(title, colour_maps.sequential(), shown["low"], shown["high"])
    unit, factor = units.of_curvature(scene, POWER[name])
    low, high = shown["low"] * factor, shown["high"] * factor
    return Legend(f"{title}  [{unit}]", _scale(name), low, high)


def _values(mesh: bpy.types.Mesh, name: str) -> np.ndarray | None:
    """(n,) values at the vertices, or codes at vertices or corners; None without results."""
    if name == "region":
        regions = read_result(mesh, "umbilics_region")
        return None if regions is None else to_corners(mesh, regions)
    if name == "type":
        return read_result(mesh, "umbilics_surface_type")
    k1 = read_result(mesh, "umbilics_k1")
    k2 = read_result(mesh, "umbilics_k2")
    if k1 is None or k2 is None:
        return None
    return _FROM_CURVATURES[name](k1, k2)


def _range(display: bpy.types.PropertyGroup, values: np.ndarray) -> tuple[float, float]:
    """The range of the colours, which the scene keeps for the legend and for locking."""
    if not display.lock_range:
        low, high = colour_maps.robust_range(values, display.percentile, _SIGNED[display.map])
        _set_range(display, low, high)
    return display.range_low, display.range_high


def _set_range(display: bpy.types.PropertyGroup, low: float, high: float) -> None:
    with changes.silence("map"):
        display.range_low, display.range_high = low, high


def _scale(name: str) -> np.ndarray:
    return colour_maps.diverging() if _SIGNED[name] else colour_maps.sequential()


def _region_colours(count: int) -> np.ndarray:
    """(count + 1, 3) sRGB: light grey outside, then one for each region."""
    return np.vstack([np.full((1, 3), 0.86), colour_maps.distinct(count)])


def _store(mesh: bpy.types.Mesh, colours: np.ndarray, domain: str) -> None:
    present = mesh.color_attributes.get(NAME)
    if present is None:
        active = mesh.color_attributes.active_color
        mesh[BEFORE] = active.name if active is not None else ""
    elif present.domain != domain:
        mesh.color_attributes.remove(present)
        present = None
    if present is None:
        present = mesh.color_attributes.new(NAME, "BYTE_COLOR", domain)
        present = mesh.color_attributes[NAME]
    rgba = np.ones((len(colours), 4), dtype=np.float32)
    rgba[:, :3] = colours
    present.data.foreach_set("color_srgb", rgba.ravel())
    mesh.color_attributes.active_color_index = mesh.color_attributes.find(NAME)
    mesh.update()


def _map_changed(context: bpy.types.Context) -> None:
    show(context, ())
    changes.notify("view", context)


def register() -> None:
    changes.listen("map", _map_changed)


def unregister() -> None:
    changes.forget("map", _map_changed)
