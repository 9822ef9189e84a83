"""Make ui/help/guide.html, the page that *Online Manual* opens, from docs/guide.md.

    python tools/make_manual.py

Pictures stay behind: the page ships with the extension. A test sees to it that it is up to date.
"""

import html
import re
from pathlib import Path

from places import REPOSITORY

SOURCE = REPOSITORY / "docs" / "guide.md"
PAGE = REPOSITORY / "ui" / "help" / "guide.html"

_STYLE = (
    "body{max-width:44em;margin:2em auto;padding:0 1em;font:16px/1.5 sans-serif;color:#222}"
    "code{background:#eee;padding:0 .2em}h2{margin-top:2em;border-bottom:1px solid #ccc}"
)


def page(text: str) -> str:
    """The guide's Markdown, as far as it is used there, as HTML."""
    parts = []
    for block in re.split(r"\n\s*\n", re.sub(r"!\[[^\]]*\]\([^)]*\)", "", text)):
        lines = [line for line in block.strip().splitlines() if line.strip()]
        if not lines:
            continue
        first = lines[0]
        if heading := re.match(r"(#+) (.*)", first):
            level, title = len(heading[1]), heading[2]
            parts.append(f'<h{level} id="{anchor(title)}">{_inline(title)}</h{level}>')
        elif first.startswith("- "):
            items = re.split(r"\n(?=- )", "\n".join(lines))
            rows = "".join(f"<li>{_inline(item[2:])}</li>\n" for item in items)
            parts.append(f"<ul>\n{rows}</ul>")
        elif first.startswith("|"):
            cells = [" ".join(cell.strip() for cell in line.split("|")).strip() for line in lines]
            rows = [cell for cell in cells if cell.strip(" -")]
            parts += [f"<p>{_inline(row)}</p>" for row in rows]
        else:
            parts.append(f"<p>{_inline(' '.join(lines))}</p>")
    body = "\n".join(parts)
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>Umbilics</title>\n'
        f"<style>{_STYLE}</style></head>\n<body>\n{body}\n</body></html>\n"
    )


def anchor(title: str) -> str:
    """What a link to a heading ends with."""
    return re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-")


def _inline(text: str) -> str:
    text = html.escape(" ".join(text.split()), quote=False)
    text = re.sub(r"`([^`]+)`", r"<code>\1</code>", text)
    text = re.sub(r"\*\*([^*]+)\*\*", r"<b>\1</b>", text)
    text = re.sub(r"\*([^*]+)\*", r"<i>\1</i>", text)
    # Other files of docs/ do not ship.
    return re.sub(r"\[([^\]]+)\]\([^)]*\)", r"\1", text)


def write(path: Path = PAGE) -> None:
    """Write the page."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(page(SOURCE.read_text("utf-8")), "utf-8")


if __name__ == "__main__":
    write()
