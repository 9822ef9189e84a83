"""Blender with preferences and extensions of its own, apart from the user's."""

import json
import os
import subprocess
from pathlib import Path

from places import BLENDER, run_quietly

_DESCRIBE = """
import importlib.util, json, platform, sys, bpy
print("BLENDER " + json.dumps({
    "version": list(bpy.app.version),
    "python": f"{sys.version_info.major}.{sys.version_info.minor}",
    "scipy": importlib.util.find_spec("scipy") is not None,
    "system": platform.system(),
    "machine": platform.machine(),
}))
"""

_SYSTEMS = {"Windows": "windows", "Darwin": "macos", "Linux": "linux"}
_MACHINES = {"x86_64": "x64", "amd64": "x64", "arm64": "arm64", "aarch64": "arm64"}


def describe() -> dict:
    """Version, Python, SciPy and extension platform of the Blender that tools/blender runs."""
    # The first time, this sets Blender up and tells the user so on standard error.
    if subprocess.run([BLENDER, "--version"], stdout=subprocess.DEVNULL, check=False).returncode:
        raise SystemExit(1)
    command = [BLENDER, "-b", "--factory-startup", "--python-exit-code", "1"]
    output = run_quietly([*command, "--python-expr", _DESCRIBE], "start Blender")
    line = next(line for line in output.splitlines() if line.startswith("BLENDER "))
    facts = json.loads(line.removeprefix("BLENDER "))
    machine = facts["machine"].lower()
    facts["platform"] = f"{_SYSTEMS[facts['system']]}-{_MACHINES.get(machine, machine)}"
    return facts


def environment(resources: Path) -> dict[str, str]:
    """The environment in which Blender keeps everything of the user's in that folder."""
    kept = {k: v for k, v in os.environ.items() if not k.startswith("BLENDER_USER_")}
    # Blender leaves out a folder that is not there.
    resources.mkdir(parents=True, exist_ok=True)
    return kept | {"BLENDER_USER_RESOURCES": str(resources)}


def install(zip_file: Path, resources: Path) -> None:
    """Install and enable the extension there, as a user does with a file from disk."""
    command = [BLENDER, "-b", "--command", "extension", "install-file"]
    command += ["--repo", "user_default", "--enable", zip_file]
    run_quietly(command, f"install {zip_file.name} in Blender", env=environment(resources))
