"""Take the pictures of docs/retopology.md: tools/retopology_pictures.py [FOLDER OF MESHES].

An ellipsoid and Blender's monkey are always drawn; with a folder also the meshes named below that
lie in it.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import build_extension
import isolated_blender
from places import BLENDER, REPOSITORY, cache_folder

NAMES = ("spot_os.obj", "hand_closed_os.obj", "rocker-arm.obj", "bunny_hr_os.obj", "fandisk.obj")

scratch = cache_folder() / "screenshots"
scratch.mkdir(parents=True, exist_ok=True)
meshes = [Path(name) / mesh for name in sys.argv[1:2] for mesh in NAMES]
with tempfile.TemporaryDirectory(dir=scratch) as name:
    folder = Path(name)
    zip_file = build_extension.build_for_this_blender(folder)
    isolated_blender.install(zip_file, folder / "blender")
    command = [BLENDER, "-b", "--python-exit-code", "1"]
    command += ["--python", REPOSITORY / "tools" / "retopology_in_blender.py", "--"]
    command += [REPOSITORY / "docs" / "figures", *(mesh for mesh in meshes if mesh.is_file())]
    environment = isolated_blender.environment(folder / "blender")
    window = [REPOSITORY / "tools" / "window"]
    window += ["--python", REPOSITORY / "tools" / "retopology_in_window.py", "--"]
    window += [REPOSITORY / "docs" / "figures"]
    window += [mesh for mesh in meshes if mesh.name == NAMES[0] and mesh.is_file()]
    for one in (command, window):
        subprocess.run(one, env=environment, check=True)
