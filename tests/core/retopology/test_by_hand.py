"""Guide strokes and poles of the user's own bend the field of the next plan."""

import numpy as np
import pytest
from surfaces import ellipsoid, torus

import core


@pytest.fixture(scope="module")
def plain():
    mesh = ellipsoid(subdivisions=5)
    guide = core.Guide(mesh.vertices, mesh.triangles, core.detect(mesh.vertices, mesh.triangles))
    return mesh, guide, guide.guidance()


def stroke_over(mesh, influence=0.3, slope=1.0):
    """A stroke over the top of the ellipsoid, across both families."""
    x = np.linspace(-0.5, 0.5, 20)
    y = slope * x
    z = np.sqrt(1.0 - x**2 / 9 - y**2 / 4)
    return core.Strokes(np.array([0, 20]), np.stack([x, y, z], axis=1), np.array([influence]))


def degrees_off(guidance, rows, wanted):
    """Angles between crosses and directions (r, 3)."""
    one, normal = guidance.direction[rows], guidance.normal[rows]
    two = np.cross(normal, one)
    x, y = (np.einsum("rc,rc->r", wanted, some) for some in (one, two))
    return np.degrees(np.abs(np.angle((x + 1j * y) ** 4))) / 4


@pytest.mark.slow
def test_the_field_runs_along_a_stroke_and_stays_elsewhere(plain):
    mesh, guide, before = plain
    after = guide.guidance(strokes=stroke_over(mesh))
    x, y, z = mesh.vertices.T
    beside = (z > 0) & (np.abs(x - y) < 0.15) & (np.abs(x + y) < 0.8)
    wanted = np.tile([1.0, 1.0, 0.0] / np.sqrt(2), (beside.sum(), 1))
    assert np.median(degrees_off(before, beside, wanted)) > 35
    assert degrees_off(after, beside, wanted).max() < 12
    below = z < -0.3
    assert degrees_off(after, below, before.direction[below]).max() < 5
    assert not after.warnings and after.poles.total == 8


@pytest.mark.slow
def test_a_stroke_far_away_or_against_another_is_said(plain):
    mesh, guide, _ = plain
    stroke = stroke_over(mesh)
    away = core.Strokes(stroke.start, stroke.position + np.array([0, 0, 5]), stroke.influence)
    assert "stroke 1 is too far" in guide.guidance(strokes=away).warnings[0]
    other = stroke_over(mesh, slope=0.0)
    both = core.Strokes(
        np.array([0, 20, 40]),
        np.concatenate([stroke.position, other.position]),
        np.array([0.3, 0.3]),
    )
    said = guide.guidance(strokes=both).warnings
    assert said and all("could not be followed over" in text for text in said)


@pytest.mark.once
def test_no_strokes_change_nothing(plain):
    _, guide, before = plain
    none = core.Strokes(np.zeros(1, int), np.zeros((0, 3)), np.zeros(0))
    assert np.array_equal(guide.guidance(strokes=none).direction, before.direction)


def wanted_like(poles, position=None, rows=slice(None)):
    place = poles.position if position is None else position
    return core.WantedPoles(place[rows], poles.valence[rows])


def test_a_moved_pole_takes_the_field_along(plain):
    mesh, guide, before = plain
    place = before.poles.position.copy()
    place[0] = mesh.vertices[np.linalg.norm(mesh.vertices - (1.0, 1.5, 0.55), axis=1).argmin()]
    after = guide.guidance(wanted=wanted_like(before.poles, place))
    assert np.linalg.norm(after.poles.position - place, axis=1).max() < mesh.edge_length
    quarters = np.bincount(after.poles.triangle, minlength=len(mesh.triangles))
    assert np.array_equal(4 * after.triangle_index, quarters)
    assert not after.warnings
    vertex, number = guide.singular_vertices(after)
    assert (number == 1).all() and len(vertex) == 8
    middle = mesh.vertices[mesh.triangles[after.poles.triangle]].mean(axis=1)
    apart = np.linalg.norm(mesh.vertices[vertex][:, None] - middle[None], axis=2)
    assert apart.min(axis=0).max() < mesh.edge_length


def test_poles_that_the_sum_forbids_are_said(plain):
    _, guide, before = plain
    after = guide.guidance(wanted=wanted_like(before.poles, rows=slice(1, None)))
    assert len(after.poles) == 7
    assert 4 * after.triangle_index.sum() == 8
    assert "other poles than planned" in after.warnings[0]


def test_a_pair_may_be_added_where_there_is_none():
    mesh = torus(columns=80, rows=32)
    guide = core.Guide(mesh.vertices, mesh.triangles, core.detect(mesh.vertices, mesh.triangles))
    rows = [100, 1400]
    after = guide.guidance(wanted=core.WantedPoles(mesh.vertices[rows], np.array([3, 5])))
    assert not after.warnings and after.poles.total == 0
    assert np.sort(4 * after.triangle_index[after.triangle_index != 0]).tolist() == [-1, 1]
    none = core.WantedPoles(np.zeros((0, 3)), np.zeros(0, int))
    assert not guide.guidance(wanted=none).triangle_index.any()


def test_strokes_that_count_for_nothing_say_why(plain):
    mesh, guide, before = plain
    stroke = stroke_over(mesh)
    # A dot, one of no numbers, and one that lies all along above another.
    above = stroke.position + np.array([0.0, 0.0, 0.1])
    lines = [stroke.position[:1], np.full((3, 3), np.nan), stroke.position, above]
    start = np.cumsum([0, *map(len, lines)])
    strokes = core.Strokes(start, np.concatenate(lines), np.full(4, 0.3))
    said = guide.guidance(strokes=strokes).warnings
    dots = [f"Guide stroke {number} has no length and does not count." for number in (1, 2)]
    assert list(said[:2]) == dots and len(said) == 3
    assert "others are nearer to the surface" in said[2]
    dots_only = core.Strokes(start[:3], np.concatenate(lines[:2]), np.full(2, 0.3))
    found = guide.guidance(strokes=dots_only)
    assert list(found.warnings) == dots
    assert np.array_equal(found.direction, before.direction)


@pytest.mark.parametrize("count, sentences", [(6, 6), (7, 6), (40, 6)])
def test_of_many_strokes_the_first_are_told_and_the_others_counted(plain, count, sentences):
    _, guide, _ = plain
    away = np.arange(count)[:, None, None] + np.array([[0.0, 0.0, 50.0], [1.0, 0.0, 50.0]])
    strokes = core.Strokes(2 * np.arange(count + 1), away.reshape(-1, 3), np.full(count, 0.1))
    said = guide.guidance(strokes=strokes).warnings
    assert len(said) == sentences and all("too far" in text for text in said[:5])
    if count > 6:
        assert said[-1] == f"{count - 5} more guide strokes could not be followed everywhere."


@pytest.mark.slow
def test_a_wanted_pole_far_from_the_surface_is_said(plain):
    _, guide, before = plain
    place = before.poles.position.copy()
    wanted = core.WantedPoles(place, before.poles.valence)
    assert not guide.guidance(wanted=wanted).warnings
    place[0, 0] += 40.0
    said = guide.guidance(wanted=core.WantedPoles(place, before.poles.valence)).warnings
    assert any("1 pole was far from the surface" in text for text in said)
    place[1] = np.nan
    with pytest.raises(core.GuidanceError, match="coordinates are not numbers"):
        guide.guidance(wanted=core.WantedPoles(place, before.poles.valence))
