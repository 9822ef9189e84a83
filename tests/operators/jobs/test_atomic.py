"""A failure at any point of writing leaves everything as it was: all or nothing."""

from types import SimpleNamespace

import bpy
import pytest
from scene_building import add_ellipsoid, empty_scene
from whole_state import differences, everything

GUIDANCE = "scene.retopology.guidance_objects"


class InjectedError(Exception):
    """What goes wrong in these tests, which no code of ours expects."""


def fails(monkeypatch, module, name, after=False):
    """Let a function fail, before or after it has done its work."""
    real = getattr(module, name)

    def broken(*arguments, **named):
        if after:
            real(*arguments, **named)
        raise InjectedError(name)

    monkeypatch.setattr(module, name, broken)


# Where the writing of a detection can fail, from the first step to the last.
DETECTING = [
    ("scene.homes", "home_for"),
    ("scene.homes", "leave"),
    ("jobs.detect", "write_results"),
    ("mesh.attributes", "remove_results"),
    ("data.summary", "forget"),
    ("data.record", "store"),
    ("data.pins", "carry_over"),
    ("data.summary", "text_of"),
    ("scene.homes", "settle"),
    ("data.summary", "store"),
    ("data.summary", "list_items"),
    ("scene.empties", "image_of"),
    ("scene.empties", "_dress"),
    ("scene.empties", "_properties"),
    ("scene.empties", "replace"),
    ("scene.filters", "write"),
    ("scene.view.maps", "_set_range"),
    ("scene.view.maps", "_store"),
    ("scene.view.maps", "write"),
]
PLANNING = [
    ("jobs.retopology", "home_of_plan"),
    (GUIDANCE, "write_attributes"),
    (GUIDANCE, "replaced"),
    (GUIDANCE, "_upright"),
    (GUIDANCE, "adopt"),
    ("data.plans", "store"),
    ("scene.homes", "settle"),
]
STATES = ["nothing there", "results there", "with a map", "in Edit Mode", "results, in Edit Mode"]


def scene(state, kind="own"):
    """An ellipsoid with what the state says; `beside`: its modifiers make other vertices."""
    obj = add_ellipsoid(subdivisions=3)
    if kind == "beside":
        obj.modifiers.new("Subdivision", "SUBSURF").levels = 1
    colours = obj.data.color_attributes.new("mine", "BYTE_COLOR", "POINT")
    obj.data.color_attributes.active_color = obj.data.color_attributes[colours.name]
    other = bpy.data.objects.new("Other", bpy.data.meshes.new("Other"))
    bpy.context.scene.collection.objects.link(other)
    if state.startswith(("results", "with")):
        bpy.ops.umbilics.detect()
        obj.umbilics.active = 1
        bpy.ops.umbilics.pin()
        bpy.ops.umbilics.guide()
    if state == "with a map":
        bpy.ops.umbilics.show_map()
        bpy.context.scene.umbilics_display.lock_range = False
    if state.endswith("Edit Mode"):
        bpy.ops.object.mode_set(mode="EDIT")
    bpy.context.scene.umbilics.scale_auto = False
    bpy.context.view_layer.update()
    return obj


def part(addon, path):
    found = addon.operators
    for name in path.split("."):
        found = getattr(found, name)
    return found


def called(addon, monkeypatch, points, write):
    """The points that the writing comes by."""
    met = set()
    with monkeypatch.context() as patch:
        for path, name in points:
            module = part(addon, path)
            real = getattr(module, name)

            def spy(*arguments, _real=real, _met=(path, name), **named):
                met.add(_met)
                return _real(*arguments, **named)

            patch.setattr(module, name, spy)
        write()
    return [point for point in points if point in met]


def assert_all_or_nothing(addon, monkeypatch, points, prepared):
    """`prepared` makes the scene and answers with what writes to it; the names of the points."""
    points = called(addon, monkeypatch, points, prepared())
    empty_scene()
    write = prepared()
    before = everything()
    for path, name in points:
        for after in (False, True):
            with monkeypatch.context() as patch:
                fails(patch, part(addon, path), name, after)
                with pytest.raises(InjectedError):
                    write()
            bpy.context.view_layer.update()
            assert differences(before, everything()) == [], (name, after)
    write()
    return [name for _, name in points]


@pytest.mark.parametrize("kind", ["own", "beside"])
@pytest.mark.parametrize("state", STATES)
def test_a_detection_that_cannot_be_written(addon, monkeypatch, state, kind):
    def prepared():
        scene(state, kind)
        detect = addon.operators.detect.UMBILICS_OT_detect
        jobs, _ = detect.jobs(SimpleNamespace(again=False), bpy.context)
        found = jobs[0].compute()
        return lambda: addon.operators.jobs.detect.write(bpy.context, jobs[0], found)

    names = assert_all_or_nothing(addon, monkeypatch, DETECTING, prepared)
    wanted = {name for _, name in DETECTING} - {"text_of", "image_of", "_set_range", "_store"}
    if state != "with a map":
        wanted -= {"write"}
    assert wanted - {"remove_results"} <= set(names)
    assert ("_store" in names) == (state == "with a map")
    assert ("text_of" in names) == (state not in ("nothing there", "in Edit Mode"))


@pytest.mark.parametrize("state", STATES)
def test_a_plan_that_cannot_be_written(addon, monkeypatch, state):
    def prepared():
        obj = scene(state)
        jobs, operator = addon.operators.jobs, addon.operators.guide
        group = bpy.context.scene.umbilics_guidance
        group.smoothness_auto, group.smoothness = False, 0.3
        job = jobs.retopology.gather(bpy.context, obj, jobs.works.plan)
        found = job.compute()
        done = operator.UMBILICS_OT_guide.done
        return lambda: done(None, bpy.context, job, found)

    names = assert_all_or_nothing(addon, monkeypatch, PLANNING, prepared)
    assert len(names) == len(PLANNING)


@pytest.mark.parametrize("name", ["forget", "leave", "remove_all"])
def test_a_clear_that_fails(addon, monkeypatch, name):
    scene("with a map")
    bpy.ops.umbilics.lines()
    bpy.context.view_layer.update()
    before = everything()
    module = {
        "forget": "data.summary",
        "leave": "scene.homes",
        "remove_all": GUIDANCE,
    }
    with monkeypatch.context() as patch:
        fails(patch, part(addon, module[name]), name, after=True)
        with pytest.raises(RuntimeError, match=name):
            bpy.ops.umbilics.clear()
    assert differences(before, everything()) == []
    assert bpy.ops.umbilics.clear() == {"FINISHED"}
