"""What has become of each file: a journal that survives being killed, and the summaries."""

from __future__ import annotations

import csv
import io
import json
import os
from collections import Counter
from pathlib import Path

KINDS = ("star", "lemon", "monstar", "uncertain")
_NUMBERS = ("vertices", "triangles", "index_sum", "expected_index_sum", "euler_characteristic")
COLUMNS = (
    *("file", "status", "object", *_NUMBERS, *KINDS, "regions", "warnings", "error"),
    *("seconds", "peak_mb", "json"),
)


class Journal:
    """A JSON-lines file with one line for each file that has ended, added as they end."""

    def __init__(self, path: Path, fresh: bool) -> None:
        """Open it, empty if `fresh`; a line torn by a kill is dropped, and of several lines on
        one file the last one counts."""
        self._path = path
        self.entries = {} if fresh else {entry["name"]: entry for entry in read(path)}
        write_whole(path, "".join(map(_line, self.entries.values())))

    def add(self, entry: dict) -> None:
        """Add an entry and wait until it is on disk."""
        self.entries[entry["name"]] = entry
        with open(self._path, "a", encoding="utf-8") as file:
            file.write(_line(entry))
            file.flush()
            os.fsync(file.fileno())


def _line(entry: dict) -> str:
    return json.dumps(entry, ensure_ascii=False) + "\n"


def read(path: Path) -> list[dict]:
    """The whole entries of a journal, none if there is no such file."""
    if not path.exists():
        return []
    entries = []
    for line in path.read_text("utf-8", errors="replace").splitlines():
        try:
            entry = json.loads(line)
        except ValueError:
            continue
        if isinstance(entry, dict) and "name" in entry:
            entries.append(entry)
    return entries


def write_whole(path: Path, text: str) -> None:
    """Write a file so that nobody ever sees a part of it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f".{path.name}.{os.getpid()}.partial")
    with open(partial, "w", encoding="utf-8", newline="") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    os.replace(partial, path)


def write_report(path: Path, entries: list[dict]) -> None:
    """The summary: JSON lines (one a file) if the path ends in .jsonl, else CSV (one an object,
    or one for a file without any)."""
    entries = sorted(entries, key=lambda entry: entry["name"])
    if path.suffix.lower() == ".jsonl":
        write_whole(path, "".join(map(_line, entries)))
        return
    text = io.StringIO()
    table = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    table.writeheader()
    for entry in entries:
        table.writerows(_rows(entry))
    write_whole(path, text.getvalue())


def _rows(entry: dict) -> list[dict]:
    about = {
        "file": entry["file"],
        "status": entry["status"],
        "error": entry.get("error", ""),
        "seconds": entry["seconds"],
        "peak_mb": entry["peak_mb"],
        "json": entry.get("results", {}).get("json", ""),
    }
    rows = []
    for found in entry["objects"]:
        row = about | {"object": found["object"]}
        if "error" in found:
            row["error"] = found["error"]
        else:
            row["error"] = ""
            row |= {name: found[name] for name in (*_NUMBERS, "regions")}
            row |= {kind: found["counts"].get(kind, 0) for kind in KINDS}
            row["warnings"] = " ".join(found["warnings"])
        rows.append(row)
    return rows or [about]


def objects_in(report: bytes | None) -> list[dict]:
    """The objects of a file's JSON report, with what the summaries tell of them."""
    if report is None:
        return []
    found = []
    for entry in json.loads(report)["objects"]:
        if "error" in entry:
            found.append({"object": entry["object"], "error": entry["error"]})
            continue
        kept = {name: entry[name] for name in ("object", *_NUMBERS, "counts", "warnings")}
        found.append(kept | {"regions": len(entry["regions"])})
    return found


def in_words(entry: dict) -> str:
    """One line on a file."""
    if entry["status"] != "done":
        return f"{entry['file']}: FAILED, {entry['error'].removeprefix(entry['file'] + ': ')}"
    counts = Counter()
    for found in entry["objects"]:
        counts.update(found["counts"])
    kinds = ", ".join(f"{counts[kind]} {kind}" for kind in KINDS if counts[kind])
    return f"{entry['file']}: {kinds or 'no umbilics'} ({entry['seconds']:.1f} s)"
