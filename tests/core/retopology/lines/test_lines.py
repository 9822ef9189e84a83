"""Evenly spaced lines of curvature: where they run, how densely and how smoothly."""

import dataclasses

import numpy as np
import pytest
from line_guides import MESHES, guide_of, guided, lines_of, rough_guide, turning
from scipy.spatial import cKDTree
from surfaces import ellipsoid, noisy, random_ellipsoid, sphere, torus

import core
from core.retopology.lines.streamlines import AUTO_SPACING


@pytest.mark.once
@pytest.mark.parametrize("name", ["ellipsoid", "torus", "cylinder"])
def test_lines_are_evenly_spaced(name):
    mesh, lines = MESHES[name], lines_of(name)
    corner = mesh.vertices[mesh.triangles]
    area = (
        0.5
        * np.linalg.norm(
            np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1
        ).sum()
    )
    spacing = AUTO_SPACING * np.sqrt(area)
    for family in (0, 1):
        some = lines.select(lines.family == family)
        assert len(some) > 5
        line = np.repeat(np.arange(len(some)), np.diff(some.start))
        tree = cKDTree(some.position)
        pairs = tree.query_pairs(0.4 * spacing, output_type="ndarray")
        apart = line[pairs[:, 0]] != line[pairs[:, 1]]
        assert apart.mean() < 0.005
        # No place of the surface is far from a line.
        distance, _ = tree.query(mesh.vertices)
        assert np.quantile(distance, 0.97) < 1.3 * spacing
        assert np.median(distance) < 0.5 * spacing


@pytest.mark.once
def test_lines_of_the_torus_are_its_circles():
    lines = lines_of("torus")
    for number in range(len(lines)):
        x, y, z = lines.points(number).T
        if lines.family[number] == 0:  # the tube: an angle around the axis is kept
            assert np.ptp(np.unwrap(np.arctan2(y, x))) < 0.02
        else:
            assert np.ptp(z) < 0.05  # over a length of up to 17; an edge is 0.1
    assert lines.closed.mean() > 0.6
    assert lines.closed[lines.family == 1].mean() > 0.9


@pytest.mark.once
def test_points_lie_in_their_triangles():
    mesh = random_ellipsoid(5000)
    lines = guided(mesh).lines()
    corner = mesh.vertices[mesh.triangles[lines.triangle]]
    there = np.einsum("pk,pkc->pc", lines.barycentric, corner)
    assert np.abs(there - lines.position).max() < 1e-9
    assert (lines.barycentric >= 0).all()
    assert np.allclose(lines.barycentric.sum(axis=1), 1.0)
    # So do the chords that end at them, but where points in between were left out.
    first = np.isin(np.arange(len(lines.position)), lines.start[:-1])
    middle = 0.5 * (lines.position + np.roll(lines.position, 1, axis=0))
    a, b, c = np.moveaxis(corner, 1, 0)
    normal = np.cross(b - a, c - a)
    inside = [
        np.einsum("pc,pc->p", np.cross(two - one, middle - one), normal)
        for one, two in ((a, b), (b, c), (c, a))
    ]
    beside = np.min(inside, axis=0) < -1e-6 * np.einsum("pc,pc->p", normal, normal)
    assert beside[~first].mean() < 0.15


@pytest.mark.once
def test_no_chord_is_without_length():
    for lines in (lines_of("random ellipsoid"), rough_guide().lines()):
        first = np.isin(np.arange(len(lines.position)), lines.start[:-1])
        step = np.linalg.norm(lines.position - np.roll(lines.position, 1, axis=0), axis=1)[~first]
        assert step.min() > 1e-6 * np.median(step)


@pytest.mark.once
def test_no_line_turns_sharply():
    mesh, lines = MESHES["ellipsoid"], lines_of("ellipsoid")
    for number in range(len(lines)):
        step = np.diff(lines.points(number), axis=0)
        step = step[np.linalg.norm(step, axis=1) > 0.2 * mesh.edge_length]
        step /= np.linalg.norm(step, axis=1, keepdims=True)
        assert np.einsum("ij,ij->i", step[1:], step[:-1]).min(initial=1.0) > 0.6


@pytest.mark.slow
@pytest.mark.parametrize("name", ["fine ellipsoid", "torus"])
def test_closed_lines_close_without_a_kink(name):
    lines = lines_of(name)
    assert lines.closed.mean() > 0.6
    for number in np.flatnonzero(lines.closed):
        points = lines.points(number)
        step = np.diff(np.vstack([points[-4:], points[:4]]), axis=0)
        step /= np.linalg.norm(step, axis=1, keepdims=True)
        assert np.einsum("ij,ij->i", step[1:], step[:-1]).min() > 0.5


@pytest.mark.once
def test_sphere_says_that_it_has_no_direction():
    guide = guided(sphere())
    with pytest.raises(core.GuidanceError, match="no preferred direction"):
        guide.lines()
    assert len(guide.separatrices()) == 0


@pytest.mark.once
def test_one_family_alone():
    guide = guided(torus(columns=60, rows=24))
    for family, name in enumerate(("first", "second")):
        lines = guide.lines(core.GuidanceSettings(families=name))
        assert set(lines.family) == {family}


