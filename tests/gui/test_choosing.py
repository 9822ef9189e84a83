"""Glyphs by mouse, and a plan in view, in a real window: see choosing.py for what is done."""

import pytest


@pytest.fixture(scope="module")
def found(play):
    return play("choosing")


def test_a_click_on_a_glyph_chooses_its_umbilic_without_an_empty(found):
    assert len(found["picked"]) == 2
    for row, active_row, active in found["picked"]:
        assert (active_row, active >= 0) == (row, True)
    assert all(found["kept_active"]) and found["beside"]


def test_a_click_on_a_pole_chooses_it_in_the_table(found):
    name, chosen, selected = found["pole"]
    assert (chosen, selected) == (name, True)


def test_after_planning_the_strokes_are_the_cross_field(found):
    assert found["field"] == "CROSS"
    assert found["types"] == ["PLAIN_AXES"]


def test_guides_are_not_rendered(found):
    assert found["lines_render"] == [True, True]


def test_dashed_lines_are_off_while_there_are_results(found):
    dashed = found["dashed_before"], found["dashed_with_results"], found["dashed_after"]
    assert dashed == (True, False, True)
