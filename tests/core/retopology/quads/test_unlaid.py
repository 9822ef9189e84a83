"""Pieces that no layout is found for are covered all the same."""

import numpy as np
import pytest
from quad_guarantees import broken_guarantees
from surfaces import cylinder, ellipsoid, torus
from surfaces.parts import plate

import core
from core.retopology.quads import preparation
from core.retopology.quads.conformity import conformity
from core.retopology.quads.finishing import finished
from core.retopology.quads.layout import counting


@pytest.fixture
def without_layout(monkeypatch):
    """No layout is ever found."""
    monkeypatch.setattr(preparation, "laid_out", lambda *_: None)


@pytest.mark.slow
@pytest.mark.parametrize(
    "mesh, characteristic, wanted",
    [(ellipsoid(subdivisions=4), 2, 300), (torus(), 0, 600), (cylinder(), 0, 1200)],
    ids=["ellipsoid", "torus", "open cylinder"],
)
def test_a_surface_without_a_layout_is_covered(without_layout, mesh, characteristic, wanted):
    made = core.remesh(mesh.vertices, mesh.triangles, core.RemeshSettings(quads=wanted))
    found = conformity(made.quads, len(made.vertices))
    assert found.manifold
    assert found.characteristic == characteristic
    np.testing.assert_array_equal(found.border, made.border)
    assert made.border.any() == (mesh.name == "cylinder")
    irregular = (found.valence != 4) & ~found.border
    np.testing.assert_array_equal(irregular, made.pole >= 0)
    np.testing.assert_array_equal(found.valence[irregular], made.pole_valence)
    assert not (made.pole_umbilic >= 0).any()
    # Vertices of borders stay, so that there may be some more quads.
    assert 0.9 * wanted < len(made.quads) < 1.3 * wanted
    (said,) = (one for one in made.warnings if "cut into three" in one)
    assert said.startswith("No layout along the curvature was found for 1 piece of the mesh")


@pytest.mark.slow
def test_quads_are_well_shaped_and_on_the_surface(without_layout):
    mesh = ellipsoid(subdivisions=4)
    made = core.remesh(mesh.vertices, mesh.triangles, core.RemeshSettings(quads=300))
    level = ((made.vertices / [3.0, 2.0, 1.0]) ** 2).sum(axis=1)
    assert np.abs(level - 1.0).max() < 0.02
    sides = made.vertices[made.quads]
    normal = np.cross(sides[:, 2] - sides[:, 0], sides[:, 3] - sides[:, 1])
    assert (np.einsum("qc,qc->q", normal, sides.mean(axis=1)) > 0).all()


def ring_of_rods(sides, thin):
    """A ring of straight rods with square sections, of eight triangles each."""
    turn = np.arange(sides) * 2.0 * np.pi / sides
    out, up = np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1), np.array([0.0, 0.0, 1.0])
    around = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    rows = np.arange(sides), np.roll(np.arange(sides), -1)
    triangles = []
    for side in range(4):
        (a, b), (c, d) = (
            [first + row for row in rows] for first in (side * sides, (side + 1) % 4 * sides)
        )
        triangles += [np.stack([a, b, d], axis=1), np.stack([a, d, c], axis=1)]
    vertices = np.concatenate([out + thin * (x * out + y * up) for x, y in around])
    return vertices, np.concatenate(triangles)


@pytest.mark.parametrize("sides, thin, wanted", [(4, 0.02, 30), (4, 0.05, 30), (12, 0.01, 100)])
def test_thin_rods_get_no_more_quads_than_their_triangles_need(
    without_layout, sides, thin, wanted
):
    """Their edges were made short for a map and hardly go again."""
    vertices, triangles = ring_of_rods(sides, thin)
    settings = core.RemeshSettings(quads=wanted, symmetry="none")
    made = core.remesh(vertices, triangles, settings)
    assert len(made.quads) <= 3 * len(triangles)
    assert broken_guarantees(vertices, triangles, made) == []


def test_very_many_rectangles_need_as_many_quads(monkeypatch):
    mesh = ellipsoid(subdivisions=4)
    for quads, laid in ((12, False), (400, True)):
        monkeypatch.setattr(counting, "MOST_RECTANGLES", 10)
        settings = core.RemeshSettings(quads=quads, symmetry="none")
        made = core.remesh(mesh.vertices, mesh.triangles, settings)
        # It is no fault of the mesh, and the preview says so before any quad is made.
        shown = core.quad_layout(mesh.vertices, mesh.triangles, settings)
        for warnings in (made.warnings, shown.warnings):
            assert laid != any("Ask for more quads" in one for one in warnings)
            assert not any(one.startswith("No layout") for one in warnings)
        assert broken_guarantees(mesh.vertices, mesh.triangles, made) == []


