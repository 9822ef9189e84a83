"""Run the pinned ruff and mypy on the repository; see tools/lint."""

import subprocess
import sys
import tempfile
from pathlib import Path

from places import REPOSITORY
from python_packages import lint_python, test_python


def ruff(*arguments: str) -> int:
    command = [test_python(), "-m", "ruff", *arguments]
    return subprocess.run(command, cwd=REPOSITORY, check=False).returncode


def mypy(*parts: str) -> int:
    """The repository is a package, and mypy wants one to have a name that could be imported,
    whatever the folder is called that it was cloned or unpacked to."""
    with tempfile.TemporaryDirectory() as folder:
        package = Path(folder) / "umbilics"
        package.symlink_to(REPOSITORY)
        options = ["--config-file", REPOSITORY / "pyproject.toml"]
        options += ["--cache-dir", REPOSITORY / ".mypy_cache"]
        command = [lint_python(), "-m", "mypy", *options, *(f"umbilics/{part}" for part in parts)]
        return subprocess.run(command, cwd=folder, check=False).returncode


if sys.argv[1:]:
    raise SystemExit(ruff(*sys.argv[1:]))
raise SystemExit(max(ruff("check", "."), mypy("core", "operators", "ui")))
