"""Esc at any moment: the worker stops and the file is as it was."""

import threading
from types import SimpleNamespace

import bpy
import pytest
from scene_building import add_ellipsoid, census, empties

HANDLERS = ("depsgraph_update_post", "undo_post", "redo_post", "load_post")


def everything():
    """All that a detection could leave behind."""
    return census() | {
        "values": {mesh.name: _bytes(mesh) for mesh in bpy.data.meshes},
        "results": {obj.name: obj.umbilics.detected for obj in bpy.data.objects},
        "pins": {obj.name: obj.umbilics.pinned for obj in bpy.data.objects},
        "hidden": {obj.name: obj.hide_get() for obj in bpy.context.view_layer.objects},
        "selected": {obj.name: obj.select_get() for obj in bpy.context.view_layer.objects},
        "active": bpy.context.view_layer.objects.active.name,
        "handlers": {name: len(getattr(bpy.app.handlers, name)) for name in HANDLERS},
        "threads": sorted(thread.name for thread in threading.enumerate()),
    }


def _bytes(mesh):
    """The values of the results, to know them by."""
    return {
        attribute.name: hash(tuple(str(getattr(item, "value", "")) for item in attribute.data))
        for attribute in mesh.attributes
        if attribute.name.startswith("umbilics")
    }


def scene(detected=False):
    """Two selected objects, one of which gets a copy for the results of its modifiers."""
    plain = add_ellipsoid(subdivisions=3, name="Plain")
    modified = add_ellipsoid(subdivisions=2, name="Modified")
    modified.modifiers.new("Subdivision", "SUBSURF").levels = 1
    bpy.context.scene.umbilics_display.source = "EVALUATED"
    plain.select_set(True)
    if detected:
        bpy.ops.umbilics.detect()
        bpy.context.object.umbilics.active = 0
        bpy.ops.umbilics.pin()
        bpy.ops.umbilics.show_map()
        # Other settings, so that a detection which was not stopped would differ.
        bpy.context.scene.umbilics.scale_auto = False
    return plain, modified


def jobs(addon):
    detect = addon.operators.detect.UMBILICS_OT_detect
    bpy.context.view_layer.update()
    found, refused = detect.jobs(SimpleNamespace(again=False), bpy.context)
    assert not refused
    assert len(found) == 2
    return found


def run(addon, stop_at=None):
    """Run to the moment number `stop_at` and press Esc there; the moments that there were."""
    running, core = addon.operators.jobs.worker, addon.core
    moments = []
    job_list = jobs(addon)
    worker = running.BackgroundTask(job_list)
    heard = worker._report

    def report(fraction, stage):
        heard(fraction, stage)
        moments.append(worker.stage)
        if stop_at is not None and len(moments) > stop_at:
            worker.cancel()

    worker._report = report
    running._running.append(worker)
    worker.start()
    try:
        if stop_at is None:
            assert len(worker.results()) == 2
        else:
            with pytest.raises(core.CancelledError):
                worker.results()
    finally:
        running.end()
    return moments


def test_the_moments_are_those_of_all_stages_and_objects(addon):
    scene()
    moments = run(addon)
    for stage in ("Reading", "Fitting", "Turning", "Finding", "Pairing", "Locating"):
        for name in ("Plain", "Modified"):
            assert f"{name}: {stage}" in " ".join(moments), moments


@pytest.mark.parametrize("detected", [False, True], ids=["nothing there", "results there"])
def test_at_every_moment_nothing_is_left_behind(addon, detected):
    scene(detected)
    before = everything()
    count = len(run(addon))
    assert everything() == before, "reading alone changes nothing"
    assert count > 10
    for moment in range(count):
        run(addon, stop_at=moment)
        assert everything() == before, moment


def test_esc_between_the_last_step_and_the_writing_counts(addon):
    scene()
    worker = addon.operators.jobs.worker.begin(*jobs(addon))
    worker.join()
    worker.cancel()
    addon.operators.jobs.worker.end()
    with pytest.raises(addon.core.CancelledError):
        worker.results()


@pytest.mark.parametrize("levels", [0, 1])
def test_what_was_read_in_one_scene_is_written_there_whatever_the_window_shows(addon, levels):
    engine, modes = addon.operators.jobs.detect, addon.operators.scene.modes
    obj = add_ellipsoid(subdivisions=3)
    if levels:
        obj.modifiers.new("Subdivision", "SUBSURF").levels = levels
    context, first = bpy.context, bpy.context.scene
    place = modes.place_of(context)
    inputs = engine.gather(
        obj, addon.core.Settings(), depsgraph=context.evaluated_depsgraph_get() if levels else None
    )
    found = inputs.compute()
    other = bpy.data.scenes.new("Other")
    with context.temp_override(scene=other, view_layer=other.view_layers[0]):
        with modes.in_place(context, place):
            engine.write(context, inputs, found)
        assert context.scene == other
    assert len(empties(obj)) == 4
    assert all(empty.users_scene == (first,) for empty in empties(obj))
    assert not other.collection.all_objects
    gone = modes.in_place(context, ("Gone", "ViewLayer"))
    with pytest.raises(addon.core.UmbilicsError, match="is no longer there"), gone:
        pass


def test_the_end_of_a_finished_run_does_not_cancel_it(addon):
    scene()
    worker = addon.operators.jobs.worker.begin(*jobs(addon))
    worker.join()
    addon.operators.jobs.worker.end()
    assert len(worker.results()) == 2


def test_what_takes_long_is_packed_before_the_final_write(addon, monkeypatch):
    engine, record = addon.operators.jobs.detect, addon.operators.data.record
    obj = add_ellipsoid(subdivisions=4)
    inputs = engine.gather(obj, addon.core.Settings())
    found = engine.results_of(inputs, engine.compute(inputs))

    def too_late(*_):
        raise AssertionError("the window is kept waiting")

    monkeypatch.setattr(addon.core, "pack", too_late)
    monkeypatch.setattr(record, "_decode", too_late)
    engine.write(bpy.context, inputs, found)
    assert len(empties(obj)) == 4
    monkeypatch.undo()
    kept = record.of(obj)
    again = record._decode(obj.umbilics.record, obj.umbilics.stamp)
    assert (kept.edge == again.edge).all()
    assert (kept.detection.candidates.position == again.detection.candidates.position).all()
