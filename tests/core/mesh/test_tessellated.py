"""Tessellated parts: exact faces are regions of their kind, and nothing else is taken for one."""

import numpy as np
import pytest
import surfaces
from hypothesis import given, settings
from hypothesis import strategies as st
from mesh_files import read_mesh
from surfaces.parts import plate, turned

import core
from core.mesh.mending.repair import clean
from core.mesh.tessellated import tessellation


def moved(vertices: np.ndarray, seed: int) -> np.ndarray:
    """Turned, scaled and moved at random, in single precision as files have it."""
    random = np.random.default_rng(seed)
    turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    scale = 10.0 ** random.uniform(-2, 2)
    place = scale * (vertices @ turn.T + random.normal(size=3))
    return place.astype(np.float32).astype(float)


def kinds_of(detection: core.Detection) -> dict[str, int]:
    kinds = [region.kind for region in detection.regions]
    return {kind: kinds.count(kind) for kind in set(kinds)}


@pytest.mark.parametrize("holes, around", [(1, 12), (3, 24), (4, 32), (2, 90)])
def test_a_plate_with_holes(holes, around):
    vertices, triangles = plate(holes, around)
    detection = core.detect(vertices, triangles)
    assert kinds_of(detection) == {"planar": 6, "cylindrical": holes**2}
    assert len(detection.candidates) == 0
    assert detection.index_sum == detection.expected_index_sum == 2.0 - 2 * holes**2
    covered = np.concatenate([region.triangles for region in detection.regions])
    np.testing.assert_array_equal(np.sort(covered), np.arange(len(triangles)))
    for region in detection.regions:
        wanted = 0.0 if region.kind == "planar" else -0.5 / 0.12
        assert region.curvature == pytest.approx(wanted, rel=0.02, abs=1e-9)
    (warning,) = detection.warnings
    assert warning.startswith("The mesh is a tessellated part: 6 planar faces")


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=10)
def test_wherever_it_lies_and_in_single_precision(seed):
    vertices, triangles = plate(2, 20)
    detection = core.detect(moved(vertices, seed), triangles)
    assert kinds_of(detection) == {"planar": 6, "cylindrical": 4}
    assert len(detection.candidates) == 0


@pytest.mark.parametrize("seed", range(3))
def test_cone_cylinder_and_dome(seed):
    """Flat base, cylinder, a step, cone, a step, half a sphere."""
    dome = np.pi / 2 * np.arange(1, 9) / 9
    radius = np.concatenate([[0, 2, 2, 1.5, 1.0, 0.5], 0.5 * np.cos(dome), [0]])
    height = np.concatenate([[0, 0, 1, 1, 3, 3.0], 3.0 + 0.5 * np.sin(dome), [3.5]])
    vertices, triangles = turned(radius, height, 48)
    detection = core.detect(moved(vertices, seed), triangles)
    assert kinds_of(detection) == {"planar": 3, "cylindrical": 1, "conical": 1, "spherical": 1}
    assert len(detection.candidates) == 0
    (ball,) = [region for region in detection.regions if region.kind == "spherical"]
    (wall,) = [region for region in detection.regions if region.kind == "cylindrical"]
    assert ball.curvature / wall.curvature == pytest.approx(2.0 / 0.25, rel=0.02)
    assert ball.area / wall.area == pytest.approx(0.5**2 / 2.0, rel=0.02)


def box() -> tuple[np.ndarray, np.ndarray]:
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return corners, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


@pytest.mark.parametrize(
    "mesh, kinds",
    [
        (box(), {"planar": 6}),
        (turned(np.array([0, 1, 0]), np.array([-1, -1, 1]), 32), {"planar": 1, "conical": 1}),
        (turned(np.array([0, 1, 1, 0]), np.array([-1, -1, 1, 1]), 6), {"planar": 8}),
    ],
    ids=["cube", "cone", "prism"],
)
def test_few_quads_between_creases_are_a_part(mesh, kinds):
    detection = core.detect(*mesh)
    assert kinds_of(detection) == kinds
    assert len(detection.umbilics) == 0
    assert detection.index_sum == 2.0


