"""Which candidates the filters keep, and what they say, on candidates made by hand."""

from dataclasses import replace

import numpy as np
import pytest
from surfaces import ellipsoid

import core
from core.umbilics.filters import AT_BORDER, SMOOTH_MORE

# A pair that noise makes, a pair that is there, one that nothing cancels, one whose persistence
# is unknown.
PERSISTENCE = np.array([1.0, 1.0, 4.0, 4.0, np.inf, np.nan])
INDEX = np.array([0.5, -0.5, 0.5, -0.5, 0.5, 0.5])


@pytest.fixture(scope="module")
def found():
    mesh = ellipsoid(subdivisions=2)
    return core.detect(mesh.vertices, mesh.triangles)


@pytest.fixture
def detection(found):
    count = len(INDEX)
    candidates = replace(
        found.candidates.select(np.zeros(count, int)),
        persistence=PERSISTENCE,
        index=INDEX,
        resolved=np.array([False, False, True, True, True, True]),
        at_border=np.zeros(count, bool),
        elliptic=np.ones(count, bool),
    )
    return replace(found, candidates=candidates, warnings=(), trust_ratio=0.0)


def changed(detection, **arrays):
    return replace(detection, candidates=replace(detection.candidates, **arrays))


def rows_of(detection, settings=None, **by_hand):
    """The rows kept, which all three front doors agree on."""
    settings = settings or core.Settings()
    rows = core.kept_rows(detection, settings, **by_hand)
    np.testing.assert_array_equal(core.select(detection, settings, **by_hand).rows, rows)
    filtered = core.filtered(detection, settings, **by_hand)
    np.testing.assert_array_equal(filtered.umbilics.persistence, PERSISTENCE[rows])
    return rows.tolist()


def test_automatic_drops_the_pairs_that_are_not_resolved_and_nothing_else(detection):
    assert rows_of(detection) == [2, 3, 4, 5]
    # Whatever nothing cancels stays, resolved or not.
    assert rows_of(changed(detection, resolved=np.zeros(6, bool))) == [4, 5]


@pytest.mark.parametrize(
    "level, rows",
    [(0.0, [0, 1, 2, 3, 4, 5]), (1.0, [0, 1, 2, 3, 4, 5]), (1.1, [2, 3, 4, 5]), (9.0, [4, 5])],
)
def test_a_level_keeps_what_reaches_it_and_what_has_none(detection, level, rows):
    settings = core.Settings(persistence=level)
    assert rows_of(detection, settings) == rows
    chosen = core.select(detection, settings)
    assert chosen.persistence_level == level
    assert chosen.index_sum == INDEX[rows].sum()


def test_the_automatic_level_is_just_above_what_is_dropped(detection):
    level = core.select(detection, core.Settings()).persistence_level
    assert level == np.nextafter(1.0, 2.0)
    assert rows_of(detection, core.Settings(persistence=level)) == rows_of(detection)
    nothing = changed(detection, resolved=np.ones(6, bool))
    assert core.select(nothing, core.Settings()).persistence_level == 0.0
    without = changed(detection, persistence=np.full(6, np.nan))
    assert core.select(without, core.Settings(persistence=2.0)).persistence_level == 0.0


@pytest.mark.parametrize(
    ("most", "deleted", "rows"),
    [
        (6, (), [0, 1, 2, 3, 4, 5]),
        (3, (), [0, 1, 4]),
        # Of the two that cancel together only one would be left: none is.
        (2, (), [4]),
        # What is deleted makes room for others.
        (2, (0,), [1, 4]),
        (2, (4,), [0, 1]),
        (1, (4, -1, 6), [0]),
    ],
)
def test_at_most_so_many_are_kept_the_most_important(detection, most, deleted, rows):
    weighed = changed(detection, importance=np.array([5.0, 5.0, 4.0, 4.0, 9.0, 1.0]))
    assert rows_of(weighed, core.Settings(persistence=0.0, at_most=most), deleted=deleted) == rows


def test_borders_and_the_opening_leave_out(detection):
    at_border = np.arange(6) == 3
    elliptic = np.arange(6) != 4
    detection = changed(detection, at_border=at_border, elliptic=elliptic)
    assert rows_of(detection) == [2, 4, 5]
    assert rows_of(detection, core.Settings(opening=2)) == [2, 5]


def test_what_is_pinned_stays_and_what_is_deleted_goes_whatever_the_filters_say(detection):
    detection = changed(detection, at_border=np.arange(6) == 3)
    assert rows_of(detection, pinned=[0, 3, 6, -1], deleted=[4, 7, -2]) == [0, 2, 3, 5]
    # Deleted and pinned is deleted.
    assert rows_of(detection, pinned=[2], deleted=[2]) == [4, 5]


def test_rows_that_do_not_exist_are_no_rows_from_the_end(detection):
    assert rows_of(detection, deleted=[-1, 6]) == [2, 3, 4, 5]
    left_out = changed(detection, at_border=np.arange(6) == 5)
    assert rows_of(left_out, pinned=[-1, 6]) == [2, 3, 4]
    for deleted, count in (([-1, 6], 1), ([5], 0)):
        warnings = core.select(left_out, core.Settings(), deleted=deleted).warnings
        assert len(warnings) == count


def test_regions_count_for_the_sum(detection):
    region = core.Region(np.arange(3), 1.0, 1.5, "spherical", 1.0)
    chosen = core.select(replace(detection, regions=(region, region)), core.Settings())
    assert chosen.index_sum == INDEX[2:].sum() + 3.0


def test_more_smoothing_is_advised_where_noise_that_was_dropped_is_as_large_as_the_shape(detection):
    def advised(trust_ratio, settings):
        noisy = replace(detection, trust_ratio=trust_ratio, warnings=("before", SMOOTH_MORE))
        warnings = core.select(noisy, settings).warnings
        assert warnings[0] == "before" and warnings.count(SMOOTH_MORE) <= 1
        return SMOOTH_MORE in warnings

    assert advised(0.71, core.Settings())
    assert not advised(0.7, core.Settings())
    assert not advised(0.1, core.Settings())
    # Nothing was dropped.
    assert not advised(0.9, core.Settings(persistence=0.0))


def test_candidates_left_out_at_a_border_are_counted_in_words(detection):
    def said(detection, **by_hand):
        settings = by_hand.pop("settings", core.Settings())
        warnings = core.select(detection, settings, **by_hand).warnings
        return [text.removesuffix(AT_BORDER).strip() for text in warnings if AT_BORDER in text]

    assert said(detection) == []
    # The first is dropped as noise, and would be so anywhere.
    detection = changed(
        replace(detection, warnings=(f"9 candidates {AT_BORDER}",)),
        at_border=np.isin(np.arange(6), (0, 2, 4)),
        elliptic=np.arange(6) != 4,
    )
    assert said(detection) == ["2 candidates"]
    assert said(detection, settings=core.Settings(opening=2)) == ["1 candidate"]
    assert said(detection, pinned=[4]) == ["1 candidate"]
    assert said(detection, deleted=[2, 6, -1]) == ["1 candidate"]
    assert said(detection, pinned=[2], deleted=[4]) == []
