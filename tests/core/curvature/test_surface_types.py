import numpy as np
import pytest
from exact_fields import surface_of
from hypothesis import given
from hypothesis import strategies as st
from surfaces import cylinder, ellipsoid, paraboloid, plane, saddle, similar

from core.curvature.surface_types import SURFACE_TYPES, surface_types, typical_curvature


@pytest.mark.parametrize(
    ("name", "k1", "k2"),
    [
        ("peak", 1.0, 0.5),
        ("pit", -0.5, -1.0),
        ("ridge", 1.0, 0.0),
        ("valley", 0.0, -1.0),
        ("flat", 0.0, 0.0),
        ("minimal", 1.0, -1.0),
        ("saddle ridge", 1.0, -0.5),
        ("saddle valley", 0.5, -1.0),
    ],
)
def test_the_eight_types(name: str, k1: float, k2: float) -> None:
    for wiggle in (-0.004, 0.0, 0.004):
        code = surface_types(np.array([k1 + wiggle]), np.array([k2 + wiggle]), 0.01)
        assert SURFACE_TYPES[code[0]] == name


def test_unknown_curvature_has_no_type() -> None:
    types = surface_types(np.array([np.nan, 1.0]), np.array([0.0, 1.0]), 0.1)
    assert types.tolist() == [-1, 0]


@given(st.floats(-2, 2), st.floats(0, 2), st.floats(0, 0.5))
def test_turning_the_normals_swaps_up_and_down(k2: float, gap: float, tolerance: float) -> None:
    k1 = k2 + gap
    swap = {"peak": "pit", "ridge": "valley", "saddle ridge": "saddle valley"}
    swap |= {down: up for up, down in swap.items()}
    (code,) = surface_types(np.array([k1]), np.array([k2]), tolerance)
    (other,) = surface_types(np.array([-k2]), np.array([-k1]), tolerance)
    name = SURFACE_TYPES[code]
    assert SURFACE_TYPES[other] == swap.get(name, name)


@pytest.mark.parametrize(
    ("mesh", "name"),
    [
        (ellipsoid(subdivisions=3), "peak"),
        (paraboloid(cells=20), "pit"),  # wound upwards
        (cylinder(), "ridge"),
        (plane(), "flat"),
    ],
    ids=lambda value: getattr(value, "name", value),
)
def test_known_quadrics(mesh, name: str) -> None:
    for scale in (1e-3, 1.0, 1e3):
        scaled = similar(mesh, scale)
        surface = surface_of(scaled)
        k1, k2 = scaled.k1 * surface.unit, scaled.k2 * surface.unit
        types = surface_types(k1, k2, 0.01 * typical_curvature(surface, k1, k2))
        assert {SURFACE_TYPES[code] for code in np.unique(types)} == {name}


def test_a_saddle_is_minimal_in_the_middle_only() -> None:
    mesh = saddle()
    types = surface_types(mesh.k1, mesh.k2, 0.01)
    middle = np.linalg.norm(mesh.vertices, axis=1).argmin()
    assert SURFACE_TYPES[types[middle]] == "minimal"
    assert {"saddle ridge", "saddle valley"} <= {SURFACE_TYPES[code] for code in types}


def test_typical_curvature_of_a_plane_is_that_of_a_sphere_around_it() -> None:
    surface = surface_of(plane())
    zero = np.zeros(len(surface.vertices))
    assert typical_curvature(surface, zero, zero) == pytest.approx(1 / np.sqrt(2))
