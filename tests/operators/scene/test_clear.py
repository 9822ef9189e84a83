"""Clear finds all that is ours and nothing that is the user's."""

import bpy
import pytest
from scene_building import add_ellipsoid, census, empties, empty_scene, result_names


def ours():
    """Names of all objects and collections that carry a tag of ours."""
    return [
        data.name
        for data in (*bpy.data.objects, *bpy.data.collections)
        if any(
            key.startswith("umbilics")
            and not key.startswith("umbilics_plan")
            and key not in data.bl_rna.properties
            for key in data.keys()  # noqa: SIM118
        )
    ]


def select(*objects):
    for obj in bpy.context.view_layer.objects:
        obj.select_set(obj in objects)
    bpy.context.view_layer.objects.active = objects[0]


@pytest.fixture(scope="module")
def file_of_two(tmp_path_factory):
    """A file with two objects that have umbilics, poles and lines each."""
    empty_scene()
    objects = [add_ellipsoid(subdivisions=3, name=name) for name in ("First", "Second")]
    objects[1].location.x = 10.0
    for obj in objects:
        select(obj)
        bpy.ops.umbilics.detect()
        bpy.ops.umbilics.guide()
        bpy.ops.umbilics.lines()
    path = str(tmp_path_factory.mktemp("two") / "two.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
    return path


@pytest.fixture
def two(file_of_two):
    """The objects of the file."""
    bpy.ops.wm.open_mainfile(filepath=file_of_two)
    return [bpy.data.objects[name] for name in ("First", "Second")]


def test_the_selection_is_cleared(two):
    select(*two)
    assert bpy.ops.umbilics.clear() == {"FINISHED"}
    assert not ours()
    assert not result_names(two[0])
    assert not result_names(two[1])


def test_what_is_left_of_a_deleted_object_goes_with_the_next_clear(two):
    first, second = two
    select(first)
    bpy.ops.object.delete()
    assert len(ours()) > len(empties(second)) + 3
    select(second)
    assert bpy.ops.umbilics.clear() == {"FINISHED"}
    assert not ours()
    assert census()["objects"] == ["Second"]
    assert not bpy.data.curves


def test_collections_that_the_user_emptied_go_too(two):
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.delete()
    assert ours()
    add_ellipsoid(subdivisions=1)
    assert bpy.ops.umbilics.clear_file() == {"FINISHED"}
    assert not ours()
    assert bpy.ops.umbilics.clear_file() == {"CANCELLED"}


def test_what_was_cleared_is_said_as_it_is(two, capfd):
    first, _ = two

    def said():
        assert bpy.ops.umbilics.clear_file() == {"FINISHED"}
        return capfd.readouterr().out

    assert "Cleared 2 objects.\n" in said()
    select(first)
    bpy.ops.umbilics.detect()
    assert "Cleared one object.\n" in said()
    bpy.ops.umbilics.detect()
    bpy.ops.object.delete()
    assert "Info: What was left of other objects is removed.\n" in said()


def test_joined_objects(two):
    first, second = two
    select(second, first)
    bpy.ops.object.join()
    assert bpy.ops.umbilics.clear() == {"FINISHED"}
    assert census()["objects"] == ["Second"]
    assert not ours()
    assert not result_names(second)


def test_separated_objects(two):
    first, second = two
    select(second, first)
    bpy.ops.object.join()
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.separate(type="LOOSE")
    bpy.ops.object.mode_set(mode="OBJECT")
    assert bpy.ops.umbilics.clear_file() == {"FINISHED"}
    assert census()["objects"] == ["Second", "Second.001"]
    assert not ours()
    assert not any(obj.umbilics.detected or result_names(obj) for obj in bpy.data.objects)


@pytest.mark.parametrize("command", ["clear", "clear_file"])
def test_what_is_left_of_results_on_a_mesh_goes_by_its_stamp(two, command):
    """One each of the values of a detection and of a plan, on a mesh that another object took."""
    first, second = two
    for name in result_names(first):
        if name not in ("umbilics_k1", "umbilics_cross"):
            first.data.attributes.remove(first.data.attributes[name])
    heir = bpy.data.objects.new("Heir", first.data)
    bpy.context.collection.objects.link(heir)
    bpy.data.objects.remove(first)
    assert len(result_names(heir)) == 2
    select(second)
    assert getattr(bpy.ops.umbilics, command)() == {"FINISHED"}
    assert not result_names(heir)
    assert not any(key.startswith("umbilics") for key in heir.data.keys())  # noqa: SIM118


def test_results_beside_an_object_outlive_the_clearing_of_another():
    kept = add_ellipsoid(subdivisions=2, name="Kept")
    kept.modifiers.new("Subdivision", "SUBSURF").levels = 2
    bpy.ops.umbilics.detect()
    bpy.ops.umbilics.guide()
    other = add_ellipsoid(subdivisions=3, name="Other")
    bpy.ops.umbilics.detect()
    assert bpy.ops.umbilics.clear() == {"FINISHED"}
    assert not other.umbilics.detected
    assert "umbilics_k1" in kept.umbilics.mesh.attributes
    assert "umbilics_cross" in kept.umbilics_plan.mesh.attributes


def test_a_map_over_what_modifiers_make_goes_with_all_in_the_file():
    obj = add_ellipsoid(subdivisions=2, name="Kept")
    obj.modifiers.new("Subdivision", "SUBSURF").levels = 1
    bpy.ops.umbilics.detect()
    bpy.ops.umbilics.show_map()
    assert len(bpy.data.meshes) == 2
    assert bpy.ops.umbilics.clear_file() == {"FINISHED"}
    assert census()["objects"] == ["Kept"]
    assert len(bpy.data.meshes) == 1


def test_all_in_the_file_in_every_scene(two):
    other = bpy.data.scenes.new("Other")
    away = add_ellipsoid(subdivisions=3, name="Away")
    bpy.ops.umbilics.detect()
    for obj in (away, *empties(away)):
        other.collection.objects.link(obj)
    bpy.context.scene.collection.objects.unlink(away)
    assert bpy.ops.umbilics.clear_file() == {"FINISHED"}
    assert census()["objects"] == ["Away", "First", "Second"]
    assert not ours()
    assert not away.umbilics.detected
    assert bpy.ops.umbilics.clear_file() == {"CANCELLED"}


def left_as_it_is(empty):
    pass


def animated(empty):
    empty.keyframe_insert("location", frame=1)


def renamed(empty):
    empty.name = "Mine"


def constrained(empty):
    empty.constraints.new("COPY_LOCATION")


def with_a_child(empty):
    child = bpy.data.objects.new("Child", None)
    bpy.context.scene.collection.objects.link(child)
    child.parent = empty


@pytest.mark.parametrize("work", [left_as_it_is, animated, renamed, constrained, with_a_child])
def test_an_umbilic_that_was_freed_and_used_is_the_users(two, work):
    freed = empties(two[0])[0]
    freed.parent = None
    work(freed)
    name = freed.name
    assert bpy.ops.umbilics.clear_file() == {"FINISHED"}
    assert name in bpy.data.objects


def test_objects_of_the_users_in_our_collections_stay(two):
    mine = bpy.data.objects.new("Mine", None)
    next(c for c in bpy.data.collections if "umbilics" in c).objects.link(mine)
    assert bpy.ops.umbilics.clear_file() == {"FINISHED"}
    assert mine.name in bpy.data.objects
    assert mine.users_collection


def test_it_can_be_undone(two):
    bpy.ops.ed.undo_push(message="before")
    before = census()["objects"]
    bpy.ops.umbilics.clear_file()
    bpy.ops.ed.undo_push(message="after")
    bpy.ops.ed.undo()
    assert census()["objects"] == before
    assert bpy.data.objects["First"].umbilics.detected


def test_a_copy_of_an_older_version_is_the_users_and_its_source_is_shown_again():
    obj = add_ellipsoid(subdivisions=3)
    copy = add_ellipsoid(subdivisions=4, name="Ellipsoid with modifiers")
    copy["umbilics_copy_of"], copy["umbilics_base"] = obj.name_full, "0-0"
    obj.hide_set(True)
    select(copy)
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    assert len(empties(copy)) == 4
    assert bpy.ops.umbilics.clear() == {"FINISHED"}
    assert not obj.hide_get()
    assert copy.name in bpy.context.view_layer.objects
    assert not ours()
