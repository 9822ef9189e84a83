"""From the zip to a map and back, in a Blender without the extension: see new_user.py."""

import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
from surfaces.sampling import icosphere

SCENARIO = Path(__file__).with_name("new_user.py")
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
    lines = [f"v {a:.6f} {b:.6f} {c:.6f}" for a, b, c in points]
    lines += [f"f {a} {b} {c}" for a, b, c in triangles + 1]
    path = folder / "bumps.obj"
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    window, zip_file = os.environ.get("UMBILICS_WINDOW"), os.environ.get("UMBILICS_ZIP")
    if not window:
        pytest.skip("needs a window: run it with tools/test --gui")
    folder = tmp_path_factory.mktemp("new_user")
    (folder / "blender").mkdir()
    chosen = os.environ.get("UMBILICS_PICTURES")
    pictures = Path(chosen) if chosen else folder
    done = subprocess.run(
        [window, "--python", SCENARIO, "--", zip_file, mesh_file(folder), pictures],
        capture_output=True,
        text=True,
        timeout=400,
        check=False,
        env=os.environ | {"BLENDER_USER_RESOURCES": str(folder / "blender")},
    )
    report = pictures / "new_user.json"
    assert report.exists(), done.stdout + done.stderr
    assert done.returncode == 0, done.stderr
    return json.loads(report.read_text())


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
