"""--progress jsonl: how much of the work on a mesh is done."""

import json

import bpy
import pytest
from scene_building import add_ellipsoid

WORKS = {"Detecting": [], "Planning": ["--guide", "g"], "Checking": ["--check-topology", "x.obj"]}
WORKS |= {"Matching": ["--find-symmetry"]}


@pytest.fixture
def mesh(tmp_path, monkeypatch):
    add_ellipsoid(subdivisions=3, name="Egg")
    bpy.ops.wm.obj_export(filepath=str(tmp_path / "x.obj"), export_materials=False)
    monkeypatch.chdir(tmp_path)


def told(text):
    events = [json.loads(line) for line in text.splitlines() if line.startswith("{")]
    return [(event["share"], event["part"]) for event in events if event["event"] == "progress"]


@pytest.mark.parametrize("asked", [*([work] for work in WORKS), list(WORKS)], ids="-".join)
def test_shares_never_go_back_and_only_what_is_asked_for_is_named(
    run, part, mesh, monkeypatch, capfd, asked
):
    monkeypatch.setattr(part("messages"), "_PAUSE", 0.0)
    options = [word for work in asked for word in WORKS[work]]
    assert run("x.obj", "--json", "o.json", "--progress", "jsonl", *options) == 0
    shares, parts = zip(*told(capfd.readouterr().out), strict=True)
    assert list(shares) == sorted(shares)
    assert shares[0] == 0.0 and 0.9 < shares[-1] <= 1.0
    # What is checked is held against a plan.
    planned = {"Planning"} if "Checking" in asked else set()
    assert set(parts) & set(WORKS) == {"Detecting", *asked} | planned


def test_a_work_that_says_less_than_before_is_told_as_far_as_it_was(part, capfd, monkeypatch):
    monkeypatch.setattr(part("messages"), "_PAUSE", 0.0)
    watched = part("messages").Watched({"file": None, "object": "Egg"})
    for share in (0.2, 0.7, 0.6, 0.8):
        watched(share, "Evening out")
    assert [share for share, _ in told(capfd.readouterr().out)] == [0.2, 0.7, 0.7, 0.8]
