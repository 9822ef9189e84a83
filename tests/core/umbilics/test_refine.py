"""The place of an umbilic by a fit of higher degree, on surfaces whose heights it fits exactly."""

import dataclasses

import numpy as np
import pytest
from surfaces import grid_points

import core
from core.base.progress import Progress
from core.curvature.close_up import closer
from core.curvature.close_up.closer import look_closer
from core.curvature.estimate import estimate
from core.curvature.fits.flattened import fit_flattened
from core.curvature.scale import Scale
from core.mesh.borders import distance_to_border
from core.mesh.mending.repair import clean
from core.mesh.normals import vertex_normals
from core.umbilics import refine as refining
from core.umbilics.refine import refine

BEND = 0.5
# Third derivatives xxx, xxy, xyy, yyy at the umbilic: a lemon, a star.
LEMON, STAR = (0.9, 0.2, 0.5, -0.1), (0.6, 0.1, -0.7, 0.2)


def graph(third, rough=0.0, cells=24, unit=1.0):
    """z = BEND r^2 / 2 and a cubic, a graph with its only umbilic near the middle at the origin."""
    points, triangles = grid_points(cells, cells, (-0.5, -0.5), (0.5, 0.5))
    random = np.random.default_rng(0)
    points = points + (np.abs(points).max(axis=1) < 0.49)[:, None] * (
        0.2 / cells * random.uniform(-1.0, 1.0, points.shape)
    )
    x, y = points.T
    a, b, c, d = third
    z = 0.5 * BEND * (x * x + y * y)
    z += (a * x**3 + 3 * b * x * x * y + 3 * c * x * y * y + d * y**3) / 6.0
    z += rough / cells * random.standard_normal(len(z))
    return unit * np.column_stack([x, y, z]), triangles


def fitted(vertices, triangles, scale=2.0):
    surface, _ = clean(vertices, triangles)
    normals = vertex_normals(surface)
    found = estimate(surface, normals, core.Settings(scale=scale), None, None, Progress())
    # The jets alone, without what is looked at more closely.
    return surface, dataclasses.replace(found, closer=None, degree=0)


def beginning(surface, away):
    """The triangle over a place in the plane, with equal weights."""
    middle = surface.vertices[surface.triangles].mean(axis=1) * surface.unit + surface.origin
    row = np.argmin(np.linalg.norm(middle[:, :2] - away, axis=1))
    return np.array([row]), np.full((1, 3), 1.0 / 3.0)


def places(surface, found, away=(0.0, 0.0)):
    return refine(surface, *beginning(surface, away), found, Progress())


def place_of(surface, found):
    corners = surface.vertices[surface.triangles[found.triangle]]
    assert (found.barycentric >= 0).all() and np.allclose(found.barycentric.sum(axis=1), 1.0)
    return np.einsum("kc,kcx->kx", found.barycentric, corners) * surface.unit + surface.origin


@pytest.mark.parametrize("third", [LEMON, STAR])
@pytest.mark.parametrize("away", [(0.0, 0.0), (0.03, -0.02)])
def test_a_cubic_graph_gives_up_all_it_is_made_of(third, away):
    surface, fit = fitted(*graph(third))
    found = places(surface, fit, away)
    assert found.found.all()
    # The fit stands on the plane of the triangle that it begins in, which is not quite the
    # umbilic's own: there the heights are no polynomial.
    assert np.abs(place_of(surface, found)[0, :2]).max() < 1e-5
    np.testing.assert_allclose(found.normal, [[0.0, 0.0, 1.0]], atol=1e-6)
    # A bowl curves away from its outward side.
    np.testing.assert_allclose(found.curvature / surface.unit, -BEND, rtol=1e-6)
    # The deviator -(z_xx - z_yy + 2i z_xy) is p w + q conj(w) of the place w = x + iy.
    a, b, c, d = third
    along_x, along_y = -(a - c + 2j * b), -(b - d + 2j * c)
    p, q = 0.5 * (along_x - 1j * along_y), 0.5 * (along_x + 1j * along_y)
    # By the turn of the frame that the fit chose.
    turn = complex(*found.x[0, :2])
    assert abs(turn) == pytest.approx(1.0)
    np.testing.assert_allclose(found.y[0, :2], ((1j * turn).real, (1j * turn).imag), atol=1e-6)
    np.testing.assert_allclose(found.p / surface.unit**2, p * turn.conjugate(), rtol=1e-5)
    np.testing.assert_allclose(found.q / surface.unit**2, q * turn.conjugate() ** 3, rtol=1e-5)
    # Nothing is left of the heights, so that the zero is as clear as can be.
    assert found.error[0] < 1e-6 and found.slope_error[0] < 1e-5
    assert found.clarity[0] > 1e4


