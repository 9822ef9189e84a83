"""Run the arguments with the Python of the benchmarks, which has the current Blender's NumPy."""

import os
import sys

from python_packages import benchmark_python

python = str(benchmark_python())
os.execv(python, [python, *sys.argv[1:]])
