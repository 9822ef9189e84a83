"""The overlay in every sort of 3D view, the search and the manual: see views.py."""

from pathlib import Path
from urllib.parse import unquote, urlparse

import pytest


@pytest.fixture(scope="module")
def found(play):
    return play("views")


def seen(found, name, at_least=1):
    """Counts of all regions, with umbilics in front in each and some behind in any."""
    assert all(region["front"] >= at_least for region in found[name])
    assert sum(region["behind"] for region in found[name]) > 0
    return found[name]


def assert_hidden_by_the_surface(found, name, at_least=1):
    for region in seen(found, name, at_least):
        assert region["front_seen"] == region["front"], name
        assert region["behind_seen"] == 0, name


def test_glyphs_are_where_the_umbilics_are_and_hidden_by_the_surface(found):
    assert_hidden_by_the_surface(found, "solid")


def test_x_ray_shows_those_behind_until_it_is_switched_off(found):
    assert found["xray_on"]
    for region in seen(found, "xray"):
        assert region["behind_seen"] == region["behind"]
        assert region["front_seen"] == region["front"]
    assert_hidden_by_the_surface(found, "xray_off")


def test_local_view_shows_the_glyphs_of_its_objects_alone(found):
    assert_hidden_by_the_surface(found, "both", at_least=2)
    assert found["local"]
    assert_hidden_by_the_surface(found, "local_first")
    (second,) = seen(found, "local_second")
    assert second["front_seen"] == second["behind_seen"] == 0
    assert_hidden_by_the_surface(found, "global", at_least=2)


def test_each_quarter_of_a_quad_view_is_drawn_for_its_own_side(found):
    assert len(found["quad"]) == 4
    assert_hidden_by_the_surface(found, "quad")
    for region in seen(found, "quad_xray"):
        assert region["front_seen"] == region["front"]
        assert region["behind_seen"] == region["behind"]
    assert found["regions_after_quad"] == 1


def test_two_windows_are_drawn_each_from_its_side_and_follow_the_same_switches(found):
    for name in ("window_first", "window_second", "window_closed"):
        (region,) = found[name]
        assert region["front_seen"] == region["front"] > 0
        assert region["behind_seen"] == 0
    for name in ("window_first_off", "window_second_off"):
        (region,) = found[name]
        assert region["front_seen"] == 0


def test_the_search_finds_and_runs_the_detection(found):
    assert found["search_detects"]


def test_the_manual_opens_at_a_chapter_that_there_is(found):
    for what, chapter in (("manual", "first-detection"), ("explained", "statistics")):
        (url,) = set(found[what])
        parts = urlparse(url)
        page = Path(unquote(parts.path))
        assert f'id="{parts.fragment}"' in page.read_text("utf-8")
        assert parts.fragment == chapter
