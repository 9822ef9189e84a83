"""What has become of each file: a journal that survives being killed and a full disk."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from .... import core

ENDED = ("done", "failed")
# What an entry tells of an object that was analysed, besides its counts.
NUMBERS = ("vertices", "triangles", "index_sum", "expected_index_sum", "euler_characteristic")


class Journal:
    """A JSON-lines file with one line for each file that has ended, added as they end.

    A line with the status "delivering" stands before the results of a file are put into their
    places, so that whatever lies there is known to be a result.
    """

    def __init__(self, path: Path, fresh: bool) -> None:
        """Open it; of several lines on one file the last one counts.

        If `fresh`, the files are to be done again, but that their results are results stays
        known. Lines that are torn or incomplete are dropped.

        Raises
        ------
        OSError
            It cannot be written.
        """
        self._path = path
        self.entries = {entry["name"]: entry for entry in read(path)}
        if fresh:
            self.entries = {
                name: {"name": name, "status": "earlier", "results": entry["results"]}
                for name, entry in self.entries.items()
                if entry["results"]
            }
        text = "".join(map(line, self.entries.values()))
        write_whole(path, text)
        self._whole = len(text.encode())
        self._waiting: list[str] = []
        self.trouble = ""

    def add(self, entry: dict[str, Any]) -> bool:
        """Add an entry and wait until it is on disk; whether it is.

        What cannot be written, as when the disk is full, is written with the next entry.
        """
        self.entries[entry["name"]] = entry
        self._waiting.append(line(entry))
        data = "".join(self._waiting).encode()
        try:
            with open(self._path, "r+b") as file:
                # Half of a line may stand there, from an attempt that failed.
                file.truncate(self._whole)
                file.seek(self._whole)
                file.write(data)
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:
            self.trouble = f"{self._path}: cannot be written ({error.strerror})"
            return False
        self._whole += len(data)
        self._waiting.clear()
        self.trouble = ""
        return True


def line(entry: dict[str, Any]) -> str:
    """An entry as one line of ASCII: names may hold what some readers take for ends of lines."""
    return json.dumps(entry) + "\n"


def read(path: Path) -> list[dict[str, Any]]:
    """The whole entries of a journal, none if there is no such file.

    Every entry has a "name", a "status" and "results", and what has ended all the rest.
    """
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        return []
    entries = []
    # Only \\n ends a line.
    for text in data.decode("utf-8", "replace").split("\n"):
        try:
            entry = json.loads(text)
        except ValueError:
            continue
        if _is_complete(entry):
            entries.append(entry)
    return entries


def ended(entries: Iterable[dict[str, Any]]) -> list[dict[str, Any]]:
    """Those of files that have been done or have failed."""
    return [entry for entry in entries if entry["status"] in ENDED]


_TYPES: dict[str, type | tuple[type, ...]] = {
    "file": str,
    "seconds": (int, float),
    "peak_mb": (int, float),
    "arguments": str,
    "objects": list,
}


def _is_complete(entry: object) -> bool:
    if not isinstance(entry, dict):
        return False
    if not isinstance(entry.get("name"), str) or not isinstance(entry.get("results"), dict):
        return False
    if entry.get("status") not in ENDED:
        return entry.get("status") in ("delivering", "earlier")
    if any(not isinstance(entry.get(name), kind) for name, kind in _TYPES.items()):
        return False
    if entry["status"] == "failed" and not (isinstance(entry.get("error"), str) and entry["error"]):
        return False
    return all(map(_is_complete_object, entry["objects"]))


def _is_complete_object(found: object) -> bool:
    if not isinstance(found, dict) or not isinstance(found.get("object"), str):
        return False
    return "error" in found or found.keys() >= {*NUMBERS, "counts", "warnings", "regions"}


def results_in(folders: Iterable[Path]) -> set[str]:
    """Real paths of all the results that the journals in some folders know of."""
    found = set()
    for folder in folders:
        for path in sorted(Path(folder).glob("report*.jsonl")):
            try:
                entries = read(path)
            except OSError:
                # A folder of this name, or not ours to read: then it says nothing.
                continue
            for entry in entries:
                for kind in entry["results"]:
                    for place in places_of(entry, kind):
                        found.add(os.path.realpath(path.parent / place))
    return found


def places_of(entry: dict[str, Any], kind: str) -> list[str]:
    """Where the results of a kind are, as seen from the journal's folder."""
    places = entry["results"].get(kind, [])
    return [places] if isinstance(places, str) else [str(place) for place in places]


def write_whole(path: Path, text: str) -> None:
    """Write a file so that nobody ever sees a part of it."""
    with core.whole_file(path) as partial:
        partial.write_text(text, "utf-8", newline="")
