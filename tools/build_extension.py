"""Build the extension's zips in dist/.

Without options: one zip for each platform, with the SciPy wheels that Blender.org's Blender
needs, and, where the Blender of tools/blender takes none of them, the one for it; which that is is
said at the end. What goes in is the list RUNTIME below and nothing else.
"""

import argparse
import re
import shutil
import tempfile
import tomllib
from pathlib import Path

import isolated_blender
import scipy_wheels
from places import BLENDER, REPOSITORY, fail, run_quietly, say

RUNTIME = ("blender_manifest.toml", "__init__.py", "core", "operators", "ui", "LICENSE")


def manifest() -> dict:
    return tomllib.loads((REPOSITORY / "blender_manifest.toml").read_text("utf-8"))


def files_to_ship() -> list[Path]:
    """The repository's files that go into every zip, as paths from its folder."""
    files = []
    for name in RUNTIME:
        source = REPOSITORY / name
        if not source.exists():
            fail(f"{source} is missing: the extension can't be built without it.")
        files += source.rglob("*") if source.is_dir() else [source]
    inside = (file.relative_to(REPOSITORY) for file in sorted(files) if file.is_file())
    return [
        file
        for file in inside
        if not any(part == "__pycache__" or part.startswith(".") for part in file.parts)
    ]


def stage(folder: Path, platform: str | None) -> None:
    """Lay out what ships: for one platform with its wheels, or for any without wheels."""
    for file in files_to_ship():
        (folder / file).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(REPOSITORY / file, folder / file)
    if platform:
        _add_wheels(folder, platform)


def _add_wheels(folder: Path, platform: str) -> None:
    (folder / "wheels").mkdir()
    names = []
    for wheel in scipy_wheels.read_lock():
        if wheel.platform == platform:
            shutil.copy(scipy_wheels.fetch(wheel), folder / "wheels" / wheel.name)
            names.append(wheel.name)
    path = folder / "blender_manifest.toml"
    text = path.read_text("utf-8")
    if (platform, "3.11") in scipy_wheels.MISSING:
        text = text.replace('blender_version_min = "4.2.0"', 'blender_version_min = "5.1.0"')
    wheels = "".join(f'  "./wheels/{name}",\n' for name in names)
    added = f'platforms = ["{platform}"]\nwheels = [\n{wheels}]\n\n'
    # Before the first table, as everything after its heading belongs to it.
    path.write_text(re.sub(r"^\[", added + "[", text, count=1, flags=re.MULTILINE), "utf-8")
    listed = [Path(name).name for name in tomllib.loads(path.read_text("utf-8"))["wheels"]]
    on_disk = [file.name for file in (folder / "wheels").iterdir()]
    found = scipy_wheels.problems(platform, listed, on_disk)
    if found:
        fail(f"the wheels for {platform} are wrong: " + "; ".join(found))


def build(output: Path, platform: str | None) -> Path:
    """Build one zip in the folder `output` with Blender's own builder, and return its path."""
    about = manifest()
    suffix = "-" + platform.replace("-", "_") if platform else ""
    zip_file = output.resolve() / f"{about['id']}-{about['version']}{suffix}.zip"
    output.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="umbilics-build-") as folder:
        staged = Path(folder) / "umbilics"
        staged.mkdir()
        stage(staged, platform)
        # The builder reads the manifest only; validating the result reads the code's place too.
        new = Path(folder) / zip_file.name
        command = [BLENDER, "--factory-startup", "--command", "extension"]
        run_quietly(
            [*command, "build", "--source-dir", staged, "--output-filepath", new],
            f"build {zip_file.name}",
        )
        run_quietly([*command, "validate", new], f"validate {zip_file.name}")
        shutil.move(new, zip_file)
    return zip_file


def platform_for(facts: dict) -> str | None:
    """The platform whose zip fits a Blender, None for the one without wheels.

    `facts` are those of `isolated_blender.describe`. The wheels are of no use where SciPy is
    there already, and Blender refuses a zip none of whose wheels is for its Python.

    Raises
    ------
    SystemExit
        There is no zip for it.
    """
    if facts["scipy"]:
        return None
    wanted = facts["platform"], facts["python"]
    if wanted not in scipy_wheels.TARGETS:
        version = ".".join(map(str, facts["version"]))
        known = ", ".join(f"{place} with Python {python}" for place, python in scipy_wheels.TARGETS)
        fail(
            f"Blender {version} has Python {facts['python']} on {facts['platform']} and no SciPy; "
            f"there are wheels for {known}. Install SciPy for its Python, or take another Blender."
        )
    return facts["platform"]


def build_for_this_blender(output: Path) -> Path:
    """The zip that fits the Blender of tools/blender: SciPy comes along where it has none."""
    return build(output, platform_for(isolated_blender.describe()))


def main() -> None:
    parser = argparse.ArgumentParser(prog="tools/build", description=__doc__)
    which = parser.add_mutually_exclusive_group()
    which.add_argument(
        "--platform",
        action="append",
        choices=list(scipy_wheels.TAGS),
        help="only for this platform (may be given more than once)",
    )
    which.add_argument(
        "--without-wheels",
        action="store_true",
        help="for a Blender whose Python has SciPy already, such as Debian's",
    )
    which.add_argument(
        "--for-this-blender",
        action="store_true",
        help="the one that the Blender of tools/blender needs",
    )
    parser.add_argument("--output", type=Path, default=REPOSITORY / "dist", metavar="FOLDER")
    options = parser.parse_args()
    if options.for_this_blender:
        files = [build_for_this_blender(options.output)]
    elif options.without_wheels:
        files = [build(options.output, None)]
    elif options.platform:
        files = [build(options.output, platform) for platform in options.platform]
    else:
        facts = isolated_blender.describe()
        fitting = platform_for(facts)
        platforms = [*scipy_wheels.TAGS, *([] if fitting else [None])]
        zips = {platform: build(options.output, platform) for platform in platforms}
        files = list(zips.values())
    for file in files:
        say(f"{file}: {file.stat().st_size / 1e6:.1f} MB")
    if not (options.for_this_blender or options.without_wheels or options.platform):
        version = ".".join(map(str, facts["version"]))
        say(f"for the Blender of tools/blender ({version}, Python {facts['python']}):")
        say(f"  {zips[fitting]}")


if __name__ == "__main__":
    main()
