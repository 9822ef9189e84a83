"""Closed pieces of too few vertices to tell their umbilics apart."""

import numpy as np
import pytest
import surfaces
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

import core


def hull(points):
    """Outward triangles of the points' convex hull."""
    shell = ConvexHull(points)
    kept = np.unique(shell.simplices)
    triangles = np.searchsorted(kept, shell.simplices)
    corners = points[kept][triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inwards = (normals * shell.equations[:, :3]).sum(axis=1) < 0.0
    triangles[inwards] = triangles[inwards][:, ::-1]
    return points[kept], triangles


@given(st.integers(4, 60), st.integers(0, 2**32 - 1))
@settings(max_examples=20, deadline=None)
def test_no_umbilic_of_a_few_points_stands_alone(count, seed):
    points = np.random.default_rng(seed).normal(size=(count, 3))
    detection = core.detect(*hull(points))
    assert len(detection.umbilics) != 1
    assert detection.index_sum == detection.expected_index_sum == 2.0
    kinds = {region.kind for region in detection.regions}
    assert kinds == {"unresolved"} or "unresolved" not in kinds
    assert ("unresolved" in kinds) == any("too few vertices" in text for text in detection.warnings)


@pytest.mark.parametrize(
    "axes", [(1.5, 1.2, 1.0), (2.0, 1.5, 1.0), (1.3, 1.15, 1.0), (1.8, 1.3, 1.0), (1.4, 1.25, 1.0)]
)
def test_42_vertices_tell_the_umbilics_of_a_round_ellipsoid(axes):
    shape = surfaces.sphere(subdivisions=1)
    detection = core.detect(shape.vertices * axes, shape.triangles)
    assert detection.umbilics.counts()["lemon"] == len(detection.umbilics) == 4
    assert not detection.regions


def rock():
    """A few vertices of no shape."""
    return hull(np.random.default_rng(13).normal(size=(36, 3)))


def test_one_compound_of_everything_is_a_region_and_coarse():
    vertices, triangles = rock()
    detection = core.detect(vertices, triangles)
    assert [region.kind for region in detection.regions] == ["unresolved"]
    assert len(detection.umbilics) == len(detection.candidates) == 0
    suits = core.suitability(vertices, triangles, detection)
    assert suits.few
    assert suits.is_coarse


def test_a_fine_piece_beside_it_stays_as_it_is():
    fine, (vertices, triangles) = surfaces.ellipsoid(subdivisions=3), rock()
    alone = core.detect(fine.vertices, fine.triangles)
    both = core.detect(
        np.concatenate([vertices + 20.0, fine.vertices]),
        np.concatenate([triangles, fine.triangles + len(vertices)]),
    )
    assert [region.kind for region in both.regions] == ["unresolved"]
    assert len(both.umbilics) == len(alone.umbilics) == 4
    assert both.index_sum == 4.0
    assert any(text.startswith("1 of 2 pieces have too few") for text in both.warnings)
    (paired,) = np.nonzero(both.candidates.partner >= 0)
    assert (both.candidates.partner[both.candidates.partner[paired]] == paired).all()
