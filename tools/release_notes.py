"""Print the notes of a release: the part of CHANGELOG.md on a version.

python3 tools/release_notes.py [VERSION]        without one, the manifest's
"""

import re
import sys

from build_extension import manifest
from places import REPOSITORY, fail


def notes(changelog: str, version: str) -> str:
    """The lines under the heading of the version (or of "Unreleased"), without the heading."""
    headings = list(re.finditer(r"^## +\[?([^\]\n]+?)\]?(?: .*)?$", changelog, re.MULTILINE))
    for heading, following in zip(headings, [*headings[1:], None], strict=True):
        if heading[1].split()[0] == version:
            end = following.start() if following else len(changelog)
            return changelog[heading.end() : end].strip() + "\n"
    return ""


def main() -> None:
    version = sys.argv[1] if len(sys.argv) > 1 else manifest()["version"]
    text = notes((REPOSITORY / "CHANGELOG.md").read_text("utf-8"), version)
    if not text.strip():
        fail(f"CHANGELOG.md says nothing about {version}.")
    print(text, end="")


if __name__ == "__main__":
    main()
