"""Whatever the mesh, whatever is asked of it: a finite answer or a sentence, and no warning of
NumPy on the way."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from exact_fields import surface_of
from hypothesis import given, settings
from hypothesis import strategies as st
from surfaces import hostile, icosphere, plane, sphere

import core
from core.curvature.fits.flattened import nearest_spheres
from core.umbilics.methods.at_vertices import mean_square_less_gaussian

seeds = st.integers(0, 2**32 - 1)
kinds = st.sampled_from(hostile.KINDS)


@pytest.fixture(autouse=True)
def _no_warnings():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


def answer(step):
    """What a step gives, None where it refuses in words."""
    try:
        return step()
    except core.UmbilicsError as error:
        assert str(error).endswith((".", ")."))
        return None


def assert_finite(found, *names):
    for name in names:
        assert np.isfinite(getattr(found, name)).all(), name


def of(kind, seed):
    return kind(np.random.default_rng(seed))


@pytest.mark.slow
@settings(max_examples=24)
@given(kinds, seeds, st.sampled_from("SIC"), st.sampled_from(["jets", "normals"]))
def test_detection(kind, seed, method, curvature):
    vertices, triangles = of(kind, seed)
    choices = core.Settings(method=method, curvature=curvature)
    found = answer(lambda: core.detect(vertices, triangles, choices))
    if found is None:
        return
    assert_finite(found.candidates, "position", "normal", "barycentric", "index", "curvature")
    assert not (method == "I" and found.candidates.certain.any())
    again = core.unpack(core.pack(found))
    np.testing.assert_array_equal(again.candidates.position, found.candidates.position)
    kept = core.filtered(again, choices).umbilics
    np.testing.assert_array_equal(kept.position, found.umbilics.position)


@pytest.mark.slow
@settings(max_examples=8)
@given(kinds, seeds)
def test_comparison(kind, seed):
    vertices, triangles = of(kind, seed)
    found = answer(lambda: core.compare(vertices, triangles))
    if found is not None:
        assert len(core.comparison_table(found).splitlines()) > len(found)


@pytest.mark.slow
@settings(max_examples=10)
@given(kinds, seeds, st.sampled_from([0.0, 0.4, 1.0]), st.booleans())
def test_plan_lines_and_files(kind, seed, smoothness, crests):
    vertices, triangles = of(kind, seed)
    detection = answer(lambda: core.detect(vertices, triangles))
    if detection is None:
        return
    guide = core.Guide(vertices, triangles, detection)
    # Few lines, which are as many as it takes.
    spacing = 0.4 * guide.surface.unit
    choices = core.GuidanceSettings(smoothness=smoothness, align_crests=crests, spacing=spacing)
    plan = guide.guidance(choices)
    assert_finite(plan.poles, "position", "normal", "confidence")
    used = guide.surface.source_vertex
    assert np.isfinite(plan.direction[used]).all()
    assert np.isfinite(plan.face_direction[guide.surface.source_triangle]).all()
    if guide.surface.closed.all():
        assert plan.index_sum == pytest.approx(plan.expected_index_sum)
    lines = (
        answer(lambda: guide.lines(choices)),
        guide.separatrices(choices),
        guide.ridges(choices),
    )
    edges = np.unique(np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)), axis=0)
    for found in lines:
        if found is not None:
            assert_finite(found, "position", "length")
            assert core.edge_paths(vertices, edges, found).shape == (len(edges),)
    core.ridge_edges(vertices, edges, lines[2])
    with TemporaryDirectory() as folder:
        mesh = core.UsdMesh("Thing", vertices, triangles, detection, np.eye(3))
        answer(lambda: core.write_usda(Path(folder) / "thing.usda", [mesh], "Z"))
        some = ["mesh", "rosy", "rawfield", "sing", "sharp", "csv", "json"]
        path = Path(folder) / "thing"
        core.export_guidance(path, some, guide, choices, mesh=(vertices, triangles))


@pytest.mark.slow
@settings(max_examples=8)
@given(kinds, seeds)
def test_symmetry(kind, seed):
    vertices, triangles = of(kind, seed)
    detection = answer(lambda: core.detect(vertices, triangles))
    if detection is None or np.abs(vertices[np.isfinite(vertices)]).max() > 1e38:
        # Beyond what Blender's coordinates hold, sums of squares of motions are no numbers.
        return
    plane_ = answer(core.Guide(vertices, triangles, detection).symmetry)
    if plane_ is not None:
        assert_finite(plane_, "point", "normal", "error", "score")
    shape = core.Shape.of(vertices, triangles, detection)
    turn = answer(lambda: core.find_rotation(shape))
    if turn is not None:
        assert_finite(turn, "point", "axis", "error", "score")


def stray_vertex(size):
    """A ball with a vertex so far away that everything else is one point beside it."""
    vertices, triangles = icosphere(2)
    vertices = vertices.copy()
    vertices[7] = size * np.array([1.0, 2.0, 3.0])
    return vertices, triangles


@pytest.mark.parametrize("size", [1e20, 1e100, 1e180])
def test_a_surface_without_area_is_planned_and_refused_in_words(size):
    vertices, triangles = stray_vertex(size)
    detection = core.detect(vertices, triangles)
    answer(lambda: core.detect(vertices, triangles, core.Settings(method="C")))
    guide = core.Guide(vertices, triangles, detection)
    plan = guide.guidance()
    assert np.isfinite(plan.direction).all()
    assert_finite(guide.ridges(), "position", "sharpness")
    guide.separatrices()
    with pytest.raises(core.GuidanceError, match="no area"):
        guide.lines()
    with pytest.raises(core.GuidanceError, match="no area"):
        guide.symmetry()
    if size < 1e150:  # squares of lengths are numbers
        with pytest.raises(core.MatchError, match="no area"):
            len(core.Shape.of(vertices, triangles, detection).samples)


def test_a_component_without_area_beside_another():
    vertices, triangles = icosphere(2)
    flat = vertices * (1.0, 0.0, 0.0) + (3.0, 0.0, 0.0)
    both = hostile.joined([(vertices * (3.0, 2.0, 1.0), triangles), (flat, triangles)])
    guide = core.Guide(*both, core.detect(*both))
    for smoothness in (0.0, 1.0, core.AUTO):
        plan = guide.guidance(core.GuidanceSettings(smoothness=smoothness))
        assert np.isfinite(plan.direction).all()


def test_a_component_that_goes_to_and_fro_between_two_points():
    vertices, triangles = icosphere(1)
    ends = np.random.default_rng(0).choice([-1.0, 1.0], len(vertices))
    both = hostile.joined(
        [
            (0.5 * vertices * (3.0, 2.0, 1.0), triangles),
            (np.tile(1.5 * ends[:, None], 3), triangles),
        ]
    )
    guide = core.Guide(*both, core.detect(*both))
    plan = guide.guidance(core.GuidanceSettings(smoothness=0.4))
    assert np.isfinite(plan.direction).all()
    guide.separatrices()
    guide.simplified(core.Progress())


def test_where_there_is_no_area_nothing_is_least():
    vertices, triangles = stray_vertex(1e100)
    values = mean_square_less_gaussian(
        surface_of(replace(sphere(), vertices=vertices, triangles=triangles))
    )
    assert not np.isnan(values).any()
    assert np.isposinf(values).any()


@pytest.mark.parametrize("size", [1e-70, 1e-9, 1.0, 1e9, 1e100])
def test_nearest_spheres_do_not_hang_on_the_size(size):
    random = np.random.default_rng(0)
    x, y = random.uniform(-0.5, 0.5, (2, 40, 3))
    z = 1.0 - np.sqrt(1.0 - x * x - y * y)
    found = nearest_spheres(size * x, size * y, size * z)
    np.testing.assert_allclose(found * size, 1.0, rtol=1e-9)


def test_nearest_spheres_of_samples_in_a_line_or_a_point():
    x = np.linspace(-1.0, 1.0, 30)[:, None] * np.array([1.0, 0.5, 0.0])
    y = np.linspace(-1.0, 1.0, 30)[:, None] * np.array([0.0, 1.0, 0.0])
    assert np.isfinite(nearest_spheres(x, y, 0.0 * x)).all()
    assert np.isfinite(nearest_spheres(x, y, x * x + y * y)).all()


ANY_WAY = [
    core.Settings(),
    core.Settings(regions=False),
    core.Settings(regions=False, persistence=0.0, merge=False),
    core.Settings(triangles="published"),
    core.Settings(method="I"),
    core.Settings(method="C"),
    core.Settings(curvature="normals", regions=False),
    core.Settings(normal_smoothing=2, regions=False),
]


@pytest.mark.parametrize("choices", ANY_WAY, ids=lambda one: f"{one.method} {one.curvature}")
@pytest.mark.parametrize("shape", ["sphere", "turned sphere", "plane", "tilted plane"])
def test_nothing_is_certain_where_there_is_nothing(shape, choices):
    if shape.endswith("sphere"):
        mesh = sphere(subdivisions=2)
        turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
        vertices = mesh.vertices @ (turn if shape.startswith("turned") else np.eye(3))
    else:
        mesh = plane(cells=12, tilt=0.3 if shape.startswith("tilted") else 0.0)
        vertices = mesh.vertices
    found = core.detect(vertices, mesh.triangles, choices)
    assert not found.candidates.certain.any()


def test_numbers_that_usd_cannot_hold_are_refused(tmp_path):
    vertices, triangles = icosphere(1)
    vertices = 1e200 * vertices
    mesh = core.UsdMesh("Huge", vertices, triangles, core.detect(vertices, triangles), np.eye(3))
    with pytest.raises(core.FormatError, match="single precision"):
        core.write_usda(tmp_path / "huge.usda", [mesh], "Z")
    assert not list(tmp_path.iterdir())


def test_edges_with_an_end_that_is_no_place_are_never_on_a_line():
    mesh = sphere(subdivisions=3)
    vertices, triangles = mesh.vertices * (3.0, 2.0, 1.0), mesh.triangles
    guide = core.Guide(vertices, triangles, core.detect(vertices, triangles))
    edges = np.unique(np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)), axis=0)
    lines = guide.separatrices()
    plain = core.edge_paths(vertices, edges, lines)
    spoiled = np.concatenate([vertices, [[np.nan, 0.0, 0.0], [np.inf, 0.0, 0.0]]])
    more = np.concatenate([edges, [[0, len(vertices)], [1, len(vertices) + 1]]])
    found = core.edge_paths(spoiled, more, lines)
    np.testing.assert_array_equal(found, np.append(plain, [False, False]))
    # Nor do those without a length, be they most: doubles leave them.
    on = int(edges[plain][0, 0])
    for more_of_them in (1, 2 * len(edges)):
        doubles = np.full((more_of_them, 2), on)
        found = core.edge_paths(vertices, np.concatenate([edges, doubles]), lines)
        np.testing.assert_array_equal(found[: len(edges)], plain)
    assert not core.edge_paths(vertices, doubles, lines).any()
    assert not core.ridge_edges(spoiled, more, guide.ridges()).kind[-2:].any()


EXACT = {
    "column by column": (np.asfortranarray, np.asfortranarray),
    "the other byte order": (lambda x: x.astype(">f8"), lambda t: t.astype(">i4")),
    "unsigned": (lambda x: x, lambda t: t.astype(np.uint64)),
    "lists": (np.ndarray.tolist, np.ndarray.tolist),
    "single precision": (lambda x: x.astype(np.float32), lambda t: t),
}


@pytest.mark.parametrize("form", EXACT)
def test_the_form_of_the_arrays_does_not_matter(form):
    vertices, triangles = hostile.blob(np.random.default_rng(5))
    vertices = vertices.astype(np.float32).astype(np.float64)
    of_vertices, of_triangles = EXACT[form]
    plain = core.detect(vertices, triangles)
    given_ = of_vertices(vertices), of_triangles(triangles)
    for one in given_:
        if isinstance(one, np.ndarray):
            one.flags.writeable = False
    other = core.detect(*given_)
    np.testing.assert_array_equal(other.candidates.position, plain.candidates.position)
    np.testing.assert_array_equal(other.curvature.k1, plain.curvature.k1)


@pytest.mark.slow
@settings(max_examples=8)
@given(kinds, seeds, st.integers(-60, 60))
def test_a_scale_by_a_power_of_two_changes_no_digit(kind, seed, power):
    vertices, triangles = of(kind, seed)
    plain = answer(lambda: core.detect(vertices, triangles))
    if plain is None or np.abs(vertices[np.isfinite(vertices)]).max() > 1e200:
        return
    factor = 2.0**power
    other = core.detect(vertices * factor, triangles)
    one, two = plain.candidates, other.candidates
    np.testing.assert_array_equal(two.position, one.position * factor)
    np.testing.assert_array_equal(two.index, one.index)
    np.testing.assert_array_equal(two.kind, one.kind)
    np.testing.assert_array_equal(two.persistence, one.persistence / factor)
    np.testing.assert_array_equal(two.certain, one.certain)


@pytest.mark.parametrize("exponent", [-300, -150, -38, 38, 150])
def test_ridges_and_comparison_at_any_size(exponent):
    mesh = sphere(subdivisions=2)
    vertices = mesh.vertices * (3.0, 2.0, 1.0) * 10.0**exponent
    found = core.compare(vertices, mesh.triangles)
    plain = core.compare(mesh.vertices * (3.0, 2.0, 1.0), mesh.triangles)
    assert [one.missed for one in found] == [one.missed for one in plain]
    guide = core.Guide(vertices, mesh.triangles, found[0].detection)
    ridges = guide.ridges(core.GuidanceSettings(ridge_kinds="all", least_bend=0.0))
    assert_finite(ridges, "position", "sharpness", "strength")
