"""Which candidates are real: what borders, errors of places and close pairs do to the verdict."""

from types import SimpleNamespace

import numpy as np
import pytest
from exact_fields import flat_surface

from core.umbilics.compounds import merged, settled
from core.umbilics.judged import Evidence, judge
from core.umbilics.located import Located
from core.umbilics.pairing.persistence import measure_persistence

RADIUS, NOISE = 0.3, 0.01
# Fits are 1 and more: chances of one in 10^8 are clear of this.
CLEAR = 100.0


@pytest.fixture(scope="module")
def square():
    """A flat square of 31 cells, and the triangle nearest to places x, y of it."""
    surface, _ = flat_surface(cells=31)
    middle = surface.vertices[surface.triangles].mean(axis=1)[:, :2]
    return surface, lambda *place: int(np.linalg.norm(middle - place, axis=1).argmin())


def rings_in(surface, rings):
    """A place so many rings from the middle of the left border."""
    return surface.vertices[:, 0].min() + (rings + 0.4) * 2.0 / 31.0, 0.05


def located(triangles, **given):
    k = len(triangles)
    usual = {
        "singular": np.array(triangles),
        "triangle": np.array(triangles),
        "barycentric": np.full((k, 3), 1.0 / 3.0),
        "vertex": np.full(k, -1),
        "index": np.full(k, 0.5),
        "elliptic": np.ones(k, bool),
        "normal": np.tile([0.0, 0.0, 1.0], (k, 1)),
        "x": np.tile([1.0, 0.0, 0.0], (k, 1)),
        "y": np.tile([0.0, 1.0, 0.0], (k, 1)),
        "p": np.ones(k, complex),
        "q": np.zeros(k, complex),
        "curvature": np.zeros(k),
        "noise": np.full(k, NOISE),
        "uncertainty": np.full(k, 0.001 * RADIUS),
        "slope_error": np.zeros(k),
        "clarity": np.full(k, CLEAR),
        "asked": np.ones(k, bool),
        "seen": np.ones(k, bool),
    }
    return Located(**usual | {name: np.asarray(value) for name, value in given.items()})


def judged(surface, found, partner=None, persistence=None, **evidence):
    k, n = len(found), len(surface.vertices)
    partner = np.full(k, -1) if partner is None else np.asarray(partner)
    persistence = np.full(k, np.inf) if persistence is None else np.asarray(persistence, float)
    usual = {
        "gap": np.ones(n),
        "noise": np.full(n, NOISE),
        "radius": np.full(n, RADIUS),
        "determined": np.ones(n, bool),
        "regions": [],
        "jets": False,
        "certified": False,
        "exact": False,
    }
    return judge(surface, found, Evidence(**usual | evidence), persistence, partner)


@pytest.mark.parametrize(
    "rings, radii, seen, clarity, exact, at_border",
    [
        # Within one ring whatever it is.
        (0, 0.001, True, CLEAR, False, True),
        (1, 0.001, True, CLEAR, True, True),
        (2, 0.001, True, CLEAR, False, False),
        (3, 0.001, True, CLEAR, False, False),
        # As far in as fits reach, those that stand a tenth of the fits' radius from where they may.
        (3, 0.05, True, CLEAR, False, False),
        (3, 0.2, True, CLEAR, False, True),
        (5, 0.2, True, CLEAR, False, True),
        (3, 0.001, False, CLEAR, False, True),
        (3, 0.2, True, CLEAR, True, False),
        (8, 0.2, True, CLEAR, False, False),
        # Twice as far in those that are not clear of the error besides.
        (10, 0.2, True, 1.0, False, True),
        (8, 0.05, True, 1.0, False, False),
        (8, 0.2, True, 3.0, False, False),
        (13, 0.2, True, 1.0, False, False),
    ],
)
def test_what_a_border_may_have_made(square, rings, radii, seen, clarity, exact, at_border):
    surface, nearest = square
    found = located(
        [nearest(*rings_in(surface, rings))],
        uncertainty=[radii * RADIUS],
        seen=[seen],
        clarity=[clarity],
    )
    assert judged(surface, found, exact=exact).at_border.tolist() == [at_border]


