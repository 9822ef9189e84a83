"""Method S in the coordinates of any map: the umbilics do not depend on it."""

import numpy as np
import pytest
import surfaces

import core

MAPS = {
    "the plane itself": lambda x, y: (x, y),
    "stretched": lambda x, y: (3.0 * x, y),
    "sheared": lambda x, y: (x + 1.5 * y, y),
    "bent": lambda x, y: (x + 0.3 * y**2, y - 0.2 * x**2),
    "mirrored": lambda x, y: (-x, y),
}


@pytest.fixture(scope="module")
def patch():
    return surfaces.seed_patch(5400, seed=1)


def detected(mesh, settings, uv=None):
    return core.detect(
        mesh.vertices, mesh.triangles, settings, given=mesh.curvature, uv=uv
    ).umbilics


def uv_of(mesh, name):
    x, y = MAPS[name](mesh.vertices[:, 0], mesh.vertices[:, 1])
    return np.stack([x, y], axis=1)[mesh.triangles]


@pytest.mark.parametrize("triangles", ["certified", "published"])
@pytest.mark.parametrize("name", MAPS)
def test_the_patch_has_its_three_umbilics_in_any_coordinates(patch, name, triangles):
    settings = core.Settings(curvature="given", parametrization="uv", triangles=triangles)
    found = detected(patch, settings, uv_of(patch, name))
    # Triangles of the hull are slivers, in which a stretched map sees zeros of its own.
    found = found.select(np.abs(found.position[:, :2]).max(axis=1) < 1.15)
    assert len(found) == 3
    distance = np.linalg.norm(found.position[:, None] - patch.umbilics.position[None], axis=2)
    nearest = distance.argmin(axis=1)
    assert sorted(nearest) == [0, 1, 2]
    edge = np.linalg.norm(
        patch.vertices[patch.triangles[:, 0]] - patch.vertices[patch.triangles[:, 1]], axis=1
    ).mean()
    assert distance.min(axis=1).max() < edge
    assert (found.index == patch.umbilics.index[nearest]).all()


def test_a_folded_map_is_refused_where_it_folds(patch):
    uv = uv_of(patch, "the plane itself")
    uv[..., 0] = np.abs(uv[..., 0])
    settings = core.Settings(curvature="given", parametrization="uv")
    result = core.detect(patch.vertices, patch.triangles, settings, given=patch.curvature, uv=uv)
    assert len(result.umbilics) == 3
    assert any("refused" in text for text in result.warnings)


def test_without_a_map_it_says_so(patch):
    with pytest.raises(core.ChartError, match="no UV map"):
        detected(patch, core.Settings(curvature="given", parametrization="uv"))


def test_as_published_each_triangle_decides_for_itself():
    mesh = surfaces.noisy(surfaces.ellipsoid(subdivisions=4), 0.2, seed=3)

    def all_found(triangles, parametrization):
        settings = core.Settings(
            curvature="normals",
            persistence=0.0,
            regions=False,
            triangles=triangles,
            parametrization=parametrization,
        )
        return core.detect(mesh.vertices, mesh.triangles, settings)

    certified = all_found("certified", "projection")
    assert certified.index_sum == 2.0
    published = [all_found("published", name) for name in ("projection", "conformal")]
    rows = [set(one.candidates.triangle) for one in published]
    # It loses and doubles some, and the parametrization decides which.
    assert rows[0] != set(certified.candidates.triangle)
    assert rows[0] != rows[1]
    for one in published:
        assert set(np.flatnonzero(one.triangle_index)) == set(one.candidates.triangle)
