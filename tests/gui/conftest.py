"""Plays a scenario in a real window; the tests read what it has found."""

import json
import os
import subprocess
from pathlib import Path

import pytest

# What hands.py ends Blender with if clicks or keys had no effect.
LOST = 3


@pytest.fixture(scope="session")
def play(tmp_path_factory):
    """A function that plays the scenario NAME.py of this folder and gives back its finds.

    Paths behind the name are handed to the scenario before that of its report; with `new_user`,
    Blender begins with a folder of its own for what its user has set. A scenario whose hand was
    not heard is played again. The pictures stay in $UMBILICS_PICTURES if that is set.
    """
    window = os.environ.get("UMBILICS_WINDOW")
    if not window:
        pytest.skip("needs a window: run it with tools/test --gui")

    def played(name: str, *arguments: Path | str, new_user: bool = False):
        chosen = os.environ.get("UMBILICS_PICTURES")
        folder = Path(chosen) if chosen else tmp_path_factory.mktemp(name)
        report = folder / f"{name}.json"
        script = Path(__file__).with_name(f"{name}.py")
        for _ in range(3):
            report.unlink(missing_ok=True)
            own = {"BLENDER_USER_RESOURCES": str(tmp_path_factory.mktemp("blender"))}
            done = subprocess.run(
                [window, "--python", script, "--", *arguments, report],
                capture_output=True,
                text=True,
                timeout=1800,
                check=False,
                env=os.environ | (own if new_user else {}),
            )
            if done.returncode != LOST:
                break
        assert report.exists(), done.stdout + done.stderr
        assert done.returncode == 0, done.stderr
        return json.loads(report.read_text())

    return played