@pytest.mark.parametrize(
    "rings, exact, follows",
    [(3, False, True), (5, False, False), (2, True, True), (3, True, False)],
)
def test_what_cancels_with_one_of_a_border_goes_with_it(square, rings, exact, follows):
    surface, nearest = square
    x, y = rings_in(surface, 0)
    other = nearest(rings_in(surface, rings)[0], y + 0.3)
    found = located([nearest(x, y), other], index=[0.5, -0.5])
    verdict = judged(surface, found, partner=[1, 0], persistence=[1.0, 1.0], exact=exact)
    assert verdict.at_border.tolist() == [True, follows]
    assert not judged(surface, found, exact=exact).at_border[1]
    turned = located(found.triangle[::-1], index=[-0.5, 0.5])
    assert judged(surface, turned, exact=exact).at_border.tolist() == [False, True]


def test_beyond_doubt_is_what_nothing_speaks_against(square):
    surface, nearest = square
    middle = nearest(0.0, 0.0)
    assert judged(surface, located([middle])).certain.all()
    against = {
        "not shown": {"seen": [False]},
        "not clear": {"clarity": [3.0]},
        "near a border": {"triangle": [nearest(*rings_in(surface, 3))]},
    }
    for reason, change in against.items():
        assert not judged(surface, located([middle], **change)).certain.any(), reason
    undetermined = np.ones(len(surface.vertices), bool)
    undetermined[surface.triangles[middle, 1]] = False
    assert not judged(surface, located([middle]), determined=undetermined).certain.any()
    # Of operators that are given a fit says nothing, and no border cuts one off.
    unknown = located([nearest(*rings_in(surface, 3))], clarity=[np.nan])
    assert judged(surface, unknown, exact=True).certain.all()


@pytest.mark.parametrize("name, chance", [("present", 1e-2), ("certain", 1e-8)])
def test_noise_alone_makes_one_on_the_whole_surface_by_a_known_chance(square, name, chance):
    """Deviators of noise are longer than t errors by exp(-t^2), at each fit that shares no sample
    with another: samples a root mean square distance away fill a disc of sqrt(2) of that."""
    surface, nearest = square
    fits = surface.face_normal_area[1].sum() / (2.0 * np.pi * RADIUS**2)
    clear = np.sqrt(np.log(fits / chance))
    for factor, stands in ((0.998, False), (1.002, True)):
        found = located([nearest(0.0, 0.0)], clarity=[factor * clear])
        assert getattr(judged(surface, found), name).tolist() == [stands]
    # A fit over the whole surface is one.
    clear = np.sqrt(np.log(1.0 / chance))
    found = located([nearest(0.0, 0.0)], clarity=[1.002 * clear])
    whole = np.full(len(surface.vertices), 2.0)
    assert getattr(judged(surface, found, radius=whole), name).all()


def test_of_two_that_could_cancel_a_third_the_one_that_is_shown_stays(square):
    surface, nearest = square
    place = [(-0.3, 0.0), (0.0, 0.0), (0.3, 0.0)]
    rows, index = [nearest(*one) for one in place], [0.5, -0.5, 0.5]
    away = [np.linalg.norm(surface.vertices[:, :2] - one, axis=1) for one in place]
    # Both pairs meet at one gap.
    gap = np.minimum(np.minimum.reduce(away), 0.1)
    seen = np.array([True, True, False])
    measured = measure_persistence(surface, gap, np.array(rows), np.array(index), [], seen)
    assert measured[1].tolist() == [-1, 2, 1]
    for jets, certified, again in ((True, True, True), (False, True, False), (True, False, False)):
        found = located(rows, index=index, seen=seen)
        verdict = judged(
            surface, found, [1, 0, -1], [0.1, 0.1, np.inf], gap=gap, jets=jets, certified=certified
        )
        assert (verdict.partner.tolist() == [-1, 2, 1]) == again
        assert np.array_equal(verdict.persistence, measured[0]) == again
    # Those that no finer fit was made for do not ask for it.
    found = located(rows, index=index, seen=seen, asked=seen)
    verdict = judged(
        surface, found, [1, 0, -1], [0.1, 0.1, np.inf], gap=gap, jets=True, certified=True
    )
    assert verdict.partner.tolist() == [1, 0, -1]


