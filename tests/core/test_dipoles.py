"""Which opposite singularities are taken for pairs, however many stand within reach."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import cdist

from core.retopology.dipoles import PARTNERS, _nearest_opposite


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
