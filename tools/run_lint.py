"""Run the pinned ruff and mypy on the repository; see tools/lint."""

import subprocess
import sys

from places import REPOSITORY
from python_packages import lint_python, test_python

commands = [[test_python(), "-m", "ruff", *(sys.argv[1:] or ["check", "."])]]
if not sys.argv[1:]:
    commands.append([lint_python(), "-m", "mypy", "core", "operators", "ui"])
codes = [subprocess.run(command, cwd=REPOSITORY, check=False).returncode for command in commands]
raise SystemExit(max(codes))
