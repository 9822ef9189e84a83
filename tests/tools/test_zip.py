"""The built zip: what is in it, and that Blender takes it."""

import os
import tomllib
import zipfile
from pathlib import Path, PurePosixPath

import pytest

RUNTIME = {"blender_manifest.toml", "__init__.py", "LICENSE", "core", "operators", "ui"}


@pytest.fixture(scope="module")
def built():
    path = os.environ.get("UMBILICS_ZIP")
    if not path:
        pytest.skip("there is no zip to look at: tools/test builds one")
    with zipfile.ZipFile(path) as file:
        yield file


def test_only_runtime_files_ship(built):
    paths = [PurePosixPath(name) for name in built.namelist() if not name.endswith("/")]
    assert {path.parts[0] for path in paths} - {"wheels"} == RUNTIME
    for path in paths:
        assert not any(part.startswith((".", "__pycache__")) for part in path.parts), path
        if path.parts[0] in ("core", "operators", "ui"):
            help_page = path.parent == PurePosixPath("ui/help") and path.suffix == ".html"
            assert path.suffix in (".py", ".po") or help_page, path


def test_the_manifest_keeps_the_rules_of_the_extensions_site(built):
    manifest = tomllib.loads(built.read("blender_manifest.toml").decode())
    assert manifest["id"] == "umbilics"
    assert len(manifest["tagline"]) <= 64
    assert manifest["tagline"][-1].isalnum()
    assert all(len(reason) <= 64 for reason in manifest["permissions"].values())
    assert {"__pycache__/", ".*", "/*.zip"} <= set(manifest["build"]["paths_exclude_pattern"])


def test_the_code_leaves_the_search_path_of_python_alone(built):
    for name in built.namelist():
        if name.endswith(".py"):
            code = built.read(name).decode()
            assert "sys.path" not in code, name
            assert "sys.modules" not in code, name


def test_the_zip_is_the_working_tree_of_now(built):
    repository = Path(__file__).resolve().parents[2]
    assert built.read("__init__.py") == (repository / "__init__.py").read_bytes()
