"""Results as sentences."""

import math

import pytest


@pytest.fixture
def words(addon):
    return addon.operators.base.words


@pytest.mark.parametrize(
    ("counts", "text"),
    [
        ({}, "no umbilics"),
        ({"star": 0, "lemon": 0}, "no umbilics"),
        ({"star": 1, "lemon": 0}, "1 star"),
        ({"star": 2, "lemon": 4}, "4 lemons and 2 stars"),
        ({"star": 2, "lemon": 4, "monstar": 1}, "4 lemons, 2 stars and 1 monstar"),
        ({"star": 2, "uncertain": 3}, "3 of uncertain kind and 2 stars"),
        ({"star": 2, "uncertain": 0}, "2 stars"),
    ],
)
def test_counts_are_listed_the_most_first(words, counts, text):
    assert words.counts_in_words(counts) == text


def test_lost_pins_are_counted(words):
    assert words.pins_lost(1).startswith("One pinned or deleted umbilic has no umbilic")
    assert words.pins_lost(2).startswith("2 pinned or deleted umbilics have none")


GOOD = {
    "matched": 8,
    "missing": 0,
    "extra": 0,
    "faces": 100,
    "quads": 100,
    "angle": math.nan,
    "jacobian": math.nan,
    "folded": 0,
    "edges": 0.25,
    "from_surface": math.nan,
    "covered": 1.0,
}
POLES, NEAR = "8 of 8 planned poles, 0 missing, 0 extra", "Within 0.25 edges of the surface"


@pytest.mark.parametrize(
    ("other", "lines"),
    [
        ({}, [POLES, NEAR]),
        ({"missing": 2, "extra": 1}, ["8 of 10 planned poles, 2 missing, 1 extra", NEAR]),
        ({"quads": 97}, [POLES, "3 of 100 faces are no quads", NEAR]),
        ({"angle": 3.21}, [POLES, "3.2\N{DEGREE SIGN} from the directions of curvature", NEAR]),
        ({"jacobian": 0.5}, [POLES, "Least scaled Jacobian 0.50", NEAR]),
        ({"edges": 0.0}, [POLES, "Within 0.001 edges of the surface"]),
        ({"folded": 1}, [POLES, "1 quad folded or facing against the surface", NEAR]),
        ({"folded": 2}, [POLES, "2 quads folded or facing against the surface", NEAR]),
        ({"from_surface": 0.34}, [POLES, NEAR, "Surface within 0.34 edges of the mesh"]),
        ({"from_surface": 0.0}, [POLES, NEAR, "Surface within 0.001 edges of the mesh"]),
        ({"covered": 0.9996}, [POLES, NEAR]),
        # Never rounded up to all of it.
        ({"covered": 0.99949}, [POLES, NEAR, "Covers 99.9 % of the surface"]),
        ({"covered": 0.5}, [POLES, NEAR, "Covers 50.0 % of the surface"]),
    ],
)
def test_a_topology_is_told_in_lines_of_what_there_is(words, other, lines):
    assert words.TopologyFigures(**GOOD | other).lines() == lines
