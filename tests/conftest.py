"""What all the tests share. tools/test runs them; see there for what runs where."""

import importlib
import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings
from mesh_files import PACKAGED, packaged_path, read_mesh

try:
    import bpy
except ImportError:
    bpy = None

REPOSITORY = Path(__file__).resolve().parent.parent

# Folders whose tests need Blender around them.
IN_BLENDER = ("operators", "ui")

# The machines are slow and shared, so that a deadline would fail by chance. The same examples every
# time: a suite that is green stays so until something changes, and a failure can be repeated.
# `tools/test --hypothesis-profile explore` looks for new ones.
settings.register_profile(
    "repeatable",
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
    derandomize=True,
)
settings.register_profile("explore", settings.get_profile("repeatable"), derandomize=False)
settings.load_profile("repeatable")


def pytest_ignore_collect(collection_path: Path) -> bool | None:
    # These import bpy, which must not fail the collection of the others.
    if bpy is None and collection_path.suffix == ".py" and _needs_blender(collection_path):
        return True
    return None


def _needs_blender(path: Path) -> bool:
    parts = path.relative_to(REPOSITORY / "tests").parts
    return bool(parts) and parts[0] in IN_BLENDER


def pytest_report_header() -> str:
    if bpy is None:
        return "Blender: none; tests/operators and tests/ui are left out (tools/test runs them)"
    return f"Blender: {bpy.app.version_string}"


@pytest.fixture
def addon():
    """The installed extension, `bl_ext.user_default.umbilics`."""
    if bpy is None:
        pytest.skip("needs Blender: run it with tools/test")
    return importlib.import_module("bl_ext.user_default.umbilics")


@pytest.fixture(scope="session")
def meshes_folder() -> Path:
    """The folder of real meshes, which are no part of the repository."""
    named = os.environ.get("UMBILICS_MESHES")
    folder = Path(named) if named else REPOSITORY.parent / "shared" / "meshes"
    if not folder.is_dir():
        pytest.skip(f"no real meshes: $UMBILICS_MESHES is not set and {folder} does not exist")
    return folder


@pytest.fixture
def real_mesh(request):
    """A function from the name of a real mesh to its vertices and triangles.

    Those of `mesh_files.PACKAGED` come with packages of the tests, the others from the folder.
    """

    def read(name: str):
        if name in PACKAGED:
            path = packaged_path(name)
            if path is None:
                pytest.skip(f"{name}: {PACKAGED[name][0]} is not installed in this Python")
            return read_mesh(path)
        path = request.getfixturevalue("meshes_folder") / name
        if not path.is_file():
            pytest.skip(f"{name} is not in the folder of meshes")
        return read_mesh(path)

    return read
