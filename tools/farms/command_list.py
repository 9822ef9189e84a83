"""Print the commands of a batch in parts, one a line: for OpenCue's cuecmd, GNU parallel and so on.

The last line makes the summary and is for when all the others have ended; --without-summary leaves
it out, --only-summary prints nothing else. What follows `--` goes to the extension's command as it
is.
"""

import argparse
import shlex
import sys


def commands(
    blender: str, meshes: list[str], results: str, parts: int, options: list[str]
) -> list[str]:
    """One command for each part, quoted for a shell."""
    start = [blender, "-b", "--command", "umbilics"]
    out = ["--out", results, "--resume", "--tolerant"]
    return [
        shlex.join([*start, *options, *out, "--part", f"{part}/{parts}", "--", *meshes])
        for part in range(1, parts + 1)
    ]


def summary(blender: str, results: str) -> str:
    """The command for when all parts have ended."""
    return shlex.join([blender, "-b", "--command", "umbilics", "--out", results, "--summary"])


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="tools/farms/command_list.py", description=__doc__)
    parser.add_argument("paths", metavar="MESHES … RESULTS", nargs="+")
    parser.add_argument("--parts", type=int, default=16, metavar="N", help="how many (default: 16)")
    parser.add_argument("--blender", default="blender", help="the workers' Blender")
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--without-summary", action="store_true")
    which.add_argument("--only-summary", action="store_true")
    cut = arguments.index("--") if "--" in arguments else len(arguments)
    found = parser.parse_args(arguments[:cut])
    *meshes, results = found.paths
    if found.parts < 1 or (not meshes and not found.only_summary):
        parser.error("there must be meshes, a folder for the results, and a part at least.")
    lines = []
    if not found.only_summary:
        lines += commands(found.blender, meshes, results, found.parts, arguments[cut + 1 :])
    if not found.without_summary:
        lines.append(summary(found.blender, results))
    print("\n".join(lines))
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
