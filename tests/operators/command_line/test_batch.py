"""Batches: the plan, the journal, and whole runs with broken files, a kill and a resume."""

import json
import os
import signal
import subprocess
import sys
import time
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
import surfaces
from batch_files import BLENDER, command, needs_program, rows_of, write_ellipsoid


@pytest.fixture
def batch(part):
    return part("batch")


@pytest.fixture
def plan(part):
    return part("batch.plan")


@pytest.fixture
def journal(part):
    return part("batch.journal")


def test_folders_patterns_and_files_each_give_their_tasks(plan, tmp_path):
    for name in ("a/x.obj", "a/b/y.PLY", "a/notes.txt", "c/z.stl", "c/w.stl"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("")
    named = [str(tmp_path / "a"), str(tmp_path / "c" / "*.stl"), str(tmp_path / "a/x.obj")]
    tasks = plan.tasks_for(named, (".obj", ".ply", ".stl"), (1, 1))
    assert [task.name for task in tasks] == ["b/y.PLY", "w.stl", "x.obj", "z.stl"]
    assert tasks[2].source == str(tmp_path / "a" / "x.obj")


def test_parts_share_the_tasks_out(plan, tmp_path):
    for number in range(10):
        (tmp_path / f"{number}.obj").write_text("")
    parts = [plan.tasks_for([str(tmp_path)], (".obj",), (k, 3)) for k in (1, 2, 3)]
    names = sorted(task.name for part in parts for task in part)
    assert names == [f"{number}.obj" for number in range(10)]


def test_two_files_of_one_name_are_refused(plan, tmp_path):
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "x.obj").write_text("")
    with pytest.raises(plan.PlanError, match=r"x\.obj"):
        plan.tasks_for([str(tmp_path / "a"), str(tmp_path / "b")], (".obj",), (1, 1))


def test_a_torn_line_of_the_journal_is_dropped(journal, tmp_path):
    path = tmp_path / "report.jsonl"
    rest = {"results": {}, "seconds": 1.0, "peak_mb": 1, "arguments": "", "objects": []}
    whole = {"name": "a.obj", "status": "done", "file": "a.obj"} | rest
    path.write_text(json.dumps(whole) + "\n" + '{"name": "b.obj", "sta')
    kept = journal.Journal(path, fresh=False)
    assert list(kept.entries) == ["a.obj"]
    kept.add({"name": "c.obj", "status": "done", "file": "c.obj"} | rest)
    assert [entry["name"] for entry in journal.read(path)] == ["a.obj", "c.obj"]


def test_the_progress_line_has_a_rate_and_the_time_left(batch):
    display = import_module(f"{batch.__name__}.display")
    line = display.progress_line(50, 200, 2, 25.0)
    assert line == "[#####---------------] 50/200, 2 failed, 2.0 files/s, 75 s left"
    assert display.duration(3 * 3600 + 1200) == "3 h 20 min"


@needs_program
def test_bad_files_do_not_stop_the_others(said_by, tmp_path):
    write_ellipsoid(tmp_path / "in/good.obj")
    write_ellipsoid(tmp_path / "in/deeper/good.obj", 1.2)
    (tmp_path / "in/broken.ply").write_text("no mesh")
    (tmp_path / "in/empty.stl").write_text("")
    out = tmp_path / "out"
    files = tmp_path / "in", tmp_path / "none.obj"
    code, said = said_by(*files, "--out", out, "--jobs", 2, "--also", "ply")
    assert code == 1
    assert "2 done, 3 failed" in said
    assert "none.obj: FAILED, there is no such file." in said
    rows = {os.path.relpath(row["file"], tmp_path): row for row in rows_of(out / "report.csv")}
    assert {name: row["status"] for name, row in rows.items()} == {
        "in/good.obj": "done",
        "in/deeper/good.obj": "done",
        "in/broken.ply": "failed",
        "in/empty.stl": "failed",
        "none.obj": "failed",
    }
    assert rows["in/good.obj"]["lemon"] == "4"
    assert "empty" in rows["in/empty.stl"]["error"]
    made = {path.relative_to(out).as_posix() for path in out.rglob("*") if path.is_file()}
    assert made == {
        *("report.csv", "report.jsonl", "good.obj.json", "good.obj.ply"),
        *("deeper/good.obj.json", "deeper/good.obj.ply"),
    }
    report = json.loads((out / "deeper/good.obj.json").read_text())
    assert report["objects"][0]["index_sum"] == 2.0


