"""Numbers in sentences, and sentences that several refuse with."""

from __future__ import annotations

WITHOUT_AREA = (
    "The mesh has no area: all its faces are as good as lines or points. Look for vertices that "
    "lie far away."
)


def counted(number: int, noun: str, plural: str | None = None) -> str:
    """ "1 edge", "3 edges"; with a plural of its own "3 vertices"."""
    return f"{number} {noun if number == 1 else plural or noun + 's'}"
