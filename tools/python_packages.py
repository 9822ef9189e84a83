"""The Python packages of the tests, in the user's cache."""

import hashlib
import sys
import venv
from pathlib import Path

from places import TOOLS, cache_folder, made_once, run_quietly, say

REQUIREMENTS = TOOLS / "test_requirements.txt"
# These are installed without their dependencies.
MESHES = TOOLS / "test_meshes.txt"
REQUIREMENTS_TO_MEASURE = TOOLS / "benchmark_requirements.txt"
REQUIREMENTS_TO_LINT = TOOLS / "lint_requirements.txt"
REQUIREMENTS_TO_MUTATE = TOOLS / "mutation_requirements.txt"
REQUIREMENTS_IN_BLENDER = TOOLS / "test_requirements_blender.txt"


def _key(*requirements: Path) -> str:
    content = b"".join(path.read_bytes() for path in requirements)
    return hashlib.sha256(content).hexdigest()[:12]


def _environment(name: str, what: str, *requirements: Path, alone: tuple[Path, ...] = ()) -> Path:
    """The Python of an environment with these requirements, made once; those `alone` are installed
    without what they depend on. `what` it is for is said while it is made."""

    def make(folder: Path) -> None:
        say(f"installing {what}, once …")
        venv.create(folder, with_pip=True, symlinks=True)
        command = [folder / "bin" / "python", "-m", "pip", "install"]
        files = [word for path in requirements for word in ("-r", path)]
        run_quietly([*command, *files], f"install {what}")
        for path in alone:
            run_quietly([*command, "--no-deps", "-r", path], f"install {path.name}")

    version = f"{sys.version_info.major}.{sys.version_info.minor}"
    key = _key(*requirements, *alone)
    folder = cache_folder() / "python" / f"{name}-{version}-{key}"
    return made_once(folder, make) / "bin" / "python"


def test_python() -> Path:
    """A Python with all of test_requirements.txt and test_meshes.txt. Use its programs with -m."""
    what = "what the tests need (NumPy, SciPy, pytest, …)"
    return _environment("tests", what, REQUIREMENTS, alone=(MESHES,))


def benchmark_python() -> Path:
    """A Python with the NumPy of the current Blender, and what meshes are made with."""
    what = "what the benchmarks need (NumPy, SciPy, scikit-image, …)"
    return _environment("benchmarks", what, REQUIREMENTS_TO_MEASURE)


def lint_python() -> Path:
    """A Python with mypy. Use it with -m."""
    return _environment("lint", "mypy", REQUIREMENTS_TO_LINT)


def mutation_python() -> Path:
    """A Python with what the tests need and Cosmic Ray."""
    what = "what the tests need and Cosmic Ray"
    return _environment("mutate", what, REQUIREMENTS, REQUIREMENTS_TO_MUTATE)


def packages_for_blender() -> Path:
    """A folder with pytest and hypothesis for the Python of any Blender."""

    def make(folder: Path) -> None:
        options = ["--target", folder, "--only-binary=:all:", "--platform", "any"]
        # The oldest Python in question, and no compiled code.
        options += ["--python-version", "3.11", "--implementation", "py", "--abi", "none"]
        command = [test_python(), "-m", "pip", "install", *options, "-r", REQUIREMENTS_IN_BLENDER]
        run_quietly(command, "install pytest for Blender's Python")

    folder = cache_folder() / "python" / f"blender-{_key(REQUIREMENTS_IN_BLENDER)}"
    return made_once(folder, make)
