"""Numbers in sentences."""

from __future__ import annotations


def counted(number: int, noun: str, plural: str | None = None) -> str:
    """ "1 edge", "3 edges"; with a plural of its own "3 vertices"."""
    return f"{number} {noun if number == 1 else plural or noun + 's'}"
