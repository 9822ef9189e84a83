"""Strokes and poles that come from files."""

import json
from pathlib import Path

import numpy as np
import pytest
from surfaces import ellipsoid

import core
from core.formats.curves import read_curves

ROOT = Path(__file__).resolve().parents[3]


def written(folder, content, name="hand.json"):
    path = folder / name
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    return path


def test_strokes_and_poles_of_a_json_file(tmp_path):
    content = {
        "strokes": [
            {"points": [[0, 0, 1], [1, 0, 1], [1, 1, 1]], "closed": True, "influence": 0.5},
            {"points": [[0, 0, 2], [1, 0, 2]]},
        ],
        "poles": [{"position": [1, 2, 3], "valence": 3}, {"x": 4, "y": 5.5, "z": 6, "valence": 5}],
    }
    found = core.read_steering(written(tmp_path, content))
    assert [line.tolist() for line in found.lines] == [
        [[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 0, 1]],
        [[0, 0, 2], [1, 0, 2]],
    ]
    strokes = found.strokes(10.0, core.StrokeSettings(influence=0.2))
    assert strokes.start.tolist() == [0, 4, 6] and strokes.influence.tolist() == [0.5, 2.0]
    assert found.strokes(10.0).influence.tolist() == [0.5, 1.0]
    assert found.wanted.position.tolist() == [[1, 2, 3], [4, 5.5, 6]]
    assert found.wanted.valence.tolist() == [3, 5]
    turn = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]])
    assert found.turned(turn).lines[1].tolist() == [[0, 0, 2], [0, 1, 2]]
    assert found.turned(turn).wanted.position[0].tolist() == [-2, 1, 3]


def test_poles_that_are_not_there_are_planned_and_no_poles_are_none(tmp_path):
    free = core.read_steering(written(tmp_path, {"strokes": []}))
    assert free.wanted is None and free.strokes(1.0) is None
    none = core.read_steering(written(tmp_path, {"poles": []}))
    assert none.wanted.position.shape == (0, 3)


@pytest.mark.slow
def test_the_poles_that_a_guidance_was_written_with_can_be_read(tmp_path):
    mesh = ellipsoid(subdivisions=3)
    guide = core.Guide(mesh.vertices, mesh.triangles, core.detect(mesh.vertices, mesh.triangles))
    both = mesh.vertices, mesh.triangles
    settings = core.GuidanceSettings()
    kinds = ["json", "separatrices"]
    made = core.export_guidance(tmp_path / "e", kinds, guide, settings, mesh=both)
    found = core.read_steering(made.paths[0])
    assert np.allclose(found.wanted.position, made.guidance.poles.position)
    again = guide.guidance(wanted=found.wanted).poles
    assert sorted(again.valence) == sorted(made.guidance.poles.valence)
    lines = core.read_steering(made.paths[1])
    # The four arcs are one ellipse.
    (line,) = lines.lines
    assert (line[0] == line[-1]).all()
    held = guide.guidance(strokes=lines.strokes(6.0))
    assert held.warnings == ()


def test_polylines_of_an_obj_go_on_where_they_meet(tmp_path):
    """Blender writes an element for every edge."""
    points = "".join(f"v {x} {y} 0\n" for x, y in ((0, 0), (1, 0), (2, 0), (2, 1), (5, 5), (6, 5)))
    path = written(tmp_path, points + "# Möbius\nl 2 3\nl 1 2\nl 4/9 3/9\nl -2 -1\n", "lines.obj")
    lines = [line[:, :2].tolist() for line in core.read_steering(path).lines]
    assert sorted(map(len, lines)) == [2, 4]
    long = next(line for line in lines if len(line) == 4)
    assert long in ([[0, 0], [1, 0], [2, 0], [2, 1]], [[2, 1], [2, 0], [1, 0], [0, 0]])
    # Three that meet stay apart, and a ring is one line that comes back.
    star = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nl 1 2\nl 1 3\nl 1 4\n"
    assert len(core.read_steering(written(tmp_path, star, "star.obj")).lines) == 3
    ring = "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\nl 2 3\nl 3 1\n"
    (line,) = core.read_steering(written(tmp_path, ring, "ring.obj")).lines
    assert len(line) == 4 and (line[0] == line[-1]).all()
    assert len(read_curves(path)[0]) == 4


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("{", "is not JSON"),
        ("[]", "must be an object"),
        ({"lines": []}, "must be an object with"),
        ({"strokes": {}}, '"strokes" must be a list'),
        ({"strokes": [[1, 2]]}, "stroke 1 must be an object"),
        ({"strokes": [{"points": [[0, 0, 0]]}]}, "stroke 1 needs two points"),
        ({"strokes": [{"points": [[0, 0], [1, 1]]}]}, "three numbers"),
        ('{"strokes": [{"points": [[0, 0, NaN], [1, 1, 1]]}]}', "three numbers"),
        ({"strokes": [{"points": [[0] * 3, [1] * 3], "closed": 1}]}, '"closed" of stroke 1'),
        ({"strokes": [{"points": [[0] * 3, [1] * 3], "influence": -1}]}, '"influence" of stroke 1'),
        ({"poles": [3]}, "pole 1 must be an object"),
        ({"poles": [{"valence": 3}]}, "a place of pole 1"),
        ({"poles": [{"position": [0, 0, 0], "valence": 4}]}, "a pole has 3 or 5"),
        ({"poles": [{"position": [0, 0, 0]}]}, "a pole has 3 or 5"),
    ],
)
def test_what_is_wrong_is_said(tmp_path, content, said):
    with pytest.raises(core.FormatError, match=said):
        core.read_steering(written(tmp_path, content))


def test_files_of_other_kinds_are_refused(tmp_path):
    with pytest.raises(core.FormatError, match=r"\.json and \.obj"):
        core.read_steering(written(tmp_path, "x", "strokes.svg"))
    with pytest.raises(core.FormatError, match="holds no line"):
        core.read_steering(written(tmp_path, "v 0 0 0\n", "mesh.obj"))
    with pytest.raises(core.FormatError, match="cannot be read"):
        core.read_steering(tmp_path / "none.json")
