"""The guidance in the scene: plan, lines, separatrices, marks, files, mirror; all repeatable."""

import bpy
import numpy as np
import pytest
from scene_building import (
    add_ellipsoid,
    add_mesh,
    census,
    marked,
    moved,
    parts,
    spline_points,
    values,
)

AXES = np.array([3.0, 2.0, 1.0])


def test_plan_of_the_ellipsoid_has_the_corners_of_a_cube():
    obj = add_ellipsoid()
    assert bpy.ops.umbilics.detect() == {"FINISHED"}
    assert bpy.ops.umbilics.guide() == {"FINISHED"}
    bpy.context.view_layer.update()
    poles = parts(obj, "poles")
    assert [pole["umbilics_valence"] for pole in poles] == [3] * 8
    places = np.array([pole.matrix_world.translation for pole in poles])
    assert len({tuple(signs) for signs in np.sign(places)}) == 8
    assert np.abs((places / AXES) @ (places / AXES).T).diagonal() == pytest.approx(1.0, abs=0.01)
    assert sorted(pole["umbilics_umbilic"] for pole in poles) == [0, 0, 1, 1, 2, 2, 3, 3]
    plan = obj.umbilics_plan
    assert (len(plan.poles), plan.expected, plan.closed) == (8, 8, True)
    assert plan.poles[0].origin.startswith("Lemon")
    assert values(obj, "umbilics_cross_index").sum() == pytest.approx(2.0)
    assert np.linalg.norm(values(obj, "umbilics_cross"), axis=1) == pytest.approx(1.0, abs=1e-5)
    across = values(obj, "umbilics_cross_face")
    normals = np.array([polygon.normal for polygon in obj.data.polygons])
    assert np.abs(np.einsum("ij,ij->i", across, normals)).max() < 1e-3


def test_plan_without_a_detection_and_with_quads():
    bpy.ops.mesh.primitive_cube_add()
    obj = bpy.context.object
    for _ in range(4):
        bpy.ops.object.modifier_add(type="SUBSURF")
        bpy.ops.object.modifier_apply(modifier=obj.modifiers[0].name)
    assert bpy.ops.umbilics.guide() == {"FINISHED"}
    assert sum(4 - pole["umbilics_valence"] for pole in parts(obj, "poles")) == 8
    assert len(values(obj, "umbilics_cross_face")) == len(obj.data.polygons)


def test_poles_keep_out_of_the_marked_zone():
    obj = add_ellipsoid()
    group = obj.vertex_groups.new(name="Zone")
    inside = [vertex.index for vertex in obj.data.vertices if vertex.co.x > 2.0]
    group.add(inside, 1.0, "REPLACE")
    bpy.context.scene.umbilics_guidance.zone = "Zone"
    bpy.ops.umbilics.guide()
    bpy.context.view_layer.update()
    poles = parts(obj, "poles")
    assert len(poles) == 8
    assert max(pole.matrix_world.translation.x for pole in poles) <= 2.0


def test_separatrices_run_along_the_middle_ellipse():
    obj = add_ellipsoid()
    bpy.ops.umbilics.detect()
    assert bpy.ops.umbilics.separatrices() == {"FINISHED"}
    curves = parts(obj, "separatrices")
    assert [curve["umbilics_family"] for curve in curves] == [0, 1]
    assert [len(curve.data.splines) for curve in curves] == [2, 2]
    # A sphere's worth of edges: half of one is about 0.05.
    for curve in curves:
        for points in spline_points(curve):
            assert np.abs(points[:, 1]).max() < 0.05
        assert len(curve["umbilics_lengths"]) == len(curve.data.splines)


def test_lines_lie_on_the_surface_and_follow_the_object():
    obj = add_ellipsoid()
    obj.matrix_world = moved(x=5.0)
    assert bpy.ops.umbilics.lines() == {"FINISHED"}
    curves = parts(obj, "lines")
    assert len(curves) == 2
    points = np.concatenate([p for curve in curves for p in spline_points(curve)])
    level = np.sqrt((((points - (5.0, 0.0, 0.0)) / AXES) ** 2).sum(axis=1))
    assert np.abs(level - 1.0).max() < 0.02
    assert any(spline.use_cyclic_u for curve in curves for spline in curve.data.splines)
    obj.matrix_world = moved(x=-5.0)
    after = np.concatenate([p for curve in curves for p in spline_points(curve)])
    assert np.abs(after - points - (-10.0, 0.0, 0.0)).max() < 1e-4


def test_marks_are_connected_edges_and_those_of_the_user_stay():
    obj = add_ellipsoid()
    bpy.ops.umbilics.detect()
    own = obj.data.edges[7]
    own.use_seam = True
    assert bpy.ops.umbilics.mark_seams(lines="SEPARATRICES", mark="SEAM") == {"FINISHED"}
    seams = marked(obj, "use_seam")
    length = sum(
        (obj.data.vertices[a].co - obj.data.vertices[b].co).length
        for a, b in (obj.data.edges[i].vertices for i in np.flatnonzero(seams))
    )
    # The middle principal ellipse, x^2 / 9 + z^2 = 1, is 13.36 around.
    assert 13.0 < length < 16.0
    assert bpy.ops.umbilics.mark_seams(lines="SEPARATRICES", mark="SHARP") == {"FINISHED"}
    assert marked(obj, "use_edge_sharp").sum() == pytest.approx(seams.sum(), abs=2)
    bpy.ops.umbilics.clear()
    assert list(np.flatnonzero(marked(obj, "use_seam"))) == [7]
    assert not marked(obj, "use_edge_sharp").any()


