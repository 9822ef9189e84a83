"""tools/run: how it reads its arguments, and what it says of a result."""

from pathlib import Path

import pytest
import run_umbilics


@pytest.mark.parametrize(
    ("arguments", "files", "options"),
    [
        ([], [], []),
        (["a.obj", "b.PLY"], ["a.obj", "b.PLY"], []),
        (["--method", "S"], [], ["--method", "S"]),
        (["a.obj", "--opening", "2", "b.stl"], ["a.obj", "b.stl"], ["--opening", "2"]),
        (["--no-regions", "a.glb"], ["a.glb"], ["--no-regions"]),
        (["--opening=2", "folder/mesh"], ["folder/mesh"], ["--opening=2"]),
    ],
)
def test_files_and_options_are_told_apart(arguments, files, options):
    assert run_umbilics.split_arguments(arguments) == ([Path(f) for f in files], options)


def test_results_that_would_overwrite_something_are_refused(tmp_path):
    one, two = tmp_path / "a" / "x.obj", tmp_path / "b" / "X.ply"
    own = tmp_path / "out" / "x-umbilics.blend"
    assert run_umbilics.overwritten([one], tmp_path / "out") == ""
    assert "both" in run_umbilics.overwritten([one, two], tmp_path / "out")
    assert "files to read" in run_umbilics.overwritten([one, own], tmp_path / "out")


def entry(**changes):
    return {
        "object": "mesh",
        "triangles": 1280,
        "counts": {"star": 0, "lemon": 4, "monstar": 0, "compound": 0, "uncertain": 0},
        "index_sum": 2.0,
        "expected_index_sum": 2.0,
        "euler_characteristic": 2,
        "regions": [],
        "warnings": [],
    } | changes


def test_a_closed_surface_whose_indices_sum_to_its_characteristic():
    assert run_umbilics.in_words("e.obj", {"objects": [entry()]}) == (
        "e.obj: 1,280 triangles, 4 umbilics (4 lemons); "
        "their indices sum to 2, which is χ, as it must be."
    )


def test_a_sum_that_is_wrong_is_said_to_be():
    text = run_umbilics.in_words("e.obj", {"objects": [entry(index_sum=1.5)]})
    assert text.endswith("their indices sum to 1.5, but χ is 2.")


def test_an_open_surface():
    open_surface = entry(
        counts={"star": 1, "lemon": 2, "uncertain": 1},
        index_sum=0.5,
        expected_index_sum=None,
        euler_characteristic=-3,
    )
    assert run_umbilics.in_words("e.obj", {"objects": [open_surface]}) == (
        "e.obj: 1,280 triangles, 4 umbilics (1 star, 2 lemons, 1 uncertain); "
        "their indices sum to 0.5 (χ is -3; the surface is not closed)."
    )


def test_regions_warnings_and_objects_are_named():
    report = {
        "objects": [
            entry(counts={}, regions=[{}], warnings=["Two faces are the same."]),
            entry(object="other"),
            {"object": "bad", "error": "no faces"},
        ]
    }
    first, warning, second = run_umbilics.in_words("e.blend", report).splitlines()
    assert first.startswith("e.blend, mesh: 1,280 triangles, no umbilics; 1 spherical or planar")
    assert warning == "  Warning: Two faces are the same."
    assert second.startswith("e.blend, other: ")
