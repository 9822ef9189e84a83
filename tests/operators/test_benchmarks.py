"""The parts of the benchmarks that run inside Blender still fit the add-on."""

import sys
from importlib import import_module
from pathlib import Path

from scene_building import empties, empty_scene


def test_reading_detecting_and_writing_are_timed(addon, monkeypatch):
    monkeypatch.setattr(sys, "path", [*sys.path, str(Path(__file__).parents[2] / "benchmarks")])
    speed = import_module("speed_in_blender")
    empty_scene()
    obj = speed.ellipsoid_object(4)
    assert all(part > 0.0 for part in speed.seconds(addon.__name__, obj))
    assert len(empties(obj)) == 4
