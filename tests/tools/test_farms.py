"""What is given to render farms: an Open Job Description, command lists, a container recipe."""

import importlib.util
import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
import surfaces
from mesh_files import write_obj

ROOT = Path(__file__).resolve().parents[2]
FARMS = ROOT / "tools" / "farms"
TEMPLATE = FARMS / "umbilics.openjd.yaml"


def openjd(*arguments):
    pytest.importorskip("openjd.cli", reason="openjd-cli is not here; tools/test installs it")
    code = "from openjd.cli import main; main()"
    return subprocess.run(
        [sys.executable, "-c", code, *map(str, arguments)],
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture
def listening(tmp_path):
    """A program that stands for Blender and writes down its arguments, one list a line."""
    program, heard = tmp_path / "blender", tmp_path / "heard.jsonl"
    program.write_text(
        f"#!{sys.executable}\nimport json, sys\n"
        f"with open({str(heard)!r}, 'a') as file:\n"
        "    file.write(json.dumps(sys.argv[1:]) + '\\n')\n"
    )
    program.chmod(0o755)
    return program, lambda: [json.loads(line) for line in heard.read_text().splitlines()]


def test_the_template_is_valid():
    done = openjd("check", TEMPLATE)
    assert done.returncode == 0, done.stdout + done.stderr


def test_a_job_deals_out_the_parts_and_ends_with_the_summary(listening, tmp_path):
    program, heard = listening
    (tmp_path / "my meshes").mkdir()
    options = "--also 'png' --opening 2"
    done = openjd(
        *("run", TEMPLATE, "--step", "Summary", "--run-dependencies"),
        *("-p", f"Meshes={tmp_path / 'my meshes'}", "-p", f"Results={tmp_path / 'out'}"),
        *("-p", "Parts=2", "-p", f"Blender={program}", "-p", f"Options={options}"),
    )
    assert done.returncode == 0, done.stdout + done.stderr
    first, second, last = heard()
    assert "1/2" in first and "2/2" in second
    assert f"--options={options}" in first
    assert first[-1] == str(tmp_path / "my meshes")
    assert last == ["-b", "--command", "umbilics", "--out", str(tmp_path / "out"), "--summary"]


def test_a_job_runs_here_with_the_real_command(tmp_path):
    if "UMBILICS_ZIP" not in os.environ:
        pytest.skip("the extension is not installed: tools/test does that")
    surface = surfaces.ellipsoid((3.0, 2.0, 1.0), 2)
    write_obj(tmp_path / "in" / "a.obj", surface.vertices, surface.triangles)
    done = openjd(
        *("run", TEMPLATE, "--step", "Summary", "--run-dependencies"),
        *("-p", f"Meshes={tmp_path / 'in'}", "-p", f"Results={tmp_path / 'out'}"),
        *("-p", "Parts=1", "-p", f"Blender={ROOT / 'tools' / 'blender'}"),
        *("-p", "Options=--opening 1 --also 'ply'"),
    )
    assert done.returncode == 0, done.stdout + done.stderr
    made = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"a.obj.json", "a.obj.ply", "report.csv"} <= made
    report = json.loads((tmp_path / "out" / "a.obj.json").read_text())
    assert report["settings"]["opening"] == 1


@pytest.fixture
def command_list(capsys):
    spec = importlib.util.spec_from_file_location("command_list", FARMS / "command_list.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)

    def lines(*arguments):
        assert module.main([str(argument) for argument in arguments]) == 0
        return capsys.readouterr().out.splitlines()

    return lines


def test_a_command_list_is_what_a_shell_takes(command_list, listening, tmp_path):
    program, heard = listening
    lines = command_list(
        "my meshes", "out dir", "--parts", 3, "--blender", program, "--", "--also", "png"
    )
    assert len(lines) == 4
    for line in lines:
        # As OpenCue's cuecmd and GNU parallel run them.
        assert subprocess.run(line, shell=True, check=False).returncode == 0
    start = ["-b", "--command", "umbilics"]
    assert heard()[1] == [
        *(*start, "--also", "png", "--out", "out dir", "--resume", "--tolerant"),
        *("--part", "2/3", "--", "my meshes"),
    ]
    assert heard()[3] == [*start, "--out", "out dir", "--summary"]


def test_the_summary_can_be_apart(command_list):
    assert len(command_list("m", "o", "--parts", 2, "--without-summary")) == 2
    (line,) = command_list("o", "--only-summary")
    assert shlex.split(line)[-3:] == ["--out", "o", "--summary"]


def test_the_container_has_what_blender_needs_and_only_what_is_built_for_it():
    recipe = (FARMS / "Containerfile").read_text()
    root = (ROOT / "tools" / "debian_root.sh").read_text()
    needed = re.search(r"debian_packages=\((.*?)\)", root, re.DOTALL)[1].split()
    window = {"xvfb", "xauth", "imagemagick", "xdotool"}
    assert [name for name in needed if name not in window and name not in recipe] == []
    (folder,) = re.findall(r"^COPY (\S+)/umbilics-\*\.zip", recipe, re.MULTILINE)
    assert f"--output {folder}" in recipe
    assert f"--output {folder}" in (ROOT / "docs" / "batch.md").read_text("utf-8")


def test_the_table_of_farms_names_files_that_are_there():
    text = (ROOT / "docs" / "batch.md").read_text("utf-8")
    for name in re.findall(r"\]\(\.\./(tools/[^)]+)\)", text):
        assert (ROOT / name).is_file(), name
