"""From the zip to a map and back, in a Blender without the extension: see new_user.py."""

import os
from pathlib import Path

import numpy as np
import pytest
from mesh_files import write_obj
from surfaces.sampling import icosphere

BUNNY = "stanford-bunny.obj"


def mesh_file(folder: Path) -> Path:
    """The bunny if it is there, else a sphere with bumps."""
    named = os.environ.get("UMBILICS_MESHES")
    meshes = Path(named) if named else Path(__file__).parents[3] / "shared" / "meshes"
    if (meshes / BUNNY).exists():
        return meshes / BUNNY
    points, triangles = icosphere(5)
    x, y, z = points.T
    points = points * (1.0 + 0.3 * np.sin(3 * x) * np.sin(3 * y + 1) * np.sin(3 * z + 2))[:, None]
    write_obj(folder / "bumps.obj", points, triangles)
    return folder / "bumps.obj"


@pytest.fixture(scope="module")
def found(play, tmp_path_factory):
    mesh = mesh_file(tmp_path_factory.mktemp("mesh"))
    return play("new_user", os.environ["UMBILICS_ZIP"], mesh, new_user=True)


def test_the_zip_is_installed_from_the_preferences(found):
    assert not found["installed_before"]
    assert found["installed"]


def test_the_imported_mesh_is_detected_and_thinned_out(found):
    assert len(found["imported"]) == 1
    assert not found["before"]["detected"]
    assert 0 < found["thinned"] < found["detected"]


def test_a_click_in_the_list_selects_one_umbilic(found):
    assert len(found["chosen"]) == 1


def test_the_gap_is_shown(found):
    assert found["map"]
    assert found["shading_with_map"] == "VERTEX"


def test_undo_takes_all_of_it_back_the_shading_of_the_view_too(found):
    assert found["undo_steps"] <= 5
    assert found["after"] == found["before"]
