"""Run pytest inside Blender, against the installed extension.

    blender -b --python tools/pytest_in_blender.py -- PACKAGES pytest-arguments…
    python tools/pytest_in_blender.py -- PACKAGES pytest-arguments…

PACKAGES is the folder with pytest for Blender's Python. The second form is for a Python that has
Blender as a module.
"""

import os
import sys
from pathlib import Path

import bpy

if not bpy.app.binary_path:
    # The module reads no preferences, where it is enabled already.
    bpy.ops.preferences.addon_enable(module="bl_ext.user_default.umbilics")

packages, *arguments = sys.argv[sys.argv.index("--") + 1 :]
tests = Path(__file__).resolve().parent.parent / "tests"
extensions = Path(bpy.utils.user_resource("EXTENSIONS"))
installed = extensions / "user_default" / "umbilics"

# `import core` finds the installed copy, never the repository's.
folders = [installed, packages, tests, *(path for path in tests.iterdir() if path.is_dir())]
sys.path[:0] = [str(folder) for folder in folders]

import pytest  # noqa: E402

options = ["-o", "pythonpath=", "-p", "no:cacheprovider"]
code = pytest.main([*options, *arguments])
sys.stdout.flush()
sys.stderr.flush()
# Without Blender's own end: the tests are done, and its exit code is not pytest's.
os._exit(int(code))
