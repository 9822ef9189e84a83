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


@given(st.integers(4, 60), st.integers(0, 2**32 - 1), st.booleans())
@settings(max_examples=20, deadline=None)
def test_no_umbilic_is_invented_on_a_few_points(count, seed, round_body):
    points = np.random.default_rng(seed).normal(size=(count, 3))
    if round_body:
        points *= (3.0, 2.0, 1.0) / np.linalg.norm(points, axis=1)[:, None]
    detection = core.detect(*hull(points))
    assert len(detection.umbilics) == 0
    assert detection.index_sum == detection.expected_index_sum == 2.0
    kinds = {region.kind for region in detection.regions}
    assert kinds == {"unresolved"} or "unresolved" not in kinds
    assert len(detection.warnings) == 1


@pytest.mark.parametrize("subdivisions, few", [(1, True), (2, False), (3, False)])
def test_an_ellipsoid_of_80_triangles_and_finer_ones(subdivisions, few):
    shape = surfaces.ellipsoid(subdivisions=subdivisions)
    detection = core.detect(shape.vertices, shape.triangles)
    assert [region.kind for region in detection.regions] == ["unresolved"] * few
    assert len(detection.umbilics) == (0 if few else 4)
    suits = core.suitability(shape.vertices, shape.triangles, detection)
    assert suits.few == few
    assert suits.is_coarse or not few


def test_a_fine_piece_beside_it_stays_as_it_is():
    fine, coarse = surfaces.ellipsoid(subdivisions=3), surfaces.ellipsoid(subdivisions=1)
    alone = core.detect(fine.vertices, fine.triangles)
    both = core.detect(
        np.concatenate([fine.vertices, coarse.vertices + 9.0]),
        np.concatenate([fine.triangles, coarse.triangles + len(fine.vertices)]),
    )
    assert [region.kind for region in both.regions] == ["unresolved"]
    assert len(both.umbilics) == len(alone.umbilics) == 4
    assert both.index_sum == 4.0
    assert any(text.startswith("1 of 2 pieces have too few") for text in both.warnings)