@pytest.mark.once
def test_borders_stay_where_they_are(without_layout):
    """A coarse edge of a round border has its middle elsewhere."""
    mesh = cylinder(columns=64)
    made = core.remesh(mesh.vertices, mesh.triangles, core.RemeshSettings(quads=200))
    x, y, z = made.vertices[made.border].T
    assert len(x) < 2 * 64
    np.testing.assert_allclose(np.abs(z), 1.5, atol=1e-9)
    # Sides of the 64-gon, which the input's border is.
    half = np.pi / 64.0
    within = np.mod(np.arctan2(y, x), 2.0 * half) - half
    np.testing.assert_allclose(np.hypot(x, y) * np.cos(within), np.cos(half), atol=1e-9)


@pytest.mark.slow
def test_creases_stay(without_layout):
    vertices, triangles = plate(1, 24, radius=0.2)
    made = core.remesh(vertices, triangles, core.RemeshSettings(quads=400))
    top = np.abs(made.vertices[:, 2]) > 0.05 - 1e-6
    wall = np.abs(np.hypot(*(made.vertices[:, :2] - 0.5).T) - 0.2) < 0.002
    assert made.feature[top & wall].all()
    assert (top & wall).sum() >= 48


@pytest.mark.slow
def test_the_other_pieces_follow_the_curvature(monkeypatch):
    """Of two ellipsoids one has no layout."""
    mesh = ellipsoid(subdivisions=3)
    n = len(mesh.vertices)
    laid_out = preparation.laid_out
    results = iter([None])
    monkeypatch.setattr(preparation, "laid_out", lambda *all_: next(results, laid_out(*all_)))
    vertices = np.concatenate([mesh.vertices, mesh.vertices + np.array([10.0, 0.0, 0.0])])
    triangles = np.concatenate([mesh.triangles, mesh.triangles + n])
    made = core.remesh(vertices, triangles, core.RemeshSettings(quads=600))
    assert conformity(made.quads, len(made.vertices)).characteristic == 4
    sides = [made.vertices[made.quads].mean(axis=1)[:, 0] < 5.0]
    sides.append(~sides[0])
    # The median: beside the umbilics, where curvatures are alike, angles say nothing.
    off = sorted(float(np.nanmedian(made.angle[side])) for side in sides)
    assert off[0] < 2.0 and off[1] > 10.0
    assert abs(len(made.quads) - 600) < 60


@pytest.mark.slow
def test_quads_that_do_not_join_up_are_not_returned(monkeypatch):
    monkeypatch.setattr(finished, "_joins_up", lambda *_: False)
    mesh = ellipsoid(subdivisions=3)
    made = core.remesh(mesh.vertices, mesh.triangles, core.RemeshSettings(quads=200))
    assert conformity(made.quads, len(made.vertices)).manifold
    assert any("cut into three" in one for one in made.warnings)


@pytest.mark.once
def test_a_piece_far_smaller_than_a_quad_does_not_vanish():
    large, small = torus(columns=40, rows=16), ellipsoid(subdivisions=2)
    vertices = np.concatenate([large.vertices, 0.01 * small.vertices + 9.0])
    triangles = np.concatenate([large.triangles, small.triangles + len(large.vertices)])
    made = core.remesh(vertices, triangles, core.RemeshSettings(quads=100))
    found = conformity(made.quads, len(made.vertices))
    assert found.manifold
    assert found.characteristic == 2
    assert (made.vertices > 8.9).all(axis=1).any()


@pytest.mark.slow
def test_few_folds_do_not_cost_the_layout(monkeypatch):
    """Where quads cannot be unfolded a piece is cut only if many are folded."""
    mesh = ellipsoid(subdivisions=3)
    settings = core.RemeshSettings(quads=300)
    whole = core.remesh(mesh.vertices, mesh.triangles, settings)
    quality = finished.oriented_quality
    folded = 1

    def worse(*given):
        found = quality(*given)
        found[:folded] = -1.0
        return found

    monkeypatch.setattr(finished, "oriented_quality", worse)
    monkeypatch.setattr(finished, "_unfolded", lambda *_: None)
    made = core.remesh(mesh.vertices, mesh.triangles, settings)
    assert len(made.pole_valence) == len(whole.pole_valence)
    folded = 200
    made = core.remesh(mesh.vertices, mesh.triangles, settings)
    assert len(made.pole_valence) > len(whole.pole_valence)


def test_pieces_smaller_than_a_quad_are_said_to_be():
    mesh = ellipsoid(subdivisions=3)
    n = len(mesh.vertices)
    vertices = np.concatenate([mesh.vertices, 0.01 * mesh.vertices + [4.0, 0.0, 0.0]])
    triangles = np.concatenate([mesh.triangles, mesh.triangles + n])
    made = core.remesh(vertices, triangles, core.RemeshSettings(quads=300))
    (said,) = (one for one in made.warnings if "cut into three" in one)
    assert said.startswith("1 piece of the mesh smaller than a quad")
    layout = core.quad_layout(vertices, triangles, core.RemeshSettings(quads=300))
    assert said in layout.warnings
