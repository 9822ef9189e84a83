"""A plan and what is made of it in a real window: see retopology.py for what is done in it."""

import json
import os
import subprocess
from pathlib import Path

import pytest

SCENARIO = Path(__file__).with_name("retopology.py")


@pytest.fixture(scope="session")
def found(tmp_path_factory):
    window = os.environ.get("UMBILICS_WINDOW")
    if not window:
        pytest.skip("needs a window: run it with tools/test --gui")
    chosen = os.environ.get("UMBILICS_PICTURES")
    folder = Path(chosen) if chosen else tmp_path_factory.mktemp("window")
    report = folder / "retopology.json"
    done = subprocess.run(
        [window, "--python", SCENARIO, "--", report],
        capture_output=True,
        text=True,
        timeout=400,
        check=False,
    )
    assert report.exists(), done.stdout + done.stderr
    return json.loads(report.read_text())


def test_the_cross_field_is_drawn_over_the_view(found):
    # Without a detection there are no strokes of principal directions; crosses cover some pixels.
    assert found["poles"] > 0
    assert found["alike_principal"] > 0.98
    assert found["alike_crosses"] < found["alike_principal"] - 0.01


def test_guides_are_drawn_beside_the_window(found):
    assert found["guides"] in (["GREASEPENCIL"], ["GPENCIL"])


def test_the_window_lives_while_files_are_written(found):
    assert found["export_runs_beside"]
    endings = ("obj", "rawfield", "rosy", "sharp", "sing")
    assert found["files"] == [f"thing.{ending}" for ending in endings]
    assert found["export_longest_pause"] < 0.2 * found["export_seconds"]
