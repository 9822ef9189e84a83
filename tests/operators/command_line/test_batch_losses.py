"""Nothing is lost in a batch: odd names, torn output, full disks, kills, locks, own results."""

import csv
import errno
import io
import json
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from worker_stand_in import COMMAND


@pytest.fixture
def batch(part):
    return part("batch")


@pytest.fixture
def do(batch, part, tmp_path):
    """Does a batch with the stand-in; its exit code and the rows of its table by file."""

    def do(*named, also=(), command=COMMAND, **options):
        out = options.pop("out", tmp_path / "out")
        kinds = ("json", *also)
        tasks = part("batch.plan").tasks_for(
            map(str, named), (".obj", ".ply"), (1, 1), out, [f".{kind}" for kind in kinds]
        )
        usual = {
            "worker_arguments": (),
            "jobs": 2,
            "part": (1, 1),
            "report": None,
            "resume": False,
            "tolerant": False,
            "time_limit": 60.0,
        }
        plan = batch.Plan(tasks=tasks, out=out, kinds=kinds, **usual | options)
        code = batch.run(plan, command)
        with open(plan.summary, newline="", encoding="utf-8") as file:
            return code, {row["file"]: row for row in csv.DictReader(file)}

    return do


def made(folder):
    return {
        path.relative_to(folder).as_posix()
        for path in folder.rglob("*")
        if path.is_file() and not path.name.startswith("report")
    }


ODD = (
    b"--json=pwned.obj",
    b"-x.obj",
    b"b\xff.obj",
    b"new\nline.obj",
    "line\u2028separator.obj".encode(),
    "nel\u0085.obj".encode(),
    b"=1+2.obj",
    b"@sum.obj",
    b"m" * 251 + b".obj",
    "ä".encode() * 125 + b".obj",
    b"n" * 255 + b"/" + b"k" * 248 + b".obj",
    b"tab\t.obj",
    b" blank .obj",
    b"back\\slash.obj",
    b"a.obj",
    b"a.obj.json/q.obj",
)


def test_every_name_that_a_file_can_have_gets_its_results(do, part, tmp_path, monkeypatch):
    folder = tmp_path / "in"
    for name in ODD:
        path = os.path.join(os.fsencode(folder), name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "wb") as file:
            file.write(b"well")
    (folder / "x.ply").mkdir()
    os.mkfifo(folder / "pipe.obj")
    monkeypatch.chdir(folder)
    code, rows = do(".")
    assert code == 1
    failed = [row for row in rows.values() if row["status"] != "done"]
    assert [row["file"] for row in failed] == ["./pipe.obj"]
    assert "pipe" in failed[0]["error"]
    assert len(rows) == len(ODD) + 1
    # Every report is one of its own, and where the table says.
    places = {row["json"].removeprefix("'") for row in rows.values()} - {""}
    assert len(places) == len(ODD)
    assert places == made(tmp_path / "out")
    text = (tmp_path / "out" / "report.csv").read_text("utf-8")
    assert len(text.splitlines()) == len(ODD) + 2
    # All of them are known again.
    journal = tmp_path / "out" / "report.jsonl"
    assert len(journal.read_text("ascii").splitlines()) == 2 * len(ODD) + 1
    stamps = {place: (tmp_path / "out" / place).stat().st_mtime_ns for place in places}
    do(".", resume=True)
    assert stamps == {place: (tmp_path / "out" / place).stat().st_mtime_ns for place in places}


FORMULA = ("=", "+", "-", "@", "＝", "＋", "－", "＠")
NUMBERS = ("seconds", "peak_mb")


def written_table(part, path, *texts):
    """A summary with the texts wherever there can be some."""
    entry = {
        "name": "a.obj",
        "file": texts[0],
        "status": "failed",
        "results": {"json": [texts[1]]},
        "objects": [{"object": texts[2], "error": texts[3]}, {"object": texts[0], "error": ""}],
        "seconds": -1.5,
        "peak_mb": 0,
        "error": texts[1],
    }
    part("batch.summary").write_report(path, [entry])
    return path.read_text("utf-8")


def cells(text, separators):
    """What programs take for cells that people wrote, by what they hold for their separators; a
    quote in the middle of a cell means something to some of them and to others not."""
    lines = text.splitlines()[1:]
    if separators == ",":
        return [
            cell
            for row in csv.DictReader(io.StringIO(text))
            for name, cell in row.items()
            if name not in NUMBERS
        ]
    naive = [cell.strip().strip('"').strip() for line in lines for cell in line.split(";")]
    naive = [cell for cell in naive if not cell.startswith(",")]
    return naive + [cell for row in csv.reader(lines, delimiter=";") for cell in row]


