"""Where the results of an object live.

Numbers, list and empties are kept with the object that was analysed, or, where another file's
object cannot keep them, with a stand-in for it (see `display_objects`). Values at vertices and
faces go to the object's own mesh if its vertices and faces are those that were analysed and it
holds no other object's results; otherwise to a mesh of ours, which the object points to and
which lies in no scene. A mesh says in a custom property whose results it holds: objects may
share a mesh and differ in scale, and the results of one are false for the other.

Two parts of the results have a home each: `DETECTION` and `PLAN`, the names of the properties
that point to it.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np

from ..mesh.attributes import check_result_names, is_whole, read_result, remove_results
from ..mesh.build import same_surface
from ..mesh.fetch import LAYOUT, fetch
from ..mesh.fingerprint import mesh_signature
from ..mesh.read import current_mesh
from . import display_objects
from .targets import is_local
from .transaction import Transaction

DETECTION, PLAN = "umbilics", "umbilics_plan"
# On a mesh: stamp of the detection, and of the plan, whose values it holds.
_STAMP = {DETECTION: "umbilics_stamp", PLAN: "umbilics_plan_stamp"}

STAMPS = tuple(_STAMP.values())


@dataclass(frozen=True)
class Home:
    """Where results go: numbers and empties to `owner`, values to `mesh`.

    `evaluated`: they are results of what modifiers and shape keys make of the object.
    """

    owner: bpy.types.Object
    mesh: bpy.types.Mesh
    evaluated: bool


def owner_of(obj: bpy.types.Object) -> bpy.types.Object:
    """The object that keeps the results of `obj`: a stand-in of it, else itself."""
    if is_local(obj):
        return obj
    return display_objects.display_of(obj) or obj


def home_for(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    depsgraph: bpy.types.Depsgraph | None,
    transaction: Transaction,
    part: str = DETECTION,
) -> Home:
    """Where new results of `obj`, which is not in Edit Mode, go; `settle` makes it known.

    With a `depsgraph` they are results of what modifiers and shape keys make of it.
    """
    evaluated = depsgraph is not None
    if is_local(obj) and is_local(obj.data) and not _is_taken(obj, part):
        if not evaluated:
            return Home(obj, obj.data, evaluated)
        with current_mesh(obj, depsgraph) as seen:
            if same_faces(seen, obj.data):
                return Home(obj, obj.data, evaluated)
    with current_mesh(obj, depsgraph) as seen:
        display = None if is_local(obj) else display_objects.display_of(obj)
        if display is not None and mesh_signature(seen) == mesh_signature(display.data):
            mesh = display.data
        else:
            mesh = transaction.made(same_surface(seen, f"Umbilics of {obj.name}"))
    if is_local(obj):
        return Home(obj, mesh, evaluated)
    display = display_objects.place(context, obj, mesh, False, transaction)
    if obj.mode == "OBJECT" and context.view_layer.objects.active == obj:
        transaction.on_failure(_select_instead, context, display, obj)
        obj.select_set(False)
        display.select_set(True)
        context.view_layer.objects.active = display
    return Home(display, mesh, evaluated)


def _select_instead(
    context: bpy.types.Context, one: bpy.types.Object, other: bpy.types.Object
) -> None:
    one.select_set(False)
    other.select_set(True)
    context.view_layer.objects.active = other


def settle(home: Home, part: str, transaction: Transaction) -> None:
    """Let the owner point to its new home, and the mesh say whose results it holds."""
    transaction.keep_custom(home.mesh, (_STAMP[part],))
    transaction.keep_properties(home.owner, part)
    made = getattr(home.owner, part)
    made.mesh = None if home.mesh == home.owner.data else home.mesh
    made.source = "EVALUATED" if home.evaluated else "BASE"
    home.mesh[_STAMP[part]] = made.stamp


def mesh_of(obj: bpy.types.Object | None, part: str = DETECTION) -> bpy.types.Mesh | None:
    """The mesh that holds the values of the object's results; None if there is none."""
    if obj is None or obj.type != "MESH":
        return None
    made = getattr(obj, part)
    if made.mesh is not None:
        return made.mesh
    # Files of earlier versions have results and no stamp on the mesh.
    stamp = obj.data.get(_STAMP[part], made.stamp)
    return obj.data if stamp == made.stamp else None