@needs_program
def test_a_killed_batch_is_resumed_with_nothing_lost_and_nothing_twice(said_by, tmp_path):
    count = 3
    for number in range(count):
        write_ellipsoid(tmp_path / f"in/{number}.obj", 1.0 + 0.1 * number)
    (tmp_path / "in/broken.obj").write_text("f 1 2 3\n")
    out = tmp_path / "out"
    arguments = (tmp_path / "in", "--out", out, "--jobs", 1)
    running = subprocess.Popen(command(*arguments), stderr=subprocess.DEVNULL)
    journal = out / "report.jsonl"
    deadline = time.monotonic() + 600
    while time.monotonic() < deadline:
        if journal.exists() and '"done"' in journal.read_text():
            break
        time.sleep(0.05)
    os.kill(running.pid, signal.SIGKILL)
    running.wait()
    # Nothing of it goes on alone.
    while _processes_that_name(out):
        time.sleep(0.05)
    before = [line for line in journal.read_text().splitlines() if '"done"' in line]
    assert 0 < len(before) < count + 1
    stamps = {path: path.stat().st_mtime_ns for path in out.glob("*.json")}

    code, said = said_by(*arguments, "--resume")
    assert code == 1
    assert f"{count} done, 1 failed" in said
    names = [json.loads(line)["name"] for line in journal.read_text().splitlines()]
    assert set(names) == {*(f"{number}.obj" for number in range(count)), "broken.obj"}
    rows = rows_of(out / "report.csv")
    assert sorted(row["file"] for row in rows) == sorted({row["file"] for row in rows})
    assert len(rows) == count + 1
    # What the journal had was not done again.
    kept = {json.loads(line)["name"] for line in before if '"done"' in line}
    for path, stamp in stamps.items():
        if path.stem in kept:
            assert path.stat().st_mtime_ns == stamp

    _, said = said_by(*arguments, "--resume")
    assert f"1 files to do, {count} done before" in said


def _processes_that_name(path):
    """Numbers of the processes whose command has the path in it, on Linux."""
    found = []
    for place in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            if os.fsencode(path) in place.read_bytes():
                found.append(int(place.parent.name))
        except OSError:
            continue
    return found


def write_large_ply(path):
    """1.3 million triangles, for which Blender needs more than a gigabyte."""
    surface, count = surfaces.ellipsoid((3.0, 2.0, 1.0), 5), 256
    places = 7.0 * np.stack(np.unravel_index(np.arange(count), (8, 8, 4)), axis=1)
    points = (surface.vertices + places[:, None]).reshape(-1, 3).astype("<f4")
    first = len(surface.vertices) * np.arange(count)[:, None, None]
    faces = np.empty(count * len(surface.triangles), [("count", "u1"), ("corners", "<i4", 3)])
    faces["count"], faces["corners"] = 3, (surface.triangles + first).reshape(-1, 3)
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(points)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    path.write_bytes(header.encode() + points.tobytes() + faces.tobytes())


