"""Make the pages of ui/help that *Online Manual* opens, from those of docs/ of the same names.

    python tools/make_manual.py

Pictures and their captions stay behind: the pages ship with the extension. A test sees to it that
they are up to date.
"""

import html
import re
from pathlib import Path

from places import REPOSITORY

PAGES = ("guide", "retopology")

_STYLE = (
    "body{max-width:44em;margin:2em auto;padding:0 1em;font:16px/1.5 sans-serif;color:#222}"
    "code,pre{background:#eee;padding:0 .2em}h2{margin-top:2em;border-bottom:1px solid #ccc}"
    "td,th{padding:.1em .6em;text-align:left}"
)


def source(name: str) -> Path:
    """Where a page is written."""
    return REPOSITORY / "docs" / f"{name}.md"


def target(name: str) -> Path:
    """The page as it ships."""
    return REPOSITORY / "ui" / "help" / f"{name}.html"


def page(text: str) -> str:
    """Markdown, as far as it is used there, as HTML."""
    parts, was_picture = [], False
    for block in re.split(r"\n\s*\n", text):
        shown = re.sub(r"!\[[^\]]*\]\([^)]*\)", "", block).strip()
        is_caption = was_picture and re.fullmatch(r"\*[^*].*[^*]\*", shown, re.DOTALL)
        was_picture = not shown
        if shown and not is_caption:
            parts.append(_block([line for line in shown.splitlines() if line.strip()]))
    body = "\n".join(parts)
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>Umbilics</title>\n'
        f"<style>{_STYLE}</style></head>\n<body>\n{body}\n</body></html>\n"
    )


def _block(lines: list[str]) -> str:
    """What stands between two empty lines."""
    first = lines[0]
    if heading := re.match(r"(#+) (.*)", first):
        level, title = len(heading[1]), heading[2]
        return f'<h{level} id="{anchor(title)}">{_inline(title)}</h{level}>'
    if first.startswith("```"):
        code = html.escape("\n".join(lines[1:-1]), quote=False)
        return f"<pre>{code}</pre>"
    if first.startswith("|"):
        return _table(lines)
    for mark, tag in ((r"- ", "ul"), (r"\d+\. ", "ol")):
        if re.match(mark, first):
            items = re.split(rf"\n(?={mark})", "\n".join(lines))
            rows = "".join(f"<li>{_inline(re.sub(mark, '', one, count=1))}</li>\n" for one in items)
            return f"<{tag}>\n{rows}</{tag}>"
    return f"<p>{_inline(' '.join(lines))}</p>"


def _table(lines: list[str]) -> str:
    """A head, unless it is empty, and rows."""
    rows = [[cell.strip() for cell in line.strip().strip("|").split("|")] for line in lines]
    head, _, *body = rows
    found = []
    for tag, cells in (("th", head), *(("td", row) for row in body)):
        if any(cells):
            row = "".join(f"<{tag}>{_inline(cell)}</{tag}>" for cell in cells)
            found.append(f"<tr>{row}</tr>\n")
    return f"<table>\n{''.join(found)}</table>"


def anchor(title: str) -> str:
    """What a link to a heading ends with."""
    return re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-")


def _inline(text: str) -> str:
    text = html.escape(" ".join(text.split()), quote=False)
    text = re.sub(r"`([^`]+)`", r"<code>\1</code>", text)
    text = re.sub(r"\*\*([^*]+)\*\*", r"<b>\1</b>", text)
    text = re.sub(r"\*([^*]+)\*", r"<i>\1</i>", text)
    pages = "|".join(PAGES)
    text = re.sub(rf"\[([^\]]+)\]\(({pages})\.md(#[^)]*)?\)", r'<a href="\2.html\3">\1</a>', text)
    text = re.sub(r"\[([^\]]+)\]\((#[^)]*)\)", r'<a href="\2">\1</a>', text)
    # Other files of docs/ do not ship.
    return re.sub(r"\[([^\]]+)\]\([^)]*\)", r"\1", text)


def write() -> None:
    """Write the pages."""
    for name in PAGES:
        target(name).parent.mkdir(parents=True, exist_ok=True)
        target(name).write_text(page(source(name).read_text("utf-8")), "utf-8")


if __name__ == "__main__":
    write()
