"""Take the guide's pictures: build, and play tools/guide_in_window.py in a window.

The first chapters show the Stanford bunny, stanford-bunny.obj, if it is in $UMBILICS_MESHES or
../shared/meshes; without it their pictures stay as they are.
"""

import os
import subprocess
import tempfile
from pathlib import Path

import build_extension
import isolated_blender
from places import REPOSITORY, cache_folder, say

scratch = cache_folder() / "screenshots"
scratch.mkdir(parents=True, exist_ok=True)
meshes = Path(os.environ.get("UMBILICS_MESHES") or REPOSITORY.parent / "shared" / "meshes")
with tempfile.TemporaryDirectory(dir=scratch) as name:
    folder = Path(name)
    zip_file = build_extension.build_for_this_blender(folder)
    command = [REPOSITORY / "tools" / "window", "--python", REPOSITORY / "tools/guide_in_window.py"]
    command += ["--", REPOSITORY / "docs" / "figures", zip_file]
    bunny = meshes / "stanford-bunny.obj"
    if bunny.exists():
        command.append(bunny)
    else:
        say(f"{bunny} is not there: the pictures of it stay as they are")
    environment = isolated_blender.environment(folder / "blender")
    raise SystemExit(subprocess.run(command, env=environment, check=False).returncode)