@needs_program
@pytest.mark.skipif(sys.platform != "linux", reason="only Linux bounds another process's memory")
def test_a_file_that_needs_more_than_its_share_of_memory_fails_alone(
    batch, plan, monkeypatch, capfd, tmp_path
):
    write_ellipsoid(tmp_path / "small.obj")
    write_large_ply(tmp_path / "large.ply")
    machine = import_module(f"{batch.__name__}.machine")
    monkeypatch.setattr(machine, "free_memory", lambda: 700 << 20)
    names = ("large.ply", "small.obj")
    wanted = batch.Plan(
        tasks=tuple(plan.Task(str(tmp_path / name), name) for name in names),
        out=tmp_path / "out",
        kinds=("json",),
        worker_arguments=(),
        jobs=1,
        part=(1, 1),
        report=None,
        resume=False,
        tolerant=False,
        time_limit=600.0,
    )
    assert batch.run(wanted, command()) == 1
    said = capfd.readouterr().err
    assert "each with at most 700 MB of memory" in said
    large, small = rows_of(tmp_path / "out" / "report.csv")
    assert (large["status"], small["status"]) == ("failed", "done")
    assert "out of memory: give it more with fewer --jobs" in large["error"]


@needs_program
@pytest.mark.skipif(sys.platform != "linux", reason="Linux enforces bounds")
@pytest.mark.parametrize("results", [["--json", "a.json"], ["--out", "out"]], ids=["one", "batch"])
# Within loading the program's libraries, its threads, its scripts.
@pytest.mark.parametrize("limit", [1, 60, 150])
def test_memory_too_small_for_blender_itself_is_said(
    said_by, tmp_path, monkeypatch, results, limit
):
    monkeypatch.chdir(tmp_path)
    write_ellipsoid(tmp_path / "a.obj")
    code, said = said_by("a.obj", *results, "--memory-limit", limit)
    assert code == 1
    assert "out of memory: give it more with fewer --jobs or a larger --memory-limit" in said
    assert f"it had {limit} MB; Blender alone takes up to 500" in said
    assert not list(tmp_path.rglob("a*.json"))


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux bounds another process's memory")
@pytest.mark.parametrize(("megabytes", "is_spent"), [(150, True), (4096, False)])
def test_an_end_too_soon_for_a_look_is_laid_on_a_bound_below_blenders_need(
    batch, megabytes, is_spent
):
    # How it ends differs from system to system: exit code 127, or signal 6, 9 or 11.
    machine = import_module(f"{batch.__name__}.machine")
    with subprocess.Popen(["sleep", "60"]) as process:
        memory = machine.Memory(process.pid)
        memory.limit(megabytes << 20)
        process.kill()
    assert memory.is_spent() is is_spent


@pytest.mark.parametrize("code", [-9, -15, -6, -11, 11])
def test_a_file_is_not_blamed_where_something_else_ended_blender(batch, code):
    words = import_module(f"{batch.__name__}.machine").end_in_words(code)
    assert words.startswith(f"Blender ended with {'signal' if code < 0 else 'exit code'} ")
    assert ("something else ended it" in words) == (code in (-9, -15))
    assert ("the file may be damaged" in words) != (code in (-9, -15))


@needs_program
def test_parts_are_brought_together_in_one_summary(said_by, tmp_path):
    write_ellipsoid(tmp_path / "in/a.obj")
    (tmp_path / "in/b.stl").write_text("")
    out = tmp_path / "out"
    for part in ("1/2", "2/2"):
        code, _ = said_by(tmp_path / "in", "--out", out, "--part", part, "--tolerant")
        assert code == 0
    code, said = said_by("--out", out, "--summary")
    assert code == 1
    assert "1 done, 1 failed" in said
    assert [row["status"] for row in rows_of(out / "report.csv")] == ["done", "failed"]


def test_batch_options_without_a_folder_are_refused(said_by):
    code, said = said_by("a.obj", "--resume")
    assert code == 2
    assert "--resume needs --out DIR" in said


@needs_program
def test_a_process_of_its_own_does_not_tell_its_version_once_more(part):
    quiet = part("command")._quiet()
    if not quiet:
        pytest.skip("this Blender has no option for it")
    command = [BLENDER, *quiet, "-b", "--factory-startup", "--python-expr", "print('here')"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout == "here\n"