def pyramid(sides: int) -> tuple[np.ndarray, np.ndarray]:
    """Upright, its base a fan of triangles: a tetrahedron if it has three sides."""
    angle = 2 * np.pi * np.arange(sides) / sides
    base = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(sides)])
    walls = [(j, (j + 1) % sides, sides) for j in range(sides)]
    floor = [(0, j + 1, j) for j in range(1, sides - 1)]
    return np.concatenate([base, [[0.0, 0.0, 2.0]]]), np.array(walls + floor)


@pytest.mark.parametrize(
    "mesh, faces",
    [
        (pyramid(3), 4), (pyramid(4), 5), (pyramid(5), 6), (pyramid(7), 8),
        (surfaces.icosphere(0), 20),
        (turned(np.array([0, 1, 0]), np.array([-2.0, 0, 2.0]), 5), 10),
    ],
    ids=["tetrahedron", "pyramid", "of five", "of seven", "icosahedron", "two pyramids"],
)  # fmt: skip
@pytest.mark.parametrize("seed", range(2))
def test_a_polyhedron_is_its_faces(mesh, faces, seed):
    """All of its edges are creases, whatever share of the edges of triangles is flat."""
    detection = core.detect(moved(mesh[0], seed), mesh[1])
    assert kinds_of(detection) == {"planar": faces}
    assert len(detection.candidates) == 0
    assert detection.index_sum == 2.0
    (warning,) = detection.warnings
    assert "If it stands for a round body" in warning


@pytest.mark.parametrize("around", [11, 12, 16, 24])
@pytest.mark.parametrize("top", [0.0, 0.4])
def test_cones_of_few_segments(around, top):
    """Vertices lie on a steeper cone than facets touch."""
    profile = [(0, -1), (1.0, -1)] + ([(top, 1.0)] if top else []) + [(0, 1.0)]
    radius, height = np.array(profile, float).T
    vertices, triangles = turned(radius, height, around)
    detection = core.detect(vertices, triangles)
    assert kinds_of(detection) == {"planar": 2 if top else 1, "conical": 1}
    assert len(detection.candidates) == 0
    (cone,) = [region for region in detection.regions if region.kind == "conical"]
    # Half of one over the radius, along the slope, where most vertices are.
    at = 0.5 * (1.0 + top) if top else 1.0
    steep = np.cos(np.arctan(0.5 * (1.0 - top)))
    assert cone.curvature == pytest.approx(0.5 * steep / at, rel=0.05)


def test_round_faces_that_leave_flat_ones_without_a_crease():
    """A slab whose four upright edges are rounded: eight facets of ten degrees and more."""
    angle = np.concatenate([np.arange(9) * np.pi / 16 + k * np.pi / 2 for k in range(4)])
    corner = np.repeat([(1, 1), (-1, 1), (-1, -1), (1, -1)], 9, axis=0) * (2.0, 1.0)
    rim = corner + 0.3 * np.column_stack([np.cos(angle), np.sin(angle)])
    n = len(rim)
    top, bottom = np.full(n, 0.5), np.full(n, -0.5)
    vertices = np.concatenate([np.column_stack([rim, top]), np.column_stack([rim, bottom])])
    j = np.arange(n)
    k = (j + 1) % n
    fan = np.stack([0 * j[1:-1], j[1:-1], j[2:]], axis=1)
    triangles = np.concatenate([
        fan, fan[:, ::-1] + n, np.stack([k, j, j + n], axis=1), np.stack([k, j + n, k + n], axis=1)
    ])  # fmt: skip
    detection = core.detect(vertices, triangles)
    assert kinds_of(detection) == {"planar": 6, "cylindrical": 4}
    assert len(detection.candidates) == 0
    for region in detection.regions:
        if region.kind == "cylindrical":
            assert region.curvature == pytest.approx(0.5 / 0.3, rel=0.02)


def test_a_crease_angle_by_hand_parts_the_faces_too():
    vertices, triangles = plate(2, 24)
    by_hand = core.detect(vertices, triangles, core.Settings(crease_angle=50.0))
    assert kinds_of(by_hand) == {"planar": 6, "cylindrical": 4}
    across = core.detect(vertices, triangles, core.Settings(crease_angle=180.0))
    assert not kinds_of(across).get("cylindrical")


def globe(segments: int, rings: int) -> tuple[np.ndarray, np.ndarray]:
    theta = np.pi * np.arange(rings + 1) / rings
    return turned(np.sin(theta), -np.cos(theta), segments)


