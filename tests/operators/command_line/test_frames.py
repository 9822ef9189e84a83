"""--frames: what modifiers, armatures and shape keys make of a mesh at each frame."""

import json
from math import radians

import bpy
import numpy as np
import pytest
from scene_building import add_ellipsoid, ellipsoid_umbilics


@pytest.fixture
def frames(addon):
    return addon.operators.command_line.frames


def stretched(frame):
    """Half axes of the ellipsoid at a frame: the longest grows, the others stay."""
    return 3.0 + 0.2 * (frame - 1), 2.0, 1.0


def posed_ellipsoid():
    """An ellipsoid on an armature whose one bone, along x, grows and turns from frame 1 to 10."""
    obj = add_ellipsoid(subdivisions=5, name="Egg")
    bpy.ops.object.armature_add()
    rig = bpy.context.object
    bpy.ops.object.mode_set(mode="EDIT")
    bone = rig.data.edit_bones[0]
    bone.head, bone.tail, bone.roll = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), 0.0
    name = bone.name
    bpy.ops.object.mode_set(mode="POSE")
    pose = rig.pose.bones[name]
    pose.rotation_mode = "XYZ"
    for frame in range(1, 11):
        pose.scale = (1.0, stretched(frame)[0] / 3.0, 1.0)
        pose.rotation_euler = (0.0, 0.0, radians(5.0 * (frame - 1)))
        pose.keyframe_insert("scale", frame=frame)
        pose.keyframe_insert("rotation_euler", frame=frame)
    bpy.ops.object.mode_set(mode="OBJECT")
    group = obj.vertex_groups.new(name=name)
    group.add(range(len(obj.data.vertices)), 1.0, "REPLACE")
    modifier = obj.modifiers.new("Armature", "ARMATURE")
    modifier.object = rig
    return obj


def test_a_posed_rig_gives_the_right_umbilics_at_each_of_ten_frames(run, tmp_path):
    obj = posed_ellipsoid()
    scene = tmp_path / "rig.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(scene), copy=True)
    truth = {}
    for frame in range(1, 11):
        bpy.context.scene.frame_set(frame)
        posed = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
        places = np.array([posed.matrix_world @ vertex.co for vertex in posed.data.vertices])
        rest = np.array([vertex.co for vertex in obj.data.vertices])
        # The pose is linear, a stretch and then a turn: where it takes the umbilics is known.
        linear = np.linalg.lstsq(rest, places, rcond=None)[0].T
        stretch = np.linalg.svd(linear)[1]
        assert np.allclose(sorted(stretch), [1.0, 1.0, stretched(frame)[0] / 3.0], atol=1e-5)
        flat = ellipsoid_umbilics(stretched(frame))
        unstretched = flat / (stretched(frame)[0] / 3.0, 1.0, 1.0)
        truth[frame] = unstretched @ linear.T
    before = scene.read_bytes()
    assert run(scene, "--frames", "1-10", "--json", tmp_path / "o.json") == 0
    assert scene.read_bytes() == before
    entries = json.loads((tmp_path / "o.json").read_text())["objects"]
    assert [entry["frame"] for entry in entries] == list(range(1, 11))
    for entry in entries:
        found = np.array([umbilic["position"] for umbilic in entry["umbilics"]])
        away = np.linalg.norm(found[:, None] - truth[entry["frame"]][None], axis=2)
        assert len(found) == 4
        assert away.min(axis=0).max() < 0.1
        assert entry["index_sum"] == 2.0
    # The frames differ by more than the tolerance, or the test would not tell them apart.
    assert np.linalg.norm(truth[10] - truth[1], axis=1).min() > 0.3


def test_without_frames_the_mesh_is_taken_as_it_was_modelled_if_that_is_asked_for(run, tmp_path):
    posed_ellipsoid()
    bpy.context.scene.frame_set(10)
    assert run("--json", tmp_path / "o.json", "--source", "base") == 0
    (entry,) = json.loads((tmp_path / "o.json").read_text())["objects"]
    assert "frame" not in entry
    found = np.array([umbilic["position"] for umbilic in entry["umbilics"]])
    away = np.linalg.norm(found[:, None] - ellipsoid_umbilics()[None], axis=2)
    assert away.min(axis=0).max() < 0.1
    # What is modelled has no frames.
    assert run("--json", tmp_path / "o.json", "--source", "base", "--frames", "1") == 2


def test_all_results_but_the_report_have_a_file_for_each_frame(run, tmp_path):
    obj = add_ellipsoid(subdivisions=2, name="Egg")
    obj.modifiers.new("Finer", "SUBSURF").levels = 1
    kinds = ("json", "ply", "blend")
    results = [word for kind in kinds for word in (f"--{kind}", tmp_path / f"o.{kind}")]
    guide = ("--guide", tmp_path / "g", "--guide-files", "sing")
    assert run("--frames", "2,4", *results, *guide) == 0
    made = {path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*.*")}
    assert made == {
        *("o.json", "o.0002.ply", "o.0004.ply", "o.0002.blend", "o.0004.blend"),
        *("g/Egg.0002.sing", "g/Egg.0004.sing"),
    }


def test_frames_are_read_as_they_are_written(frames):
    assert frames.read("1-3,7,10-20x5,2") == (1, 2, 3, 7, 10, 15, 20)
    assert frames.read("-3--1") == (-3, -2, -1)
    assert frames.read(frames.in_words((5, -2, 9))) == (5, -2, 9)


@pytest.mark.parametrize("text", ["", "a", "3-1", "1-5x0", "1,,2", "1.5", "1-9999999", "0-200000"])
def test_what_are_no_frames_is_an_error_of_the_arguments(run, text, capfd):
    assert run("--frames", text) == 2
    assert "error:" in capfd.readouterr().err
