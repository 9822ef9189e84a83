"""Find the umbilics of meshes with a real Blender, set up here if there is none.

Without a file, Blender's monkey is taken, subdivided. Each file gives three more in the output
folder: NAME-umbilics.blend to open in Blender, NAME-umbilics.json with every number, and
NAME-umbilics.png, a picture. Options that are not listed here go to the extension's own command
as they are: --method S, --curvature normals, …
"""

import argparse
import hashlib
import json
import subprocess
import sys
from pathlib import Path

import build_extension
import isolated_blender
from places import BLENDER, REPOSITORY, cache_folder, locked, run_quietly, say

MONKEY = Path(__file__).with_name("make_monkey.py")


def set_up() -> dict[str, str]:
    """The environment of a Blender with the current extension installed."""
    facts = isolated_blender.describe()
    version = ".".join(map(str, facts["version"]))
    folder = cache_folder() / "run" / f"blender-{version}"
    with locked(folder.with_suffix(".lock")):
        wheels = None if facts["scipy"] else facts["platform"]
        digest = _digest_of_sources(wheels)
        note = folder / "installed"
        if not note.exists() or note.read_text() != digest:
            say(f"installing the extension in Blender {version}, apart from your own settings …")
            zip_file = build_extension.build(folder, wheels)
            resources = folder / "settings"
            note.unlink(missing_ok=True)
            isolated_blender.install(zip_file, resources)
            note.write_text(digest)
    return isolated_blender.environment(folder / "settings")


def _digest_of_sources(wheels: str | None) -> str:
    """Changes whenever the zip would."""
    digest = hashlib.sha256(repr(wheels).encode())
    for file in build_extension.files_to_ship():
        digest.update(repr(str(file)).encode() + (REPOSITORY / file).read_bytes())
    return digest.hexdigest()


def detect(file: Path, output: Path, options: list[str], environment: dict[str, str]) -> int:
    """Run the extension's command on one file and say what it found; its exit code."""
    results = {kind: output / f"{file.stem}-umbilics.{kind}" for kind in ("blend", "json", "png")}
    for result in results.values():
        result.unlink(missing_ok=True)
    command = [str(BLENDER), "-b", "--command", "umbilics", str(file), *options]
    for kind, result in results.items():
        command += [f"--{kind}", str(result)]
    sys.stdout.flush()
    code = subprocess.run(
        command, env=environment, stdin=subprocess.DEVNULL, stdout=sys.stderr, check=False
    ).returncode
    if code == 0:
        print(f"\n{file.name}: {in_words(json.loads(results['json'].read_text()))}")
        for what, kind in (("Blender file", "blend"), ("numbers", "json"), ("picture", "png")):
            print(f"  {what + ':':14}{results[kind]}")
    return code


def in_words(result: dict) -> str:
    """What a result file says, as a sentence or two."""
    kinds = list(result["umbilics"]["kind"])
    counts = {kind: kinds.count(kind) for kind in sorted(set(kinds))}
    listed = [f"{n} {kind if n == 1 else kind + 's'}" for kind, n in counts.items()]
    found = "1 umbilic" if len(kinds) == 1 else f"{len(kinds) or 'no'} umbilics"
    text = f"{found} ({', '.join(listed)})." if listed else f"{found}."
    total, euler = result["index_sum"], result["euler_characteristic"]
    text += f" Their indices sum to {total:g}; the Euler characteristic χ is {euler:g}"
    text += ", as it must be." if total == euler else "."
    return text


def main() -> int:
    parser = argparse.ArgumentParser(prog="tools/run", description=__doc__, allow_abbrev=False)
    parser.add_argument("files", nargs="*", type=Path, metavar="FILE")
    parser.add_argument(
        "--output",
        type=Path,
        default=Path("umbilics-output"),
        metavar="FOLDER",
        help="where the results go (default: ./umbilics-output)",
    )
    chosen, options = parser.parse_known_args()
    for file in chosen.files:
        if not file.is_file():
            say(f"there is no file {file}.")
            return 1
    environment = set_up()
    output = chosen.output.resolve()
    output.mkdir(parents=True, exist_ok=True)
    files = [file.resolve() for file in chosen.files]
    if not files:
        monkey = output / "monkey.blend"
        command = [BLENDER, "-b", "--factory-startup", "--python-exit-code", "1"]
        run_quietly([*command, "--python", MONKEY, "--", monkey], "make the monkey")
        files = [monkey]
    codes = [detect(file, output, options, environment) for file in files]
    return max(codes)


if __name__ == "__main__":
    raise SystemExit(main())
