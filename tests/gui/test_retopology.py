"""A plan and what is made of it in a real window: see retopology.py for what is done in it."""

import pytest


@pytest.fixture(scope="module")
def found(play):
    return play("retopology")


def test_the_cross_field_is_drawn_over_the_view(found):
    # Without a detection there are no strokes of principal directions; crosses cover some pixels.
    assert found["poles"] > 0
    assert found["field_of_the_plan"] == "CROSS"
    assert found["alike_principal"] > 0.98
    assert found["alike_crosses"] < found["alike_principal"] - 0.01


def test_guides_are_drawn_beside_the_window(found):
    assert found["guides"] in (["GREASEPENCIL"], ["GPENCIL"])


def test_the_window_lives_while_files_are_written(found):
    assert found["export_runs_beside"]
    endings = ("obj", "rawfield", "rosy", "sharp", "sing")
    assert found["files"] == [f"thing.{ending}" for ending in endings]
    assert found["ticks_while_exporting"] > 0


def test_a_plan_and_quads_are_adjusted_by_a_key_and_undone_by_another(found):
    made, adjusted, undone = found["guide"]
    assert made["poles"] == adjusted["poles"] == 8
    # What the panel shows then is what the plan was made with.
    assert adjusted["stale"] == []
    assert undone["poles"] == 0
    made, adjusted, undone = found["remesh_to_quads"]
    assert 1900 < made["faces"]["Icosphere Quads"] < 2100
    assert 280 < adjusted["faces"]["Icosphere Quads"] < 320
    assert made["faces"].keys() == adjusted["faces"].keys()
    assert "Icosphere Quads" not in undone["faces"]
    assert undone["poles"] == 8