@pytest.mark.parametrize(
    "apart, persistence, clarity, seen, resolved",
    [
        # In radii, in errors of the gap, in errors of the circle around each.
        (1.0, 1000.0, 1.0, True, True),
        (1.0, 0.1, 1.0, True, False),
        # Places that their errors could bring together, though the gap between seems sure.
        (0.2, 1000.0, 1.0, True, False),
        # What finer fits show at both is there, however little parts them.
        (1.0, 0.1, CLEAR, True, True),
        (0.2, 0.1, CLEAR, True, True),
        # What no finer fit shows is not, however much does.
        (1.0, 1000.0, 0.0, False, False),
    ],
)
def test_pairs_are_resolved(square, apart, persistence, clarity, seen, resolved):
    surface, nearest = square
    pair = [nearest(-0.5 * apart * RADIUS, 0.0), nearest(0.5 * apart * RADIUS, 0.0)]
    found = located(
        pair,
        index=[0.5, -0.5],
        clarity=[clarity] * 2,
        uncertainty=[0.08 * RADIUS] * 2,
        seen=[seen] * 2,
    )
    verdict = judged(surface, found, partner=[1, 0], persistence=[persistence * NOISE] * 2)
    assert verdict.resolved.tolist() == [resolved] * 2
    assert verdict.present.tolist() == [clarity == CLEAR] * 2


@pytest.mark.parametrize(
    "apart, persistence, resolved", [(2.5, 100.0, True), (1.5, 100.0, False), (2.5, 3.2, False)]
)
def test_slopes_say_nothing_of_what_their_fit_does_not_reach(square, apart, persistence, resolved):
    """Of the half of a flat point, whose place could be anywhere, and what cancels with it."""
    surface, nearest = square
    pair = [nearest(-0.5 * apart * RADIUS, 0.0), nearest(0.5 * apart * RADIUS, 0.0)]
    found = located(
        pair, index=[0.5, -0.5], clarity=[2.1] * 2, uncertainty=[3.0 * RADIUS, 0.1 * RADIUS]
    )
    verdict = judged(surface, found, partner=[1, 0], persistence=[persistence * NOISE] * 2)
    assert verdict.resolved.tolist() == [resolved] * 2


def test_pairs_at_a_border_are_not_told_by_their_errors(square):
    """The border makes places vague without making pairs."""
    surface, nearest = square
    x, y = rings_in(surface, 0)
    pair = [nearest(x, y), nearest(x + 0.05, y)]
    found = located(pair, index=[0.5, -0.5], clarity=[1.0, 1.0], uncertainty=[0.2 * RADIUS] * 2)
    verdict = judged(surface, found, partner=[1, 0], persistence=[1000.0 * NOISE] * 2)
    assert verdict.at_border.all() and verdict.resolved.all()
    # Nor where one of the two is farther in.
    pair = [nearest(x, y), nearest(rings_in(surface, 6)[0], y)]
    found = located(pair, index=[0.5, -0.5], clarity=[2.2] * 2, uncertainty=[0.8 * RADIUS] * 2)
    verdict = judged(surface, found, partner=[1, 0], persistence=[1000.0 * NOISE] * 2)
    assert verdict.at_border.tolist() == [True, False] and verdict.resolved.all()