def test_errors_grow_with_the_roughness_and_clarity_falls():
    errors, slopes, clarity = [], [], []
    for rough in (0.0002, 0.0004):
        surface, fit = fitted(*graph(LEMON, rough))
        found = places(surface, fit)
        assert found.found.all()
        assert np.linalg.norm(place_of(surface, found)[0, :2]) < 0.05
        errors.append(found.error[0])
        slopes.append(found.slope_error[0])
        clarity.append(found.clarity[0])
    assert errors[1] == pytest.approx(2.0 * errors[0], rel=0.1)
    assert slopes[1] == pytest.approx(2.0 * slopes[0], rel=0.1)
    assert clarity[1] == pytest.approx(0.5 * clarity[0], rel=0.2)
    # Of the length of a deviator and of a slope: by the radius of the samples, under one here.
    assert slopes[0] > errors[0]


def test_errors_of_neighbours_that_are_shared_count():
    surface, fit = fitted(*graph(LEMON, 0.002), scale=3.0)
    scale = Scale(dataclasses.replace(fit.neighbourhood, rings=4))
    one, three = (
        places(surface, dataclasses.replace(fit, closer=each, degree=4))
        for each in (scale, dataclasses.replace(scale, factor=3.0))
    )
    assert one.slope_error[0] > 0.0
    for name, times in (("error", 3.0), ("slope_error", 3.0), ("clarity", 1.0 / 3.0)):
        np.testing.assert_allclose(getattr(three, name), times * getattr(one, name))


def test_slopes_are_as_uncertain_as_the_place_that_they_are_read_at():
    """Of two surfaces with the same linear form the one on which it changes more, under the same
    errors of the points."""
    errors = []
    for fourth in (0.0, 60.0):
        vertices, triangles = graph(LEMON, 0.002)
        x, y = vertices[:, :2].T
        vertices[:, 2] += fourth * (x**4 - 6.0 * x * x * y * y + y**4) / 24.0
        surface, fit = fitted(vertices, triangles, scale=3.0)
        scale = Scale(dataclasses.replace(fit.neighbourhood, rings=6))
        found = places(surface, dataclasses.replace(fit, closer=scale, degree=4))
        assert found.found.all()
        errors.append(found.slope_error[0] / found.error[0])
    assert errors[1] > 1.5 * errors[0]


def test_where_there_is_no_zero_nothing_changes():
    """Too far from the umbilic, on a cylinder, and without jets."""
    surface, fit = fitted(*graph(LEMON))
    cylinder = graph((0.0, 0.0, 0.0, 0.0))
    cylinder[0][:, 2] = 0.5 * BEND * cylinder[0][:, 0] ** 2
    for each, found, away in (
        (surface, fit, (0.3, 0.3)),
        (*fitted(*cylinder), (0.0, 0.0)),
        (surface, dataclasses.replace(fit, neighbourhood=None), (0.0, 0.0)),
    ):
        triangle, weights = beginning(each, away)
        result = refine(each, triangle, weights, found, Progress())
        assert not result.found.any() and not result.clarity.any()
        np.testing.assert_array_equal(result.triangle, triangle)
        np.testing.assert_array_equal(result.barycentric, weights)
        assert np.isnan(result.error).all()


def test_many_are_refined_as_each_alone():
    surface, fit = fitted(*graph(STAR))
    rows = np.concatenate([beginning(surface, (x, y))[0] for x in (0, 0.3) for y in (0, -0.02)])
    together = refine(surface, rows, np.full((4, 3), 1.0 / 3.0), fit, Progress())
    assert together.found.tolist() == [True, True, False, False]
    np.testing.assert_allclose(*place_of(surface, together)[:2], atol=1e-5)


def test_a_unit_of_length_is_a_unit_of_length():
    small, large = (places(*fitted(*graph(LEMON, 0.002, unit=unit))) for unit in (1.0, 1000.0))
    np.testing.assert_allclose(small.clarity, large.clarity, rtol=1e-6)
    np.testing.assert_allclose(small.barycentric, large.barycentric, atol=1e-7)


def looked(vertices, triangles, exact=None, rings=2, focused=True):
    surface, fit = fitted(vertices, triangles)
    around = dataclasses.replace(fit.neighbourhood, rings=rings, focused=focused)
    scale = Scale(around)
    return surface, fit, look_closer(surface, fit.field, fit.radius, scale, Progress(), exact)


def test_a_closer_look_is_taken_around_the_umbilic_alone():
    """The graph is of degree three, and its curvatures to the third order are not: the fit of
    degree five errs less."""
    surface, before, after = looked(*graph(LEMON))
    assert after.degree == 5 and after.scale.neighbourhood.rings == 3
    better = np.flatnonzero(after.field.noise < before.field.noise)
    place = surface.vertices[better, :2] * surface.unit + surface.origin[:2]
    assert 12 <= len(better) <= 60 and np.abs(place).max() < 4.5 / 24
    changed = np.flatnonzero((after.field.d1 != before.field.d1).any(axis=1))
    assert np.isin(changed, better).all()
    assert (after.radius[better] > before.radius[better]).all()
    rest = np.setdiff1d(np.arange(len(before.radius)), better)
    for name in ("k1", "k2", "d1", "d2", "normal", "noise"):
        fitted_anew = getattr(after.field, name) != getattr(before.field, name)
        assert fitted_anew.reshape(len(before.radius), -1).any(axis=1)[better].all(), name
        np.testing.assert_array_equal(
            getattr(after.field, name)[rest], getattr(before.field, name)[rest]
        )


