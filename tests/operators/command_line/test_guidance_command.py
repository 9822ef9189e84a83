"""--guide on the command line: files beside each other, and what is said."""

import json

from scene_building import add_ellipsoid


def test_guide_writes_the_files_asked_for(run, tmp_path, capsys):
    add_ellipsoid()
    kinds = ["mesh", "rosy", "sing", "lines", "separatrices", "json"]
    assert run("--guide", tmp_path / "out", "--guide-files", *kinds) == 0
    assert "Poles: 8 of valence 3" in capsys.readouterr().out
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [
        "Ellipsoid-lines.obj",
        "Ellipsoid-poles.json",
        "Ellipsoid-separatrices.obj",
        "Ellipsoid.obj",
        "Ellipsoid.rosy",
        "Ellipsoid.sing",
    ]
    poles = json.loads((tmp_path / "out" / "Ellipsoid-poles.json").read_text())["poles"]
    assert [pole["valence"] for pole in poles] == [3] * 8


def test_wrong_smoothness_is_an_error_of_the_arguments(run, tmp_path):
    add_ellipsoid(subdivisions=2)
    assert run("--guide", tmp_path, "--smoothness", "2") == 2
