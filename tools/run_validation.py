"""Repeat the experiments of the paper and write docs/validation.md with its figures.

The analytic surfaces are made here. The scanned models are read from MESH_FOLDER, which is not
part of the project: stanford-bunny.obj, rocker-arm.obj, hand_closed_os.obj, torso_vtk.obj and
ship_wigley_of.stl.
Nothing is fetched; the page says which figures are left out where a model is not there.
"""

import argparse
import subprocess
from pathlib import Path

from places import BLENDER, REPOSITORY, fail, say
from run_umbilics import set_up

SCRIPT = Path(__file__).with_name("validate_in_blender.py")


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="tools/validate",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_argument("folder", metavar="MESH_FOLDER", nargs="?", type=Path, help="the models")
    parser.add_argument(
        "--output",
        type=Path,
        default=REPOSITORY / "docs",
        metavar="FOLDER",
        help="where validation.md and figures/validation/ go (default: docs)",
    )
    parser.add_argument(
        "--only",
        metavar="PART",
        action="append",
        default=[],
        help="only these parts, for a quick look: patch, parametrization, convergence, regularity, "
        "models, applications, cost",
    )
    chosen = parser.parse_args()
    if chosen.folder is not None and not chosen.folder.is_dir():
        fail(f"there is no folder {chosen.folder}.")
    output = chosen.output.resolve()
    folder = str(chosen.folder.resolve()) if chosen.folder else ""
    command = [str(BLENDER), "-b", "--python-exit-code", "1", "--python", str(SCRIPT), "--"]
    say("this takes some minutes …")
    with set_up("validate") as environment:
        code = subprocess.run(
            [*command, folder, str(output), *chosen.only],
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            check=False,
        ).returncode
    if code:
        fail(f"the validation did not come to its end (exit code {code}); see above.")
    print(output / "validation.md")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
