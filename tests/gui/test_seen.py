"""A model under a modifier, in a real window: see seen.py for what is done."""

import pytest


@pytest.fixture(scope="module")
def found(play):
    return play("seen")


def test_the_first_click_analyses_what_is_seen_and_leaves_the_object_alone(found):
    assert found["analysed"] == "With Subdivision, whole object"
    detected = found["detected"]
    assert detected["umbilics"] > 4
    assert detected["active"]
    assert not detected["hidden"]
    assert detected["mode"] == "OBJECT"


def test_the_verdict_has_a_button_that_does_what_it_says(found):
    assert found["cube"]["remedy"] == "SUBDIVIDE" and not found["cube"]["good"]
    assert found["modifiers"] == ["SUBSURF"]
    # The limit of a cube has an umbilic at each face and corner.
    assert found["mended"] == {"good": True, "remedy": "", "found": "14 umbilics"}


def test_one_undo_takes_back_what_was_mended_and_what_was_found_then(found):
    modifiers, detected, umbilics = found["undone"]
    assert (modifiers, detected, umbilics) == (0, True, 0)


def test_escape_leaves_everything_as_it_was_whatever_was_begun(found):
    assert len(found["stopped"]) == 7
    for begun, (cancelled, left) in found["stopped"].items():
        assert cancelled and left == [], begun


def test_the_map_covers_the_surface_and_lets_clicks_through(found):
    assert found["grey"] < 0.2
    assert found["mapped"] > 0.9
    assert found["clicked"]


def test_edit_mode_gives_the_same_and_stays(found):
    assert found["edited"] == found["detected"] | {"mode": "EDIT"}
