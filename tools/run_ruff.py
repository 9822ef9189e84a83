"""Run the pinned ruff on the repository; see tools/lint."""

import subprocess
import sys

from places import REPOSITORY
from python_packages import test_python

arguments = sys.argv[1:] or ["check", "."]
command = [test_python(), "-m", "ruff", *arguments]
raise SystemExit(subprocess.run(command, cwd=REPOSITORY, check=False).returncode)
