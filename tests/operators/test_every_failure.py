"""Whatever fails in an operator that writes, wherever, its scene is as it was before or as it is
after: each call of a function of ours fails once."""

import dataclasses
import sys
from pathlib import Path

import bmesh
import bpy
import pytest
from scene_building import add_ellipsoid, empty_scene
from whole_state import differences, everything


class InjectedError(Exception):
    """What goes wrong in these tests, which no code of ours expects."""


# What changes nothing; where it fails is where the next function would.
READ_ONLY = (
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
        return code.co_name[0] != "<" and not place.startswith(READ_ONLY)

    def __enter__(self):
        sys.settrace(self._look)
        return self

    def __exit__(self, *_):
        sys.settrace(None)

    def ends(self):
        """The numbers of the first and the last call of each function."""
        first, last = {}, {}
        for number, code in enumerate(self.made):
            first.setdefault(code, number)
            last[code] = number
        return sorted({*first.values(), *last.values()})


def detected():
    obj = add_ellipsoid(subdivisions=2)
    bpy.ops.umbilics.detect()
    bpy.context.scene.umbilics_display.lock_range = False
    return obj


def planned():
    obj = detected()
    bpy.ops.umbilics.guide()
    return obj


def chosen():
    detected().umbilics.active = 1


def deleted():
    chosen()
    bpy.ops.umbilics.delete_umbilic()


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
    bpy.ops.umbilics.draw_guides()


def checked():
    surface = detected()
    mesh = surface.data.copy()
    made = bpy.data.objects.new("Checked", mesh)
    bpy.context.scene.collection.objects.link(made)
    made.select_set(True)
    bpy.context.view_layer.objects.active = made
    bpy.context.view_layer.update()


def angled():
    checked()
    bpy.ops.umbilics.check_topology()


def two():
    add_ellipsoid(subdivisions=2)
    other = add_ellipsoid(subdivisions=2, name="Other")
    other.rotation_euler = (0.3, 0.2, 0.1)
    bpy.data.objects["Ellipsoid"].select_set(True)
    bpy.context.view_layer.update()


def other_settings():
    planned()
    bpy.context.scene.umbilics.scale_auto = False


def split():
    obj = detected()
    work = bmesh.new()
    work.from_mesh(obj.data)
    bmesh.ops.split_edges(work, edges=work.edges[:40])
    work.to_mesh(obj.data)
    work.free()
    obj.data.update()
    bpy.ops.umbilics.detect()


def edited():
    other_settings()
    bpy.ops.object.mode_set(mode="EDIT")


# What is there, the operator, and what it is given.
OPERATORS = [
    (lambda: add_ellipsoid(subdivisions=2), "detect", {}),
    (other_settings, "detect", {}),
    (edited, "detect", {}),
    (two, "detect", {}),
    (two, "align_to_other", {}),
    (detected, "add_arrows", {}),
    (planned, "add_pole", {"valence": "5"}),
    (mirrored, "align_to_x", {}),
    (filtered, "apply_filters", {}),
    (chosen, "pin", {}),
    (chosen, "delete_umbilic", {}),
    (deleted, "restore_deleted", {}),
    (with_all, "clear", {}),
    (with_all, "clear_file", {}),
    (checked, "check_topology", {}),
    (angled, "show_check", {}),
    (detected, "show_map", {}),
    (mapped, "hide_map", {}),
    (detected, "new_retopology", {}),
    (detected, "guide", {"smoothness_auto": False, "smoothness": 0.3}),
    (planned, "lines", {"spacing_auto": False, "spacing": 0.5}),
    (planned, "separatrices", {}),
    (planned, "ridges", {}),
    (planned, "draw_guides", {}),
    (planned, "mark_seams", {"lines": "SEPARATRICES", "mark": "CREASE"}),
    (detected, "symmetry", {}),
    (detected, "rotation_symmetry", {}),
    (detected, "preview_layout", {"quads": 60}),
    (detected, "remesh_to_quads", {"quads": 60}),
    (detected, "mend", {"way": "CREASES"}),
    (split, "mend", {"way": "MERGE"}),
    (detected, "mend", {"way": "SMOOTH"}),
    (detected, "mend", {"way": "SUBDIVIDE"}),
]


@pytest.fixture
def computed_once(addon, monkeypatch):
    """What jobs compute is known from the first time on: here it is about the writing."""
    worker, known = addon.operators.jobs.worker, []
    real = worker.outcome_of

    def outcome_of(job):
        if len(known) <= outcome_of.asked:
            known.append(real(job))
        outcome_of.asked += 1
        return known[outcome_of.asked - 1]

    def begin():
        outcome_of.asked = 0

    def start():
        known.clear()
        begin()

    start()
    monkeypatch.setattr(worker, "outcome_of", outcome_of)
    detect = addon.core.detect

    def without_seconds(*arguments, **named):
        found = detect(*arguments, **named)
        return dataclasses.replace(found, timings=dict.fromkeys(found.timings, 0.0))

    monkeypatch.setattr(addon.core, "detect", without_seconds)
    return start, begin


@pytest.mark.parametrize(
    ("prepare", "name", "given"),
    OPERATORS,
    ids=[f"{name}-{getattr(prepare, '__name__', '')}" for prepare, name, _ in OPERATORS],
)
def test_all_or_nothing(addon, computed_once, prepare, name, given):
    import time

    T0 = time.process_time()
    start, begin = computed_once
    folder = Path(addon.operators.__file__).parent
    operator = getattr(bpy.ops.umbilics, name)

    def prepared():
        empty_scene()
        start()
        prepare()
        start()
        bpy.context.view_layer.update()
        return everything()

    before = prepared()
    with Calls(folder) as calls:
        assert operator(**given) == {"FINISHED"}
    bpy.context.view_layer.update()
    after = everything()
    assert differences(before, after) != []
    known = prepared()
    assert differences(before, known) == []
    broken = {}
    for number in calls.ends():
        begin()
        try:
            with Calls(folder, number, calls.computed):
                operator(**given)
        except RuntimeError:
            pass
        bpy.context.view_layer.update()
        now = everything()
        left = differences(before, now)
        if left and differences(after, now):
            broken[f"{number} {calls.made[number].co_qualname}"] = (
                left[:4],
                differences(after, now)[:4],
            )
        if left:
            assert differences(before, prepared()) == []
    import time

    print("TIMES", name, len(calls.made), len(calls.ends()), time.process_time() - T0)
    for k, v in broken.items():
        print(
            "BROKEN",
            name,
            k,
            "FROM BEFORE",
            [str(x)[:150] for x in v[0]],
            "FROM AFTER",
            [str(x)[:150] for x in v[1]],
        )
    assert not broken
