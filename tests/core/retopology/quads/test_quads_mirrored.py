"""Quads with a plane of symmetry: exact images, halves, and pieces that lie on one side alone."""

import numpy as np
import pytest
from quad_guarantees import holds
from quad_surfaces import bumpy
from scipy import sparse
from scipy.sparse import csgraph
from surfaces import cylinder, ellipsoid, sphere, torus

import core
from core.retopology.quads.conformity import conformity


@pytest.mark.slow
@pytest.mark.parametrize("symmetry", ["y", "auto"])
def test_symmetric_quads_are_their_own_image(symmetry):
    vertices, triangles = ellipsoid(subdivisions=4).vertices, ellipsoid(subdivisions=4).triangles
    settings = core.RemeshSettings(quads=600, symmetry=symmetry)
    made = core.remesh(vertices, triangles, settings)
    holds(vertices, triangles, made)
    assert not any("mirrored" in said for said in made.warnings)
    assert sorted(made.pole_valence) == [3] * 8
    assert np.array_equal(np.bincount(made.pole_umbilic[made.pole_umbilic >= 0]), [2, 2, 2, 2])
    assert abs(len(made.quads) / 600 - 1) < 0.1
    if symmetry == "y":
        image = {tuple(row) for row in (made.vertices * [1.0, -1.0, 1.0] + 0.0).tolist()}
        assert image == {tuple(row) for row in (made.vertices + 0.0).tolist()}


@pytest.mark.slow
def test_a_surface_is_mirrored_where_it_is_open_and_where_it_is_not_symmetric():
    open_ = cylinder()
    made = core.remesh(
        open_.vertices, open_.triangles, core.RemeshSettings(quads=300, symmetry="x")
    )
    assert holds(open_.vertices, open_.triangles, made).border.any()
    vertices, triangles = bumpy(5)
    made = core.remesh(vertices, triangles, core.RemeshSettings(quads=500, symmetry="z"))
    found = conformity(made.quads, len(made.vertices))
    assert found.manifold and found.characteristic == 2 and not found.border.any()
    assert any("The mirrored half is up to" in said for said in made.warnings)
    far = vertices + np.array([5.0, 0.0, 0.0])
    with pytest.raises(core.RemeshError, match="plane"):
        core.remesh(-far, triangles, core.RemeshSettings(symmetry="x"))


@pytest.mark.slow
@pytest.mark.parametrize("quads", [100, 400])
def test_what_touches_the_plane_of_symmetry_in_a_vertex_is_parted_there(quads):
    """Above the plane through its middle a saddle is two pieces that share a vertex."""
    x, y = np.meshgrid(*[np.linspace(-1.0, 1.0, 41)] * 2)
    vertices = np.stack([x, y, 0.6 * (x**2 - y**2)], axis=-1).reshape(-1, 3)
    row = np.arange(len(vertices)).reshape(41, 41)
    a, b, c, d = (part.ravel() for part in (row[:-1, :-1], row[:-1, 1:], row[1:, 1:], row[1:, :-1]))
    triangles = np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)
    made = core.remesh(vertices, triangles, core.RemeshSettings(quads=quads, symmetry="z"))
    found = conformity(made.quads, len(made.vertices))
    # Each of them with its image is a disk.
    assert found.manifold and found.characteristic == 2 and found.border.any()


def beside_each_other(*places):
    """Spheres of a fifth of the size around a large one, as one mesh."""
    one = sphere(subdivisions=3)
    all_ = [one.vertices] + [0.2 * one.vertices + place for place in places]
    rows = [one.triangles + number * len(one.vertices) for number in range(len(all_))]
    return np.concatenate(all_), np.concatenate(rows)


def pieces_on_sides(made):
    """How many closed pieces of quads lie on the side where x < 0, across x = 0, and beyond it."""
    one, other = made.quads.ravel(), np.roll(made.quads, -1, axis=1).ravel()
    n = len(made.vertices)
    graph = sparse.coo_array((np.ones(len(one)), (one, other)), shape=(n, n))
    count, label = csgraph.connected_components(graph, directed=False)
    along = [made.vertices[label == row, 0] for row in range(count)]
    ends = np.array([[x.min(), x.max()] for x in along])
    return [(ends[:, 1] < 0).sum(), (ends.prod(axis=1) < 0).sum(), (ends[:, 0] > 0).sum()]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("places", "single", "kept", "both"),
    [
        ([[-2.0, 0.0, 0.0]], 1, [1, 1, 0], [1, 1, 1]),
        ([[2.0, 0.0, 0.0]], 1, [0, 1, 1], [1, 1, 1]),
        ([[-2.0, 0.0, 0.0], [-2.0, 0.5, 0.0]], 2, [2, 1, 0], [2, 1, 2]),
        ([[-2.0, 0.0, 0.0], [2.0, 0.6, 0.0]], 2, [1, 1, 1], [2, 1, 2]),
        ([[-2.0, 0.0, 0.0], [2.0, 0.0, 0.0]], 0, [1, 1, 1], [1, 1, 1]),
        ([[-2.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 0.05, 0.0]], 1, [1, 1, 2], [2, 1, 2]),
    ],
)
def test_single_pieces_beside_a_plane_of_symmetry_stay_or_get_an_image(places, single, kept, both):
    """Nothing is lost: what lies on one side alone stays once, or is there twice where that is
    asked for, and the rest is its own image to the last bit."""
    vertices, triangles = beside_each_other(*places)
    for mirror_single, wanted in ((False, kept), (True, both)):
        settings = core.RemeshSettings(quads=400, symmetry="x", mirror_single=mirror_single)
        made = core.remesh(vertices, triangles, settings)
        assert pieces_on_sides(made) == wanted
        topology = conformity(made.quads, len(made.vertices))
        assert topology.manifold and not topology.border.any()
        assert topology.characteristic == 2 * sum(wanted)
        assert len(made.patch) == len(made.angle) == len(made.quads)
        said = [one for one in made.warnings if "plane of symmetry" in one]
        assert not any("mirrored half" in one for one in made.warnings)
        told = 0 if mirror_single else single
        assert [int(one.split()[0]) for one in said] == ([told] if told else [])
        assert abs(len(made.quads) / 400 - 1) < 0.2
        mine = made.vertices[np.abs(made.vertices[:, 0]) < 1.5] + 0.0
        if mirror_single:
            mine = made.vertices + 0.0
        image = {tuple(row) for row in (mine * [-1.0, 1.0, 1.0] + 0.0).tolist()}
        assert image == {tuple(row) for row in mine.tolist()}


@pytest.mark.slow
def test_a_half_is_mirrored_whatever_becomes_of_single_pieces():
    """What is open along the plane is a half, and so is all of a mesh that lies on one side."""
    ring, eye = torus(columns=60, rows=24), sphere(subdivisions=3)
    upper = ring.triangles[(ring.vertices[ring.triangles][:, :, 0] >= -1e-9).all(axis=1)]
    rows = len(ring.vertices) + eye.triangles
    for away, wanted in ((4.0, [1, 1, 1]), (-4.0, [1, 1, 0])):
        places = np.concatenate([ring.vertices, 0.5 * eye.vertices + [away, 0.0, 0.0]])
        settings = core.RemeshSettings(quads=400, symmetry="x")
        made = core.remesh(places, np.concatenate([upper, rows]), settings)
        assert pieces_on_sides(made) == wanted
        assert abs(len(made.quads) / 400 - 1) < 0.2
