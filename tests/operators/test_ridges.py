"""Ridges in the scene: curves, marks, files, the command line; all of it can be taken back."""

import csv
import json

import bpy
import numpy as np
import pytest
from scene_building import add_ellipsoid, census, marked, parts, spline_points, values


def creases(obj):
    found = obj.data.attributes.get("crease_edge")
    values = np.zeros(len(obj.data.edges), np.float32)
    if found is not None:
        found.data.foreach_get("value", values)
    return values


def test_the_crest_of_an_ellipsoid_is_a_closed_curve():
    obj = add_ellipsoid()
    assert bpy.ops.umbilics.ridges() == {"FINISHED"}
    (curve,) = parts(obj, "ridges")
    assert curve.name.startswith("Ridges")
    (points,) = spline_points(curve)
    # The section z = 0 of the ellipsoid with half axes 3, 2 and 1.
    assert np.abs(points[:, 2]).max() < 0.05
    assert curve.data.splines[0].use_cyclic_u
    assert list(curve["umbilics_kinds"]) == ["crest"]
    assert 55.0 < curve["umbilics_bends"][0] < 85.0
    assert curve["umbilics_lengths"][0] == pytest.approx(15.87, rel=0.01)


def test_least_bend_leaves_lines_out():
    obj = add_ellipsoid()
    bpy.context.scene.umbilics_guidance.least_bend = np.radians(120.0)
    assert bpy.ops.umbilics.ridges() == {"FINISHED"}
    assert not parts(obj, "ridges")
    bpy.context.scene.umbilics_guidance.least_bend = np.radians(15.0)
    bpy.context.scene.umbilics_guidance.ridge_kinds = "all"
    assert bpy.ops.umbilics.ridges() == {"FINISHED"}
    kinds = {kind for curve in parts(obj, "ridges") for kind in curve["umbilics_kinds"]}
    assert {"crest", "minimal", "hyperbolic maximal"} <= kinds


@pytest.mark.parametrize("mark", ["SEAM", "SHARP", "CREASE"])
def test_ridges_become_marks_and_those_of_the_user_stay(mark):
    obj = add_ellipsoid()
    own = obj.data.attributes.new("crease_edge", "FLOAT", "EDGE")
    own.data[5].value = 0.25
    obj.data.edges[7].use_seam = True
    assert bpy.ops.umbilics.mark_seams(lines="RIDGES", mark=mark) == {"FINISHED"}
    found = {
        "SEAM": marked(obj, "use_seam"),
        "SHARP": marked(obj, "use_edge_sharp"),
        "CREASE": creases(obj) == 1.0,
    }[mark]
    chosen = np.flatnonzero(found)
    chosen = chosen[chosen != 7]
    heights = [
        abs(obj.data.vertices[vertex].co.z) for i in chosen for vertex in obj.data.edges[i].vertices
    ]
    assert len(chosen) > 50 and max(heights) < 0.2
    bpy.ops.umbilics.clear()
    assert list(np.flatnonzero(creases(obj))) == [5] and creases(obj)[5] == 0.25
    assert list(np.flatnonzero(marked(obj, "use_seam"))) == [7]
    assert not marked(obj, "use_edge_sharp").any()


def test_the_nearest_edges_carry_kind_bend_and_strength():
    obj = add_ellipsoid()
    assert bpy.ops.umbilics.ridges() == {"FINISHED"}
    (curve,) = parts(obj, "ridges")
    kind = values(obj, "umbilics_ridge")
    bend, strength = values(obj, "umbilics_ridge_bend"), values(obj, "umbilics_ridge_strength")
    on = kind == 1
    assert set(kind) == {0, 1} and on.sum() > 50
    assert (bend[~on] == 0).all() and (strength[~on] == 0).all()
    assert np.degrees(bend[on].mean()) == pytest.approx(curve["umbilics_bends"][0], rel=0.05)
    # Across the section z = 0 the curvature is a / (z half axis)^2 at its sharpest end.
    assert strength.max() == pytest.approx(3.0, rel=0.05)
    # As mesh edges they are connected: each end is shared.
    ends = np.array([edge.vertices[:] for edge in obj.data.edges])[on]
    assert (np.bincount(ends.ravel())[np.unique(ends)] == 2).all()
    bpy.context.scene.umbilics_guidance.least_bend = np.radians(120.0)
    assert bpy.ops.umbilics.ridges() == {"FINISHED"}
    assert not values(obj, "umbilics_ridge").any()


def test_under_modifiers_that_make_other_edges_there_are_curves_alone():
    obj = add_ellipsoid(subdivisions=3)
    obj.modifiers.new("Subdivision", "SUBSURF").levels = 1
    assert bpy.ops.umbilics.ridges() == {"FINISHED"}
    assert "umbilics_ridge" not in obj.data.attributes


def test_again_replaces_and_clear_leaves_nothing():
    obj = add_ellipsoid()
    before = census()
    for _ in range(2):
        bpy.ops.umbilics.ridges()
    assert len(parts(obj, "ridges")) == 1
    bpy.ops.umbilics.clear()
    assert census() == before


def test_command_line_writes_lines_and_figures(addon, run, tmp_path, capsys):
    add_ellipsoid()
    assert run("--guide", tmp_path, "--guide-files", "mesh", "--ridges") == 0
    assert "Ellipsoid-ridges.csv" in capsys.readouterr().out
    names = {"Ellipsoid.obj", "Ellipsoid-ridges.obj", "Ellipsoid-ridges.csv"}
    assert {file.name for file in tmp_path.iterdir()} == names | {"Ellipsoid-ridges.json"}
    found, family, closed = addon.core.formats.read_curves(tmp_path / "Ellipsoid-ridges.obj")
    assert len(found) == 1 and closed.all() and not family.any()
    rows = list(csv.DictReader((tmp_path / "Ellipsoid-ridges.csv").open()))
    assert len(rows) == len(found[0])
    assert {row["kind"] for row in rows} == {"crest"}
    points = json.loads((tmp_path / "Ellipsoid-ridges.json").read_text())["ridges"]
    assert [float(row["bend"]) for row in rows] == [point["bend"] for point in points]


def test_ridges_without_a_folder_are_an_error_of_the_arguments(run, capsys):
    assert run("--ridges") == 2
    assert "--guide" in capsys.readouterr().err
