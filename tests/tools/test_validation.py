"""tools/validate: the page, the matching and the planes of symmetry that it rests on."""

import ast
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from validation import equations, symmetry
from validation.page import Page, number
from validation.surfaces_found import in_patch, match, operators, paper_points

ROOT = Path(__file__).resolve().parents[2]
COMMAND = ROOT / "tools" / "run_validation.py"
INSTALLED = "bl_ext.user_default.umbilics"


def top_names(file):
    """What a module has by name at its top."""
    for part in ast.parse(file.read_text("utf-8")).body:
        if isinstance(part, ast.FunctionDef | ast.ClassDef):
            yield part.name
        elif isinstance(part, ast.Import | ast.ImportFrom):
            yield from (alias.asname or alias.name for alias in part.names)
        else:
            yield from (name.id for name in ast.walk(part) if isinstance(name, ast.Name))


@pytest.mark.parametrize("file", sorted(ROOT.glob("tools/**/*.py")), ids=lambda file: file.stem)
def test_what_a_tool_imports_of_the_installed_extension_is_there(file):
    """Only a run in Blender would tell, and no test runs them all."""
    for part in ast.walk(ast.parse(file.read_text("utf-8"))):
        if not isinstance(part, ast.ImportFrom) or not (part.module or "").startswith(INSTALLED):
            continue
        place = ROOT.joinpath(*part.module.removeprefix(INSTALLED).strip(".").split("."))
        module = place / "__init__.py" if place.is_dir() else place.with_suffix(".py")
        for alias in part.names:
            inside = (place / alias.name).is_dir() or (place / f"{alias.name}.py").is_file()
            assert inside or alias.name in set(top_names(module)), f"{part.module}: {alias.name}"


def test_a_page(tmp_path):
    page = Page(tmp_path, None)
    page.heading("Title", 1)
    page.text("Two\n   lines.")
    page.table(["what", "how many"], [["points", 3], ["edges", "1,200"]])
    assert page.figure("picture", "What it\n shows.") == page.figures / "picture.png"
    page.save()
    text = (tmp_path / "validation.md").read_text("utf-8")
    assert text.startswith("# Title\n\nTwo lines.\n\n| what | how many |\n| --- | ---: |\n")
    assert "![picture](figures/validation/picture.png)\n\n*What it shows.*" in text


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0"), (0.12345, "0.123"), (12.3456, "12.3"), (1234.5, "1234"), (1e-7, "1.00e-07")],
)
def test_numbers(value, text):
    assert number(value) == text


def test_unknown_numbers_are_dashes():
    assert number(float("nan")) == "–"


def test_the_papers_own_test_finds_the_three(patch):
    for kind in ("projection", "conformal"):
        points, triangles = paper_points(patch, kind)
        assert np.count_nonzero(in_patch(points)) == 3
        assert len(triangles) == len(points)
        result = match(patch, points, in_patch(points))
        assert np.all(result.error < 0.3)
        assert result.near.tolist() == [1, 1, 1]
        assert result.spurious == 0


@pytest.mark.parametrize("kind", ["exact", "jets", "normals"])
def test_operators_of_each_kind(patch, kind):
    field = operators(patch, kind)
    assert len(field.k1) == len(patch.vertices)
    inside = in_patch(patch.vertices)
    error = np.abs(field.k1 - patch.k1)[inside]
    assert np.median(error) < 0.1 * np.median(np.abs(patch.k1[inside]))


@pytest.fixture(scope="module")
def patch():
    from surfaces import seed_patch

    return seed_patch(5400)


def test_the_plane_of_a_mirrored_cloud():
    random = np.random.default_rng(2)
    half = random.normal(size=(600, 3)) * (1.0, 2.0, 3.0) + (4.0, 0.0, 0.0)
    normal = np.array([1.0, 0.04, -0.02])
    normal /= np.linalg.norm(normal)
    true = symmetry.Mirror(normal, 0.3, 0.0)
    points = np.vstack([half, true.image(half)])
    found = symmetry.of_mesh(points)
    angle, shift = symmetry.difference(found, true, points)
    assert angle < 0.1
    assert shift < 0.01


def test_statements_about_equations_hold():
    corollary, jacobian, generic = equations.statements()
    assert "finds 0 points" in corollary
    assert "of index +0.5 at" in generic
    assert "B⁻¹" in jacobian


def test_a_missing_folder_is_a_clear_error(tmp_path):
    done = subprocess.run(
        [sys.executable, COMMAND, tmp_path / "nowhere"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    assert "there is no folder" in done.stderr


def test_a_half_meshed_anew_leaves_the_other_and_the_surface():
    from surfaces.sampling import icosphere

    points, triangles = icosphere(3)
    true = symmetry.Mirror(np.array([1.0, 0.0, 0.0]), 0.0, 0.0)
    places, faces = symmetry.half_anew(points, triangles, true, 0.0)
    below = points[:, 0] <= 0.0
    assert np.array_equal(places[below], points[below])
    assert np.abs(places[~below] - points[~below]).max() > 0.01
    assert np.abs(np.linalg.norm(places, axis=1) - 1.0).max() < 0.02
    changed = (faces != triangles).any(axis=1)
    assert changed[(points[triangles][:, :, 0] > 0).all(axis=1)].mean() > 0.1
    assert not changed[(points[triangles][:, :, 0] <= 0).any(axis=1)].any()


def test_flipped_edges_leave_a_closed_surface():
    from surfaces.sampling import icosphere

    from core.mesh.mending.repair import clean

    points, triangles = icosphere(3)
    flipped = symmetry.flipped_edges(points, triangles, 0.2, np.random.default_rng(0))
    surface, warnings = clean(points, flipped)
    assert surface.closed.all()
    assert surface.euler_characteristic.sum() == 2
    assert not warnings
    valence = np.bincount(flipped.ravel())
    assert valence.std() > 1.0


def test_clusters_count_once():
    from types import SimpleNamespace

    from validation.regularity import clustered_index

    triangles = np.array([[0, 1, 2], [2, 1, 3], [4, 5, 6]])
    found = SimpleNamespace(vertex=np.array([0, 1, 4, 3]), index=np.array([0.5, 0.5, -0.5, -0.5]))
    assert clustered_index(triangles, found) == -0.5


@pytest.mark.parametrize(("what", "value"), [("flipped", 0.3), ("stretched", 6.0)])
def test_irregular_meshes_put_i_off_and_not_s(what, value):
    from validation.regularity import _mesh, _run

    told = np.array([_run(_mesh(what, value, seed), "normals", seed) for seed in range(2)])
    assert (told[:, 1] == 2.0).all()
    assert told[:, 4].max() > 0.0
