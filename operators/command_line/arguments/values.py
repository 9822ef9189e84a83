"""What an argument of the command may be, each with the sentence for what it may not."""

from __future__ import annotations

import math
from argparse import ArgumentParser, ArgumentTypeError
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from .... import core

T = TypeVar("T")


def path(text: str) -> str:
    """The name of a file or folder; without letters it would be taken for the folder that the
    command runs in, or for none."""
    if not text:
        raise ArgumentTypeError("the name is empty")
    return text


def place(text: str) -> Path:
    return Path(path(text))


def whole_number(text: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise ArgumentTypeError(f"'{text}' is not a whole number") from None


def positive_whole_number(text: str) -> int:
    value = whole_number(text)
    if value < 1:
        raise ArgumentTypeError(f"'{text}' is not 1 or more")
    return value


def number(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ArgumentTypeError(f"'{text}' is not a number")
    return value


def positive_number(text: str) -> float:
    value = number(text)
    if value <= 0.0:
        raise ArgumentTypeError(f"'{text}' is not more than 0")
    return value


def part(text: str) -> tuple[int, int]:
    """The K-th of N, as in 3/16."""
    first, _, second = text.partition("/")
    try:
        found = int(first), int(second)
    except ValueError:
        found = 0, 0
    if not 1 <= found[0] <= found[1]:
        raise ArgumentTypeError(f"'{text}' is not like 3/16")
    return found


def settings(
    parser: ArgumentParser,
    kind: Callable[..., T],
    given: dict[str, Any],
    called: Callable[[str], str] = str,
) -> T:
    """Settings of a kind; wrong ones end the command with the name of their option, which `called`
    tells."""
    try:
        return kind(**given)
    except core.InvalidSettingsError as error:
        words = str(error)
        name = words.partition(" ")[0]
        if name in given:
            words = f"--{called(name).replace('_', '-')}{words.removeprefix(name)}"
        parser.error(words)


def or_automatic(read: Callable[[str], T]) -> Callable[[str], T | str]:
    """A reader that takes the word for "let the program choose" as well."""
    return lambda text: core.AUTO if text == core.AUTO else read(text)
