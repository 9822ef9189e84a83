"""Run the validation inside Blender, with the installed extension.

blender -b --python tools/validate_in_blender.py -- MESH_FOLDER OUTPUT [PART …]
"""

import sys
import time
from pathlib import Path

import bpy

folder, output, *only = sys.argv[sys.argv.index("--") + 1 :]
tools = Path(__file__).resolve().parent
installed = Path(bpy.utils.user_resource("EXTENSIONS")) / "user_default" / "umbilics"
# `import core` finds the installed copy, never the repository's.
sys.path[:0] = [str(path) for path in (installed, tools, tools.parent / "tests")]

from places import say  # noqa: E402
from validation import (  # noqa: E402
    applications,
    convergence,
    cost,
    equations,
    introduction,
    models,
    parametrization,
    patch,
    regularity,
)
from validation.page import Page  # noqa: E402

PARTS = {
    "patch": patch.write,
    "parametrization": parametrization.write,
    "convergence": convergence.write,
    "regularity": regularity.write,
    "models": models.write,
    "applications": applications.write,
    "cost": cost.write,
}

page = Page(Path(output), Path(folder) if folder else None)
introduction.write(page)
for name, write in PARTS.items():
    if only and name not in only:
        continue
    start = time.perf_counter()
    write(page)
    say(f"{name}: {time.perf_counter() - start:.0f} s")
if not only:
    equations.write(page)
introduction.close(page)
page.save()
