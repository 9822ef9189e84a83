"""A picture of the screen, or of a part of it, small enough for the documentation."""

import subprocess
from pathlib import Path

from hands import picture


def shot(path: Path, left: int = 0, top: int = 0, right: int = 1600, bottom: int = 900) -> None:
    """Colours enough for an interface and a shaded surface; pixels from the left and the top."""
    picture(path)
    crop = f"{right - left}x{bottom - top}+{left}+{top}"
    command = ["convert", path, "-crop", crop, "+repage", "+dither", "-posterize", "64"]
    packed = ["-strip", "-define", "png:compression-level=9", "-define", "png:compression-filter=5"]
    subprocess.run([*command, *packed, f"PNG24:{path}"], check=True)
