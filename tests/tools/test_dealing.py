"""How tools/test deals the tests out."""

import os
import threading
from pathlib import Path

import pytest
import run_tests


def files_in(path):
    return [path] if path.suffix == ".py" else list(path.rglob("test_*.py"))


@pytest.mark.parametrize("suite", run_tests.USUAL)
def test_every_file_is_in_one_part(suite):
    dealt, there = (
        [file for path in paths for file in files_in(Path(path))]
        for paths in (
            [path for part in run_tests.parts_of(suite, []) for path in part.paths],
            run_tests.paths_of(suite, []),
        )
    )
    assert there and sorted(dealt) == sorted(there)


@pytest.fixture
def played(monkeypatch, tmp_path):
    """A function that runs suites of which each part only meets others: as many names as meet at
    first, and all of them."""

    def play(suites, beside, cores=2):
        monkeypatch.setattr(os, "cpu_count", lambda: cores)
        met, names, meeting = [], [], threading.Barrier(beside)

        def counted(_tests, name, _run, _paths):
            names.append(name)
            if len(names) <= beside:
                meeting.wait(60.0)
                met.append(name)

        monkeypatch.setattr(run_tests.Tests, "_counted", counted)
        run_tests.Tests(tmp_path, [], []).run(suites)
        assert sorted(names) == sorted(
            part.name for suite in suites for part in run_tests.parts_of(suite, [])
        )
        return [name.split()[0] for name in met]

    return play


def test_a_window_is_driven_beside_two_others(played):
    assert sorted(played(run_tests.USUAL, 3)) == ["blender", "blender", "gui"]


def test_windows_alone_are_driven_two_at_a_time(played):
    assert played(("gui",), 2) == ["gui", "gui"]


def test_on_one_core_there_is_one_at_a_time(played):
    assert played(run_tests.USUAL, 1, cores=1) == ["blender"]
