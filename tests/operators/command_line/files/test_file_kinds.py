"""Every kind of mesh file: what is read, in which coordinates, and what this Blender cannot."""

import json
import shutil

import bpy
import numpy as np
import pytest
from scene_building import add_ellipsoid, add_object, ellipsoid_umbilics, empty_scene

PLACE = np.array([1.0, 2.0, 3.0])
USD = ("usd", "usda", "usdc", "usdz")


@pytest.fixture
def kinds(addon):
    return addon.operators.command_line.files.file_kinds


def has(name):
    return name in dir(bpy.ops.wm)


def found_in(run, path, *options):
    target = path.with_name(path.name + ".json")
    assert run(path, "--json", target, *options) == 0
    return json.loads(target.read_text())["objects"]


def away(entry, truth):
    found = np.array([umbilic["position"] for umbilic in entry["umbilics"]])
    assert len(found) == 4
    return np.linalg.norm(found[:, None] - truth[None], axis=2).min(axis=0).max()


def placed_ellipsoid(subdivisions=4):
    obj = add_ellipsoid(subdivisions=subdivisions, name="Egg")
    obj.location = PLACE
    bpy.context.view_layer.update()
    return obj


def y_up(points):
    return points[:, (0, 2, 1)] * (1.0, 1.0, -1.0)


@pytest.mark.skipif(not has("usd_export"), reason="this Blender was built without USD")
@pytest.mark.parametrize("suffix", ["usda", "usdc", "usdz"])
@pytest.mark.parametrize("up", ["Y", "Z"])
def test_usd_in_its_own_coordinates_whatever_is_up(run, tmp_path, suffix, up):
    placed_ellipsoid()
    path = tmp_path / f"egg.{suffix}"
    bpy.ops.wm.usd_export(filepath=str(path), convert_orientation=up == "Y")
    (entry,) = found_in(run, path)
    wanted = ellipsoid_umbilics() + PLACE
    assert away(entry, y_up(wanted) if up == "Y" else wanted) < 0.1


@pytest.mark.skipif(not has("usd_export"), reason="this Blender was built without USD")
def test_usd_of_other_programs_has_no_turn_of_blenders_at_its_root(run, tmp_path):
    """As `test_usd_in_its_own_coordinates`, but the points themselves have y up."""
    add_ellipsoid(subdivisions=4, name="Egg")
    assert run("--usda", tmp_path / "own.usda") == 0
    text = (tmp_path / "own.usda").read_text()
    assert 'upAxis = "Z"' in text
    (tmp_path / "y.usda").write_text(text.replace('upAxis = "Z"', 'upAxis = "Y"'))
    (entry,) = found_in(run, tmp_path / "y.usda")
    assert away(entry, ellipsoid_umbilics()) < 0.1


@pytest.mark.skipif(not has("usd_export"), reason="this Blender was built without USD")
def test_lengths_of_usd_are_those_that_stand_in_the_file(run, tmp_path):
    placed_ellipsoid()
    path = tmp_path / "egg.usda"
    bpy.ops.wm.usd_export(filepath=str(path))
    text = path.read_text()
    assert "metersPerUnit = 1" in text
    path.write_text(text.replace("metersPerUnit = 1", "metersPerUnit = 0.01"))
    (entry,) = found_in(run, path)
    assert away(entry, ellipsoid_umbilics() + PLACE) < 0.1


@pytest.mark.skipif(not has("usd_export"), reason="this Blender was built without USD")
def test_our_own_usd_is_read_back(run, tmp_path):
    placed_ellipsoid()
    assert run("--usda", tmp_path / "own.usda") == 0
    (entry,) = found_in(run, tmp_path / "own.usda")
    assert away(entry, ellipsoid_umbilics() + PLACE) < 0.1
    empty_scene()
    bpy.ops.wm.usd_import(filepath=str(tmp_path / "own.usda"))
    (mesh,) = (obj for obj in bpy.data.objects if obj.type == "MESH")
    assert {"k1", "k2", "d1", "d2"} <= set(mesh.data.attributes.keys())


@pytest.mark.skipif(not has("alembic_export"), reason="this Blender was built without Alembic")
def test_alembic_in_its_own_coordinates(run, tmp_path):
    placed_ellipsoid()
    bpy.ops.wm.alembic_export(filepath=str(tmp_path / "egg.abc"), as_background_job=False)
    (entry,) = found_in(run, tmp_path / "egg.abc")
    assert away(entry, y_up(ellipsoid_umbilics() + PLACE)) < 0.1


