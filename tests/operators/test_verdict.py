"""The line under Detect says what is to be thought of it, and its button mends it."""

import bpy
import numpy as np
import pytest
from scene_building import add_ellipsoid, add_mesh


@pytest.fixture
def judged(addon):
    return lambda obj: addon.operators.base.verdict.verdict(obj.umbilics)


def test_a_fine_ellipsoid_is_trusted(judged):
    obj = add_ellipsoid(subdivisions=4)
    bpy.ops.umbilics.detect()
    found = judged(obj)
    assert (found.found, found.trust, found.is_good) == ("4 umbilics", "trust good", True)


@pytest.mark.parametrize(
    ("primitive", "given", "levels"),
    [("cube", {}, 4), ("cone", {"vertices": 10}, 4), ("cylinder", {}, 4), ("monkey", {}, 2)],
    ids=["cube", "cone", "cylinder", "monkey"],
)
def test_what_is_too_coarse_gets_a_subdivision(judged, primitive, given, levels):
    """One click is enough."""
    getattr(bpy.ops.mesh, f"primitive_{primitive}_add")(**given)
    obj = bpy.context.object
    bpy.ops.umbilics.detect()
    found = judged(obj)
    assert (found.remedy, found.is_good) == ("SUBDIVIDE", False)
    assert bpy.ops.umbilics.mend(way=found.remedy) == {"FINISHED"}
    assert [modifier.levels for modifier in obj.modifiers] == [levels]
    assert "Subdivision" in obj.umbilics.analysed
    assert judged(obj).remedy != "SUBDIVIDE"


def box():
    """A box of fine quads: six flat sides that meet at right angles."""
    bpy.ops.mesh.primitive_cube_add()
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.subdivide(number_cuts=8)
    bpy.ops.object.mode_set(mode="OBJECT")
    return bpy.context.object


def test_a_box_is_a_hard_surface_until_creases_are_heeded(judged):
    obj, settings = box(), bpy.context.scene.umbilics
    settings.crease_angle_auto, settings.crease_angle = False, np.pi
    bpy.ops.umbilics.detect()
    assert judged(obj).remedy == "CREASES"
    assert bpy.ops.umbilics.mend(way="CREASES") == {"FINISHED"}
    assert np.degrees(bpy.context.scene.umbilics.crease_angle) == pytest.approx(30.0)
    assert judged(obj).remedy == ""


def test_marked_edges_are_heeded_creases(judged):
    obj = box()
    bpy.context.scene.umbilics.regions = False
    bpy.ops.umbilics.detect()
    assert judged(obj).remedy == "CREASES"
    for edge in obj.data.edges:
        ends = [obj.data.vertices[end].co for end in edge.vertices]
        flush = [all(abs(abs(co[axis]) - 1.0) < 1e-6 for co in ends) for axis in range(3)]
        edge.use_edge_sharp = sum(flush) >= 2
    bpy.ops.umbilics.detect()
    assert judged(obj).remedy == ""
    bpy.context.scene.umbilics.crease_marks = False
    bpy.ops.umbilics.detect()
    assert judged(obj).remedy == "CREASES"


def test_no_tick_where_the_noise_is_unknown(judged):
    obj = add_ellipsoid(subdivisions=4)
    bpy.context.scene.umbilics.curvature = "normals"
    bpy.ops.umbilics.detect()
    assert not judged(obj).is_good
    assert "unknown" in judged(obj).trust


def test_strong_noise_wants_a_wider_scale(judged):
    obj = add_ellipsoid(subdivisions=5, radii=(1.2, 1.1, 1.0))
    rng = np.random.default_rng(3)
    points = np.array([vertex.co for vertex in obj.data.vertices])
    points += 0.01 * rng.standard_normal(points.shape)
    obj.data.vertices.foreach_set("co", points.astype(np.float32).ravel())
    obj.data.update()
    settings = bpy.context.scene.umbilics
    settings.scale_auto, settings.scale = False, 2.0
    bpy.ops.umbilics.detect()
    assert judged(obj).remedy == "SMOOTH"
    before = obj.umbilics.scale
    assert bpy.ops.umbilics.mend(way="SMOOTH") == {"FINISHED"}
    assert 1.3 * before < obj.umbilics.scale < 2.0 * before


