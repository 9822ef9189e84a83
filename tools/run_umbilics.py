"""Find the umbilics of meshes with a real Blender, set up here if there is none.

Without a file, Blender's monkey is taken, subdivided. Each file gives three more in the output
folder: NAME-umbilics.blend to open in Blender, NAME-umbilics.json with every number, and
NAME-umbilics.png, a picture. Options that are not listed here go to the extension's own command
as they are: --method S, --curvature normals, …
"""

import argparse
import contextlib
import hashlib
import json
import math
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import build_extension
import isolated_blender
from places import BLENDER, REPOSITORY, cache_folder, locked, run_quietly, say

MESHES = (".obj", ".ply", ".stl", ".off", ".gltf", ".glb", ".fbx", ".abc", ".blend")
MESHES += (".usd", ".usda", ".usdc", ".usdz")
MONKEY = Path(__file__).with_name("make_monkey.py")


@contextlib.contextmanager
def set_up(purpose: str = "run") -> Iterator[dict[str, str]]:
    """The environment of a Blender with the current extension installed, to run it in.

    Each purpose has an installation of its own, so that a long run does not hold up others.
    """
    facts = isolated_blender.describe()
    version = ".".join(map(str, facts["version"]))
    wheels = None if facts["scipy"] else facts["platform"]
    digest = _digest_of_sources(wheels)
    folder = cache_folder() / purpose / f"blender-{version}"
    lock, note, resources = (
        folder.with_name(folder.name + ".lock"),
        folder / "installed",
        folder / "settings",
    )
    while True:
        # Nobody may install another state of the extension while this one runs.
        with locked(lock, shared=True):
            if note.exists() and note.read_text() == digest:
                yield isolated_blender.environment(resources)
                return
        with locked(lock):
            say(f"installing the extension in Blender {version}, apart from your own settings …")
            note.unlink(missing_ok=True)
            zip_file = build_extension.build(folder, wheels)
            isolated_blender.install(zip_file, resources)
            note.write_text(digest)


def _digest_of_sources(wheels: str | None) -> str:
    """Changes whenever the zip would."""
    digest = hashlib.sha256(repr(wheels).encode())
    for file in build_extension.files_to_ship():
        digest.update(repr(str(file)).encode() + (REPOSITORY / file).read_bytes())
    return digest.hexdigest()


def results_of(file: Path, output: Path) -> dict[str, Path]:
    """Where the results of a file go."""
    return {kind: output / f"{file.stem}-umbilics.{kind}" for kind in ("blend", "json", "png")}


def overwritten(files: list[Path], output: Path) -> str:
    """What the results would overwrite, in a sentence; empty if nothing."""
    read = {os.path.realpath(file).casefold() for file in files}
    written: dict[str, Path] = {}
    for file in files:
        for result in results_of(file, output).values():
            key = os.path.realpath(result).casefold()
            if key in read:
                return f"{result} is one of the files to read; name another folder with --output."
            if written.setdefault(key, file) != file:
                return f"{written[key]} and {file} would both have their results in {result}."
    return ""


def detect(file: Path, output: Path, options: list[str], environment: dict[str, str]) -> int:
    """Run the extension's command on one file and say what it found; its exit code."""
    results = results_of(file, output)
    command = [str(BLENDER), "-b", "--command", "umbilics", str(file), *options]
    for kind, result in results.items():
        result.unlink(missing_ok=True)
        command += [f"--{kind}", str(result)]
    # Blender's own chatter is not for the reader; the command's complaints are.
    done = subprocess.run(
        command, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, check=False
    )
    if done.returncode not in (0, 1):
        sys.stderr.write(done.stdout.decode(errors="replace"))
    if results["json"].exists():
        print("\n" + in_words(file.name, json.loads(results["json"].read_text("utf-8"))))
        for what, kind in (("in Blender", "blend"), ("in numbers", "json"), ("picture", "png")):
            if results[kind].exists():
                print(f"  {what + ':':12}{results[kind]}")
        sys.stdout.flush()
    return done.returncode


def in_words(name: str, report: dict) -> str:
    """What the JSON report of a file says, in sentences."""
    lines = []
    objects = [entry for entry in report["objects"] if "error" not in entry]
    for entry in objects:
        label = name if len(objects) == 1 else f"{name}, {entry['object']}"
        lines.append(f"{label}: {_what_was_found(entry)}")
        lines += [f"  Warning: {warning}" for warning in entry["warnings"]]
        lines += [_one_method(row) for row in entry.get("comparison", ())]
    return "\n".join(lines)


def _what_was_found(entry: dict) -> str:
    counts = {kind: count for kind, count in entry["counts"].items() if count}
    total = sum(counts.values())
    text = f"{entry['triangles']:,} triangles, {_number_of(total, 'umbilic')}"
    if counts:
        text += f" ({', '.join(_number_of(count, kind) for kind, count in counts.items())})"
    text += "; "
    if entry["regions"]:
        text += f"{_number_of(len(entry['regions']), 'spherical or planar region')}; "
    index, expected = entry["index_sum"], entry["expected_index_sum"]
    euler = entry["euler_characteristic"]
    if expected is None:
        return text + f"their indices sum to {index:g} (χ is {euler}; the surface is not closed)."
    if math.isclose(index, expected, abs_tol=1e-6):
        return text + f"their indices sum to {index:g}, which is χ, as it must be."
    return text + f"their indices sum to {index:g}, but χ is {expected:g}."


def _one_method(row: dict) -> str:
    """A line of the comparison of the methods."""
    if row["refusal"]:
        return f"  Method {row['method']}: {row['refusal']}"
    text = f"  Method {row['method']}: {_number_of(len(row['positions']), 'point')}"
    if row["method"] == "S":
        return text + "."
    return text + (
        f"; {row['confirmed']} of the umbilics of S confirmed, {row['missed']} missed, "
        f"{row['unmatched']} points elsewhere."
    )


def _number_of(count: int, name: str) -> str:
    plural = "" if count == 1 or name == "uncertain" else "s"
    return f"{count or 'no'} {name}{plural}"


def split_arguments(arguments: list[str]) -> tuple[list[Path], list[str]]:
    """Files, and the extension's own options with their values."""
    files, options = [], []
    for previous, argument in zip(["", *arguments], arguments, strict=False):
        after_option = previous.startswith("--") and "=" not in previous
        is_mesh = Path(argument).suffix.lower() in MESHES
        if argument.startswith("-") or (after_option and not is_mesh):
            options.append(argument)
        else:
            files.append(Path(argument))
    return files, options


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="tools/run",
        usage="tools/run [FILE …] [options]",
        description=__doc__,
        allow_abbrev=False,
    )
    parser.add_argument(
        "--output",
        type=Path,
        default=Path("umbilics-output"),
        metavar="FOLDER",
        help="where the results go (default: ./umbilics-output)",
    )
    chosen, rest = parser.parse_known_args()
    files, options = split_arguments(rest)
    for file in files:
        if not file.is_file():
            say(f"there is no file {file}.")
            return 1
    output = chosen.output.resolve()
    files = list(dict.fromkeys(file.resolve() for file in files))
    if refusal := overwritten(files, output):
        say(refusal)
        return 2
    with set_up() as environment:
        output.mkdir(parents=True, exist_ok=True)
        if not files:
            files = [output / "monkey.blend"]
            command = [BLENDER, "-b", "--factory-startup", "--python-exit-code", "1"]
            run_quietly([*command, "--python", MONKEY, "--", files[0]], "make the monkey")
        return max([detect(file.resolve(), output, options, environment) for file in files])


if __name__ == "__main__":
    raise SystemExit(main())
