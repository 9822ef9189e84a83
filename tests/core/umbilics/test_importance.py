"""Of the umbilics that are kept, so many as are wanted: the most important ones."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from surfaces import ellipsoid, noisy, quartic, seed_patch

import core
from core.umbilics.pairing.persistence import importance


@pytest.fixture(scope="module")
def detection():
    mesh = noisy(ellipsoid(subdivisions=4), 0.1)
    return core.detect(mesh.vertices, mesh.triangles, core.Settings(scale=2.0, regions=False))


def test_importance_is_persistence_in_errors(detection):
    found = detection.candidates
    paired = np.flatnonzero(found.partner >= 0)
    lesser = np.fmin(found.noise, found.noise[found.partner])[paired]
    assert np.allclose(found.importance[paired], found.persistence[paired] / lesser)
    assert np.array_equal(found.importance[paired], found.importance[found.partner[paired]])
    forced = np.isinf(found.persistence)
    assert forced.any()
    assert np.allclose(
        found.importance[forced], detection.curvature.gap.max() / found.noise[forced]
    )
    # Twice the noise, half the importance; where none is known the median gap stands for it.
    values = importance(np.array([1.0, 1.0]), np.array([1, 0]), np.array([0.5, 0.25]), np.ones(3))
    assert values.tolist() == [4.0, 4.0]
    gap = np.array([1.0, 2.0, 6.0])
    values = importance(np.array([np.inf]), np.array([-1]), np.array([np.nan]), gap)
    assert values.tolist() == [3.0]
    unknown = np.full(3, np.nan)
    assert importance(np.array([np.inf]), np.array([-1]), np.ones(1), unknown).tolist() == [0.0]


@given(st.integers(1, 60))
@settings(max_examples=30, deadline=None)
def test_at_most_so_many_and_always_whole_pairs(detection, most):
    everything = core.Settings(persistence=0.0)
    wanted = core.Settings(persistence=0.0, at_most=most)
    chosen, rows = core.select(detection, wanted), core.kept_rows(detection, everything)
    found = detection.candidates
    assert len(chosen.rows) <= most
    assert len(chosen.rows) >= min(most, len(rows)) - 1
    out = np.setdiff1d(rows, chosen.rows)
    assert not len(out) or found.importance[chosen.rows].min() >= found.importance[out].max()
    if most >= 4:
        # What topology keeps comes first here, and pairs go together.
        assert chosen.index_sum == 2.0


def test_none_is_left_out_where_there_are_fewer(detection):
    rows = core.kept_rows(detection, core.Settings())
    assert np.array_equal(rows, core.kept_rows(detection, core.Settings(at_most=len(rows))))
    assert len(core.kept_rows(detection, core.Settings(at_most=2))) == 2


def test_pins_and_deletions_come_first(detection):
    least = int(np.argmin(detection.candidates.importance))
    best = int(np.argmax(detection.candidates.importance))
    chosen = core.Settings(persistence=0.0, at_most=4)
    rows = core.kept_rows(detection, chosen, pinned=[least], deleted=[best])
    # Three that topology keeps are left, and of the next pair there is no room for both.
    assert least in rows and best not in rows and len(rows) == 4


def test_the_setting_of_a_detection_is_the_filter_of_its_umbilics():
    mesh = quartic(4)
    found = core.detect(mesh.vertices, mesh.triangles, core.Settings(at_most=5))
    assert 0 < len(found.umbilics) <= 5 < len(found.candidates)


@pytest.mark.once
@pytest.mark.parametrize("method", ["I", "C"])
def test_methods_that_pair_nothing_have_an_importance_too(method):
    mesh = seed_patch(900)
    found = core.detect(mesh.vertices, mesh.triangles, core.Settings(method=method))
    assert (found.candidates.importance > 0.0).all()
    if len(found.candidates):
        few = core.detect(mesh.vertices, mesh.triangles, core.Settings(method=method, at_most=1))
        assert len(few.umbilics) == 1


@pytest.mark.once
def test_the_weak_pair_of_a_smooth_surface_is_less_important():
    mesh = seed_patch(5400)
    found = core.detect(mesh.vertices, mesh.triangles).umbilics
    star = found.importance[found.index < 0]
    assert len(found) == 3 and star.max() == found.importance.max()
