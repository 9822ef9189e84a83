"""No result is made of something older, and whatever was read and has changed is named."""

import bpy
import numpy as np
import pytest
from scene_building import add_ellipsoid, moved


@pytest.fixture
def reasons(addon):
    def ask(obj, plan=False):
        bpy.context.view_layer.update()
        staleness = addon.operators.scene.staleness
        found = (staleness.plan_reasons if plan else staleness.reasons)(bpy.context, obj)
        return " ".join(found)

    return ask


@pytest.fixture
def detections(addon, monkeypatch):
    """How many detections were computed, as a list that grows."""
    made, real = [], addon.core.detect

    def counted(*arguments, **named):
        made.append(arguments)
        return real(*arguments, **named)

    monkeypatch.setattr(addon.core, "detect", counted)
    return made


def detected(subdivisions=3):
    obj = add_ellipsoid(subdivisions=subdivisions)
    bpy.ops.umbilics.detect()
    return obj


def give(obj):
    """Keep the results as attributes of the user's, and let them be read."""
    settings = bpy.context.scene.umbilics
    for name, kind in (("k1", 1), ("k2", 1), ("d1", 3), ("d2", 3)):
        key = "value" if kind == 1 else "vector"
        layout = "FLOAT" if kind == 1 else "FLOAT_VECTOR"
        values = np.empty(kind * len(obj.data.vertices), np.float32)
        obj.data.attributes[f"umbilics_{name}"].data.foreach_get(key, values)
        obj.data.attributes.new(f"my_{name}", layout, "POINT").data.foreach_set(key, values)
        setattr(settings, f"given_{name}", f"my_{name}")
    settings.curvature = "given"


def move(obj):
    obj.data.vertices[0].co.x += 0.1


def rebuild(obj):
    obj.data.flip_normals()


def mark_sharp(obj):
    for edge in obj.data.edges[:50]:
        edge.use_edge_sharp = True


def mark_seams(obj):
    obj.data.edges[0].use_seam = True


def unwrap(obj):
    obj.data.uv_layers.active.uv[0].vector.x += 0.5


def overwrite(obj):
    obj.data.attributes["my_k1"].data[0].value += 1.0


def scale(obj):
    obj.scale.z = 1.5


@pytest.mark.parametrize(
    ("work", "word"),
    [
        (move, "moved"),
        (rebuild, "faces"),
        (mark_sharp, "sharp"),
        (scale, "scaled"),
        (overwrite, "given curvatures"),
    ],
)
def test_what_was_read_and_has_changed_is_named(reasons, work, word):
    obj = detected()
    if work == overwrite:
        give(obj)
        bpy.ops.umbilics.detect()
    assert reasons(obj) == ""
    work(obj)
    obj.data.update()
    assert word in reasons(obj)
    bpy.ops.umbilics.detect()
    assert reasons(obj) == ""


