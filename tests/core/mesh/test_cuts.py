"""Automatic seams: every surface is opened to disks that a conformal map distorts little."""

import numpy as np
import pytest
from exact_fields import surface_of
from surfaces import ellipsoid, paraboloid, seed_patch, sphere, torus
from surfaces.implicit import genus_two
from surfaces.voxels import marching_tetrahedra

import core
from core.mesh.mending.repair import clean
from core.mesh.unfolding.charts import charts_from_seams, require_disks
from core.mesh.unfolding.cuts import MOST_SCALING, _scaling, opened_to_disks

NONE = np.zeros((0, 2), int)


def with_holes():
    """A patch with three holes in it."""
    mesh = seed_patch(1500, seed=4)
    middle = mesh.vertices[mesh.triangles].mean(axis=1)[:, :2]
    keep = np.ones(len(middle), bool)
    for place in ((0.5, 0.5), (-0.5, 0.2), (0.1, -0.6)):
        keep &= np.linalg.norm(middle - place, axis=1) > 0.2
    return clean(mesh.vertices, mesh.triangles[keep])[0]


def two_parts():
    one, two = torus(), sphere(subdivisions=2)
    vertices = np.concatenate([one.vertices, two.vertices + np.array([10.0, 0, 0])])
    return clean(vertices, np.concatenate([one.triangles, two.triangles + len(one.vertices)]))[0]


def tetrahedron():
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    return clean(points, np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]))[0]


SHAPES = {
    "a sphere": lambda: surface_of(sphere(subdivisions=3)),
    "a long ellipsoid": lambda: surface_of(ellipsoid((8.0, 1.5, 1.0), subdivisions=4)),
    "one handle": lambda: surface_of(torus()),
    "two handles": lambda: clean(*marching_tetrahedra(genus_two(), 24))[0],
    "holes": with_holes,
    "two parts": two_parts,
    "four triangles": tetrahedron,
}


@pytest.mark.parametrize("name", SHAPES)
def test_every_shape_is_opened_to_disks_of_bounded_scale(name):
    surface = SHAPES[name]()
    charts = opened_to_disks(surface, charts_from_seams(surface, NONE))
    require_disks(charts)
    assert charts.count == surface.component_count
    on_border = np.zeros(len(charts.vertex), bool)
    half_edges = np.flatnonzero(charts.border)
    on_border[charts.corners.ravel()[half_edges]] = True
    scaling = _scaling(surface, charts, on_border)
    assert np.abs(scaling).max() <= np.log(MOST_SCALING)


def test_a_disk_that_is_flat_enough_stays_whole():
    surface = surface_of(paraboloid())
    before = charts_from_seams(surface, NONE)
    assert np.array_equal(opened_to_disks(surface, before).border, before.border)


def test_marked_seams_stay_cuts():
    mesh = torus()
    surface = surface_of(mesh)
    seams = mesh.triangles[:40, :2]
    marked = charts_from_seams(surface, seams)
    opened = opened_to_disks(surface, marked)
    require_disks(opened)
    assert opened.border[marked.border].all()


@pytest.mark.parametrize("subdivisions", [4, 5])
def test_method_c_finds_the_lemons_of_a_closed_ellipsoid_without_seams(subdivisions):
    mesh = ellipsoid(subdivisions=subdivisions)
    settings = core.Settings(method="C", curvature="given", persistence=0.0)
    found = core.detect(mesh.vertices, mesh.triangles, settings, given=mesh.curvature).umbilics
    away = np.linalg.norm(found.position[:, None] - mesh.umbilics.position[None], axis=2)
    assert (away.min(axis=0) < mesh.edge_length).all()
    assert found.index.sum() == 2.0


def test_method_s_over_charts_finds_them_too():
    mesh = ellipsoid(subdivisions=4)
    for triangles in ("certified", "published"):
        settings = core.Settings(
            curvature="given", persistence=0.0, parametrization="charts", triangles=triangles
        )
        found = core.detect(mesh.vertices, mesh.triangles, settings, given=mesh.curvature).umbilics
        away = np.linalg.norm(found.position[:, None] - mesh.umbilics.position[None], axis=2)
        assert (away.min(axis=0) < mesh.edge_length).all()
        assert len(found) == 4
