"""The summary of a batch: a table for people and spreadsheets, or JSON lines for programs."""

from __future__ import annotations

import csv
import io
import json
import re
from collections import Counter
from pathlib import Path
from typing import Any

from ..files.guard import shown
from .journal import NUMBERS, line, places_of, write_whole

KINDS = ("star", "lemon", "monstar", "compound", "uncertain")
COLUMNS = (
    *("file", "status", "object", "frame", *NUMBERS, *KINDS, "regions", "warnings", "error"),
    *("seconds", "peak_mb", "json"),
)
# A spreadsheet takes a cell that begins so for a formula and would run it, blanks and quotes before
# it or not; where semicolons part cells, as in half of Europe, what follows one begins a cell too.
# The wide forms count where such letters are usual.
# https://owasp.org/www-community/attacks/CSV_Injection
_FORMULA = re.compile(r"""(^|;)(?=[\s"']*[=+\-@＝＋－＠])""")


def write_report(path: Path, entries: list[dict[str, Any]]) -> None:
    """The summary: JSON lines (one a file) if the path ends in .jsonl, else CSV (one an object,
    or one for a file without any).

    Raises
    ------
    OSError
        It cannot be written.
    """
    entries = sorted(entries, key=lambda entry: entry["name"])
    if path.suffix.lower() == ".jsonl":
        write_whole(path, "".join(map(line, entries)))
        return
    text = io.StringIO()
    table = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    table.writeheader()
    for entry in entries:
        for row in _rows(entry):
            table.writerow({name: _cell(value) for name, value in row.items()})
    write_whole(path, text.getvalue())


def _cell(value: object) -> object:
    """Text on one line that is no formula, nor has one in it; numbers stay as they are."""
    return _FORMULA.sub(r"\1'", shown(value)) if isinstance(value, str) else value


def _rows(entry: dict[str, Any]) -> list[dict[str, Any]]:
    about = {
        "file": entry["file"],
        "status": entry["status"],
        "error": entry.get("error", ""),
        "seconds": entry["seconds"],
        "peak_mb": entry["peak_mb"],
        "json": " ".join(places_of(entry, "json")),
    }
    rows = []
    # The reason of a file is that of its objects where one of them has any.
    in_objects = any("error" in found for found in entry["objects"])
    for found in entry["objects"]:
        row = about | {"object": found["object"], "frame": found.get("frame")}
        if "error" in found:
            row["error"] = found["error"]
        else:
            row["error"] = "" if in_objects else about["error"]
            row |= {name: found[name] for name in (*NUMBERS, "regions")}
            row |= {kind: found["counts"].get(kind, 0) for kind in KINDS}
            row["warnings"] = " ".join(found["warnings"])
        rows.append(row)
    return rows or [about]


def objects_in(report: bytes | None) -> list[dict[str, Any]]:
    """The objects of a file's JSON report, with what the summaries tell of them; none if there
    is no report or it is not whole."""
    found = []
    try:
        for entry in json.loads(report or b"")["objects"]:
            about = {name: entry[name] for name in ("object", "frame") if name in entry}
            if "error" in entry:
                found.append(about | {"error": entry["error"]})
                continue
            kept = {name: entry[name] for name in (*NUMBERS, "counts")}
            # In a batch nobody reads what a single file says of its plan and its quads.
            warnings = [
                sentence
                for part in (entry, *(entry.get(name, {}) for name in ("plan", "quads")))
                for sentence in part.get("warnings", ())
            ]
            more = {"warnings": warnings, "regions": len(entry["regions"])}
            found.append(about | kept | more)
    except (ValueError, KeyError, TypeError):
        return []
    return found


def beside_in(report: bytes | None) -> list[str]:
    """The files that a file's JSON report names as read beside it."""
    try:
        return [str(one["file"]) for one in json.loads(report or b"")["source"].get("beside", [])]
    except (ValueError, KeyError, TypeError, AttributeError):
        return []


def in_words(entry: dict[str, Any]) -> str:
    """One line on a file."""
    if entry["status"] != "done":
        return f"{entry['file']}: FAILED, {entry['error'].removeprefix(entry['file'] + ': ')}"
    counts: Counter[str] = Counter()
    for found in entry["objects"]:
        counts.update(found.get("counts", {}))
    kinds = ", ".join(f"{counts[kind]} {kind}" for kind in KINDS if counts[kind])
    return f"{entry['file']}: {kinds or 'no umbilics'} ({entry['seconds']:.1f} s)"
