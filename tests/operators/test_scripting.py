"""The recipes of docs/scripting.md run as they stand."""

import json
import re
from pathlib import Path

import bpy
import numpy as np
import pytest
from scene_building import empty_scene

PAGE = Path(__file__).resolve().parents[2] / "docs" / "scripting.md"


@pytest.fixture(scope="module")
def recipes():
    return re.findall(r"^```python\n(.*?)^```", PAGE.read_text("utf-8"), re.MULTILINE | re.DOTALL)


@pytest.fixture
def run(recipes, addon):
    """Runs the first so many recipes in one namespace, which it returns."""

    def first(count):
        empty_scene()
        names = {}
        for number, code in enumerate(recipes[:count], start=1):
            exec(compile(code, f"recipe {number}", "exec"), names)
        return names

    return first


def test_there_are_five(recipes):
    assert len(recipes) == 5


def test_detecting_finds_the_four_umbilics(run):
    obj = run(1)["obj"]
    assert (obj.umbilics.lemon, obj.umbilics.star) == (4, 0)
    assert sum("umbilics_kind" in child for child in obj.children) == 4


def test_attributes_are_read(run):
    names = run(2)
    assert names["gap"][names["flattest"]] < 0.1 * np.median(names["gap"])
    assert np.allclose(np.linalg.norm(names["d1"], axis=1), 1.0, atol=1e-5)


def test_arrows_are_added(run):
    group = run(3)["group"]
    inputs = {item.name for item in group.interface.items_tree if item.in_out == "INPUT"}
    assert {"Length", "Every", "k1", "k2"} <= inputs


def test_the_core_gives_arrays_and_leaves_the_scene_alone(run):
    detection = run(4)["detection"]
    assert list(detection.umbilics.kind) == ["lemon"] * 4
    assert detection.index_sum == detection.expected_index_sum == 2.0


@pytest.mark.skipif(not bpy.app.binary_path, reason="Blender as a module is no program")
def test_the_command_ends_well(run):
    names = run(5)
    assert names["done"].returncode == 0, names["done"].stderr
    (entry,) = json.loads((names["folder"] / "ellipsoid.json").read_text())["objects"]
    assert entry["counts"]["lemon"] == 4
