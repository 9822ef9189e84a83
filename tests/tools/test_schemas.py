"""What the command writes for programs holds to the schemas that docs/ promises."""

import json
import os
import re
import subprocess
from pathlib import Path

import jsonschema
import pytest
import surfaces
from mesh_files import write_obj

ROOT = Path(__file__).resolve().parents[2]


def schema(name):
    found = json.loads((ROOT / "docs" / "schemas" / f"{name}.schema.json").read_text())
    jsonschema.Draft202012Validator.check_schema(found)
    return jsonschema.Draft202012Validator(found)


@pytest.fixture(scope="module")
def egg(tmp_path_factory):
    """An ellipsoid as OBJ."""
    surface = surfaces.ellipsoid((3.0, 2.0, 1.0), 3)
    path = tmp_path_factory.mktemp("mesh") / "egg.obj"
    write_obj(path, surface.vertices, surface.triangles)
    return path


def run(*arguments):
    if "UMBILICS_ZIP" not in os.environ:
        pytest.skip("the extension is not installed: tools/test does that")
    command = [ROOT / "tools" / "blender", "-b", "--command", "umbilics", *map(str, arguments)]
    return subprocess.run(
        command, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False
    )


def events_in(text):
    return [json.loads(line) for line in text.splitlines() if line.startswith("{")]


def test_a_report_with_all_that_can_be_in_it_is_valid(egg, tmp_path):
    target = tmp_path / "o.json"
    quads = ("--quads", "150", "--guide", tmp_path / "g", "--guide-files", "quads")
    quads += ("--check-topology", egg)
    done = run(egg, "--json", target, "--per-vertex", "--compare", *quads, "--progress", "jsonl")
    assert done.returncode == 0, done.stderr
    report = json.loads(target.read_text())
    schema("report").validate(report)
    assert {"curvature", "comparison", "quads", "topology"} <= report["objects"][0].keys()
    events = events_in(done.stdout)
    for event in events:
        schema("event").validate(event)
    names = [event["event"] for event in events]
    assert (names[0], names[1], names[-2:]) == ("command", "start", ["file", "end"])
    assert "progress" in names and "object" in names
    shares = [event["share"] for event in events if event["event"] == "progress"]
    assert shares == sorted(shares)


def test_the_report_and_the_events_of_a_batch_are_valid(egg, tmp_path):
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "egg.obj").write_bytes(egg.read_bytes())
    (tmp_path / "in" / "bad.stl").write_text("")
    done = run(tmp_path / "in", "--out", tmp_path / "o", "--progress", "jsonl", "--frames", "1-2")
    assert done.returncode == 1, done.stderr
    events = events_in(done.stdout)
    for event in events:
        schema("event").validate(event)
    assert [event["event"] for event in events] == ["command", "batch", "file", "file", "end"]
    assert events[-1] == {"event": "end", "exit_code": 1}
    report = json.loads((tmp_path / "o" / "egg.obj.json").read_text())
    schema("report").validate(report)
    assert [entry["frame"] for entry in report["objects"]] == [1, 2]


def test_a_single_file_is_given_up_at_the_limits(egg, tmp_path):
    target = tmp_path / "o.json"
    done = run(egg, "--json", target, "--time-limit", "0.05", "--progress", "jsonl")
    assert done.returncode == 1
    assert f"umbilics: {egg}: given up after 0.05 s (--time-limit)." in done.stderr
    for event in events_in(done.stdout):
        schema("event").validate(event)
    # Too little even for Blender to start in.
    done = run(egg, "--json", target, "--memory-limit", "40")
    assert done.returncode == 1
    assert f"umbilics: {egg}: " in done.stderr
    assert "--memory-limit" in done.stderr
    assert list(tmp_path.iterdir()) == []
    done = run(egg, "--json", target, "--time-limit", "600", "--memory-limit", "8000")
    assert done.returncode == 0, done.stderr
    assert "egg: 4 lemons" in done.stdout
    schema("report").validate(json.loads(target.read_text()))


def test_every_name_in_the_schema_is_in_the_manual():
    text = (ROOT / "docs" / "json.md").read_text("utf-8")
    found = json.loads((ROOT / "docs" / "schemas" / "report.schema.json").read_text())

    def names(part):
        if isinstance(part, dict):
            yield from part.get("properties", {})
            for inner in part.values():
                yield from names(inner)
        elif isinstance(part, list):
            for inner in part:
                yield from names(inner)

    kinds = {"star", "lemon", "monstar", "compound", "uncertain"}
    missing = [name for name in sorted(set(names(found)) - kinds) if f"`{name}`" not in text]
    assert missing == []


def test_the_exit_codes_are_those_of_the_manual():
    folder = ROOT / "operators" / "command_line"
    source = (folder / "exit_codes.py").read_text()
    codes = {int(code) for code in re.findall(r"= (\d+)$", source, re.MULTILINE)}
    text = (ROOT / "docs" / "batch.md").read_text("utf-8")
    table = text.split("## Exit codes")[1].split("## ")[0]
    assert {int(code) for code in re.findall(r"^\| (\d+) \|", table, re.MULTILINE)} == codes
    (end,) = (one for one in schema("event").schema["oneOf"] if "exit_code" in one["properties"])
    assert set(end["properties"]["exit_code"]["enum"]) == codes