@pytest.mark.parametrize(
    ("charts", "work", "other"), [("seams", mark_seams, unwrap), ("uv", unwrap, mark_seams)]
)
def test_what_was_not_read_may_change(reasons, charts, work, other):
    """Method C reads seams or the UV map, whichever the charts come from; method S neither."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=12, y_subdivisions=12)
    obj = bpy.context.object
    height = [0.3 * v.co.x**2 + 0.2 * v.co.y**2 + 0.1 * v.co.x**3 for v in obj.data.vertices]
    for vertex, z in zip(obj.data.vertices, height, strict=True):
        vertex.co.z = z
    settings = bpy.context.scene.umbilics
    settings.method, settings.charts = "C", charts
    bpy.ops.umbilics.detect()
    assert reasons(obj) == ""
    other(obj)
    obj.data.update()
    assert reasons(obj) == ""
    work(obj)
    obj.data.update()
    assert ("seams" in reasons(obj).lower()) == (work == mark_seams)
    assert ("UV map" in reasons(obj)) == (work == unwrap)


def test_marks_that_are_not_read_make_nothing_old(reasons):
    bpy.context.scene.umbilics.crease_marks = False
    obj = detected()
    mark_sharp(obj)
    obj.data.update()
    assert reasons(obj) == ""


def test_faces_of_other_sizes_over_the_same_corners_are_others(addon):
    """A triangle and a pentagon, or two quads: the corners in a row are the same."""
    of_mesh = addon.operators.mesh.fingerprint.of_mesh
    points = [
        (0, 0, 0),
        (1, 0, 0),
        (1, 1, 0),
        (0, 1, 0),
        (2, 0, 1),
        (2, 1, 1),
        (3, 0, 1),
        (3, 1, 2),
    ]
    found = []
    for faces in ([(0, 1, 2), (3, 4, 5, 6, 7)], [(0, 1, 2, 3), (4, 5, 6, 7)]):
        mesh = bpy.data.meshes.new("Mesh")
        mesh.from_pydata(points, [], faces)
        found.append(of_mesh(mesh, np.eye(4)))
    assert found[0].digests["positions"] == found[1].digests["positions"]
    assert found[0].changed(found[1], found[0].digests) == ["faces"]


def test_a_moved_or_mirrored_object_is_the_same_and_a_sheared_one_is_not(addon):
    fingerprint = addon.operators.mesh.fingerprint
    then = fingerprint.Fingerprint({}, fingerprint.metric_of(np.eye(4)))
    for matrix, same in (
        (moved(x=3.0), True),
        (moved(scale=(-1.0, 1.0, 1.0)), True),
        (moved(scale=(1.0, 1.0, 1.001)), False),
        (np.eye(4) + np.eye(4, k=1) * 0.1, False),
    ):
        now = fingerprint.Fingerprint({}, fingerprint.metric_of(np.array(matrix)))
        assert (then.changed(now, ("scale",)) == []) == same


@pytest.mark.parametrize(
    "text", ["", "[]", "[{}, [1]]", "{}", "[1, 2]", "[" * 10000, '[{}, ["a"]]']
)
def test_a_damaged_fingerprint_is_that_of_nothing(addon, text):
    fingerprint = addon.operators.mesh.fingerprint
    damaged = fingerprint.Fingerprint.from_text(text)
    now = fingerprint.Fingerprint({"faces": "f"}, fingerprint.metric_of(np.eye(4)))
    assert damaged.changed(now, ("faces", "scale")) == ["faces", "scale"]


def test_a_plan_goes_on_from_the_detection_and_never_from_an_older_one(detections):
    obj = detected()
    assert len(detections) == 1
    bpy.ops.umbilics.guide()
    bpy.ops.umbilics.separatrices()
    assert len(detections) == 1, "the same input"
    mark_sharp(obj)
    obj.data.update()
    bpy.ops.umbilics.guide()
    assert len(detections) == 2
    bpy.ops.umbilics.detect()
    bpy.ops.umbilics.guide()
    assert len(detections) == 3


def test_a_plan_is_the_same_whether_or_not_a_detection_is_remembered(addon):
    def places(obj):
        poles = [child for child in obj.children if child.get("umbilics_guidance") == "poles"]
        return sorted(tuple(pole.location) for pole in poles)

    obj = detected()
    bpy.ops.umbilics.guide()
    remembered = places(obj)
    addon.operators.base.caches.DETECTIONS.clear()
    addon.operators.base.caches.GUIDES.clear()
    bpy.ops.umbilics.guide()
    assert places(obj) == remembered


def umbilics_of_poles(obj):
    poles = [child for child in obj.children if child.get("umbilics_guidance") == "poles"]
    return sorted({pole["umbilics_umbilic"] for pole in poles} - {-1})


def test_a_deletion_by_hand_does_not_outlive_clear():
    obj = detected()
    bpy.context.scene.umbilics_guidance.plan = "umbilics"
    obj.umbilics.active = 0
    bpy.ops.umbilics.delete_umbilic()
    bpy.ops.umbilics.guide()
    assert umbilics_of_poles(obj) == [0, 1, 2]
    bpy.ops.umbilics.clear()
    bpy.ops.umbilics.guide()
    assert umbilics_of_poles(obj) == [0, 1, 2, 3]


def test_a_plan_keeps_what_the_filters_keep():
    obj = detected()
    bpy.context.scene.umbilics_guidance.plan = "umbilics"
    bpy.context.scene.umbilics.at_most = 2
    bpy.ops.umbilics.guide()
    assert len(umbilics_of_poles(obj)) == 2
    bpy.context.scene.umbilics.at_most = 0
    bpy.ops.umbilics.guide()
    assert umbilics_of_poles(obj) == [0, 1, 2, 3]


def test_a_deletion_by_hand_holds_in_a_plan_of_the_mesh_as_it_is_now():
    """The mesh was refined since: rows are others, and the umbilic is known by its place."""
    obj = detected()
    bpy.context.scene.umbilics_guidance.plan = "umbilics"
    obj.umbilics.active = 0
    bpy.ops.umbilics.delete_umbilic()
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide(smoothness=1.0)
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.umbilics.guide()
    assert umbilics_of_poles(obj) == [0, 1, 2]


def test_a_plan_says_what_it_is_older_than(reasons):
    obj = detected(subdivisions=4)
    group = bpy.context.scene.umbilics_guidance
    obj.vertex_groups.new(name="Zone").add([0, 1, 2], 1.0, "REPLACE")
    group.zone = "Zone"
    bpy.ops.umbilics.guide()
    assert reasons(obj, plan=True) == ""
    group.smoothness_auto, group.smoothness = False, 0.1
    assert "Smoothness" in reasons(obj, plan=True)
    group.property_unset("smoothness_auto")
    group.spacing_auto = False
    assert reasons(obj, plan=True) == "", "that is for lines"
    obj.umbilics.active = 0
    bpy.ops.umbilics.delete_umbilic()
    assert "Other umbilics" in reasons(obj, plan=True)
    bpy.ops.umbilics.restore_deleted()
    assert reasons(obj, plan=True) == ""
    obj.vertex_groups["Zone"].add([3], 1.0, "REPLACE")
    obj.data.update_tag()
    assert "vertex group" in reasons(obj, plan=True)
    bpy.ops.umbilics.guide()
    mark_sharp(obj)
    obj.data.update()
    assert "sharp" in reasons(obj, plan=True)
    bpy.ops.umbilics.guide()
    assert reasons(obj, plan=True) == ""
    obj.scale.x = 2.0
    assert "scaled" in reasons(obj, plan=True)


def test_staleness_is_looked_at_once_until_the_object_is_touched(addon, monkeypatch, reasons):
    obj = detected()
    assert reasons(obj) == ""
    looked, real = [], addon.operators.mesh.fingerprint.of_mesh

    def counted(*arguments):
        looked.append(1)
        return real(*arguments)

    monkeypatch.setattr(addon.operators.mesh.fingerprint, "of_mesh", counted)
    for _ in range(5):
        assert reasons(obj) == ""
    assert len(looked) == 0
    move(obj)
    obj.data.update()
    for _ in range(5):
        assert "moved" in reasons(obj)
    assert len(looked) == 1


def test_lines_of_a_sphere_are_refused_in_words_and_the_other_files_written(tmp_path):
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=4)
    path = str(tmp_path / "sphere.obj")
    assert bpy.ops.umbilics.export_field(filepath=path, lines=True) == {"FINISHED"}
    assert sorted(file.name for file in tmp_path.iterdir()) == [
        "sphere.obj",
        "sphere.rosy",
        "sphere.sharp",
    ]
    only = dict.fromkeys(("mesh", "rosy", "sharp"), False)
    with pytest.raises(RuntimeError) as caught:
        bpy.ops.umbilics.export_field(filepath=path, lines=True, **only)
    assert "no preferred direction" in str(caught.value)
    assert "Traceback" not in str(caught.value)


def test_operators_keep_no_state_of_their_own(addon):
    """Module-level containers and `global` are for registration, the task and the caches."""
    import ast
    from pathlib import Path

    allowed = {
        ("jobs/worker.py", "_running"),
        ("base/changes.py", "_listeners"),
        ("command_line/__init__.py", "_handles"),
        # What a Mend that runs takes back.
        ("mend.py", "_mended"),
    }
    root, found = Path(addon.operators.__file__).parent, set()
    for file in root.rglob("*.py"):
        name = file.relative_to(root).as_posix()
        tree = ast.parse(file.read_text("utf-8"))
        for node in ast.walk(tree):
            if isinstance(node, ast.Global):
                found |= {(name, each) for each in node.names}
        for node in tree.body:
            value = getattr(node, "value", None)
            is_empty = isinstance(value, ast.List | ast.Dict | ast.Set) and not any(
                getattr(value, part, None) for part in ("elts", "keys")
            )
            if isinstance(node, ast.Assign | ast.AnnAssign) and is_empty:
                targets = node.targets if isinstance(node, ast.Assign) else [node.target]
                found |= {(name, target.id) for target in targets}
    assert found == allowed
