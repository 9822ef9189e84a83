"""Which opposite singularities are taken for pairs, and what becomes of the field between them."""

import numpy as np
import pytest
from exact_fields import flat_surface
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import cdist

from core.base.progress import Progress
from core.fields.connection import connection_laplacian, weights_and_areas
from core.retopology.crosses.dipoles import PARTNERS, _nearest_opposite, without_dipoles


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 60), st.integers(0, 60), st.integers(0, 2**31))
def test_each_is_paired_with_its_nearest_opposites_and_no_more(positive, negative, seed):
    """Pairs grow with the number of singularities, not with its square: a soup of a thousand
    triangles had a quarter of a million, all within reach of each other."""
    random = np.random.default_rng(seed)
    index = random.permutation(np.r_[np.full(positive, 0.25), np.full(negative, -0.5)])
    place = random.normal(size=(len(index), 3))
    one, two = _nearest_opposite(place, index)
    assert (index[one] > 0).all() and (index[two] < 0).all()
    assert len(np.unique(one * 1000 + two)) == len(one) <= PARTNERS * len(index)
    distance = cdist(place, place)
    distance[np.sign(index)[:, None] == np.sign(index)] = np.inf
    pairs = set(zip(one.tolist(), two.tolist(), strict=True))
    for row in range(len(index)):
        if np.isfinite(distance[row]).any():
            other = int(distance[row].argmin())
            assert ((row, other) if index[row] > 0 else (other, row)) in pairs


# Of the pair: whole cells away from the origin.
MIDDLE = (8.0 + 4.0j) / 61.0


@pytest.fixture(scope="module")
def flat():
    surface, z = flat_surface(cells=61)
    normal = np.tile([0.0, 0.0, 1.0], (len(z), 1))
    axis = np.ascontiguousarray((normal[:, [2, 0, 1]] + 1j * normal[:, [1, 2, 0]]).T)
    weights, _ = weights_and_areas(surface)
    matrix, _ = connection_laplacian(surface, weights, axis, 4)
    return surface, z, normal, matrix


def joined(flat, distance, apart, fixed=None, sheet=1.0):
    """How many singularities are left of one of each sign at such a distance; the field before
    and after, and the places of its vertices."""
    surface, z, normal, matrix = flat
    u = (z - MIDDLE - 0.5 * distance) * (z - MIDDLE + 0.5 * distance).conj()
    u = u / np.abs(u)

    def direction(field):
        angle = np.angle(field) / 4.0
        return np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)

    fixed = surface.border if fixed is None else fixed
    after, index = without_dipoles(
        surface, matrix, u, fixed, sheet * normal, direction, apart, Progress()
    )
    return int(np.count_nonzero(index)), u, after


@pytest.mark.parametrize(
    "distance, apart, left",
    [
        # Farther apart than is asked for.
        (0.5, 0.4, 2),
        (0.5, 0.6, 0),
        (0.2, 0.25, 0),
        # Nearer than an edge and a half of the mesh, whatever is asked for; and not so.
        (0.05, 0.0, 0),
        (0.12, 0.0, 2),
    ],
)
def test_opposite_ones_are_joined_that_are_too_near(flat, distance, apart, left):
    number, before, after = joined(flat, distance, apart)
    assert number == left
    if left:
        assert np.array_equal(before, after)
    else:
        # Away from the two the field is what it was, within the disc it is harmonic.
        _, z, _, matrix = flat
        changed = np.flatnonzero(before != after)
        assert np.abs(z[changed] - MIDDLE).max() <= 1.6 * distance + 0.05
        assert np.abs((matrix @ after)[changed]).max() < 5e-3
        assert set(np.flatnonzero(np.abs(z - MIDDLE) < 0.5 * distance)) <= set(changed)


def test_what_is_held_stays(flat):
    _, z, _, _ = flat
    number, before, after = joined(flat, 0.2, 0.3, fixed=np.ones(len(z), bool))
    assert number == 2 and np.array_equal(before, after)
    half = z.real > MIDDLE.real
    _, before, after = joined(flat, 0.2, 0.3, fixed=half)
    assert np.array_equal(before[half], after[half])


def test_a_disc_does_not_reach_the_other_side_of_a_thin_sheet(flat):
    """Vertices whose normal is the other way are those of the other side."""
    number, before, after = joined(flat, 0.2, 0.3, sheet=-1.0)
    assert number == 2 and np.array_equal(before, after)
