"""Names of results: any file may be an input, but not every name can be extended to a result's."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable, Mapping

# Bytes that a file system takes, and what may follow a name: endings, and the mark below.
_LONGEST = 255
_ENDINGS = 40


def result_name(name: str) -> str:
    """The name of a file's results, from its path below the folder that was given.

    Mostly the same. Where a part of it is too long for an ending, is not UTF-8 or holds letters
    that cannot be printed on a line, it is cut or spelled out, and marked with a digest so that
    it stays the only one.
    """
    return "/".join(_part(part) for part in name.split("/"))


def apart(names: Iterable[str], endings: Iterable[str]) -> Mapping[str, str]:
    """A name of results for each name: that itself, but marked where NAME.ending is a folder that
    another result lies in."""
    names, endings = set(names), tuple(endings)
    folders = {name[:cut] for name in names for cut in range(len(name)) if name[cut] == "/"}
    return {
        name: name + _mark(name)
        if any(f"{name}{ending}" in folders for ending in endings)
        else name
        for name in names
    }


def _part(part: str) -> str:
    data = os.fsencode(part)
    text = data.decode("utf-8", "backslashreplace")
    text = "".join(
        letter if letter.isprintable() else letter.encode("unicode_escape").decode()
        for letter in text
    ).replace("/", "_")
    if text == part and len(data) <= _LONGEST - _ENDINGS:
        return part
    short = text.encode()[: _LONGEST - _ENDINGS - 20].decode("utf-8", "ignore")
    return short + _mark(part)


def _mark(name: str) -> str:
    return "~" + hashlib.sha256(os.fsencode(name)).hexdigest()[:12]