def leave(
    obj: bpy.types.Object,
    layouts: dict[str, tuple[str, str]],
    part: str,
    transaction: Transaction,
    for_home: bpy.types.Mesh | None = None,
) -> bool:
    """Remove the values of the object's results, unless another object shows them as well.

    The answer is whether there were any. What is left on its mesh of an object that is no more
    goes, too. Values on a mesh that new ones are `for_home` are left to be replaced.
    """
    made, found = getattr(obj, part), False
    if made.mesh is not None:
        transaction.keep_properties(obj, part)
        mesh, made.mesh, found = made.mesh, None, True
        if mesh != for_home:
            discard_unused(mesh, transaction)
    if not is_local(obj.data) or obj.data == for_home:
        return found
    if _is_taken(obj, part):
        return found or _holds(obj, obj.data, part)
    if not are_ours(obj.data, layouts, part):
        return found
    transaction.keep_attributes(obj.data, tuple(layouts))
    transaction.keep_custom(obj.data, (_STAMP[part],))
    if _STAMP[part] in obj.data:
        del obj.data[_STAMP[part]]
    return remove_results(obj.data, layouts.keys(), layouts) > 0 or found


def check_names(obj: bpy.types.Object, layouts: dict[str, tuple[str, str]], part: str) -> None:
    """Raise `AttributeNameError` if the user has what is called like a result on the object's
    mesh."""
    check_result_names(obj, layouts, are_ours(obj.data, layouts, part))


def are_ours(mesh: bpy.types.Mesh, layouts: dict[str, tuple[str, str]], part: str) -> bool:
    """Whether attributes of a mesh that are called like results, of their types, are results: it
    says so, an object says so (in files of earlier versions), or they are there as a whole."""
    return (
        _STAMP[part] in mesh
        or any(_holds(obj, mesh, part) for obj in _users(mesh))
        or is_whole(mesh, layouts)
    )


def move_out(
    obj: bpy.types.Object, copied: dict[str, tuple[str, str]], transaction: Transaction
) -> bpy.types.Mesh | None:
    """A mesh with a detection's values that no object with other results shares.

    Where the object's own mesh is shared so, its values are copied to a mesh of ours.
    """
    mesh = mesh_of(obj)
    if mesh is None or mesh != obj.data or all(_holds(other, mesh) for other in _users(mesh)):
        return mesh
    made = transaction.made(same_surface(mesh, f"Umbilics of {obj.name}"))
    for name, (domain, kind) in copied.items():
        values = read_result(mesh, name, copied)
        if values is not None:
            _, _, key, _ = LAYOUT[kind]
            made.attributes.new(name, kind, domain).data.foreach_set(key, values.ravel())
    leave(obj, copied, DETECTION, transaction)
    settle(Home(obj, made, obj.umbilics.source == "EVALUATED"), DETECTION, transaction)
    return made


def others_with_results(obj: bpy.types.Object) -> bool:
    """Whether another object that shares the mesh has results, wherever they are."""
    return any(
        other != obj and (other.umbilics.detected or other.umbilics_plan.planned)
        for other in _users(obj.data)
    )


def discard_unused(mesh: bpy.types.Mesh, transaction: Transaction) -> None:
    """Have a mesh go at the end if nothing uses it then but objects that go."""

    def find(going: set[bpy.types.ID]) -> list[bpy.types.Mesh]:
        shown = sum(isinstance(one, bpy.types.Object) and one.data == mesh for one in going)
        return [mesh] if mesh.users <= shown else []

    transaction.sweep(find)


def _is_taken(obj: bpy.types.Object, part: str) -> bool:
    """Whether the object's mesh holds results of another object."""
    return any(other != obj and _holds(other, obj.data, part) for other in _users(obj.data))


def _holds(obj: bpy.types.Object, mesh: bpy.types.Mesh, part: str = DETECTION) -> bool:
    """Whether `mesh`, its own, holds the results of an object that has some."""
    return bool(getattr(obj, part).stamp) and mesh_of(obj, part) == mesh


def _users(mesh: bpy.types.Mesh) -> list[bpy.types.Object]:
    return [obj for obj in bpy.data.objects if obj.data == mesh]


def same_faces(one: bpy.types.Mesh, other: bpy.types.Mesh) -> bool:
    """Whether faces join the same vertices in two meshes, wherever those are."""
    counts = [(len(m.vertices), len(m.polygons), len(m.loops)) for m in (one, other)]
    return counts[0] == counts[1] and all(
        (
            fetch(getattr(one, kind), key, 1, np.int32)
            == fetch(getattr(other, kind), key, 1, np.int32)
        ).all()
        for kind, key in (("polygons", "loop_start"), ("loops", "vertex_index"))
    )