@pytest.mark.parametrize(
    "mesh",
    [
        globe(16, 50), globe(64, 32), globe(12, 12),
        (globe(16, 200)[0] * (3, 2, 1), globe(16, 200)[1]),
        (globe(48, 24)[0] * (3, 2, 1), globe(48, 24)[1]),
    ],
    ids=["16x50", "64x32", "12x12", "ellipsoid 16x200", "ellipsoid 48x24"],
)  # fmt: skip
def test_quads_of_a_round_body_are_no_part(mesh):
    """A third of their edges is flat, exactly as on CAD."""
    surface, _ = clean(*mesh)
    assert tessellation(surface) is None
    assert tessellation(surface, 5.0) is None


def test_without_a_gap_no_angle_makes_facets(meshes_folder):
    """Its faces are round and free-form, its edges sharp to smooth, and two in five are flat."""
    path = meshes_folder / "fandisk.obj"
    if not path.is_file():
        pytest.skip("the fandisk is not in the folder of meshes")
    surface, _ = clean(*read_mesh(path))
    assert tessellation(surface) is None
    assert tessellation(surface, 30.0) is None


@pytest.mark.once
@pytest.mark.parametrize(
    "shape",
    [
        surfaces.ellipsoid(subdivisions=4), surfaces.torus(), surfaces.plane(),
        surfaces.noisy(surfaces.ellipsoid(subdivisions=4), 0.3), surfaces.seed_patch(grid=True),
        surfaces.cylinder(),
    ],
    ids=lambda shape: shape.name,
)  # fmt: skip
def test_smooth_and_noisy_surfaces_are_no_part(shape):
    surface, _ = clean(shape.vertices, shape.triangles)
    assert tessellation(surface) is None
    found = core.detect(shape.vertices, shape.triangles)
    across = core.detect(shape.vertices, shape.triangles, core.Settings(crease_angle=180.0))
    np.testing.assert_array_equal(found.curvature.k1, across.curvature.k1)
    assert found.warnings == across.warnings


def test_free_form_faces_keep_their_umbilics():
    """A bump of an ellipsoid stands on a flat plate that carries most of the area."""
    points, triangles = surfaces.grid_points(60, 60, (-1.0, -1.0), (1.0, 1.0))
    x, y = points.T
    inside = 1.0 - (x / 0.6) ** 2 - (y / 0.45) ** 2
    height = np.where(inside > 0, 0.8 * np.sqrt(np.maximum(inside, 0.0)), 0.0)
    detection = core.detect(np.column_stack([points, height]), triangles)
    for region in detection.regions:
        if region.kind == "planar":
            corners = triangles[region.triangles]
            assert (height[corners] < 0.05).mean() > 0.9


@pytest.mark.slow
def test_a_part_as_written_by_a_program(meshes_folder):
    path = meshes_folder / "cad_tray_tm.stl"
    if not path.is_file():
        pytest.skip("the tray is not in the folder of meshes")
    detection = core.detect(*read_mesh(path))
    found = kinds_of(detection)
    assert found["planar"] == 20 and found["cylindrical"] == 40
    assert len(detection.umbilics) == 0
    assert detection.index_sum == -44.0


@pytest.mark.once
def test_cylinders_and_cones_have_exact_directions():
    vertices, triangles = turned(np.array([0, 2, 2, 1.0, 0]), np.array([0, 0, 3, 5, 5.0]), 40)
    detection = core.detect(vertices, triangles)
    assert kinds_of(detection) == {"planar": 2, "cylindrical": 1, "conical": 1}
    assert detection.index_sum == 2.0
    field = detection.curvature
    low = np.isclose(vertices[:, 2], 0.0) & (np.hypot(*vertices[:, :2].T) > 1.0)
    np.testing.assert_allclose(field.k1[low], 0.5, rtol=0.01)
    np.testing.assert_allclose(field.k2[low], 0.0, atol=1e-9)
    np.testing.assert_allclose(np.abs(field.d2[low, 2]), 1.0, atol=1e-6)
    guide = core.Guide(vertices, triangles, detection)
    assert np.isfinite(guide.guidance().direction).all()
    lines = guide.lines()
    # Lines run along the cylinder or around it, and leave the flat ends alone.
    assert len(lines) > 0
    wall = (lines.position[:, 2] > 0.1) & (lines.position[:, 2] < 2.9)
    assert wall.any()
