"""The page about lines measures what it says."""

import numpy as np
import pytest
from mesh_files import write_obj
from surfaces import ellipsoid

from benchmarks import lines as page
from core.retopology.lines.polylines import Lines


def drawn(*paths, normals=None, family=0):
    """Lines through points, in planes of given normals, z for none."""
    points = np.concatenate([np.asarray(path, float) for path in paths])
    start = np.cumsum([0, *map(len, paths)])
    count, none = len(paths), np.full(len(paths), -1)
    up = np.tile([0.0, 0.0, 1.0], (len(points), 1)) if normals is None else np.asarray(normals)
    return Lines(
        start, points, up, np.zeros(len(points), int), np.zeros((len(points), 3)),
        np.full(count, family), np.ones(count), np.zeros(count, bool), none, none,
    )  # fmt: skip


def test_turns_are_those_between_planes_laid_side_by_side():
    flat = drawn([(0, 0, 0), (1, 0, 0), (2, 0, 0), (2, 1, 0)])
    assert page.turns(flat) == pytest.approx([90.0])
    assert page.last_turns(flat) == pytest.approx([90.0])
    # Straight over the edge of a box; a chord through it, where a point was left out, is no turn.
    over = [(0, 0, 0), (0.9, 0, 0), (1, 0, -0.1), (1, 0, -1)]
    up, side = (0, 0, 1), (1, 0, 0)
    assert page.turns(drawn(over, normals=[up, up, side, side])) == pytest.approx([0.0])


def test_a_bow_of_chords_through_the_surface_turns_from_chord_to_chord():
    """As around the tip of a finger, where points were left out; not by all of them together."""
    angle = np.radians(25.0 * np.arange(5))
    chord = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    bow = np.concatenate([np.zeros((1, 3)), np.cumsum(chord, axis=0)])
    normals = np.tile([0.0, 0.0, 1.0], (6, 1))
    normals[2:5] += 0.1 * chord[1:4]
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    assert page.turns(drawn(bow, normals=normals)) == pytest.approx([25.0], abs=0.2)


def test_lines_that_run_beside_each_other_are_seen_and_common_pieces_are_not():
    one = [(x, 0, 0) for x in range(11)]
    near, far = ([(x, y, 0) for x in range(11)] for y in (0.1, 3.0))
    assert page.beside(drawn(one, near), 0.2) > 0.9
    assert page.beside(drawn(one, far), 0.2) == 0.0
    assert page.beside(drawn(one, [(0, 2, 0), *one[5:]]), 0.2) < 0.1


def test_every_shape_has_a_row(tmp_path, capsys):
    mesh = ellipsoid(subdivisions=3)
    write_obj(tmp_path / "egg.obj", mesh.vertices, mesh.triangles)
    assert page.main([str(tmp_path / "egg.obj"), "--out", str(tmp_path / "lines.md")]) == 0
    row = capsys.readouterr().out.partition("| egg |")[2].partition("\n")[0].split("|")
    assert [cell.strip() for cell in row[:3]] == ["4", "100.0", "4"]
    assert row[-2].strip() == "0" and row[-3].strip() == "8"
