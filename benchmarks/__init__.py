"""Measurements of the project against known truth and against other programs."""

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
# The analytic surfaces are those of the tests.
sys.path.insert(0, str(ROOT / "tests"))
