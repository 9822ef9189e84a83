"""The reader of .off files: what people write into them, and what is wrong with some."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import core

CUBE = """OFF
8 6 12
0 0 0
1 0 0
1 1 0
0 1 0
0 0 1
1 0 1
1 1 1
0 1 1
4 0 3 2 1
4 4 5 6 7
4 0 1 5 4
4 1 2 6 5
4 2 3 7 6
4 3 0 4 7
"""


def read(tmp_path, text):
    path = tmp_path / "m.off"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return core.read_off(path)


def test_a_cube(tmp_path):
    vertices, corners, sizes = read(tmp_path, CUBE)
    assert vertices.shape == (8, 3)
    assert sizes.tolist() == [4] * 6
    assert corners[:8].tolist() == [0, 3, 2, 1, 4, 5, 6, 7]


WAYS = {
    "counts beside the word": CUBE.replace("OFF\n8 6 12", "OFF 8 6 12"),
    "no number of edges": CUBE.replace("8 6 12", "8 6"),
    "comments and empty lines": "# by hand\n\n" + CUBE.replace("\n4 0 3", "  # base\n\n4 0 3"),
    "line ends of Windows": CUBE.replace("\n", "\r\n"),
    "colours of faces": CUBE.replace("4 0 3 2 1", "4 0 3 2 1 255 0 0").replace(
        "4 4 5 6 7", "4 4 5 6 7  0.1 0.2 0.3 1.0"
    ),
    "blanks before": CUBE.replace("OFF", "  OFF").replace("\n0 0 0", "\n   0 0 0"),
    "letters that are not ASCII": "# größer\n" + CUBE,
    "a mark of the byte order": "\ufeff" + CUBE,
    "line ends of old Macs": CUBE.replace("\n", "\r"),
    "no blank behind the word": CUBE.replace("OFF\n8 6 12", "OFF8 6 12"),
    "a small word": CUBE.replace("OFF", "off"),
    "a number a line": "\n".join(CUBE.split()),
    "all on one line": " ".join(CUBE.split()),
    "counts on three lines": CUBE.replace("8 6 12", "8\n6\n12"),
    "faces that are broken": CUBE.replace("4 0 1 5 4", "4 0 1\n5 4"),
    "a line end of Unicode in a comment": CUBE.replace("\n4 0 3", " # here\u2028there\n4 0 3"),
}


@pytest.mark.parametrize("text", WAYS.values(), ids=WAYS)
def test_ways_to_write_the_same(tmp_path, text):
    for found, wanted in zip(read(tmp_path, text), read(tmp_path, CUBE), strict=True):
        np.testing.assert_array_equal(found, wanted)


def test_normals_and_colours_of_vertices_are_passed_over(tmp_path):
    text = "CNOFF\n3 1 3\n0 0 0 0 0 1 9 9 9 9\n1 0 0 0 0 1 9 9 9 9\n0 1 0 0 0 1 9 9 9 9\n3 0 1 2\n"
    vertices, corners, sizes = read(tmp_path, text)
    assert vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    assert (corners.tolist(), sizes.tolist()) == ([0, 1, 2], [3])


def test_numbers_of_vertices_with_more_than_a_place_need_no_lines(tmp_path):
    text = "NOFF 3 1 0 0 0 0 0 0 1 1 0 0 0 0 1\n0 1 0 0 0 1 3 0 1 2"
    vertices, corners, _ = read(tmp_path, text)
    assert vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    assert corners.tolist() == [0, 1, 2]


def test_points_and_edges_among_the_faces_are_left_out(tmp_path):
    text = CUBE.replace("8 6 12", "8 8 12") + "2 0 1\n1 4\n"
    _, corners, sizes = read(tmp_path, text)
    assert sizes.tolist() == [4] * 6 and len(corners) == 24


BAD = {
    "not begin with OFF": "solid cube\n",
    "does not begin": "",
    "it does not begin with OFF": "OFFSET\n3 1 0\n",
    "binary": b"OFF BINARY\n\0\0\0\x08",
    "whole numbers": "OFF\nmany few\n",
    "ends before": CUBE.rsplit("\n", 2)[0],
    "fewer corners": CUBE.replace("4 3 0 4 7", "5 3 0 4 7"),
    "not there": CUBE.replace("4 3 0 4 7", "4 3 0 4 8"),
    "not a number": CUBE.replace("4 3 0 4 7", "4 3 0 4 x"),
    "nowhere": CUBE.replace("1 1 0", "1 nan 0"),
    "same number": CUBE.replace("1 1 0", "1 1"),
    "more dimensions than three": "4OFF\n1 0 0\n0 0 0 1\n",
    "dimensions than three": "nOFF\n5\n1 0 0\n0 0 0 1 2\n",
}


@pytest.mark.parametrize("words", BAD)
def test_what_is_wrong_is_said(tmp_path, words):
    with pytest.raises(core.FormatError, match=rf"m\.off: .*{words}"):
        read(tmp_path, BAD[words])


@given(st.binary(max_size=200), st.booleans())
def test_nothing_else_than_a_clear_error_comes_of_any_bytes(tmp_path_factory, data, has_head):
    path = tmp_path_factory.mktemp("off") / "m.off"
    path.write_bytes((b"OFF\n" if has_head else b"") + data)
    try:
        vertices, corners, sizes = core.read_off(path)
    except core.FormatError as error:
        assert str(error)
    else:
        assert len(corners) == sizes.sum()
        assert not len(corners) or corners.max() < len(vertices)


@given(st.lists(st.sampled_from(["0", "1", "3", "-1", "9" * 18, "1e5", "x", "\n"]), max_size=40))
def test_nor_of_any_numbers(tmp_path_factory, words):
    """In particular no counts that are larger than the file make it take memory or time."""
    path = tmp_path_factory.mktemp("off") / "m.off"
    path.write_text(f"OFF {' '.join(words)}")
    try:
        vertices, corners, sizes = core.read_off(path)
    except core.FormatError as error:
        assert str(error)
    else:
        assert len(vertices) <= len(words) and len(corners) == sizes.sum() <= len(words)


@pytest.mark.once
@given(st.lists(st.integers(3, 7), max_size=20), st.randoms(use_true_random=False))
def test_faces_of_any_size_keep_their_order(tmp_path_factory, sizes, random):
    path = tmp_path_factory.mktemp("off") / "m.off"
    faces = [[random.randrange(9) for _ in range(size)] for size in sizes]
    lines = [f"OFF {9} {len(faces)} 0", *["0 0 0"] * 9]
    lines += [f"{len(face)} {' '.join(map(str, face))}" for face in faces]
    path.write_text("\n".join(lines))
    _, corners, found = core.read_off(path)
    assert found.tolist() == sizes
    assert corners.tolist() == [corner for face in faces for corner in face]
