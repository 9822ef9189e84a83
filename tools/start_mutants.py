"""Run run_mutants.py in a Python that has what it needs; see tools/mutate."""

import subprocess
import sys

from places import TOOLS
from python_packages import mutation_python

command = [mutation_python(), TOOLS / "run_mutants.py", *sys.argv[1:]]
raise SystemExit(subprocess.run(command, check=False).returncode)
