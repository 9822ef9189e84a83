"""Ctrl-C and the like, and streams that nobody reads: what is begun ends in an orderly way."""

import json
import os
import shutil
import signal
import sys

import bpy
import pytest
from scene_building import add_ellipsoid
from worker_stand_in import COMMAND

SIGNALS = [name for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]


@pytest.fixture
def meshes(tmp_path, monkeypatch):
    """A folder, gone to, with x.obj and y.obj."""
    add_ellipsoid(subdivisions=2, name="Egg")
    bpy.ops.wm.obj_export(filepath=str(tmp_path / "x.obj"), export_materials=False)
    shutil.copy(tmp_path / "x.obj", tmp_path / "y.obj")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def stopping(addon, monkeypatch):
    """Has a signal come while something is detected."""

    def at_once(number):
        compute = addon.operators.jobs.detect.compute

        def interrupted(inputs, progress=None):
            os.kill(os.getpid(), number)
            return compute(inputs, progress)

        monkeypatch.setattr(addon.operators.jobs.detect, "compute", interrupted)

    return at_once


@pytest.mark.parametrize("name", SIGNALS)
def test_a_file_that_is_stopped_leaves_nothing_and_the_next_is_not_begun(
    run, meshes, stopping, name, capfd
):
    number = getattr(signal, name)
    before = signal.getsignal(number)
    if before == signal.SIG_IGN:
        # As shells have it for what runs in the background, where the command leaves it so.
        signal.signal(number, signal.SIG_DFL)
    stopping(number)
    try:
        code = run("x.obj", "y.obj", "--json", "o", "--ply", "o", "--progress", "jsonl")
    finally:
        if before is not None:
            signal.signal(number, before)
    said = capfd.readouterr()
    assert code == 130
    assert said.err == "umbilics: x.obj: stopped before the end.\n"
    events = [json.loads(line) for line in said.out.splitlines() if line.startswith("{")]
    assert [event["event"] for event in events if event["event"] != "progress"] == [
        "command", "start", "file", "end",
    ]  # fmt: skip
    assert events[-1]["exit_code"] == 130
    assert not (meshes / "o").exists()


def test_what_is_done_when_the_signal_comes_is_done(run, part, meshes, monkeypatch):
    write = part("report").write

    def last(*arguments):
        write(*arguments)
        os.kill(os.getpid(), signal.SIGTERM)

    monkeypatch.setattr(part("report"), "write", last)
    assert run("x.obj", "--json", "o.json") == 0
    assert run("x.obj", "y.obj", "--json", "o") == 130
    assert [path.name for path in (meshes / "o").iterdir()] == ["x.json"]


def test_meshes_to_align_to_can_be_stopped_too(run, meshes, stopping, capfd):
    stopping(signal.SIGTERM)
    assert run("x.obj", "--align-to", "y.obj", "--json", "o.json") == 130
    assert "stopped before the end" in capfd.readouterr().err


@pytest.mark.skipif("SIGHUP" not in SIGNALS, reason="no terminal that ends, as Unix has it")
def test_what_nohup_has_had_ignored_stays_ignored(part):
    stop = part("stopping").Stop()
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with stop.heard():
            os.kill(os.getpid(), signal.SIGHUP)
        assert not stop.asked()
        assert signal.getsignal(signal.SIGHUP) == signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)


def test_the_second_time_is_left_to_the_system(part):
    stop = part("stopping").Stop()
    before = signal.getsignal(signal.SIGTERM)
    with stop.heard():
        os.kill(os.getpid(), signal.SIGTERM)
        assert stop.asked()
        assert signal.getsignal(signal.SIGTERM) == signal.SIG_DFL
    assert signal.getsignal(signal.SIGTERM) == before


def test_a_file_within_limits_is_stopped_with_its_process(part, meshes, capfd):
    (meshes / "hang.obj").write_text("hang")
    words = ["hang.obj", "x.obj", "--json", "o", "--time-limit", "60"]
    request = part("arguments.parser").parse(words)
    popen = part("batch.supervised").subprocess.Popen
    started = []

    def starting(*arguments, **options):
        started.append(popen(*arguments, **options))
        os.kill(os.getpid(), signal.SIGTERM)
        return started[-1]

    with pytest.MonkeyPatch.context() as patch, request.stop.heard():
        patch.setattr(part("batch.supervised").subprocess, "Popen", starting)
        part("batch.supervised").run(request, COMMAND)
    assert len(started) == 1 and started[0].returncode != 0
    assert "hang.obj: stopped before the end" in capfd.readouterr().err


@pytest.fixture
def unread():
    """A stream that nobody reads any more."""
    reading, writing = os.pipe()
    os.close(reading)
    with open(writing, "w") as stream:
        yield stream


def test_what_nobody_reads_does_not_end_the_work(part, meshes, unread, run, monkeypatch, capfd):
    monkeypatch.setattr(sys, "stdout", unread)
    assert run("x.obj", "y.obj", "--json", "o", "--progress", "jsonl") == 0
    assert {path.name for path in (meshes / "o").iterdir()} == {"x.json", "y.json"}
    said = capfd.readouterr().err
    assert said.count("standard output takes no more") == 1


def test_nor_do_complaints_that_nobody_reads(part, meshes, unread, run, monkeypatch):
    monkeypatch.setattr(sys, "stderr", unread)
    assert run("none.obj", "x.obj", "--json", "o") == 1
    assert [path.name for path in (meshes / "o").iterdir()] == ["x.json"]
    display = part("batch.display").Display(1, unread)
    display.say("one")
    display.ended("two", failed=True)
