"""Objects of other files: linked as they are, or as library overrides."""

import bpy
import pytest
from scene_building import add_ellipsoid, census, empties

NAME = "Far"


@pytest.fixture
def library(tmp_path):
    """A file with an ellipsoid, from which `link` takes it."""
    add_ellipsoid(subdivisions=3, name=NAME)
    path = str(tmp_path / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    return path


def link(path):
    bpy.ops.wm.read_homefile(use_empty=True)
    with bpy.data.libraries.load(path, link=True) as (_, wanted):
        wanted.objects = [NAME]
    obj = next(obj for obj in bpy.data.objects if obj.library is not None)
    bpy.context.scene.collection.objects.link(obj)
    return obj


def active(obj):
    bpy.context.view_layer.objects.active = obj
    bpy.context.view_layer.update()
    return obj


def linked(path):
    return active(link(path))


def overridden(path):
    return active(link(path).override_create(remap_local_usages=True))


def overridden_with_its_mesh(path):
    obj = overridden(path)
    obj.data.override_create(remap_local_usages=True)
    assert obj.data.library is None
    return obj


WAYS = (linked, overridden, overridden_with_its_mesh)


@pytest.mark.parametrize("way", WAYS)
def test_it_is_refused_in_words_that_name_the_ways_out(library, way):
    obj = way(library)
    bpy.context.scene.umbilics_display.source = "BASE"
    before = census()
    with pytest.raises(RuntimeError) as caught:
        bpy.ops.umbilics.detect()
    assert "Traceback" not in str(caught.value)
    assert "linked from another file" in str(caught.value)
    assert "As Seen" in str(caught.value)
    assert "Make Local" in str(caught.value)
    assert census() == before
    assert not obj.umbilics.detected


@pytest.mark.parametrize("way", WAYS)
def test_results_are_beside_it_and_stay_in_the_file(library, way, tmp_path):
    source = way(library)
    before = census()
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    beside = bpy.context.object
    assert beside != source
    assert beside.library is None
    assert beside.parent == source
    (collection,) = empties(beside)[0].users_collection
    assert collection.name == f"Umbilics of {source.name_full}", "not of what stands beside it"
    assert len(empties(beside)) == 4
    assert not source.hide_get()
    assert beside.hide_render, "a picture shows one of the two"
    # Again, from either of the two, on the same object.
    for active in (beside, source):
        bpy.context.view_layer.objects.active = active
        assert bpy.ops.umbilics.detect() == {"FINISHED"}
        assert bpy.context.view_layer.objects.active == beside
        assert len(empties(beside)) == 4
    assert bpy.ops.umbilics.guide() == {"FINISHED"}
    assert beside.umbilics_plan.planned
    assert {"umbilics_k1", "umbilics_cross"} <= set(beside.data.attributes.keys())
    path = str(tmp_path / "main.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    beside = bpy.context.object
    assert len(empties(beside)) == 4
    bpy.context.scene.umbilics_display.kinds = {"star"}
    assert not empties(beside)
    assert bpy.ops.umbilics.clear() == {"FINISHED"}
    assert census() == before


def test_results_beside_it_are_out_of_date_when_it_is_worked_on(addon, library):
    source = overridden(library)
    bpy.ops.umbilics.detect()
    beside = bpy.context.object
    assert beside != source

    def reasons():
        bpy.context.view_layer.update()
        return " ".join(addon.operators.scene.staleness.reasons(bpy.context, beside))

    assert reasons() == ""
    source.modifiers.new("Wider", "DISPLACE").strength = 0.1
    assert "moved" in reasons()


@pytest.mark.parametrize("way", [linked, overridden])
def test_results_that_come_with_it_are_seen_and_cannot_be_changed(addon, library, way):
    bpy.ops.wm.open_mainfile(filepath=library)
    active(bpy.data.objects[NAME])
    bpy.ops.umbilics.detect()
    bpy.context.object.umbilics.active = 0
    bpy.ops.wm.save_mainfile()
    obj = way(library)
    assert obj.umbilics.detected
    live = addon.operators.scene.filters
    assert len(live.shown_rows(obj, bpy.context.scene)) == 4
    assert obj not in live.with_results(bpy.context)
    assert bpy.ops.umbilics.copy_coordinates.poll()
    for name in ("pin", "delete_umbilic", "restore_deleted", "clear", "show_map"):
        assert not getattr(bpy.ops.umbilics, name).poll(), name
    # The slider acts on what can be changed, which is nothing here.
    bpy.context.scene.umbilics.persistence = 1.0
    bpy.context.scene.umbilics_display.kinds = {"star"}


def with_a_linked_mesh(path):
    far = link(path)
    bpy.context.scene.collection.objects.unlink(far)
    mine = bpy.data.objects.new("Mine", far.data)
    bpy.context.scene.collection.objects.link(mine)
    return active(mine)


@pytest.mark.parametrize("way", [*WAYS, with_a_linked_mesh])
def test_edges_that_cannot_be_marked_are_refused_for_the_true_reason(library, way):
    """To apply modifiers, of which there are none, or to take the base mesh, which is refused, was
    no help."""
    obj = way(library)
    bpy.ops.umbilics.detect()
    before = census()
    with pytest.raises(RuntimeError) as caught:
        bpy.ops.umbilics.mark_seams()
    assert f"{obj.name} is linked from another file and its edges cannot" in str(caught.value)
    assert "Make Local" in str(caught.value)
    assert census() == before


def test_made_local_it_is_as_any_other(library):
    obj = linked(library)
    obj.make_local()
    obj.data.make_local()
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    assert len(empties(obj)) == 4


def test_a_local_object_with_a_mesh_of_another_file_is_cleared(library):
    mine = with_a_linked_mesh(library)
    far_mesh, before = mine.data, census()
    for name in ("detect", "guide", "lines"):
        assert getattr(bpy.ops.umbilics, name)() == {"FINISHED"}
    assert mine.data == far_mesh
    assert len(empties(mine)) == 4
    assert bpy.ops.umbilics.clear() == {"FINISHED"}
    assert census() == before
