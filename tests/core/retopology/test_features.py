"""Features: creases go on as chains, accidents of the triangulation do not, marks always count."""

import numpy as np
import pytest
from exact_fields import surface_of
from shapes import cube, rounded_box
from surfaces import ellipsoid, noisy, plane, random_ellipsoid
from surfaces.parts import plate, turned

import core
from core.base.progress import Progress
from core.mesh.creases import bent_half_edges
from core.mesh.mending.repair import clean
from core.retopology.crease_chains import crease_chains
from core.retopology.features import BORDER, CREASE, MARK, find_features, flat_faces
from core.retopology.settings import GuidanceSettings


def prism(sides, rings=3):
    """A closed prism with regular polygons at its ends, radius and half height 1."""
    angle = 2 * np.pi * np.arange(sides) / sides
    rim = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    wall = [np.column_stack([rim, np.full(sides, z)]) for z in np.linspace(-1, 1, rings)]
    points = np.concatenate([*wall, [[0, 0, -1], [0, 0, 1]]])
    i, triangles = np.arange(sides), []
    j = (i + 1) % sides
    for ring in range(rings - 1):
        low, high = ring * sides, (ring + 1) * sides
        triangles += [np.stack([low + i, low + j, high + j], axis=1)]
        triangles += [np.stack([low + i, high + j, high + i], axis=1)]
    last = (rings - 1) * sides
    triangles += [np.stack([j, i, np.full(sides, len(points) - 2)], axis=1)]
    triangles += [np.stack([last + i, last + j, np.full(sides, len(points) - 1)], axis=1)]
    return points, np.concatenate(triangles)


def edges_of(surface, half_edges):
    """(e, 2) sorted input vertices."""
    tail = surface.triangles.ravel()[half_edges]
    head = surface.triangles[:, [1, 2, 0]].ravel()[half_edges]
    return np.sort(surface.source_vertex[np.stack([tail, head], axis=1)], axis=1)


@pytest.mark.parametrize("noise", [0.05, 0.1])
def test_bent_edges_of_a_rough_surface_are_no_features(noise):
    surface = surface_of(noisy(random_ellipsoid(3000), noise))
    bent = len(bent_half_edges(surface, 40.0))
    assert bent > 100
    assert len(crease_chains(surface, 40.0).half_edge) <= 0.06 * bent


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_chains_that_noise_makes_are_no_creases(seed):
    """Beside flat triangles noise bends edges as far as any crease; and where many are bent, some
    are so in a row."""
    mesh = random_ellipsoid(3000, (1.3, 1.0, 0.8), seed)
    for noise in (0.05, 0.1):
        surface = surface_of(noisy(mesh, noise, seed))
        assert len(crease_chains(surface, 40.0).half_edge) == 0


@pytest.mark.parametrize("cells", [1, 2, 3, 8])
@pytest.mark.parametrize("noise", [0.0, 0.03])
def test_all_edges_of_a_cube_are_features(cells, noise):
    vertices, triangles = cube(cells)
    moved = np.random.default_rng(1).normal(size=vertices.shape) * noise * 2 / cells
    surface, _ = clean(vertices + moved, triangles)
    found = edges_of(surface, crease_chains(surface, 40.0).half_edge)
    one, two = vertices[found[:, 0]], vertices[found[:, 1]]
    # Both coordinates that an edge of the cube has in common are those of its sides.
    assert (((one == two) & (np.abs(one) == 1)).sum(axis=1) == 2).all()
    assert len(found) == 12 * cells


@pytest.mark.parametrize("sides", [6, 8, 12, 48])
def test_rims_of_a_can_are_features(sides):
    points, triangles = prism(sides)
    surface, _ = clean(points, triangles)
    chains = crease_chains(surface, 40.0)
    height = points[edges_of(surface, chains.half_edge), 2]
    assert ((height == 1).all(axis=1)).sum() == sides
    assert ((height == -1).all(axis=1)).sum() == sides
    # Walls of a hexagon and an octagon meet at 60 and 45 degrees.
    walls = 2 * sides if 360 / sides > 40 else 0
    assert len(chains.half_edge) == 2 * sides + walls


def halved(first, last):
    """A convex polygon's triangles, its corners numbered, as Blender cuts it: in halves."""
    if last - first < 2:
        return []
    middle = (first + last) // 2
    return [(last, middle, first), *halved(first, middle), *halved(middle, last)]


@pytest.mark.parametrize("sides", [16, 32, 64, 128])
@pytest.mark.parametrize("depth", [0.5, 2.0])
def test_the_rim_of_a_plane_face_is_a_feature_however_thin_its_triangles(sides, depth):
    """Blender's cone: noise that would bend the thin triangles of its base so far would not have
    left that plane."""
    angle = 2 * np.pi * np.arange(sides) / sides
    rim = np.stack([np.cos(angle), np.sin(angle), np.zeros(sides)], axis=1)
    i = np.arange(sides)
    wall = np.stack([i, (i + 1) % sides, np.full(sides, sides)], axis=1)
    triangles = np.concatenate([wall, halved(0, sides - 1)])
    surface, _ = clean(np.concatenate([rim, [[0.0, 0.0, depth]]]), triangles)
    found = find_features(surface, GuidanceSettings())
    assert len(found.half_edge) == sides


