"""Plays a scenario in a real window; the tests read what it has found."""

import json
import os
import subprocess
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def play(tmp_path_factory):
    """A function that plays the scenario NAME.py of this folder and gives back its finds.

    Paths behind the name are handed to the scenario before that of its report; `environment` is
    added to this one's. The pictures stay in $UMBILICS_PICTURES if that is set.
    """
    window = os.environ.get("UMBILICS_WINDOW")
    if not window:
        pytest.skip("needs a window: run it with tools/test --gui")

    def played(name: str, *arguments: Path | str, environment: dict[str, str] | None = None):
        chosen = os.environ.get("UMBILICS_PICTURES")
        folder = Path(chosen) if chosen else tmp_path_factory.mktemp(name)
        report = folder / f"{name}.json"
        report.unlink(missing_ok=True)
        script = Path(__file__).with_name(f"{name}.py")
        done = subprocess.run(
            [window, "--python", script, "--", *arguments, report],
            capture_output=True,
            text=True,
            timeout=1800,
            check=False,
            env=os.environ | (environment or {}),
        )
        assert report.exists(), done.stdout + done.stderr
        assert done.returncode == 0, done.stderr
        return json.loads(report.read_text())

    return played