@pytest.mark.parametrize("kind", ["usd", "alembic"])
def test_frames_of_a_cache_are_the_meshes_at_those_frames(run, tmp_path, kind):
    if not has(f"{kind}_export"):
        pytest.skip(f"this Blender was built without {kind}")
    obj = placed_ellipsoid()
    obj.shape_key_add(name="Basis")
    key = obj.shape_key_add(name="Long")
    for vertex, point in zip(obj.data.vertices, key.data, strict=True):
        point.co = (1.5 * vertex.co.x, vertex.co.y, vertex.co.z)
    for frame, value in ((1, 0.0), (5, 1.0)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 5
    path = tmp_path / ("egg.usdc" if kind == "usd" else "egg.abc")
    if kind == "usd":
        bpy.ops.wm.usd_export(filepath=str(path), export_animation=True)
    else:
        bpy.ops.wm.alembic_export(filepath=str(path), start=1, end=5, as_background_job=False)
    first, last = found_in(run, path, "--frames", "1,5")
    turned = y_up if kind == "alembic" else np.asarray
    assert away(first, turned(ellipsoid_umbilics() + PLACE)) < 0.1
    assert away(last, turned(ellipsoid_umbilics((4.5, 2.0, 1.0)) + PLACE)) < 0.15


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize("suffix", [*USD, "abc"])
def test_what_this_blender_was_built_without_is_a_clear_sentence(run, tmp_path, suffix, capfd):
    operator = "alembic_import" if suffix == "abc" else "usd_import"
    path = tmp_path / f"egg.{suffix}"
    path.write_text("something")
    assert run(path, "--json", tmp_path / "o.json") == 1
    (line,) = [line for line in capfd.readouterr().err.splitlines() if "umbilics:" in line]
    assert f"egg.{suffix}" in line
    if has(operator):
        reasons = ("cannot read", "no mesh", "is not an Alembic file")
        assert any(reason in line for reason in reasons)
    else:
        assert "built without" in line and "blender.org" in line


def test_off_in_its_own_coordinates(run, tmp_path):
    obj = placed_ellipsoid()
    mesh = obj.data
    lines = [f"OFF\n{len(mesh.vertices)} {len(mesh.polygons)} 0"]
    lines += ["{} {} {}".format(*(obj.matrix_world @ vertex.co)) for vertex in mesh.vertices]
    lines += [f"3 {' '.join(map(str, polygon.vertices))}" for polygon in mesh.polygons]
    (tmp_path / "egg.off").write_text("\n".join(lines))
    (entry,) = found_in(run, tmp_path / "egg.off")
    assert entry["object"] == "egg"
    assert (entry["vertices"], entry["faces"]) == (642, 1280)
    assert away(entry, ellipsoid_umbilics() + PLACE) < 0.1


def test_a_bad_off_is_one_clear_line(run, tmp_path, capfd):
    (tmp_path / "m.off").write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n")
    assert run(tmp_path / "m.off") == 1
    (line,) = capfd.readouterr().err.strip().splitlines()
    assert "m.off: a face names a vertex that is not there" in line


AXES = [("Z", "-Y"), ("Y", "-Z"), ("Z", "X"), ("X", "Y"), ("-Y", "Z")]


@pytest.mark.parametrize(("up", "forward"), AXES)
def test_fbx_in_its_own_coordinates_whatever_axes_it_has(run, tmp_path, up, forward):
    """Written with other axes, the file has other numbers: those of the file are reported."""
    placed_ellipsoid()
    path = tmp_path / "egg.fbx"
    bpy.ops.export_scene.fbx(filepath=str(path), axis_up=up, axis_forward=forward)
    from bpy_extras.io_utils import axis_conversion

    turn = np.array(axis_conversion(to_forward=forward, to_up=up))
    (entry,) = found_in(run, path)
    wanted = 100.0 * (ellipsoid_umbilics() + PLACE) @ turn.T
    assert away(entry, wanted) < 10.0


def test_the_older_importer_of_fbx_gives_the_same(run, kinds, tmp_path, monkeypatch):
    if not has("fbx_import") or "fbx" not in dir(bpy.ops.import_scene):
        pytest.skip("this Blender has only one importer of FBX")
    placed_ellipsoid()
    path = tmp_path / "egg.fbx"
    bpy.ops.export_scene.fbx(filepath=str(path))
    (new,) = found_in(run, path)
    monkeypatch.setattr(kinds, "has_operator", lambda name: False)
    (old,) = found_in(run, path)
    positions = [
        np.array(sorted(umbilic["position"] for umbilic in entry["umbilics"]))
        for entry in (new, old)
    ]
    np.testing.assert_allclose(*positions, rtol=1e-4)


def test_a_batch_takes_all_kinds_from_a_folder(addon, tmp_path):
    plan = addon.operators.command_line.batch.plan
    suffixes = addon.operators.command_line.files.importers.SUFFIXES
    for suffix in (".off", ".usda", ".usdz", ".abc", ".FBX", ".txt"):
        (tmp_path / f"m{suffix}").write_text("")
    names = [task.name for task in plan.tasks_for([str(tmp_path)], suffixes, (1, 1))]
    assert names == ["m.FBX", "m.abc", "m.off", "m.usda", "m.usdz"]


def test_usd_with_primvars_is_written_for_every_file(run, tmp_path):
    placed_ellipsoid(3)
    bpy.ops.wm.obj_export(filepath=str(tmp_path / "egg.obj"), export_materials=False)
    shutil.copy(tmp_path / "egg.obj", tmp_path / "twin.obj")
    assert run(tmp_path / "egg.obj", tmp_path / "twin.obj", "--usda", tmp_path / "o") == 0
    for name in ("egg", "twin"):
        text = (tmp_path / "o" / f"{name}.usda").read_text()
        assert text.startswith("#usda 1.0") and 'upAxis = "Y"' in text
        assert "primvars:k1" in text and "def Points" in text


@pytest.mark.usefixtures("here")
def test_what_is_there_in_place_of_a_mesh_is_said(run, tmp_path, capfd):
    def said_of(name):
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / name), copy=True)
        assert run(tmp_path / name) == 1
        return capfd.readouterr().err

    add_object(bpy.data.curves.new("Ring", "CURVE"), "Ring")
    add_object(bpy.data.metaballs.new("Drop"), "Drop")
    assert "other shapes (curve, meta): Object > Convert > Mesh" in said_of("shapes.blend")
    empty_scene()
    add_ellipsoid(subdivisions=2, name="Egg")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "lib.blend"), copy=True)
    empty_scene()
    with bpy.data.libraries.load(str(tmp_path / "lib.blend"), link=True) as (_, there):
        there.objects = ["Egg"]
    bpy.context.scene.collection.objects.link(bpy.data.objects["Egg"])
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "user.blend"))
    assert run(tmp_path / "user.blend") == 0
    (tmp_path / "lib.blend").unlink()
    assert run(tmp_path / "user.blend") == 1
    assert "lib.blend is missing: what was linked from it" in capfd.readouterr().err
    empty_scene()
    kept = bpy.data.collections.new("Kept")
    kept.objects.link(bpy.data.objects.new("Egg", bpy.data.meshes.new("Egg")))
    holder = add_object(None, "Holder")
    holder.instance_type, holder.instance_collection = "COLLECTION", kept
    assert "Make Instances Real" in said_of("instances.blend")