def test_a_crease_that_fades_out_is_followed_as_far_as_it_is_sharp():
    x, y = np.meshgrid(np.linspace(0, 1, 41), np.linspace(-0.5, 0.5, 21))
    steep = np.tan(np.radians(45)) * (1 - x)
    points = np.stack([x, y, -steep * np.abs(y)], axis=-1).reshape(-1, 3)
    row = np.arange(20)[:, None] * 41 + np.arange(40)
    a = row.ravel()
    triangles = np.concatenate(
        [np.stack([a, a + 1, a + 42], axis=1), np.stack([a, a + 42, a + 41], axis=1)]
    )
    surface, _ = clean(points, triangles)
    found = points[edges_of(surface, crease_chains(surface, 40.0).half_edge)]
    assert np.abs(found[..., 1]).max() == 0.0
    # Both sides fall by arctan(1 - x): together more than 40 degrees up to x = 0.636.
    assert found[..., 0].min() == 0.0
    assert 0.6 < found[..., 0].max() < 0.72


def test_marks_and_borders_are_features_however_short():
    mesh = plane()
    surface = surface_of(mesh)
    marked = mesh.triangles[len(mesh.triangles) // 2][None, :2]
    features = find_features(surface, GuidanceSettings(), marked)
    assert np.count_nonzero(features.kind == MARK) == 1
    assert np.count_nonzero(features.kind == BORDER) == np.count_nonzero(surface.twin < 0)
    assert (features.chain[features.kind != CREASE] == -1).all()
    without = GuidanceSettings(align_sharp=False, align_borders=False)
    assert len(find_features(surface, without, marked).half_edge) == 0


def test_chains_are_named_edge_by_edge():
    vertices, triangles = cube(4)
    surface, _ = clean(vertices, triangles)
    features = find_features(surface, GuidanceSettings())
    assert (features.kind == CREASE).all()
    chain, count = np.unique(features.chain, return_counts=True)
    assert len(chain) == 12 and (count == 4).all()


@pytest.mark.slow
def test_crests_draw_the_field_where_it_is_asked_for():
    vertices, triangles = rounded_box(5)
    guide = core.Guide(vertices, triangles, core.detect(vertices, triangles))
    assert len(guide.features(GuidanceSettings()).crest_vertex) == 0
    asked = GuidanceSettings(smoothness=0.2, align_crests=True)
    features = guide.features(asked, Progress())
    assert len(features.half_edge) == 0 and len(features.crest_vertex) > 50
    assert ((features.crest_weight > 0) & (features.crest_weight <= 1)).all()
    near = np.sort(np.abs(guide.surface.vertices[features.crest_vertex]), axis=1)
    assert np.median(near[:, 2] - near[:, 1]) < 0.05
    guidance = guide.guidance(GuidanceSettings(smoothness=0.8, align_crests=True))
    assert guidance.index_sum == 2.0


@pytest.mark.slow
@pytest.mark.parametrize(
    "mesh",
    [
        ellipsoid(subdivisions=4),
        ellipsoid((1.3, 1.0, 0.8), 4),
        random_ellipsoid(3000),
        random_ellipsoid(5000),
        noisy(ellipsoid(subdivisions=4), 0.02),
        noisy(random_ellipsoid(2000, (1.3, 1.0, 0.8)), 0.05),
        noisy(random_ellipsoid(3000), 0.05),
        noisy(random_ellipsoid(3000, (2.0, 1.5, 1.0)), 0.1),
    ],
    ids=["3 2 1", "1.3 1 .8", "random", "finer", "2 %", "round, 5 %", "random, 5 %", "10 %"],
)
def test_an_ellipsoid_has_eight_poles_at_every_smoothness(mesh):
    guide = core.Guide(mesh.vertices, mesh.triangles, core.detect(mesh.vertices, mesh.triangles))
    for smoothness in (0.0, 0.2, 0.45, 0.7, 1.0):
        poles = guide.guidance(GuidanceSettings(smoothness=smoothness)).poles
        assert len(poles) == 8 and poles.total == 8


def on_foot(radius, height, around=32):
    """A turned body cut off below, the foot a fan of triangles without a vertex inside."""
    vertices, triangles = turned(radius, height, around)
    i = np.arange(1, around - 1)
    foot = np.stack([0 * i, i + 1, i], axis=1)
    return vertices[1:], np.concatenate([triangles[around:] - 1, foot])


def dome():
    """Half an ellipsoid on its flat foot."""
    angle = np.linspace(0.0, np.pi / 2, 12)
    vertices, triangles = on_foot(np.append(0.0, np.cos(angle)), np.append(0.0, np.sin(angle)))
    return vertices * (1.4, 1.0, 0.8), triangles


def test_flat_faces_are_known_from_facets_of_round_ones():
    """All of a plate but the wall of its hole, and the foot of a can but not its wall."""
    vertices, triangles = plate(1, 24)
    hole = np.hypot(*(vertices[triangles].mean(axis=1)[:, :2].T - 0.5)) < 0.125
    can = on_foot(np.array([0, 1, 1, 0.9, 0]), np.array([0, 0, 1, 1.02, 1.04]))
    for (points, faces), flat in (
        ((vertices, triangles), ~hole),
        (can, np.ptp(can[0][can[1]][:, :, 2], axis=1) == 0.0),
    ):
        surface, _ = clean(points, faces)
        found = flat_faces(surface, find_features(surface, GuidanceSettings()))
        assert np.array_equal(found, flat[surface.source_triangle])


def test_flat_faces_have_no_lines():
    """They were drawn over the foot from chance, and a thousand over the twelve triangles of a
    cube."""
    vertices, triangles = dome()
    lines = core.Guide(vertices, triangles, core.detect(vertices, triangles)).lines()
    height = vertices[triangles[lines.triangle], 2]
    assert len(lines) > 20 and height.any(axis=1).all()
    guide = core.Guide(*cube(1), core.detect(*cube(1)))
    with pytest.raises(core.GuidanceError, match="no preferred direction"):
        guide.lines()
