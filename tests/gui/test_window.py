"""A real window, driven by mouse and keys: see first_hour.py for what is done in it."""

import pytest


@pytest.fixture(scope="module")
def found(play):
    return play("first_hour")


def test_the_button_detects_and_the_glyphs_are_drawn(found):
    assert found["detect_button_starts_a_run"]
    assert found["detected"]
    assert found["glyph_pixels"] > 100


def test_escape_at_any_moment_leaves_everything_as_it_was(found):
    assert len(found["escapes"]) == 4
    for moment, stage, cancelled, same in found["escapes"]:
        assert cancelled, (moment, stage)
        assert same, (moment, stage)


def test_dragging_the_slider_thins_the_umbilics_out(found):
    assert found["strength_after"] > found["strength_before"]
    assert found["shown_after"] < found["shown_before"]


def test_undo_and_redo(found):
    assert found["shown_after_undo"] == found["shown_before"]
    assert not found["detected_after_two_undos"]
    assert found["shown_after_redo"] == found["shown_after"]


def test_click_in_the_list_selects_and_double_click_frames(found):
    assert found["list_click_selects"]
    assert found["double_click_frames"]


def test_the_map_is_shown_and_the_view_is_put_back(found):
    assert found["map_by_button"]
    assert found["shading_with_map"] == "VERTEX"
    assert found["shading_after"] == found["shading_before"]


def test_saved_and_opened_again_it_can_still_be_filtered(found):
    assert found["reloaded_shown"] == found["saved_shown"]
    assert found["reloaded_all"] > found["reloaded_shown"]
    assert found["reloaded_pixels"] > 100


def test_the_glyphs_are_drawn_in_a_smooth_view_too(found):
    assert found["smooth_pixels"] > 100


def test_switched_off_nothing_is_left_and_on_again_all_is_back(found):
    assert found["disabled_pixels"] == 0
    assert found["residue"] == []
    assert found["enabled_pixels"] == found["reloaded_pixels"]
