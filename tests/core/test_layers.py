"""Arrows point one way: ui -> operators -> core, and core knows no Blender."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
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
