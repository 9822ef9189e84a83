"""Blender as a Python module (bpy), in a virtual environment of its own for each version.

These stand for Blender.org's builds: NumPy is there and SciPy is not, so that the extension has
to bring its own.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

from places import TOOLS, cache_folder, made_once, run_quietly, say
from python_packages import test_python

# What bpy links to on Linux, by Debian's names.
LIBRARIES = "libx11-6 libxi6 libxxf86vm1 libxfixes3 libxrender1 libxkbcommon0 libsm6 libice6 libgl1"


class UnavailableError(Exception):
    """This Blender cannot be had here; the text says why."""


class Module(NamedTuple):
    """A version of bpy, the Python it is for, and what Blender.org ships with it."""

    name: str
    python: str
    bpy: str
    numpy: str
    required: bool = True


MODULES = (
    Module("4.2 LTS", "3.11", "bpy==4.2.23", "numpy==1.24.4"),
    Module("4.5 LTS", "3.11", "bpy==4.5.15", "numpy==1.26.4"),
    Module("5.0", "3.11", "bpy==5.0.1", "numpy==1.26.4"),
    # Few machines have Python 3.13 yet; Debian 13's, set up for Blender 4.3, serves as well.
    Module("5.2 LTS", "3.13", "bpy==5.2.3", "numpy==2.3.5", required=False),
)

# Run by bash inside Debian's root file system, for its Python.
_IN_DEBIAN = 'tools=$1; shift; . "$tools/choose_blender.sh"; provide_debian_root trixie'
_IN_DEBIAN += ' && enter_debian_root "$debian_root" python3 "$@"'


def command_of(module: Module) -> list[str]:
    """The command that starts Python with this bpy installed.

    Raises
    ------
    UnavailableError
        There is no such Python here, or the packages cannot be downloaded or loaded.
    """
    folder = cache_folder() / "bpy" / f"{module.bpy}-{module.numpy}-python{module.python}"
    python = _python(module.python)
    try:
        made_once(folder, lambda partial: _install(module, python, partial))
    except SystemExit:
        raise UnavailableError(f"{module.bpy} could not be installed; see above") from None
    command = [*_inside(python), str(folder / "bin" / "python")]
    if not _loads(command):
        _install_libraries()
        if not _loads(command):
            raise UnavailableError(f"{module.bpy} does not load; it needs {LIBRARIES}")
    return command


def install(command: list[str], zip_file: Path, environment: dict[str, str]) -> str:
    """Install the extension in the Blender that `command` starts; where its SciPy comes from.

    Raises
    ------
    SystemExit
        It cannot be installed, or SciPy is not the one of the zip.
    """
    script = TOOLS / "install_in_module.py"
    output = run_quietly([*command, script, zip_file], f"install {zip_file.name}", env=environment)
    return next(line for line in output.splitlines() if line.startswith("SciPy "))


def _python(version: str) -> str | None:
    """A Python of the machine, or None for the one of Debian's root file system."""
    names = [sys.executable, f"python{version}"]
    for name in names:
        code = "import sys; print('%d.%d' % sys.version_info[:2], sys.executable)"
        try:
            done = subprocess.run([name, "-c", code], capture_output=True, text=True, check=False)
        except OSError:
            continue
        if done.returncode == 0 and done.stdout.split()[0] == version:
            return done.stdout.split(maxsplit=1)[1].strip()
    if version == "3.13" and shutil.which("apt-get"):
        return None
    raise UnavailableError(f"there is no Python {version} on this machine")


def _inside(python: str | None) -> list[str]:
    """What goes before a command so that it runs where `python` is."""
    if python is not None:
        return []
    # `python3` of the root is only the way in: the environment's own Python replaces it.
    become = "import os, sys; os.execv(sys.argv[1], sys.argv[1:])"
    return ["bash", "-c", _IN_DEBIAN, "bash", str(TOOLS), "-c", become]


def _install(module: Module, python: str | None, folder: Path) -> None:
    say(f"installing Blender {module.name} as a Python {module.python} module, once …")
    base = [python] if python else ["bash", "-c", _IN_DEBIAN, "bash", TOOLS]
    # It is moved when it is complete, which only the programs of packages would mind.
    run_quietly([*base, "-m", "venv", "--without-pip", folder], "make a virtual environment")
    packages = folder / "lib" / f"python{module.python}" / "site-packages"
    command = [test_python(), "-m", "pip", "install", "--quiet", "--target", packages]
    command += ["--only-binary=:all:", "--implementation", "cp"]
    command += ["--python-version", module.python, "--abi", "cp" + module.python.replace(".", "")]
    # pip would hold its own Python against what Blender requires.
    command += ["--abi", "abi3", "--abi", "none", "--ignore-requires-python"]
    for tag in ("manylinux_2_28", "manylinux_2_27", "manylinux_2_17", "manylinux2014"):
        command += ["--platform", f"{tag}_x86_64"]
    run_quietly([*command, module.bpy, module.numpy], f"install {module.bpy}")


def _loads(command: list[str]) -> bool:
    done = subprocess.run([*command, "-c", "import bpy"], capture_output=True, check=False)
    return done.returncode == 0


def _install_libraries() -> None:
    if os.geteuid() == 0 and shutil.which("apt-get"):
        say("installing the libraries that bpy needs with apt-get …")
        bash = 'tools=$1; shift; . "$tools/choose_blender.sh"; apt_get_install "$@"'
        command = ["bash", "-c", bash, "bash", str(TOOLS), *LIBRARIES.split()]
        subprocess.run(command, check=False)
