"""The page being written: Markdown, and the figures beside it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path


class Page:
    """Collects the page; `save` writes it.

    Attributes
    ----------
    figures:
        Folder of the figures.
    models:
        Folder of the scanned models, or None.
    left_out:
        What could not be shown, each with the reason.
    differences:
        Where the outcome is not what the paper says, collected on the way for the end.
    """

    def __init__(self, output: Path, models: Path | None) -> None:
        self._output = output
        self.figures = output / "figures" / "validation"
        self.models = models
        self.left_out: list[str] = []
        self.differences: list[str] = []
        self._blocks: list[str] = []

    def heading(self, text: str, level: int = 2) -> None:
        self._blocks.append(f"{'#' * level} {text}")

    def text(self, text: str) -> None:
        """A paragraph; line breaks inside are joined."""
        self._blocks.append(" ".join(text.split()))

    def items(self, texts: Sequence[str]) -> None:
        """A list."""
        self._blocks.append("\n".join(f"- {' '.join(text.split())}" for text in texts))

    def table(self, heading: Sequence[str], rows: Sequence[Sequence[object]]) -> None:
        """A table; columns of numbers are set to the right."""
        cells = [[str(cell) for cell in row] for row in rows]
        align = [
            "---:" if all(_is_number(row[k]) for row in cells) else "---"
            for k in range(len(heading))
        ]
        lines = [heading, align, *cells]
        self._blocks.append("\n".join(f"| {' | '.join(line)} |" for line in lines))

    def figure(self, name: str, caption: str) -> Path:
        """Refer to a figure; returns where it must be written."""
        caption = " ".join(caption.split())
        self._blocks.append(f"![{name}](figures/validation/{name}.png)\n\n*{caption}*")
        return self.figures / f"{name}.png"

    def save(self) -> None:
        """Write validation.md."""
        self._output.mkdir(parents=True, exist_ok=True)
        text = "\n\n".join(self._blocks) + "\n"
        (self._output / "validation.md").write_text(text, encoding="utf-8")


def _is_number(cell: str) -> bool:
    return bool(cell) and (cell[0].isdigit() or cell[0] in "+−-–") and " " not in cell[1:3]


def number(value: float, digits: int = 3) -> str:
    """A number for a table: significant digits, no exponent for ordinary sizes."""
    if value != value:
        return "–"
    if value == 0:
        return "0"
    if 1e-3 <= abs(value) < 1e6:
        return f"{value:.{digits}g}" if abs(value) < 1000 else f"{value:.0f}"
    return f"{value:.{digits - 1}e}"
