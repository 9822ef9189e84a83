"""Take the guide's pictures: build, install, and play tools/guide_in_window.py in a window."""

import subprocess
import tempfile
from pathlib import Path

import build_extension
import isolated_blender
from places import REPOSITORY, cache_folder

scratch = cache_folder() / "screenshots"
scratch.mkdir(parents=True, exist_ok=True)
with tempfile.TemporaryDirectory(dir=scratch) as name:
    folder = Path(name)
    zip_file = build_extension.build_for_this_blender(folder)
    isolated_blender.install(zip_file, folder / "blender")
    command = [REPOSITORY / "tools" / "window", "--python", REPOSITORY / "tools/guide_in_window.py"]
    command += ["--", REPOSITORY / "docs" / "figures", zip_file]
    environment = isolated_blender.environment(folder / "blender")
    raise SystemExit(subprocess.run(command, env=environment, check=False).returncode)