@pytest.mark.parametrize(
    "apart, persistence, error, clarity, seen, resolved",
    [
        # One error and a half is no pair of many, but of two places of their own it is enough.
        (1.5, 1.5, 0.08, 0.5, [True, True], True),
        (1.5, 1.5, 0.08, 0.5, [True, False], True),
        # Not where fits share errors, not below what a pair of noise has, not within the errors of
        # the places, and not where no finer fit shows either of them.
        (0.6, 1.5, 0.08, 0.5, [True, True], False),
        (1.5, 1.0, 0.08, 0.5, [True, True], False),
        (1.5, 1.5, 0.8, 0.5, [True, True], False),
        (1.5, 1.5, 0.08, 0.5, [False, False], False),
    ],
)
def test_two_places_of_their_own_need_less(
    square, apart, persistence, error, clarity, seen, resolved
):
    surface, nearest = square
    pair = [nearest(-0.5 * apart * RADIUS, 0.0), nearest(0.5 * apart * RADIUS, 0.0)]
    found = located(
        pair, index=[0.5, -0.5], clarity=[clarity] * 2, uncertainty=[error * RADIUS] * 2, seen=seen
    )
    verdict = judged(surface, found, partner=[1, 0], persistence=[persistence * NOISE] * 2)
    assert verdict.resolved.tolist() == [resolved] * 2
    # However clear one of them is: what needs the other to be told from noise is not beyond doubt.
    found = located(
        pair, index=[0.5, -0.5], clarity=[CLEAR, 1.0], uncertainty=[error * RADIUS] * 2, seen=seen
    )
    verdict = judged(surface, found, partner=[1, 0], persistence=[persistence * NOISE] * 2)
    assert not verdict.certain.any()


@pytest.mark.parametrize(
    "where, error, persistence, moved",
    [
        # A third of the way: one place is known twice as well as the other.
        (0.6, (0.2, 0.2 * np.sqrt(2.0)), 0.5, 1.0 / 3.0),
        # Not beyond a fit, not where errors do not bring both together, not towards a real one.
        (1.2, (0.6, 0.6 * np.sqrt(2.0)), 0.5, 0.0),
        (0.6, (0.02, 0.02), 0.5, 0.0),
        (0.6, (0.2, 0.2), 100.0, 0.0),
    ],
)
def test_of_three_where_two_cancel_the_outer_ones_are_one_place(
    square, where, error, persistence, moved
):
    surface, nearest = square
    rows = [nearest(x * where * RADIUS, 0.0) for x in (-0.5, 0.5, 0.2)]
    own, other = (e * RADIUS for e in error)
    clear = [CLEAR if persistence > 1.0 else 0.5] * 3
    found = located(rows, index=[0.5, 0.5, -0.5], uncertainty=[own, other, other], clarity=clear)
    cancels = [np.inf, persistence * NOISE, persistence * NOISE]
    verdict = judged(surface, found, partner=[-1, 2, 1], persistence=cancels)
    assert verdict.resolved.tolist() == [True, persistence > 1.0, persistence > 1.0]
    before = found.position(surface)
    after = settled(surface, found, verdict, np.full(len(surface.vertices), RADIUS))
    expected = before[0] + moved * (before[1] - before[0])
    np.testing.assert_allclose(after.position(surface)[0], expected, atol=1e-9)
    np.testing.assert_array_equal(after.position(surface)[1:], before[1:])


def test_one_of_a_whole_index_goes_with_two_of_a_half(square):
    """A group that adds up to nothing, in which there are more of one sign than of the other."""
    surface, at = square
    places = [at(0.2, 0.3), at(0.25, 0.3), at(0.2, 0.35)]
    found = located(places, index=[1.0, -0.5, -0.5])
    evidence = SimpleNamespace(gap=np.ones(len(surface.vertices)), regions=[])
    left, verdict = merged(
        surface, None, found, judged(surface, found), np.zeros(3, int), evidence
    )
    assert not verdict.resolved.any() and np.isfinite(verdict.persistence).all()
    assert verdict.partner.tolist() == [1, 0, 0] and left.index.sum() == 0.0