def test_again_replaces_and_clear_leaves_nothing():
    obj = add_ellipsoid()
    before = census()
    for _ in range(2):
        bpy.ops.umbilics.detect()
        bpy.ops.umbilics.guide()
        bpy.ops.umbilics.lines()
        bpy.ops.umbilics.separatrices()
        bpy.ops.umbilics.symmetry()
    assert [len(parts(obj, part)) for part in ("poles", "lines", "separatrices", "mirror")] == [
        8,
        2,
        2,
        1,
    ]
    bpy.ops.umbilics.clear()
    assert census() == before
    assert not len(bpy.data.curves)


def test_one_undo_takes_a_plan_back():
    obj = add_ellipsoid()
    bpy.ops.ed.undo_push(message="before")
    name = obj.name
    bpy.ops.umbilics.guide()
    bpy.ops.ed.undo_push(message="guide")
    bpy.ops.ed.undo()
    obj = bpy.data.objects[name]
    assert not parts(obj, "poles")
    assert "umbilics_cross" not in obj.data.attributes


def test_mirror_plane_aligned_to_x():
    obj = add_ellipsoid((3.0, 2.0, 1.0))
    points = np.array([vertex.co for vertex in obj.data.vertices])
    # An egg: only y and z are mirrored.
    points[:, 0] += 0.15 * points[:, 0] ** 2
    points[:, 2] += 0.1 * points[:, 0] * points[:, 2]
    points[:, 2] += 0.05 * points[:, 0] ** 2
    obj.data.vertices.foreach_set("co", points.astype(np.float32).ravel())
    obj.data.update()
    bpy.ops.umbilics.detect()
    assert bpy.ops.umbilics.symmetry() == {"FINISHED"}
    bpy.context.view_layer.update()
    plane = parts(obj, "mirror")[0]
    assert abs(plane.matrix_world.col[1].to_3d().normalized().y) > 0.9999
    assert bpy.ops.umbilics.align_to_x() == {"FINISHED"}
    bpy.context.view_layer.update()
    world = points @ np.array(obj.matrix_world)[:3, :3].T + np.array(obj.matrix_world)[:3, 3]
    assert abs(world[:, 0].min() + world[:, 0].max()) < 0.01
    assert world[:, 0].max() == pytest.approx(2.0, abs=0.01)


def test_plane_has_no_lines_and_says_so():
    columns = np.arange(12)
    x, y = np.meshgrid(columns, columns)
    i = (columns[:-1, None] * 12 + columns[None, :-1]).ravel()
    faces = np.stack([i, i + 1, i + 13, i + 12], axis=1)
    add_mesh(np.column_stack([x.ravel(), y.ravel(), np.zeros(144)]), faces)
    with pytest.raises(RuntimeError, match="no preferred direction"):
        bpy.ops.umbilics.lines()
    assert bpy.ops.umbilics.guide() == {"FINISHED"}


def test_files_are_written(tmp_path):
    obj = add_ellipsoid()
    chosen = dict.fromkeys(
        ("mesh", "rosy", "rawfield", "sing", "dmat", "sharp", "lines", "separatrices"), True
    )
    path = str(tmp_path / "thing.obj")
    assert bpy.ops.umbilics.export_field(filepath=path, csv=True, json=True, **chosen) == {
        "FINISHED"
    }
    names = {file.name for file in tmp_path.iterdir()}
    assert len(names) == 11
    rosy = (tmp_path / "thing.rosy").read_text().split()
    assert [int(word) for word in rosy[:2]] == [len(obj.data.polygons), 4]


def test_blender_reads_the_polylines(addon, tmp_path):
    obj = add_ellipsoid(subdivisions=4)
    path = str(tmp_path / "thing.obj")
    only = dict.fromkeys(("mesh", "rosy", "sharp"), False)
    bpy.ops.umbilics.export_field(filepath=path, lines=True, separatrices=True, **only)
    for name in ("lines", "separatrices"):
        file = tmp_path / f"thing-{name}.obj"
        bpy.ops.wm.obj_import(filepath=str(file), forward_axis="Y", up_axis="Z")
        read = bpy.context.selected_objects
        points, _, closed = addon.core.formats.read_curves(file)
        edges = sum(len(one) - 1 for one in points) + int(closed.sum())
        assert sum(len(one.data.vertices) for one in read) == sum(map(len, points))
        assert sum(len(one.data.edges) for one in read) == edges
        places = np.concatenate([[v.co for v in one.data.vertices] for one in read])
        ours = np.concatenate(points)
        for axis in range(3):
            assert np.sort(places[:, axis]) == pytest.approx(np.sort(ours[:, axis]), abs=1e-5)
        assert obj not in read


@pytest.mark.parametrize("path", ["", "//", "folder", "folder/"])
def test_guidance_for_no_file_is_refused_in_words(addon, tmp_path, monkeypatch, path):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder").mkdir()
    add_ellipsoid(subdivisions=2)
    assert addon.operators.export_field.in_the_way(path, ["mesh"]) == []
    for write in (bpy.ops.umbilics.export_field, bpy.ops.umbilics.write_files):
        with pytest.raises(RuntimeError, match="Name a file") as refused:
            write(filepath=path)
        assert "Traceback" not in str(refused.value)
    assert [one.name for one in tmp_path.iterdir()] == ["folder"]