@pytest.mark.slow
def test_spacing_is_in_length():
    guide = guided(torus(columns=60, rows=24))
    counts = [len(guide.lines(core.GuidanceSettings(spacing=s))) for s in (0.2, 0.4)]
    assert counts[0] > 1.6 * counts[1]


@pytest.mark.slow
def test_smoothing_lengthens_the_lines_of_a_noisy_surface():
    guide = rough_guide()
    lengths = [
        np.median(guide.lines(core.GuidanceSettings(line_smoothness=s)).length) for s in (0.0, 0.6)
    ]
    assert lengths[1] > 1.2 * lengths[0]


@pytest.mark.slow
def test_smoothing_a_clean_surface_changes_little():
    lines = guide_of("torus").lines(core.GuidanceSettings(line_smoothness=0.4))
    for number in np.flatnonzero(lines.family == 0):
        x, y, _ = lines.points(number).T
        assert np.ptp(np.unwrap(np.arctan2(y, x))) < 0.02


def vase(columns, rows, jitter=0.0, seed=0):
    """r = 2 + cos z for |z| < 2 pi: meridians and parallels change families where |cos z| = 1 / r,
    on circles of umbilics."""
    z, around = np.meshgrid(
        np.linspace(-2 * np.pi, 2 * np.pi, rows), np.arange(columns), indexing="ij"
    )
    random = np.random.default_rng(seed)
    inner = np.abs(z) < 2 * np.pi - 1e-9
    z = z + inner * jitter * random.uniform(-1, 1, z.shape) * 4 * np.pi / (rows - 1)
    angle = 2 * np.pi / columns * (around + jitter * random.uniform(-1, 1, z.shape))
    r = 2.0 + np.cos(z)
    points = np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=2).reshape(-1, 3)
    below = (np.arange(rows - 1)[:, None] * columns + np.arange(columns)).ravel()
    aside = (np.arange(rows - 1)[:, None] * columns + (np.arange(columns) + 1) % columns).ravel()
    return points, np.concatenate(
        [np.c_[below, aside, aside + columns], np.c_[below, aside + columns, below + columns]]
    )


@pytest.mark.slow
@pytest.mark.parametrize("columns, rows, jitter", [(128, 257, 0.0), (64, 129, 0.0), (96, 193, 0.3)])
def test_lines_do_not_turn_on_circles_of_umbilics(columns, rows, jitter):
    vertices, triangles = vase(columns, rows, jitter)
    lines = core.Guide(vertices, triangles, core.detect(vertices, triangles)).lines()
    turning = 0
    for number in range(len(lines)):
        points = lines.points(number)
        step, middle = np.diff(points, axis=0), 0.5 * (points[1:] + points[:-1])
        length = np.linalg.norm(step, axis=1)
        radius = np.linalg.norm(middle[:, :2], axis=1)
        slope = -np.sin(middle[:, 2])
        meridian = np.c_[slope[:, None] * middle[:, :2] / radius[:, None], np.ones(len(middle))]
        meridian /= np.linalg.norm(meridian, axis=1, keepdims=True)
        along = np.abs(np.einsum("ij,ij->i", step, meridian)) / np.maximum(length, 1e-12)
        shares = [length[along > 0.9].sum(), length[along < 0.42].sum()]
        turning += min(shares) > 0.15 * length.sum()
    assert len(lines) > 150 and turning == 0


@pytest.mark.slow
def test_automatic_smoothness_goes_by_the_noise_of_the_directions():
    mesh = ellipsoid(subdivisions=4)
    clean, exact = guided(mesh), core.GuidanceSettings(line_smoothness=0.0)
    assert np.array_equal(clean.lines().position, clean.lines(exact).position)
    unknown = np.full_like(clean.detection.curvature.noise, np.nan)
    curvature = dataclasses.replace(clean.detection.curvature, noise=unknown)
    blind = dataclasses.replace(clean.detection, curvature=curvature)
    lines = core.Guide(mesh.vertices, mesh.triangles, blind).lines()
    assert np.array_equal(lines.position, clean.lines(exact).position)
    rough = noisy(mesh, 0.05)
    # Operators that come without an error tell it by how neighbours differ.
    by_normals = core.detect(rough.vertices, rough.triangles, core.Settings(curvature="normals"))
    assert np.isnan(by_normals.curvature.noise).all()
    guide = core.Guide(rough.vertices, rough.triangles, by_normals)
    assert not np.array_equal(guide.lines().position, guide.lines(exact).position)
    # Fits over two rings follow the noise; a little more, and their field would be smoothed first.
    rough = noisy(mesh, 0.03)
    detection = core.detect(rough.vertices, rough.triangles, core.Settings(scale=2.0))
    guide = core.Guide(rough.vertices, rough.triangles, detection)
    found, wild = (
        turning(guide.separatrices(one, both_ways=True), 2 * mesh.edge_length)
        for one in (core.GuidanceSettings(), exact)
    )
    assert found < 0.9 * wild
