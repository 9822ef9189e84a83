"""A detection does not depend on where, how large or in what order the mesh is given, nor on how
many processors the machine has."""

import dataclasses
import os

import numpy as np
import pytest
import surfaces
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import core
from core.base import blas
from core.mesh.surface import BLOCK

SURFACE = surfaces.random_ellipsoid(count=1500, seed=4)
PLAIN = core.detect(SURFACE.vertices, SURFACE.triangles)

seeds = st.integers(0, 2**32 - 1)


def matched(found: core.Umbilics, expected: np.ndarray, size: float, tolerance: float) -> None:
    """The same umbilics, whatever their order, to a part `tolerance` of the size."""
    distance = np.linalg.norm(found.position[:, None] - expected[None], axis=2)
    nearest = distance.argmin(axis=1)
    assert sorted(nearest) == list(range(len(expected)))
    assert distance.min(axis=1).max() <= tolerance * size
    np.testing.assert_array_equal(found.index, PLAIN.umbilics.index[nearest])
    np.testing.assert_array_equal(found.kind, PLAIN.umbilics.kind[nearest])


@pytest.mark.slow
@settings(max_examples=10)
@given(seeds)
def test_rigid_motion(seed):
    turn = Rotation.random(random_state=seed).as_matrix()
    offset = np.random.default_rng(seed).uniform(-5, 5, 3)
    detection = core.detect(SURFACE.vertices @ turn.T + offset, SURFACE.triangles)
    matched(detection.umbilics, PLAIN.umbilics.position @ turn.T + offset, 3.0, 1e-7)
    np.testing.assert_allclose(detection.curvature.k1, PLAIN.curvature.k1, rtol=1e-6)


@pytest.mark.slow
@settings(max_examples=10)
@given(st.floats(-6, 6))
def test_uniform_scale(exponent):
    factor = 10.0**exponent
    detection = core.detect(SURFACE.vertices * factor, SURFACE.triangles)
    matched(detection.umbilics, PLAIN.umbilics.position * factor, 3.0 * factor, 1e-9)
    np.testing.assert_allclose(detection.curvature.k1 * factor, PLAIN.curvature.k1, rtol=1e-9)
    np.testing.assert_allclose(
        detection.umbilics.curvature.sum() * factor, PLAIN.umbilics.curvature.sum(), rtol=1e-8
    )


@pytest.mark.parametrize("axis", range(3))
def test_offset_of_a_million_units(axis):
    offset = 1e6 * np.eye(3)[axis]
    detection = core.detect(SURFACE.vertices + offset, SURFACE.triangles)
    # The coordinates themselves lose ten digits out there, so the edges lose seven.
    matched(detection.umbilics, PLAIN.umbilics.position + offset, 3.0, 1e-5)


@pytest.mark.slow
@settings(max_examples=10)
@given(seeds)
def test_renumbering_of_vertices_and_faces(seed):
    shuffled = surfaces.renumbered(SURFACE, seed=seed)
    detection = core.detect(shuffled.vertices, shuffled.triangles)
    matched(detection.umbilics, PLAIN.umbilics.position, 3.0, 1e-8)


def test_the_same_input_gives_the_same_bits():
    again = core.detect(SURFACE.vertices, SURFACE.triangles)
    np.testing.assert_array_equal(again.umbilics.position, PLAIN.umbilics.position)
    np.testing.assert_array_equal(again.curvature.k1, PLAIN.curvature.k1)


def test_turning_the_surface_inside_out_swaps_the_curvatures():
    detection = core.detect(SURFACE.vertices, SURFACE.triangles[:, ::-1])
    np.testing.assert_allclose(detection.curvature.k1, -PLAIN.curvature.k2, atol=1e-8)
    matched(detection.umbilics, PLAIN.umbilics.position, 3.0, 1e-7)
    assert any("point inwards" in text for text in detection.warnings)


def bits(result) -> dict[str, object]:
    """What a result holds, by name, but for the seconds that it took."""
    if dataclasses.is_dataclass(result):
        fields = [field.name for field in dataclasses.fields(result) if field.name != "timings"]
        parts = {name: getattr(result, name) for name in fields}
    elif isinstance(result, list | tuple):
        parts = {str(number): item for number, item in enumerate(result)}
    else:
        return {"": np.asarray(result).tobytes() if isinstance(result, np.ndarray) else result}
    found = {name: bits(part) for name, part in parts.items()}
    return {f"{name}.{more}": value for name, of in found.items() for more, value in of.items()}


@pytest.fixture
def on_processors(monkeypatch):
    """Call a function as on a machine of so many processors."""
    before = [(set_, get()) for get, set_ in blas.libraries()]

    def call(count, make):
        monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(count)), raising=False)
        monkeypatch.setattr(os, "cpu_count", lambda: count)
        for set_, _ in before:
            set_(count)
        return bits(make())

    yield call
    for set_, count in before:
        set_(count)


@pytest.mark.slow
@pytest.mark.parametrize("size", [2_000, BLOCK // 2 + 500])
def test_the_same_bits_on_any_number_of_processors(on_processors, size):
    mesh = surfaces.random_ellipsoid(count=size, seed=1)

    def make():
        detection = core.detect(mesh.vertices, mesh.triangles)
        guide = core.Guide(mesh.vertices, mesh.triangles, detection)
        return detection, guide.guidance(), guide.ridges(), guide.separatrices()

    one, *others = (on_processors(count, make) for count in (2, 1, 3, 16))
    assert all(other == one for other in others)


@pytest.mark.slow
@pytest.mark.parametrize("make", [surfaces.sphere, surfaces.ellipsoid])
def test_the_same_quads_on_any_number_of_processors(on_processors, make):
    mesh = make()
    settings = core.RemeshSettings(quads=1000)
    one, *others = (
        on_processors(count, lambda: core.remesh(mesh.vertices, mesh.triangles, settings))
        for count in (2, 1, 16)
    )
    assert all(other == one for other in others)
