"""Each test starts in an empty file, and meshes that were seen before are not detected again."""

import dataclasses
import importlib
import time

import pytest

PACKAGE = "bl_ext.user_default.umbilics"


@pytest.fixture(scope="session", autouse=True)
def _detections_are_shared():
    """Most tests here are about what becomes of a detection, and of the same few ellipsoids.

    Who listens to the progress, as whoever presses Esc does, has a detection of his own. A command
    that only hears signals has none: tests that send one ask first.
    """
    core = importlib.import_module(f"{PACKAGE}.core")
    digest = importlib.import_module(f"{PACKAGE}.operators.mesh.fingerprint").digest
    detect, known = core.detect, {}

    def shared(vertices, triangles, settings=None, progress=None, *, given=None, **marks):
        if progress is not None and (progress._report or not _only_signals(progress._cancelled)):
            return detect(vertices, triangles, settings, progress, given=given, **marks)
        if progress is not None:
            progress.ask()
        operators = () if given is None else (given.k1, given.k2, given.d1, given.d2)
        arrays = (vertices, triangles, *operators, *(marks[name] for name in sorted(marks)))
        key = digest(*arrays), repr(settings), tuple(sorted(marks))
        if key not in known:
            known[key] = detect(vertices, triangles, settings, given=given, **marks)
        # What tells one run from the next, in a file too, are the seconds that it took.
        found, now = known[key], time.perf_counter()
        return dataclasses.replace(found, timings=found.timings | {"cleaning": now})

    core.detect = shared
    yield
    core.detect = detect


def _only_signals(cancelled):
    """Whether nothing ends the work, or no more than a signal to a command."""
    return cancelled is None or type(getattr(cancelled, "__self__", None)).__name__ == "Stop"


@pytest.fixture
def part(addon):
    """The modules of the command by name, as "batch.plan"."""
    return lambda name: importlib.import_module(f"{PACKAGE}.operators.command_line.{name}")


@pytest.fixture
def run(part):
    """The command in this Blender: its exit code for these words."""
    return lambda *words: part("command").run([str(word) for word in words])


@pytest.fixture
def said_by(run, capfd):
    """As `run`, which starts other processes for the files of a batch: its exit code and what it
    says of them."""

    def ran(*words):
        capfd.readouterr()
        return run(*words), capfd.readouterr().err

    return ran


@pytest.fixture
def here(addon, monkeypatch):
    """Files whose damage could end Blender are read in this one, not each in one of its own.

    For tests of what is done with what a whole file holds; those of torn files, of limits and of
    signals have the processes.
    """
    command = addon.operators.command_line.command
    monkeypatch.setattr(command, "_needs_processes", lambda request: False)


@pytest.fixture(autouse=True)
def _empty_file(addon):
    from scene_building import empty_scene

    empty_scene()
