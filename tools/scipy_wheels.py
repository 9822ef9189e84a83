"""The SciPy wheels that ship in the extension, pinned in wheels.lock.

Blender.org's builds have NumPy and no SciPy. Blender 4.2 to 5.0 have Python 3.11 and, at the
oldest, NumPy 1.24; 5.1 and later have Python 3.13. NumPy is never shipped: it would take the
place of Blender's own.

    python tools/scipy_wheels.py        downloads what TARGETS names and writes the lock anew
"""

import hashlib
import re
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

from places import TOOLS, cache_folder, fail, run_quietly, say
from python_packages import test_python

LOCK = TOOLS / "wheels.lock"

# Python: SciPy's version. 1.15.3 is the last whose wheels for Python 3.11 take NumPy 1.24.
SCIPY = {"3.11": "1.15.3", "3.13": "1.17.1"}

# Extension platform: the tag that pip is asked for. One wheel for each macOS architecture: of
# two, Blender takes the one whose name sorts last, whatever macOS it needs.
TAGS = {
    "windows-x64": ["win_amd64"],
    "windows-arm64": ["win_arm64"],
    "macos-x64": ["macosx_11_0_x86_64"],
    "macos-arm64": ["macosx_12_0_arm64"],
    "linux-x64": ["manylinux_2_28_x86_64", "manylinux_2_27_x86_64", "manylinux_2_17_x86_64"],
}

# SciPy has no wheel for these, so that the zip is for Blender 5.1 and later.
MISSING = {("windows-arm64", "3.11")}

TARGETS = [(p, python) for p in TAGS for python in SCIPY if (p, python) not in MISSING]


class Wheel(NamedTuple):
    platform: str
    python: str
    sha256: str
    name: str


def read_lock() -> list[Wheel]:
    lines = (line.split("#")[0].split() for line in LOCK.read_text().splitlines())
    return [Wheel(*fields) for fields in lines if fields]


def target_of(name: str) -> tuple[str, str]:
    """The (platform, Python) that a wheel's file name says it is for."""
    parts = name.removesuffix(".whl").split("-")
    if len(parts) != 5 or not name.endswith(".whl"):
        raise ValueError(f"{name} is not the name of a wheel")
    _, _, python_tag, abi, platform_tag = parts
    version = re.fullmatch(r"cp3(\d+)", python_tag)
    # Blender does not read the ABI: it would load a free-threaded wheel, and fail.
    if not version or abi != python_tag:
        raise ValueError(f"{name} is not for an ordinary Python 3")
    shapes = {
        "windows-x64": r"win_amd64",
        "windows-arm64": r"win_arm64",
        "macos-x64": r"macosx_\d+_\d+_x86_64",
        "macos-arm64": r"macosx_\d+_\d+_arm64",
        "linux-x64": r"manylinux\w+_x86_64",
    }
    platforms = {
        platform
        for tag in platform_tag.split(".")
        for platform, shape in shapes.items()
        if re.fullmatch(shape, tag)
    }
    if len(platforms) != 1:
        raise ValueError(f"{name} is not for one platform of Blender")
    return platforms.pop(), f"3.{version[1]}"


def problems(platform: str, listed: list[str], on_disk: list[str]) -> list[str]:
    """What is wrong with the wheels that a manifest lists, given the files beside it."""
    found = [f"{name} is listed but not there" for name in sorted(set(listed) - set(on_disk))]
    found += [f"{name} is there but not listed" for name in sorted(set(on_disk) - set(listed))]
    targets = []
    for name in listed:
        try:
            targets.append(target_of(name))
        except ValueError as error:
            found.append(str(error))
        if not name.startswith("scipy-"):
            found.append(f"{name} is not SciPy")
    wanted = [target for target in TARGETS if target[0] == platform]
    for target in sorted({*targets, *wanted}):
        count, right = targets.count(target), int(target in wanted)
        if count != right:
            found.append(f"{count} wheels instead of {right} for Python {target[1]}, {target[0]}")
    return found


def _download(platform: str, python: str, version: str, tags: list[str], folder: Path) -> Path:
    command = [test_python(), "-m", "pip", "download", "--no-deps", "--only-binary=:all:"]
    for tag in tags:
        command += ["--platform", tag]
    command += ["--python-version", python, "--implementation", "cp"]
    command += ["--abi", "cp" + python.replace(".", ""), "--dest", folder, f"scipy=={version}"]
    run_quietly(command, f"download SciPy {version} for Python {python}, {platform}")
    (wheel,) = folder.glob("*.whl")
    return wheel


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def fetch(wheel: Wheel) -> Path:
    """The wheel's file, from the cache or downloaded; exactly the one in the lock."""
    place = cache_folder() / "wheels" / wheel.name
    if not place.exists():
        place.parent.mkdir(parents=True, exist_ok=True)
        _, version, _, _, tags = wheel.name.removesuffix(".whl").split("-")
        with tempfile.TemporaryDirectory(dir=place.parent) as folder:
            got = _download(wheel.platform, wheel.python, version, tags.split("."), Path(folder))
            if got.name != wheel.name:
                fail(f"{wheel.name} is in wheels.lock, but pip found {got.name}.")
            got.rename(place)
    if _sha256(place) != wheel.sha256:
        place.unlink()
        fail(f"{wheel.name} is not the file that wheels.lock names (its sha256 differs).")
    return place


def write_lock() -> None:
    lines = ["# platform python sha256 name; written by tools/scipy_wheels.py"]
    for platform, python in TARGETS:
        with tempfile.TemporaryDirectory() as folder:
            got = _download(platform, python, SCIPY[python], TAGS[platform], Path(folder))
            if target_of(got.name) != (platform, python):
                fail(f"pip found {got.name} for Python {python}, {platform}.")
            say(f"{got.name}: {got.stat().st_size / 1e6:.1f} MB")
            lines.append(f"{platform} {python} {_sha256(got)} {got.name}")
    LOCK.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    if len(sys.argv) > 1:
        raise SystemExit(__doc__)
    write_lock()
