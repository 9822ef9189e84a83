"""Whatever fails in an operator that writes, wherever, its scene is as it was before or as it is
after: each call of a function of ours fails once."""

import contextlib
import dataclasses
import sys
from pathlib import Path
from types import SimpleNamespace

import bmesh
import bpy
import pytest
from scene_building import add_ellipsoid, empty_scene
from whole_state import differences, everything


class InjectedError(Exception):
    """What goes wrong in these tests, which no code of ours expects."""


# What changes nothing, so that it fails where the next function would, and what takes back.
NO_WRITERS = (
    "base/",
    "drawing/",
    "data/preferences",
    "data/properties",
    "data/reading",
    "jobs/refusals",
    "mesh/evaluated",
    "mesh/fetch",
    "mesh/fingerprint",
    "mesh/read",
    "mesh/scope",
    "scene/modes",
    "scene/selection",
    "scene/targets",
    "scene/transaction",
)


class Calls:
    """The calls of functions that may write while something runs, if that computes first then
    after it; the one of a number fails."""

    def __init__(self, folder, failing=None, jobs=0):
        self.folder, self.failing, self.made = f"{folder}/", failing, []
        # How many jobs are computed before the calls count.
        self.jobs, self.computed = jobs, 0

    def _look(self, frame, event, _arg):
        code = frame.f_code
        # What a class body or a comprehension does is part of the function that it stands in.
        # A generator that goes on is no call.
        begins = event == "call" and frame.f_lineno == code.co_firstlineno
        if begins and self._counts(code):
            self.made.append(code)
            if len(self.made) - 1 == self.failing and self.computed == self.jobs:
                raise InjectedError(code.co_qualname)

    def _counts(self, code):
        if code.co_name == "outcome_of" and code.co_filename == __file__:
            self.made.clear()
            self.computed += 1
        if not code.co_filename.startswith(self.folder) or code.co_name == "poll":
            return False
        place = code.co_filename.removeprefix(self.folder)
        return code.co_name[0] != "<" and not place.startswith(NO_WRITERS)

    def __enter__(self):
        sys.settrace(self._look)
        return self

    def __exit__(self, *_):
        sys.settrace(None)

    def first(self):
        """The number of the first call of each function."""
        numbers = {}
        for number, code in enumerate(self.made):
            numbers.setdefault(code, number)
        return list(numbers.values())


def detected():
    obj = add_ellipsoid(subdivisions=2)
    bpy.ops.umbilics.detect()
    bpy.context.scene.umbilics_display.lock_range = False
    return obj


def other_settings():
    obj = detected()
    bpy.ops.umbilics.guide()
    bpy.context.scene.umbilics.scale_auto = False
    return obj


def edited():
    other_settings()
    bpy.ops.object.mode_set(mode="EDIT")


def planned():
    detected()
    bpy.ops.umbilics.guide()


def chosen():
    detected().umbilics.active = 1


def filtered():
    detected().umbilics.deleted = "0 2"


def mapped():
    detected()
    bpy.ops.umbilics.show_map()


def mirrored():
    detected()
    bpy.ops.umbilics.symmetry()


def with_all():
    mapped()
    bpy.ops.umbilics.guide()
    bpy.ops.umbilics.lines()


def split():
    obj = add_ellipsoid(subdivisions=2)
    work = bmesh.new()
    work.from_mesh(obj.data)
    bmesh.ops.split_edges(work, edges=work.edges[:40])
    work.to_mesh(obj.data)
    work.free()
    obj.data.update()
    bpy.ops.umbilics.detect()


def checked():
    surface = detected()
    made = bpy.data.objects.new("Checked", surface.data.copy())
    bpy.context.scene.collection.objects.link(made)
    made.select_set(True)
    bpy.context.view_layer.objects.active = made
    bpy.context.view_layer.update()


def angled():
    checked()
    bpy.ops.umbilics.check_topology()


def turned():
    add_ellipsoid(subdivisions=2)
    other = add_ellipsoid(subdivisions=2, name="Other")
    other.rotation_euler = (0.3, 0.2, 0.1)
    bpy.data.objects["Ellipsoid"].select_set(True)
    bpy.context.view_layer.update()


def several():
    turned()
    bpy.data.objects["Other"].select_set(True)