def test_no_closer_look_at_exact_vertices_and_at_borders():
    vertices, triangles = graph(LEMON)
    _, before, after = looked(vertices, triangles, exact=np.ones(len(vertices), bool))
    np.testing.assert_array_equal(after.field.k1, before.field.k1)
    # An umbilic two edges from the border.
    inside = vertices[triangles].mean(axis=1)[:, 0] < 2.5 / 24
    surface, before, after = looked(vertices, triangles[inside])
    better = np.flatnonzero(after.field.noise < before.field.noise)
    edge = 1.0 / 24
    away = distance_to_border(surface, surface.vertices[better], edge, 10 * edge)
    assert (away * surface.unit > 1.5 * edge).all()


def test_nothing_is_looked_at_closer_without_umbilics():
    cylinder = graph((0.0, 0.0, 0.0, 0.0))
    cylinder[0][:, 2] = 0.5 * BEND * cylinder[0][:, 0] ** 2
    _, before, after = looked(*cylinder)
    assert after.scale is None
    np.testing.assert_array_equal(after.field.k1, before.field.k1)


def test_noise_is_looked_at_by_degree_four_and_the_cubic_stays_elsewhere():
    _, before, after = looked(*graph(LEMON, 0.05), rings=3, focused=False)
    assert after.degree == 4
    fitted_anew = after.rings > 0
    assert fitted_anew.any() and not fitted_anew.all()
    np.testing.assert_array_equal(after.field.k1[~fitted_anew], before.field.k1[~fitted_anew])
    assert (after.field.k1[fitted_anew] != before.field.k1[fitted_anew]).all()


@pytest.mark.parametrize(
    "change, shared, at_one",
    [
        ({}, False, False),
        ({"focused": True}, False, True),
        ({"stretch": 2.0}, False, True),
        ({}, True, True),
    ],
)
def test_windows_are_compared_where_noise_is_even(monkeypatch, change, shared, at_one):
    """On clean and on stretched meshes, and where errors are shared, one scale serves all."""
    monkeypatch.setattr(closer, "_at_one_scale", lambda *_: "one scale")
    surface, fit = fitted(*graph(LEMON, 0.05))
    around = dataclasses.replace(fit.neighbourhood, **{"rings": 3, "focused": False} | change)
    scale = Scale(around, factor=3.0, shared=shared)
    found = look_closer(surface, fit.field, fit.radius, scale, Progress())
    assert (found == "one scale") == at_one


def test_a_place_is_refined_over_the_narrowest_window_around_it():
    """And by its degree; where cubics stayed, over their rings and as many more as the degree asks
    for."""
    surface, fit = fitted(*graph(LEMON, 0.05))
    triangle, _ = beginning(surface, (0.0, 0.0))
    rings = np.zeros(len(surface.vertices), np.int64)
    scale = Scale(dataclasses.replace(fit.neighbourhood, rings=4))
    degrees = rings.copy()
    fit = dataclasses.replace(fit, closer=scale, degree=4, rings=rings, degrees=degrees)
    assert refining._windows(surface, triangle, fit)[1].tolist() == [[4 + refining.NOISY[1]], [4]]
    rings[surface.triangles[triangle[0], :2]] = 7, 3
    degrees[surface.triangles[triangle[0], :2]] = 4, 5
    assert refining._windows(surface, triangle, fit)[1].tolist() == [[3], [5]]


@pytest.mark.parametrize("cells, degree", [(24, 5), (5, 4), (4, 4), (3, 3)])
def test_the_degree_is_what_the_samples_can_hold(monkeypatch, cells, degree):
    """One and a half samples for each of (d + 1)(d + 2) / 2 terms, but no less than a cubic."""
    seen = []

    def recorded(x, y, z, asked, focus, held):
        seen.extend((count, *asked, focus is not None) for count in held.tolist())
        return fit_flattened(x, y, z, asked, focus, held=held)

    monkeypatch.setattr(refining, "fit_flattened", recorded)
    vertices, triangles = graph(LEMON, cells=cells)
    if cells == 5:
        # Without a row of cells: 30 vertices, a little less than degree five takes.
        triangles = triangles[vertices[triangles].mean(axis=1)[:, 0] < 0.3]
    surface, fit = fitted(vertices, triangles)
    places(surface, fit)
    ((samples, asked, focused),) = set(seen)
    assert asked == degree
    # Weights that fall off are those of degree five alone.
    assert focused == (degree == 5)
    terms = 0.5 * (degree + 1) * (degree + 2)
    assert samples >= 1.5 * terms or degree == 3
    assert degree == 5 or samples < 1.5 * (terms + degree + 2)


def test_noise_that_makes_umbilics_everywhere_is_not_looked_at_closer(monkeypatch):
    monkeypatch.setattr(closer, "MOST_ANYWAY", 0)
    vertices, triangles = graph(LEMON, rough=0.3)
    _, before, after = looked(vertices, triangles)
    np.testing.assert_array_equal(after.field.noise, before.field.noise)
    # A single one is, on a mesh of as many vertices.
    _, before, after = looked(*graph(LEMON))
    assert (after.field.noise < before.field.noise).any()
