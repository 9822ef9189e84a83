"""--compare: methods S, I and C on one mesh; and method C from seams and UV maps in Blender."""

import json

import bpy
import numpy as np
import pytest
from scene_building import add_ellipsoid, add_mesh
from surfaces import seed_patch


def save(path) -> str:
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    return str(path)


def size_of(path) -> tuple[int, int]:
    image = bpy.data.images.load(str(path))
    size = tuple(image.size)
    bpy.data.images.remove(image)
    return size


@pytest.mark.usefixtures("here")
def test_a_table_a_picture_and_json(run, tmp_path, capfd):
    mesh = seed_patch(3000)
    add_mesh(mesh.vertices, mesh.triangles, name="Patch")
    file = save(tmp_path / "patch.blend")
    target, picture = tmp_path / "out.json", tmp_path / "out.png"
    arguments = [file, "--compare", "--method", "C", "--persistence", "0"]
    assert run(*arguments, "--json", str(target), "--png", str(picture)) == 0
    lines = capfd.readouterr().out.splitlines()
    first_words = [line.split()[0] for line in lines if line.strip()]
    assert [word for word in first_words if word in ("S", "I", "C")] == ["S", "I", "C"]
    (entry,) = json.loads(target.read_text())["objects"]
    rows = {row["method"]: row for row in entry["comparison"]}
    assert list(rows) == ["S", "I", "C", "k1-k2", "H2-K", "ratio"]
    assert rows["S"]["error"] == 0.0 < rows["k1-k2"]["error"]
    assert rows["ratio"]["index_sum"] is None
    assert len(rows["S"]["positions"]) == len(entry["umbilics"])
    assert all(row["refusal"] is None for row in rows.values())
    for row in rows.values():
        found = np.array(row["positions"])
        distance = np.linalg.norm(found[:, None] - mesh.umbilics.position[None], axis=2)
        assert distance[:, 0].min() < 2 * mesh.edge_length
    width, height = size_of(picture)
    assert width == 3 * height


@pytest.mark.usefixtures("here")
def test_a_closed_mesh_is_refused_by_c_alone(run, tmp_path, capfd):
    add_ellipsoid(subdivisions=3, name="Egg")
    file = save(tmp_path / "egg.blend")
    target = tmp_path / "out.json"
    assert run(file, "--compare", "--charts", "seams", "--json", str(target)) == 0
    (entry,) = json.loads(target.read_text())["objects"]
    refused = [row["method"] for row in entry["comparison"] if row["refusal"]]
    assert refused == ["C"]
    assert "seams" in capfd.readouterr().out
    alone = [file, "--method", "C", "--json", str(target)]
    assert run(*alone, "--charts", "seams") == 1
    assert "seams" in capfd.readouterr().err
    # By default it cuts the mesh open itself.
    assert run(*alone) == 0
    (entry,) = json.loads(target.read_text())["objects"]
    assert entry["counts"]["lemon"] == 4


@pytest.mark.usefixtures("here")
def test_c_along_seams_leaves_the_conformal_scale(run, tmp_path):
    """A seam around the waist makes two disks of the ellipsoid."""
    egg = add_ellipsoid(subdivisions=4, name="Egg")
    height = np.array([vertex.co.z for vertex in egg.data.vertices])
    upper = [all(height[vertex] > -1e-6 for vertex in face.vertices) for face in egg.data.polygons]
    sides = {}
    for face, above in zip(egg.data.polygons, upper, strict=True):
        for key in face.edge_keys:
            sides.setdefault(key, set()).add(above)
    for edge in egg.data.edges:
        edge.use_seam = len(sides[edge.key]) == 2
    file = save(tmp_path / "egg.blend")
    result = tmp_path / "result.blend"
    assert run(file, "--method", "C", "--persistence", "0", "--blend", str(result)) == 0
    bpy.ops.wm.open_mainfile(filepath=str(result))
    mesh = bpy.data.objects["Egg"].data
    attribute = mesh.attributes["umbilics_conformal_scale"]
    scale = np.empty(len(mesh.vertices), dtype=np.float32)
    attribute.data.foreach_get("value", scale)
    assert scale.min() > 0.2
    assert scale.max() < 4.0


def test_the_scale_goes_when_another_method_runs(addon):
    mesh = seed_patch(400)
    obj = add_mesh(mesh.vertices, mesh.triangles, name="Patch")
    bpy.context.view_layer.objects.active = obj
    bpy.context.scene.umbilics.method = "C"
    bpy.ops.umbilics.detect()
    assert "umbilics_conformal_scale" in obj.data.attributes
    bpy.context.scene.umbilics.method = "S"
    bpy.ops.umbilics.detect()
    assert "umbilics_conformal_scale" not in obj.data.attributes


def test_the_operator_shows_all_methods_and_leaves_the_scene_as_it_was(addon, monkeypatch):
    obj = add_ellipsoid(subdivisions=3, name="Egg")
    bpy.context.view_layer.objects.active = obj
    module = addon.operators.compare
    told = []
    real = addon.core.comparison_table
    monkeypatch.setattr(
        module.core, "comparison_table", lambda results: told.append(real(results)) or told[-1]
    )
    before = sorted(obj.data.attributes.keys()), obj.umbilics.detected, len(bpy.data.objects)
    assert bpy.ops.umbilics.compare() == {"FINISHED"}
    assert (sorted(obj.data.attributes.keys()), obj.umbilics.detected, len(bpy.data.objects)) == (
        before
    )
    (table,) = told
    words = [line.split()[0] for line in table.splitlines()]
    assert words == ["method", "S", "I", "C", "k1-k2", "H2-K", "ratio"]
