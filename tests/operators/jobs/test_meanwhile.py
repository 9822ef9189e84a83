"""What happens between reading and writing is seen by each operator that writes to a mesh which it
has read: it says so, and leaves everything as it is then."""

from functools import partial

import bpy
import pytest
from scene_building import add_ellipsoid
from whole_state import differences, everything


def one(name="Read"):
    return add_ellipsoid(subdivisions=2, name=name)


def two():
    """The active one, which is read, and the other one that it is brought onto."""
    other, read = one("Other"), one()
    read.rotation_euler = (0.3, 0.2, 0.1)
    other.select_set(True)
    bpy.context.view_layer.update()


def checked():
    """The active one is held against the other, which is its surface."""
    surface = one("Surface")
    made = bpy.data.objects.new("Read", surface.data.copy())
    bpy.context.scene.collection.objects.link(made)
    made.select_set(True)
    bpy.context.view_layer.objects.active = made
    bpy.context.view_layer.update()


def deleted(name):
    bpy.data.objects.remove(bpy.data.objects[name])


def a_vertex_moved(name):
    mesh = bpy.data.objects[name].data
    mesh.vertices[0].co.x += 0.5
    mesh.update()


def faces_turned_over(name):
    bpy.data.objects[name].data.flip_normals()


def scaled(name):
    bpy.data.objects[name].scale.x = 2.0
    bpy.context.view_layer.update()


def turned(name):
    bpy.data.objects[name].rotation_euler.x += 0.5
    bpy.context.view_layer.update()


def in_mode(mode, name):
    bpy.context.view_layer.objects.active = bpy.data.objects[name]
    bpy.ops.object.mode_set(mode=mode)


def moved_in_edit_mode(name):
    a_vertex_moved(name)
    in_mode("EDIT", name)


def sculpted(name):
    in_mode("SCULPT", name)


GONE = "{name} is no longer there. Try again."
CHANGED = "{name} was changed meanwhile. "
DEFORMED = f"{CHANGED}The mesh was edited or deformed"
MOVED = "{name} was moved meanwhile. Try again."
CHANGES = [
    (deleted, GONE),
    (a_vertex_moved, DEFORMED),
    (faces_turned_over, f"{CHANGED}The mesh was edited: its vertices or faces are others."),
    (scaled, f"{CHANGED}The object was scaled."),
    (moved_in_edit_mode, DEFORMED),
    (sculpted, "Leave Sculpt Mode first"),
]
# The operators, and what they are given.
OPERATORS = {
    "detect": {},
    "guide": {},
    "lines": {},
    "separatrices": {},
    "ridges": {},
    "draw_guides": {},
    "mark_seams": {"lines": "SEPARATRICES"},
    "symmetry": {},
    "rotation_symmetry": {},
    "preview_layout": {"quads": 60},
    "remesh_to_quads": {"quads": 60},
    "align_to_other": {},
    "check_topology": {},
}
SCENES = {"align_to_other": two, "check_topology": checked}
# Those of `detect`, of `retopology` and of `matching` see every change; one of each other one.
WHOLE = ("detect", "guide", "align_to_other")
MEANWHILE = [
    *((name, "Read", change, words) for name in WHOLE for change, words in CHANGES),
    *(
        (name, "Read", a_vertex_moved, DEFORMED)
        for name in OPERATORS
        if name not in (*WHOLE, "check_topology")
    ),
    *(("align_to_other", "Other", change, words) for change, words in CHANGES),
    ("align_to_other", "Read", turned, MOVED),
    ("align_to_other", "Other", turned, MOVED),
    ("check_topology", "Read", deleted, GONE),
    ("check_topology", "Read", a_vertex_moved, CHANGED),
    ("check_topology", "Surface", deleted, GONE),
]


@pytest.fixture
def happens(addon, monkeypatch):
    """Lets something happen when an operator has computed and not written; the state after it."""
    worker, states = addon.operators.jobs.worker, []
    real = worker.outcome_of

    def prepare(what):
        def outcome_of(job):
            found = real(job)
            what()
            states.append(everything())
            return found

        monkeypatch.setattr(worker, "outcome_of", outcome_of)
        return states

    return prepare


def run(name):
    return getattr(bpy.ops.umbilics, name)(**OPERATORS[name])


@pytest.mark.parametrize(
    ("name", "whose", "change", "words"),
    MEANWHILE,
    ids=[f"{name}-{whose}-{change.__name__}" for name, whose, change, _ in MEANWHILE],
)
def test_a_change_is_said_and_nothing_is_written(happens, name, whose, change, words):
    SCENES.get(name, one)()
    states = happens(partial(change, whose))
    with pytest.raises(RuntimeError) as refused:
        run(name)
    assert words.format(name=whose) in str(refused.value)
    assert differences(states[0], everything()) == []


@pytest.mark.parametrize("name", [*WHOLE, "check_topology", "remesh_to_quads"])
def test_who_enters_edit_mode_stays_in_it_and_has_the_results(happens, name):
    SCENES.get(name, one)()
    states = happens(partial(in_mode, "EDIT", "Read"))
    assert run(name) == {"FINISHED"}
    assert bpy.context.mode == "EDIT_MESH"
    assert differences(states[0], everything()) != []


@pytest.mark.parametrize("name", ["detect", "guide"])
def test_who_turns_the_object_has_results_that_turn_with_it(happens, name):
    one()
    happens(partial(turned, "Read"))
    assert run(name) == {"FINISHED"}


@pytest.mark.parametrize("job", ["detect", "retopology", "matching"])
def test_an_object_that_an_undo_takes_away_is_missed(addon, job):
    """As in a window, where the user has it between two calls of the operator."""
    jobs = addon.operators.jobs
    bpy.ops.ed.undo_push(message="nothing there")
    two()
    bpy.ops.ed.undo_push(message="two there")
    context = bpy.context
    if job == "detect":
        made = jobs.detect.gather(context.object, addon.core.Settings())
    elif job == "retopology":
        made = jobs.retopology.gather(context, context.object, jobs.works.lines)
    else:
        made = jobs.matching.gather(context, False)
    found = made.compute()
    bpy.ops.ed.undo()
    assert "Read" not in bpy.data.objects
    with pytest.raises(addon.core.UmbilicsError, match="is no longer there"):
        if job == "detect":
            jobs.detect.write(bpy.context, made, found)
        elif job == "retopology":
            with jobs.retopology.written(bpy.context, made):
                pass
        else:
            jobs.matching.move(bpy.context, made, found)
    assert not bpy.data.objects