TEXT = st.text("ab;,\"' \t=+-@＝\n", max_size=12)


@settings(max_examples=50, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(texts=st.tuples(TEXT, TEXT, TEXT, TEXT))
@example(texts=("=HYPERLINK(1).obj", "-y", "+x", "\t=1"))
@example(texts=("a;=1+1.obj", 'b; "=1', 'c,;"=1', "d;@1"))
def test_no_cell_is_a_formula(part, tmp_path, texts):
    text = written_table(part, tmp_path / "r.csv", *texts)
    assert len(text.splitlines()) == 3
    for separators in (",", ";"):
        for cell in cells(text, separators):
            assert not cell.lstrip().startswith(FORMULA), (separators, cell)
    assert ",-1.5,0," in text


def test_a_text_that_is_no_formula_stays_as_it_is(part, tmp_path):
    texts = ("a;b, c.obj", 'say "a-b"; no', "x = 1", "1 - 2")
    text = written_table(part, tmp_path / "r.csv", *texts)
    found = cells(text, ",")
    assert set(texts) <= set(found)


BAD = {
    "torn": "missing or incomplete",
    "silent": "exit code 1",
    "crash": "signal 6",
    "half": "exit code 1",
    "word of its own": "of its own",
}


def test_what_is_torn_or_half_made_is_not_delivered(do, tmp_path):
    for number, what in enumerate(BAD):
        (tmp_path / f"{number}.obj").write_text(what)
    (tmp_path / "good.obj").write_text("well")
    code, rows = do(*sorted(tmp_path.glob("*.obj")), also=("ply",))
    assert code == 1
    for row, words in zip(list(rows.values())[: len(BAD)], BAD.values(), strict=True):
        assert row["status"] == "failed"
        assert words in row["error"]
    assert made(tmp_path / "out") == {"good.obj.json", "good.obj.ply"}


def test_a_process_that_could_not_even_speak_failed_for_the_full_disk(
    do, part, tmp_path, monkeypatch
):
    def full(**_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(part("batch.worker"), "TemporaryFile", full)
    for name, what in (("a", "silent"), ("b", "word of its own")):
        (tmp_path / f"{name}.obj").write_text(what)
    _, rows = do(*sorted(tmp_path.glob("?.obj")))
    first, second = (row["error"] for row in rows.values())
    assert first.endswith(f"out: nothing more can be written there ({os.strerror(errno.ENOSPC)})")
    assert second == "of its own"


def test_a_folder_in_the_place_of_a_result_fails_one_file(do, tmp_path):
    for name in ("a", "b"):
        (tmp_path / f"{name}.obj").write_text("well")
    (tmp_path / "out" / "a.obj.json").mkdir(parents=True)
    code, rows = do(*sorted(tmp_path.glob("*.obj")))
    assert code == 1
    assert [row["status"] for row in rows.values()] == ["failed", "done"]
    assert "a.obj.json: cannot be written (it is a folder)" in next(iter(rows.values()))["error"]


def test_a_protected_file_in_the_place_of_a_result_fails_one_file(do, tmp_path, monkeypatch):
    for name in ("a", "b"):
        (tmp_path / f"{name}.obj").write_text("well")
    kept = tmp_path / "out" / "a.obj.json"
    kept.parent.mkdir()
    kept.write_text("the user's")
    access = os.access
    # As for a user who is not root.
    monkeypatch.setattr(os, "access", lambda path, mode: access(path, mode) and path != kept)
    code, rows = do(*sorted(tmp_path.glob("*.obj")))
    assert code == 1
    assert [row["status"] for row in rows.values()] == ["failed", "done"]
    assert "a.obj.json: cannot be written (" in next(iter(rows.values()))["error"]
    assert kept.read_text() == "the user's"


def test_guidance_of_every_file_has_a_folder(do, tmp_path):
    for folder in ("a", "b"):
        (tmp_path / "in" / folder).mkdir(parents=True)
        (tmp_path / "in" / folder / "x.obj").write_text("well")
    code, _ = do(tmp_path / "in", guide=tmp_path / "g")
    assert code == 0
    assert made(tmp_path / "g") == {"a/x.obj/Egg.rosy", "b/x.obj/Egg.rosy"}
    (tmp_path / "g" / "a" / "x.obj" / "Egg.rosy").unlink()
    do(tmp_path / "in", guide=tmp_path / "g", resume=True)
    assert made(tmp_path / "g") == {"a/x.obj/Egg.rosy", "b/x.obj/Egg.rosy"}


@pytest.mark.parametrize("change", [{"worker_arguments": ("--opening=2",)}, {"key": "version 2"}])
def test_resuming_with_other_settings_does_all_again(do, tmp_path, change, capfd):
    (tmp_path / "x.obj").write_text("well")
    do(tmp_path / "x.obj")
    do(tmp_path / "x.obj", resume=True)
    assert "0 files to do, 1 done before" in capfd.readouterr().err
    do(tmp_path / "x.obj", resume=True, **change)
    assert "1 files to do" in capfd.readouterr().err


def test_resuming_knows_the_files_that_are_read_beside(do, tmp_path, capfd):
    (tmp_path / "x.obj").write_text("with x.mtl")

    def is_done(**options):
        do(tmp_path / "x.obj", **options)
        return "0 files to do, 1 done before" in capfd.readouterr().err

    do(tmp_path / "x.obj")
    assert is_done(resume=True)
    (tmp_path / "x.mtl").write_text("one that was missing")
    os.utime(tmp_path / "x.mtl", (1e9, 1e9))
    assert not is_done(resume=True)
    assert is_done(resume=True)
    (tmp_path / "x.mtl").write_text("another")
    os.utime(tmp_path / "x.mtl", (1e9, 1e9))
    assert not is_done(resume=True)
    assert is_done(resume=True)
    (tmp_path / "x.mtl").unlink()
    assert not is_done(resume=True)


def test_a_file_that_is_saved_while_it_is_read_is_done_again(do, tmp_path, capfd):
    (tmp_path / "x.obj").write_text("touch")
    do(tmp_path / "x.obj")
    do(tmp_path / "x.obj", resume=True)
    assert "1 files to do" in capfd.readouterr().err


def test_results_inside_the_folder_of_the_meshes_are_no_meshes(do, tmp_path):
    folder = tmp_path / "in"
    folder.mkdir()
    (folder / "x.obj").write_text("well")
    (folder / "results").mkdir()
    (folder / "results" / "own.ply").write_text("well")
    for resume in (False, True, False, True):
        code, rows = do(folder, out=folder / "results", also=("ply",), resume=resume)
        assert code == 0
        names = {os.path.relpath(name, folder) for name in rows}
        assert names == {"x.obj", os.path.join("results", "own.ply")}
    # Nor are they for a batch that puts its own elsewhere.
    _, rows = do(folder, also=("ply",))
    assert len(rows) == 2


def test_lines_of_a_journal_that_are_not_whole_are_dropped(part, do, tmp_path):
    journal = tmp_path / "out" / "report.jsonl"
    journal.parent.mkdir()
    (tmp_path / "1.obj").write_text("well")
    lines = [
        '{"name": "1.obj"}',
        '{"name": "1.obj", "status": "done"}',
        '{"name": "1.obj", "status": "done", "results": {}}',
        '{"name": 1, "status": "done", "results": {}}',
        '{"name": "2.obj", "status": "failed", "results": {}, "file": "2.obj", "seconds": 1,'
        ' "peak_mb": 1, "arguments": "", "objects": [], "error": ""}',
        '{"name": "3.obj", "status": "done", "results": {}, "file": "3.obj", "seconds": 1,'
        ' "peak_mb": 1, "arguments": "", "objects": [{}]}',
        "[]", "null", "", "{", '"name"',
    ]  # fmt: skip
    journal.write_text("\n".join(lines))
    assert part("batch.journal").read(journal) == []
    code, rows = do(tmp_path / "1.obj", resume=True)
    assert (code, len(rows)) == (0, 1)


def test_a_journal_on_a_full_disk_is_written_when_there_is_room_again(part, tmp_path):
    path = tmp_path / "report.jsonl"
    kept = part("batch.journal").Journal(path, fresh=True)
    entries = [{"name": name, "status": "delivering", "results": {"json": name}} for name in "abc"]
    assert kept.add(entries[0])
    # As good as a full disk: it cannot be written, and then half of a line stands there.
    whole = path.read_bytes()
    path.unlink()
    path.mkdir()
    assert not kept.add(entries[1])
    assert "report.jsonl" in kept.trouble
    path.rmdir()
    path.write_bytes(whole + b'{"name": "b", "sta')
    assert kept.add(entries[2])
    assert part("batch.journal").read(path) == entries


def test_what_cannot_be_written_is_noticed_before_the_work(do, tmp_path):
    (tmp_path / "x.obj").write_text("well")
    (tmp_path / "file").write_text("in the way")
    for report in (tmp_path / "file" / "r.csv", tmp_path):
        with pytest.raises(OSError):
            do(tmp_path / "x.obj", report=report)
    assert not made(tmp_path / "out")


def test_what_is_no_file_is_said_without_a_process(do, part, tmp_path, monkeypatch, capfd):
    monkeypatch.setattr(part("batch.runner"), "Worker", None)
    (tmp_path / "empty.obj").touch()
    (tmp_path / "folder").mkdir()
    (tmp_path / "loop.obj").symlink_to("loop.obj")
    (tmp_path / "text.txt").write_text("well")
    (tmp_path / "away.ply").symlink_to("nowhere")
    names = ("empty.obj", "none.obj", "folder", "loop.obj", "text.txt", "away.ply", "*.stl")
    code, rows = do(*(tmp_path / name for name in names))
    assert code == 1
    whys = {os.path.basename(file): row["error"].partition(": ")[2] for file, row in rows.items()}
    assert whys.pop("text.txt").startswith("not a kind of file that can be read")
    assert whys.pop("loop.obj").startswith("cannot be read (")
    assert whys == {
        "empty.obj": "the file is empty.",
        "none.obj": "there is no such file.",
        "folder": "there are no mesh files in this folder.",
        "away.ply": "there is no such file.",
        "*.stl": "there is no such file.",
    }
    # Nor for files that have one of their own.
    capfd.readouterr()
    words = [str(tmp_path / "none.blend"), "--progress", "jsonl"]
    supervised = part("batch.supervised")
    monkeypatch.setattr(supervised, "_end_of", None)
    assert supervised.run(part("arguments.parser").parse(words), []) == 1
    said = capfd.readouterr()
    assert said.err.endswith("none.blend: there is no such file.\n")
    events = [json.loads(line)["event"] for line in said.out.splitlines()]
    assert events == ["start", "file"]


def test_a_second_batch_in_the_folder_is_refused(do, batch, part, tmp_path):
    (tmp_path / "x.obj").write_text("well")
    out = tmp_path / "out"
    out.mkdir()
    code = "import sys; sys.path.insert(0, sys.argv[1]); import pathlib, lock\n"
    code += "with lock.held(pathlib.Path(sys.argv[2]), 'batch'): print('held', flush=True); input()"
    folder = str(Path(part("batch.lock").__file__).parent)
    command = [sys.executable, "-c", code, folder, str(out)]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as other:
        assert other.stdout.readline() == "held\n"
        with pytest.raises(batch.BusyError, match=f"process {other.pid}"):
            do(tmp_path / "x.obj")
        # A part of several has a lock of its own, and so has another folder.
        assert do(tmp_path / "x.obj", part=(1, 2))[0] == 0
        other.kill()
    assert do(tmp_path / "x.obj")[0] == 0
    assert not list(out.glob(".umbilics*lock"))


def test_a_file_that_takes_too_long_is_given_up_and_leaves_nothing(do, tmp_path):
    (tmp_path / "x.obj").write_text("hang")
    code, rows = do(tmp_path / "x.obj", also=("ply",), time_limit=0.5)
    assert code == 1
    (row,) = rows.values()
    assert row["error"].startswith("given up after")
    assert not made(tmp_path / "out")


@pytest.mark.skipif(sys.platform == "win32", reason="looks for processes as Unix has them")
def test_workers_end_when_the_batch_is_killed(part, tmp_path):
    """The lifetime itself; that real workers have it is in test_batch."""
    folder = str(Path(part("batch.lifetime").__file__).parent)
    code = "import sys, time; sys.path.insert(0, sys.argv[1]); import lifetime\n"
    code += "lifetime.end_with_parent(); print('on', flush=True); time.sleep(600)"
    middle = (
        "import subprocess, sys; p = subprocess.Popen([sys.executable, '-c', sys.argv[2],"
        " sys.argv[1]], stdin=subprocess.PIPE); print(p.pid, flush=True); input()"
    )
    parent = subprocess.Popen(
        [sys.executable, "-c", middle, folder, code],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    with parent:
        said = {parent.stdout.readline().strip(), parent.stdout.readline().strip()}
        (worker,) = map(int, said - {"on"})
        parent.kill()
        parent.wait()
        while _runs(worker):
            time.sleep(0.02)


def _runs(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    try:
        # Ended, but nobody has asked for its exit code.
        return Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


def test_every_error_in_a_report_has_words(do, tmp_path):
    for name, what in (("a", "silent"), ("b", "word "), ("c", "torn")):
        (tmp_path / f"{name}.obj").write_text(what)
    do(*sorted(tmp_path.glob("*.obj")))
    for text in (tmp_path / "out" / "report.jsonl").read_text().splitlines():
        entry = json.loads(text)
        assert entry["status"] != "failed" or entry["error"].strip()