def several_detected():
    several()
    bpy.ops.umbilics.detect()
    bpy.context.scene.umbilics.scale_auto = False


def several_edited():
    several_detected()
    bpy.ops.object.mode_set(mode="EDIT")


# What is there, the operator, and what it is given. Of those that write by the same functions
# there is one; several objects are one whole.
OPERATORS = [
    (lambda: add_ellipsoid(subdivisions=2), "detect", {}),
    (other_settings, "detect", {}),
    (edited, "detect", {}),
    (several, "detect", {}),
    (several_detected, "detect", {}),
    (several_edited, "detect", {}),
    (turned, "align_to_other", {}),
    (detected, "add_arrows", {}),
    (planned, "add_pole", {"valence": "5"}),
    (mirrored, "align_to_x", {}),
    (filtered, "apply_filters", {}),
    (chosen, "pin", {}),
    (with_all, "clear", {}),
    (several_detected, "clear", {}),
    (several_detected, "clear_file", {}),
    (checked, "check_topology", {}),
    (angled, "show_check", {}),
    (detected, "show_map", {}),
    (mapped, "hide_map", {}),
    (detected, "new_retopology", {}),
    (detected, "guide", {"smoothness_auto": False, "smoothness": 0.3}),
    (detected, "lines", {"spacing_auto": False, "spacing": 0.5}),
    (detected, "ridges", {}),
    (detected, "draw_guides", {}),
    (detected, "mark_seams", {"lines": "SEPARATRICES", "mark": "CREASE"}),
    (detected, "symmetry", {}),
    (detected, "preview_layout", {"quads": 60}),
    (detected, "remesh_to_quads", {"quads": 60}),
    (detected, "mend", {"way": "CREASES"}),
    (split, "mend", {"way": "MERGE"}),
]


@pytest.fixture
def jobs(addon, monkeypatch):
    """What jobs compute is known after the first time, where it is wanted: here it is about the
    writing. A window has dashed lines, and a view that shows colours."""
    operators, kept = addon.operators, SimpleNamespace(known=None, next=0)
    real, detect = operators.jobs.worker.outcome_of, addon.core.detect

    def outcome_of(job):
        if kept.known is None:
            return real(job)
        kept.next += 1
        if len(kept.known) < kept.next:
            kept.known.append(real(job))
        return kept.known[kept.next - 1]

    def without_seconds(*arguments, **named):
        found = detect(*arguments, **named)
        return dataclasses.replace(found, timings=dict.fromkeys(found.timings, 0.0))

    monkeypatch.setattr(operators.jobs.worker, "outcome_of", outcome_of)
    monkeypatch.setattr(addon.core, "detect", without_seconds)
    view = operators.scene.view
    windowed = SimpleNamespace(app=SimpleNamespace(background=False), data=bpy.data)
    monkeypatch.setattr(view.dashed_lines, "bpy", windowed)

    def areas():
        return [(s, a) for s in bpy.data.screens for a in s.areas if a.type == "VIEW_3D"]

    monkeypatch.setattr(view.view_shading, "areas", areas)
    return kept


@pytest.mark.parametrize(
    ("prepare", "name", "given"),
    OPERATORS,
    ids=[f"{name}-{prepare.__name__}" for prepare, name, _ in OPERATORS],
)
def test_all_or_nothing(addon, jobs, prepare, name, given):
    folder = Path(addon.operators.__file__).parent

    def prepared():
        empty_scene()
        jobs.known, computed = None, jobs.known
        prepare()
        bpy.context.view_layer.update()
        jobs.known = computed or []
        return everything()

    def run(calls):
        jobs.next = 0
        with calls:
            done = getattr(bpy.ops.umbilics, name)(**given)
        bpy.context.view_layer.update()
        return done

    before, calls = prepared(), Calls(folder)
    assert run(calls) == {"FINISHED"}
    after = everything()
    assert differences(before, after) != []
    assert differences(before, prepared()) == []
    half = {}
    for number in calls.first():
        with contextlib.suppress(RuntimeError):
            run(Calls(folder, number, calls.computed))
        bpy.context.view_layer.update()
        now = everything()
        left = differences(before, now)
        if left and differences(after, now):
            half[f"{number} {calls.made[number].co_qualname}"] = left
        if left:
            assert differences(before, prepared()) == []
    assert half == {}
