"""Numbers that users give, and sizes of meshes, at their extremes: a result or a sentence."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from surfaces import ellipsoid

import core
from core.mesh.mending.repair import SMALLEST

MESH = ellipsoid((1.5, 1.2, 1.0), 1)
EXTREMES = [0, -1, 1, 5e-324, 1e-320, 1e-300, 1e-9, 1e-3, 1e9, 1e300, 2**63, 10**400, -(10**400)]
EXTREMES += [float("nan"), float("inf"), -float("inf"), np.float32(1e-40), np.int64(2**62)]
NUMBERS = st.one_of(st.sampled_from(EXTREMES), st.floats(), st.integers())
# Settings of a plan that lines alone hang on: a plan takes longer.
OF_LINES = ("spacing", "closest", "shortest", "families")


def numeric(of):
    return [name for name, one in core.options(of).items() if one.kind in ("count", "number")]


def answered(work):
    """What the work gives; None where it refuses in words."""
    try:
        return work()
    except core.UmbilicsError as error:
        assert str(error).endswith(".")
        return None


@pytest.mark.parametrize("name", numeric(core.Settings))
@settings(max_examples=12, deadline=None)
@given(value=NUMBERS)
def test_of_a_detection(name, value):
    def work():
        return core.detect(MESH.vertices, MESH.triangles, core.Settings(**{name: value}))

    found = answered(work)
    assert found is None or np.isfinite(found.curvature.k1).all()


@pytest.fixture(scope="module")
def guide():
    detection = core.detect(MESH.vertices, MESH.triangles)
    return core.Guide(MESH.vertices, MESH.triangles, detection)


@pytest.mark.slow
@pytest.mark.parametrize("name", numeric(core.GuidanceSettings))
@pytest.mark.filterwarnings("error::RuntimeWarning")
@settings(max_examples=5, deadline=None)
@given(value=NUMBERS)
def test_of_a_plan_and_its_lines(name, value, guide):
    choices = answered(lambda: core.GuidanceSettings(**{name: value}))
    if choices is None:
        return
    works = [guide.separatrices, guide.lines]
    for work in works if name in OF_LINES else [*works[:1], guide.guidance, guide.ridges]:
        answered(lambda work=work: work(choices))


@pytest.mark.slow
@pytest.mark.parametrize("name", numeric(core.RemeshSettings))
@settings(max_examples=4, deadline=None)
@given(value=st.sampled_from([value for value in EXTREMES if not 64 < value < 1e8]))
def test_of_quads(name, value):
    made = answered(
        lambda: core.remesh(MESH.vertices, MESH.triangles, core.RemeshSettings(**{name: value}))
    )
    assert made is None or np.isfinite(made.vertices).all()


def least_spacing(guide, spacing):
    """The spacing that a sentence names where lines are asked for that are closer."""
    with pytest.raises(core.GuidanceError, match="too many for this mesh") as refused:
        guide.lines(core.GuidanceSettings(spacing=spacing))
    return float(str(refused.value).split(" apart and more")[0].split()[-1])


@pytest.mark.parametrize("spacing", [5e-324, 1e-300, 1e-9, 1e-4])
def test_lines_closer_than_the_mesh_tells_are_refused(guide, spacing):
    assert 0.0 < least_spacing(guide, spacing) < 0.04


@pytest.mark.slow
def test_as_close_as_the_sentence_says_there_are_lines(guide):
    nearest = core.GuidanceSettings(spacing=least_spacing(guide, 1e-9), families="first")
    assert len(guide.lines(nearest).start) > 1


def test_lines_of_a_mesh_with_more_triangles_may_be_closer(guide):
    mesh = ellipsoid((1.5, 1.2, 1.0), 5)
    detection = core.detect(mesh.vertices, mesh.triangles)
    fine = core.Guide(mesh.vertices, mesh.triangles, detection)
    assert least_spacing(fine, 1e-9) < least_spacing(guide, 1e-9)


@pytest.mark.parametrize("length", [5e-324, 1e-300, 1e-9])
def test_quads_too_many_for_anyone_are_refused(length):
    with pytest.raises(core.RemeshError, match="more than 1,000,000 quads"):
        core.remesh(MESH.vertices, MESH.triangles, core.RemeshSettings(edge_length=length))


@pytest.mark.parametrize("of", [core.Settings, core.GuidanceSettings, core.RemeshSettings])
def test_a_number_of_too_many_digits_is_refused(of):
    for name in numeric(of):
        with pytest.raises(core.InvalidSettingsError):
            of(**{name: 10**5000})


@pytest.mark.filterwarnings("error::RuntimeWarning")
@pytest.mark.parametrize("exponent", [-323, -320, -310, -305, -299, -160, 160, 300, 307])
def test_coordinates(exponent):
    with np.errstate(under="ignore"):
        vertices = MESH.vertices * float(f"1e{exponent}")
    found = answered(lambda: core.detect(vertices, MESH.triangles))
    assert (found is None) == (exponent <= -305)
    if found is not None:
        assert found.index_sum == 2.0 and np.isfinite(found.curvature.k1).all()
        assert (found.curvature.k1 > 0.0).all()


@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_the_smallest_mesh_has_curvatures_that_are_numbers():
    random = np.random.default_rng(0)
    rough = MESH.vertices * (1.0 + 0.5 * random.random((len(MESH.vertices), 1)))
    size = 1.01 * SMALLEST / np.abs(rough).max()
    found = core.detect(size * rough, MESH.triangles)
    assert np.isfinite(found.curvature.k1).all()
    with pytest.raises(core.InvalidMeshError, match="Scale it up"):
        core.detect(0.5 * size * rough, MESH.triangles)


@pytest.mark.parametrize("exponent", [-320, -200, 200, 300])
def test_quads_of_meshes_whose_areas_are_no_numbers_are_refused(exponent):
    with pytest.raises(core.UmbilicsError, match="in size"), np.errstate(under="ignore"):
        core.remesh(MESH.vertices * float(f"1e{exponent}"), MESH.triangles)