def test_noise_of_modelled_quads_is_that_of_few_faces(judged):
    """No scan is made of quads; triangles may be one."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=40, ring_count=20)
    obj = bpy.context.object
    points = np.array([vertex.co for vertex in obj.data.vertices]) * (1.2, 1.1, 1.0)
    points += 0.004 * np.sin(40.0 * points[:, [1, 2, 0]])
    obj.data.vertices.foreach_set("co", points.astype(np.float32).ravel())
    obj.data.update()
    settings = bpy.context.scene.umbilics
    settings.scale_auto, settings.scale = False, 2.0
    bpy.ops.umbilics.detect()
    assert judged(obj).remedy == "SUBDIVIDE"
    assert bpy.ops.umbilics.mend(way="SUBDIVIDE") == {"FINISHED"}
    assert [modifier.levels for modifier in obj.modifiers] == [2]
    assert judged(obj).remedy == ""
    obj.modifiers.clear()
    obj.modifiers.new("Triangulate", "TRIANGULATE")
    bpy.ops.object.modifier_apply(modifier="Triangulate")
    bpy.ops.umbilics.detect()
    assert judged(obj).remedy == "SMOOTH"


def test_few_faces_of_a_subdivided_cage_want_another_level(judged):
    bpy.ops.mesh.primitive_cube_add()
    obj = bpy.context.object
    modifier = obj.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels = 2
    bpy.ops.umbilics.detect()
    assert judged(obj).remedy == "SUBDIVIDE"
    assert bpy.ops.umbilics.mend(way="SUBDIVIDE") == {"FINISHED"}
    assert modifier.levels == 3 and bpy.context.scene.umbilics.scale_auto
    assert judged(obj).is_good and len(obj.umbilics.items) == 14
    bpy.ops.object.modifier_apply(modifier="Subdivision")
    obj.umbilics.trust_ratio = 0.8
    assert not judged(obj).is_good and "noise" in judged(obj).trust


@pytest.mark.parametrize("way", ["SUBDIVIDE", "CREASES", "MERGE", "SMOOTH"])
@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_what_was_mended_for_a_detection_that_fails_is_taken_back(addon, monkeypatch, way, mode):
    obj = add_ellipsoid(subdivisions=2)
    obj.data.vertices[0].co = obj.data.vertices[1].co
    modifier = obj.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels, modifier.show_viewport = 1, False
    bpy.ops.umbilics.detect()
    bpy.ops.object.mode_set(mode=mode)
    settings, display = bpy.context.scene.umbilics, bpy.context.scene.umbilics_display
    display.source = "BASE"

    def state():
        if obj.mode == "EDIT":
            obj.update_from_editmode()
        chosen = {name: getattr(settings, name) for name, _ in settings.bl_rna.properties.items()}
        points = [vertex.co[:] for vertex in obj.data.vertices]
        modifiers = [(one.name, one.levels, one.show_viewport) for one in obj.modifiers]
        return chosen, points, modifiers, display.source, obj.mode

    before = state()

    def broken(*_, **__):
        raise addon.core.InvalidMeshError("No such mesh")

    monkeypatch.setattr(addon.operators.jobs.detect, "gather", broken)
    for shown in (True, False):
        if not shown and mode == "OBJECT" and way == "SUBDIVIDE":
            # The first level of a modifier that was made goes with it.
            obj.modifiers.clear()
            before = state()
        with pytest.raises(RuntimeError, match="No such mesh"):
            bpy.ops.umbilics.mend(way=way)
        assert state() == before


def test_vertices_in_the_same_place_are_merged(addon):
    ball = add_ellipsoid(subdivisions=3)
    vertices = [
        vertex.co[:]
        for face in ball.data.polygons
        for vertex in (ball.data.vertices[i] for i in face.vertices)
    ]
    obj = add_mesh(vertices, np.arange(len(vertices)).reshape(-1, 3))
    assert bpy.ops.umbilics.mend(way="MERGE") == {"FINISHED"}
    assert len(obj.data.vertices) == len(ball.data.vertices)
    assert len(obj.umbilics.items) == 4


def test_one_umbilic_and_one_region_are_said_in_the_singular(addon):
    summary = add_ellipsoid(subdivisions=2).umbilics
    summary.lemon, summary.regions, summary.noise = 1, 1, 1.0
    assert addon.operators.base.verdict.verdict(summary).found == "1 umbilic, 1 region"
    summary.lemon = 0
    found = addon.operators.base.verdict.verdict(summary)
    assert (found.found, found.is_good) == ("no isolated umbilics, 1 region", True)
    summary.regions = 0
    assert addon.operators.base.verdict.verdict(summary).found == "no umbilics"


def test_the_automatic_crease_angle_is_known(judged):
    """A box is heeded by itself; a part that is none, with as sharp edges, is not."""
    obj = box()
    bpy.ops.umbilics.detect()
    assert judged(obj).remedy == ""
    assert "; creases of more than " in obj.umbilics.analysed
    bpy.context.scene.umbilics.regions = False
    bpy.ops.umbilics.detect()
    assert judged(obj).remedy == "CREASES"
    assert "creases" not in obj.umbilics.analysed
    assert bpy.ops.umbilics.mend(way="CREASES") == {"FINISHED"}
    assert judged(obj).remedy == ""
