"""Patches that stand for the vertices in wide windows."""

import dataclasses

import numpy as np
import pytest
from scipy import sparse
from surfaces import ellipsoid, noisy, random_ellipsoid

from core.base.progress import Progress
from core.curvature.fits.jets import fit_jets
from core.mesh.mending.repair import clean
from core.mesh.neighbourhoods import Neighbourhood
from core.mesh.normals import vertex_normals
from core.mesh.patches import Patches, smoothed
from core.mesh.rings import Begun, adjacency

RINGS = 6
SURFACES = {
    "even": ellipsoid((1.2, 1.1, 1.0), 5),
    "stretched": ellipsoid((6.0, 2.0, 1.0), 5),
    "random": random_ellipsoid(8000),
}


def patched(mesh, stretch=1.0):
    """The surface, its patches, and windows of six rings of them."""
    surface, _ = clean(mesh.vertices, mesh.triangles)
    graph = adjacency(surface)
    patches = Patches(surface, vertex_normals(surface), graph, Progress())
    around = Neighbourhood(
        surface, graph, rings=RINGS, focused=False, stretch=stretch, patching=lambda: patches
    )
    return surface, patches, around


@pytest.mark.parametrize("name", SURFACES)
def test_patches_are_a_few_vertices_each_and_stand_in_their_middle(name):
    surface, patches, _ = patched(SURFACES[name])
    size = np.bincount(patches.patch)
    np.testing.assert_array_equal(patches.size, size)
    assert size.min() >= 1 and 3.0 < size.mean() < 5.0
    for number in range(0, len(size), 50):
        own = surface.vertices[patches.patch == number]
        np.testing.assert_allclose(patches.coordinates[:, number], own.mean(axis=0), atol=1e-12)


def test_the_scatter_is_that_of_the_vertices_about_their_plane():
    share = 0.1
    mesh = noisy(SURFACES["even"], share)
    surface, patches, _ = patched(mesh)
    expected = (share * mesh.edge_length / surface.unit) ** 2
    freedom = len(surface.vertices) - len(patches.size)
    assert patches.scatter.sum() / freedom == pytest.approx(expected, rel=0.2)


@pytest.mark.parametrize("name", SURFACES)
def test_windows_hold_the_nearest_patches(name):
    """All but a few at their rims of those that a search of the whole surface finds."""
    surface, patches, around = patched(SURFACES[name], 3.0 if name == "stretched" else 1.0)
    centres = np.arange(0, len(surface.vertices), 7)
    seen, shares = np.zeros(len(centres), int), []
    for rows, members, _ in around.blocks(centres, 1 << 14):
        seen[rows] += 1
        for row, some in zip(rows, members.T, strict=True):
            offset = patches.coordinates.T - surface.vertices[centres[row]]
            nearest = np.argsort(np.einsum("pc,pc->p", offset, offset))[: len(some)]
            assert len(set(some)) == len(some)
            shares.append(len(set(some) & set(nearest)) / len(some))
    assert (seen == 1).all()
    assert np.mean(shares) > 0.93
    assert np.quantile(shares, 0.01) > 0.75


def test_windows_listed_for_all_scales_are_those_of_each():
    surface, _, around = patched(SURFACES["random"])
    centres, begun = np.arange(0, len(surface.vertices), 50), Begun()
    for rings in (6, 8, 11, 16):
        wide = dataclasses.replace(around, rings=rings)
        lists = []
        for windows in (wide, dataclasses.replace(wide, begun=begun)):
            found = [set()] * len(centres)
            for rows, members, _ in windows.blocks(centres, 1 << 14):
                for row, some in zip(rows, members.T, strict=True):
                    found[row] = set(some)
            lists.append(found)
        alike = [len(one & two) / len(one) for one, two in zip(*lists, strict=True)]
        assert np.mean(alike) > 0.95


def test_windows_hold_no_more_than_the_component():
    surface, patches, around = patched(ellipsoid((1.2, 1.1, 1.0), 1))
    for _, members, _ in around.blocks(np.arange(len(surface.vertices)), 1 << 14):
        assert len(members) <= len(patches.size)


def test_narrow_and_focused_windows_hold_vertices():
    _, _, around = patched(SURFACES["even"])
    for other in ({"rings": 5}, {"focused": True}, {"reach": 1.0}):
        assert dataclasses.replace(around, **other).patches is None
    assert around.patches is not None


def test_fits_to_patches_err_as_those_to_vertices():
    """And tell the same errors."""
    mesh = noisy(SURFACES["even"], 0.1)
    surface, _, around = patched(mesh)
    around = dataclasses.replace(around, rings=8)
    normals, centres = mesh.normal[surface.source_vertex], np.arange(0, len(surface.vertices), 9)
    fits = [
        fit_jets(surface, normals, windows, Progress(), centres)
        for windows in (dataclasses.replace(around, patching=None), around)
    ]
    true = (mesh.k1 - mesh.k2)[surface.source_vertex[centres]] * surface.unit
    by_vertices, by_patches = (np.median(np.abs(fit.k1 - fit.k2 - true)) for fit in fits)
    assert by_patches < 1.1 * by_vertices
    for name in ("noise", "residual", "radius"):
        one, two = (np.median(getattr(fit, name)) for fit in fits)
        assert two == pytest.approx(one, rel=0.12)


def test_normals_are_smoothed_by_area_and_stay_where_they_cancel():
    surface, _, _ = patched(SURFACES["random"])
    n = len(surface.vertices)
    everywhere = sparse.csr_array(np.ones((n, 1), bool))
    normals = np.zeros((n, 3))
    # Two directions, each of as many vertices, but not of as much area.
    large = np.argsort(surface.vertex_area) >= n // 2
    normals[large, 0], normals[~large, 1] = 1.0, 1.0
    areas = [surface.vertex_area[large].sum(), surface.vertex_area[~large].sum(), 0.0]
    found = smoothed(surface, normals, everywhere)
    np.testing.assert_allclose(found, np.tile(areas / np.linalg.norm(areas), (n, 1)), atol=1e-12)
    nothing = smoothed(surface, np.zeros((n, 3)), everywhere)
    np.testing.assert_array_equal(nothing, np.zeros((n, 3)))
