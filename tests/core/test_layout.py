"""The house: ui -> operators -> core, rooms in one order, no cycle, no crowded folder."""

import ast
import subprocess
import sys
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
# A room imports only from itself and from the rooms before it.
ROOMS = {
    "core": (
        "base",
        "mesh",
        "fields",
        "curvature",
        "umbilics",
        "matching",
        "retopology",
        "formats",
    ),
    "operators": ("base", "drawing", "mesh", "data", "scene", "jobs", "command_line"),
}
# Files that a newcomer can take in at one glance, beside the word on the room itself. The root of
# operators is a list of what the user can do, one file an operator and nothing else.
CROWDED = 15
ONE_AN_OPERATOR = "operators"
BLENDER = {"bpy", "bmesh", "mathutils", "gpu", "gpu_extras", "blf", "bl_ui"}


def imported(path: Path) -> set[str]:
    """Top names of what a module imports; relative ones by the package they reach."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            if node.level == 0:
                names.add((node.module or "").split(".")[0])
            else:
                # The package that the dots climb to, seen from the repository.
                folder = path.parent
                for _ in range(node.level - 1):
                    folder = folder.parent
                target = folder.relative_to(ROOT).parts + tuple((node.module or "").split("."))
                if target and target[0]:
                    names.add(target[0])
                names |= {alias.name for alias in node.names if not target or not target[0]}
    return names


def modules(folder: str) -> list[Path]:
    return sorted((ROOT / folder).rglob("*.py"))


@pytest.mark.parametrize("path", modules("core"), ids=lambda path: path.name)
def test_core_imports_no_blender_and_nothing_above_it(path):
    assert not imported(path) & (BLENDER | {"operators", "ui"})
    assert "print(" not in path.read_text()


@pytest.mark.parametrize("path", modules("operators"), ids=lambda path: path.name)
def test_operators_do_not_reach_into_the_ui(path):
    assert "ui" not in imported(path)


@pytest.mark.parametrize("path", modules("ui"), ids=lambda path: path.name)
def test_ui_computes_nothing(path):
    assert not imported(path) & {"scipy"}


def test_core_imports_on_its_own():
    code = "import sys, core; assert not any(name.startswith('bpy') for name in sys.modules)"
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True)


def targets(path: Path) -> set[Path]:
    """The files of this repository that a module imports relatively."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if not isinstance(node, ast.ImportFrom) or node.level == 0:
            continue
        place = path.parents[node.level - 1].joinpath(*(node.module or "").split("."))
        for name in (None, *(alias.name for alias in node.names)):
            at = place / name if name else place
            if at.with_suffix(".py").is_file():
                found.add(at.with_suffix(".py"))
            elif name and not at.is_dir() and (place / "__init__.py").is_file():
                found.add(place / "__init__.py")
            elif name and (at / "__init__.py").is_file():
                found.add(at / "__init__.py")
    return found - {path}


def room(path: Path, house: str) -> str | None:
    parts = path.relative_to(ROOT / house).parts
    return parts[0] if len(parts) > 1 else None


@pytest.mark.parametrize("house", ROOMS)
def test_every_folder_is_a_room_of_the_list(house):
    folders = {path.parent.relative_to(ROOT / house).parts[:1] for path in modules(house)}
    assert {parts[0] for parts in folders if parts} == set(ROOMS[house])


@pytest.mark.parametrize("house", ROOMS)
def test_a_room_imports_only_rooms_before_it(house):
    against = []
    for path in modules(house):
        here = room(path, house)
        for target in targets(path):
            if here is None or not target.is_relative_to(ROOT / house):
                continue
            there = room(target, house)
            if there is None or ROOMS[house].index(there) > ROOMS[house].index(here):
                against.append(f"{path.relative_to(ROOT)} -> {target.relative_to(ROOT)}")
    assert not against


@pytest.mark.parametrize("house", ["core", "operators", "ui"])
def test_no_module_imports_itself_by_way_of_others(house):
    graph = {path: targets(path) for path in modules(house)}
    # A package's own __init__ collects what its modules hold; they do not import it.
    TopologicalSorter(graph).prepare()


@pytest.mark.parametrize("house", ["core", "operators", "ui"])
def test_no_folder_is_crowded(house):
    folders = {path.parent for path in modules(house)}
    counts = {
        str(folder.relative_to(ROOT)): len(set(folder.glob("*.py")) - {folder / "__init__.py"})
        for folder in folders
    }
    counts.pop(ONE_AN_OPERATOR, None)
    assert not {name: count for name, count in counts.items() if count > CROWDED}


def test_the_root_of_operators_holds_operators_only():
    for path in (ROOT / ONE_AN_OPERATOR).glob("*.py"):
        classes = [n.name for n in ast.parse(path.read_text()).body if isinstance(n, ast.ClassDef)]
        operators = [name for name in classes if name.startswith("UMBILICS_OT_")]
        assert path.name == "__init__.py" or len(operators) == 1, path.name


@pytest.mark.parametrize("path", modules("operators/drawing"), ids=lambda path: path.name)
def test_drawing_knows_no_blender(path):
    assert not imported(path) & BLENDER
