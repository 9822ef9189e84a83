"""Frames of an animation: `--frames 1-10,20,30-50x5`."""

from __future__ import annotations

from argparse import ArgumentTypeError
from pathlib import Path

# Blender's own bounds for a frame.
_LAST = 1_048_574
# More than these are a mistake in writing.
_MOST = 100_000


def read(text: str) -> tuple[int, ...]:
    """The frames that the text stands for, each once, in its order."""
    found: list[int] = []
    for piece in text.split(","):
        span, _, step = piece.partition("x")
        # A frame may be negative: the hyphen of a span stands after a digit.
        cut = span.find("-", 1)
        words = [span, span] if cut < 0 else [span[:cut], span[cut + 1 :]]
        try:
            first, last = map(int, words)
            every = int(step) if step else 1
        except ValueError:
            first, last, every = 0, -1, 0
        if last < first or every < 1 or max(abs(first), abs(last)) > _LAST:
            raise ArgumentTypeError(f"'{text}' is not like 1-10,20,30-50x5")
        if (last - first) // every >= _MOST:
            raise ArgumentTypeError(f"'{text}' are more than {_MOST} frames")
        found += range(first, last + 1, every)
    return tuple(dict.fromkeys(found))


def in_words(frames: tuple[int, ...]) -> str:
    """Text that `read` turns into the same frames."""
    return ",".join(map(str, frames))


def path_at(path: Path, frame: int) -> Path:
    """Where a result goes that has a file for each frame: before the ending, F.0001.png."""
    return path.with_name(f"{path.stem}.{frame:04d}{path.suffix}")


def places(path: Path, kind: str, frames: tuple[int, ...]) -> list[Path]:
    """All files that a result has, given the frames that were asked for."""
    if not frames or kind == "json":
        return [path]
    return [path_at(path, frame) for frame in frames]
