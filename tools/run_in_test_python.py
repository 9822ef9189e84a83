"""Run the arguments with the Python of the tests, which has NumPy and SciPy."""

import os
import sys

from python_packages import test_python

python = str(test_python())
os.execv(python, [python, *sys.argv[1:]])
