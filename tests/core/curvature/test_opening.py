import numpy as np
import pytest
from exact_fields import flat_surface
from hypothesis import given, settings
from hypothesis import strategies as st

from core.curvature.elliptic_part import lies_within, opened_elliptic_part
from core.curvature.surface_types import FLAT, PEAK, PIT

DRAWING = """
.............
..####.......
..####.......
..####....#..
..####.......
..#######....
....#..###...
....#..###...
.......###...
.............
............
"""


def _drawn(surface, z: np.ndarray, picture: str) -> np.ndarray:
    """A picture as a set of vertices of the grid, one letter each."""
    rows = picture.strip().splitlines()
    width = max(len(row) for row in rows)
    step = 2.0 / (width - 1)
    column = np.rint((z.real + 1) / step).astype(int)
    row = np.rint((1 - z.imag) / step).astype(int)
    return np.array(
        [
            r < len(rows) and c < len(rows[r]) and rows[r][c] == "#"
            for r, c in zip(row, column, strict=True)
        ]
    )


def test_a_drawn_grid() -> None:
    surface, z = flat_surface(cells=12)
    drawn = _drawn(surface, z, DRAWING)
    opened = opened_elliptic_part(surface, np.where(drawn, PEAK, FLAT), 1)
    assert not np.any(opened & ~drawn)
    step = 1 / 6
    single = np.abs(z - (-1 + 10 * step + 1j * (1 - 3 * step))) < 1e-9
    bridge = np.abs(z - (-1 + 4 * step + 1j * (1 - 7 * step))) < 1e-9
    middle = np.abs(z - (-1 + 3 * step + 1j * (1 - 3 * step))) < 1e-9
    block = np.abs(z - (-1 + 8 * step + 1j * (1 - 7 * step))) < 1e-9
    assert single.sum() == bridge.sum() == middle.sum() == block.sum() == 1
    assert drawn[single | bridge | middle | block].all()
    assert not opened[single | bridge].any()
    assert opened[middle | block].all()


def test_peaks_and_pits_stay_flat_does_not() -> None:
    surface, z = flat_surface(cells=20)
    types = np.where(z.real < -0.25, PEAK, np.where(z.real > 0.25, PIT, FLAT))
    opened = opened_elliptic_part(surface, types, 2)
    assert np.array_equal(opened, np.abs(z.real) > 0.25)


def test_the_border_of_the_mesh_does_not_erode() -> None:
    surface, _ = flat_surface(cells=8)
    assert opened_elliptic_part(surface, np.full(len(surface.vertices), PEAK), 50).all()


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10_000), st.integers(0, 4), st.floats(0.5, 0.98))
def test_opening_is_idempotent_and_shrinks(seed: int, passes: int, share: float) -> None:
    surface, _ = flat_surface(cells=20)
    random = np.random.default_rng(seed).random(len(surface.vertices))
    inside = random < share
    once = opened_elliptic_part(surface, np.where(inside, PIT, FLAT), passes)
    again = opened_elliptic_part(surface, np.where(once, PIT, FLAT), passes)
    assert not np.any(once & ~inside)
    assert np.array_equal(once, again)
    more = opened_elliptic_part(surface, np.where(inside, PIT, FLAT), passes + 1)
    assert not np.any(more & ~once)


def test_points_belong_to_their_nearest_corner() -> None:
    surface, _ = flat_surface(cells=4)
    inside = np.zeros(len(surface.vertices), dtype=bool)
    inside[surface.triangles[5, 2]] = True
    weights = np.array([[0.2, 0.2, 0.6], [0.6, 0.2, 0.2]])
    assert lies_within(surface, inside, np.array([5, 5]), weights).tolist() == [True, False]
    assert lies_within(surface, inside, np.zeros(0, int), np.zeros((0, 3))).shape == (0,)


@pytest.mark.parametrize("passes", [0, -1])
def test_off_keeps_the_whole_elliptic_part(passes: int) -> None:
    surface, z = flat_surface(cells=6)
    types = np.where(z.real > 0, PIT, FLAT)
    assert np.array_equal(opened_elliptic_part(surface, types, passes), z.real > 0)
