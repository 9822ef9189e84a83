"""USD in text, read again by Pixar's own library."""

from dataclasses import replace

import numpy as np
import pytest
import surfaces

import core

TURN = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


@pytest.fixture(scope="module")
def egg():
    surface = surfaces.ellipsoid((3.0, 2.0, 1.0), 3)
    detection = core.detect(surface.vertices, surface.triangles)
    return core.UsdMesh("Egg", surface.vertices, surface.triangles, detection, TURN)


@pytest.fixture
def stage(tmp_path):
    """Writes meshes and opens the file."""
    usd = pytest.importorskip("pxr.Usd", reason="usd-core is not here; tools/test installs it")

    def write(*meshes, up="Z", frame=None):
        core.write_usda(tmp_path / "o.usda", list(meshes), up, frame)
        return usd.Stage.Open(str(tmp_path / "o.usda"))

    return write


def primvars(stage, path):
    from pxr import UsdGeom

    found = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath(path)).GetPrimvarsWithAuthoredValues()
    return {one.GetPrimvarName(): (one.GetInterpolation(), np.array(one.Get())) for one in found}


def test_mesh_curvatures_and_umbilics_are_what_was_detected(stage, egg):
    from pxr import UsdGeom

    found = stage(egg)
    assert UsdGeom.GetStageUpAxis(found) == "Z"
    mesh = UsdGeom.Mesh(found.GetPrimAtPath("/Umbilics/Egg"))
    points = np.array(mesh.GetPointsAttr().Get())
    np.testing.assert_allclose(points, egg.vertices @ TURN.T, atol=1e-6)
    assert np.array_equal(np.array(mesh.GetFaceVertexIndicesAttr().Get()), egg.triangles.ravel())
    assert set(mesh.GetFaceVertexCountsAttr().Get()) == {3}
    assert mesh.GetSubdivisionSchemeAttr().Get() == "none"
    np.testing.assert_allclose(
        np.array(mesh.GetExtentAttr().Get()), [points.min(axis=0), points.max(axis=0)]
    )
    field, values = egg.detection.curvature, primvars(found, "/Umbilics/Egg")
    for name, wanted in (("k1", field.k1), ("k2", field.k2)):
        assert values[name][0] == "vertex"
        np.testing.assert_allclose(values[name][1], wanted, rtol=1e-6)
    np.testing.assert_allclose(values["d1"][1], field.d1 @ TURN.T, atol=1e-6)
    assert values["index"][0] == values["region"][0] == "uniform"
    np.testing.assert_allclose(values["index"][1], egg.detection.triangle_index)

    umbilics = egg.detection.umbilics
    points = UsdGeom.Points(found.GetPrimAtPath("/Umbilics/Egg_umbilics"))
    places = np.array(points.GetPointsAttr().Get())
    np.testing.assert_allclose(places, umbilics.position @ TURN.T, atol=1e-6)
    values = primvars(found, "/Umbilics/Egg_umbilics")
    assert list(values["kind"][1]) == umbilics.kind.tolist()
    np.testing.assert_allclose(values["index"][1], umbilics.index)
    np.testing.assert_allclose(values["persistence"][1], umbilics.persistence, rtol=1e-6)


@pytest.mark.parametrize(
    "name", ["", "3D", 'a"b\\c', "größe", "a b", "a/b", "Egg_umbilics", "x\ny"]
)
def test_any_name_makes_a_file_that_is_read(stage, egg, name):
    found = stage(egg, replace(egg, name=name), replace(egg, name=name), up="Y", frame=7)
    children = list(found.GetPrimAtPath("/Umbilics").GetChildren())
    assert len(children) == 6
    assert children[2].GetMetadata("displayName") == name
    assert found.GetStartTimeCode() == 7


def test_a_mesh_without_umbilics_or_with_unknown_curvature_is_written(stage):
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [5, 5, 5]])
    triangles = np.array([[0, 1, 2], [0, 2, 3]])
    detection = core.detect(vertices, triangles)
    mesh = core.UsdMesh("Flat", vertices, triangles, detection, np.eye(3))
    found = stage(mesh)
    values = primvars(found, "/Umbilics/Flat")
    assert len(values["k1"][1]) == 5


def test_what_cannot_be_written_is_an_error_of_the_format(egg, tmp_path):
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(core.FormatError, match="cannot be written"):
        core.write_usda(tmp_path / "file" / "o.usda", [egg], "Z")