def test_the_shape_of_bones_is_no_mesh_of_the_file(run, tmp_path):
    skin = add_ellipsoid(subdivisions=3, name="Egg")
    bones = add_object(bpy.data.armatures.new("Bones"), "Bones")
    bpy.ops.object.mode_set(mode="EDIT")
    bones.data.edit_bones.new("Bone").tail = (0.0, 0.0, 1.0)
    bpy.ops.object.mode_set(mode="OBJECT")
    skin.vertex_groups.new(name="Bone").add(range(len(skin.data.vertices)), 1.0, "REPLACE")
    skin.parent = bones
    skin.modifiers.new("Bones", "ARMATURE").object = bones
    bpy.ops.export_scene.gltf(filepath=str(tmp_path / "egg.glb"))
    (entry,) = found_in(run, tmp_path / "egg.glb")
    assert entry["object"] == "Egg"


STAGE = """#usda 1.0
(
    upAxis = "{up}"
)
def Xform "Kept"
{{
    def Mesh "Egg"
    {{
        uniform token subdivisionScheme = "none"
        int[] faceVertexCounts = [{counts}]
        int[] faceVertexIndices = [{corners}]
        point3f[] points = [{points}]
    }}
}}
def Xform "Copy" (
    instanceable = true
    references = </Kept>
)
{{
    double3 xformOp:translate = (10, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}}
def PointInstancer "Points"
{{
    rel prototypes = </Points/Inner>
    int[] protoIndices = [0, 0]
    point3f[] positions = [(20, 0, 0), (30, 0, 0)]
    def "Inner" (
        references = </Kept/Egg>
    )
    {{
    }}
}}
"""


@pytest.mark.skipif(not has("usd_export"), reason="this Blender was built without USD")
@pytest.mark.parametrize("up", ["Y", "Z"])
def test_instances_in_usd_are_meshes_in_the_coordinates_of_the_stage(run, tmp_path, up):
    mesh = add_ellipsoid(subdivisions=4).data
    corners = [index for face in mesh.polygons for index in face.vertices]
    points = [str(tuple(round(value, 6) for value in vertex.co)) for vertex in mesh.vertices]
    text = STAGE.format(
        up=up,
        counts=", ".join(["3"] * len(mesh.polygons)),
        corners=", ".join(map(str, corners)),
        points=", ".join(points),
    )
    (tmp_path / "a.usda").write_text(text)
    entries = found_in(run, tmp_path / "a.usda")
    # What points show stands for itself, where it is kept.
    places = [np.mean([one["position"] for one in entry["umbilics"]], axis=0) for entry in entries]
    assert sorted(round(place[0]) for place in places) == [0, 0, 10]
    for entry, place in zip(entries, places, strict=True):
        assert away(entry, ellipsoid_umbilics() + np.array([round(place[0]), 0, 0])) < 0.1
