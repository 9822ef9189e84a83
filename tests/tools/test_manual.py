"""The pages that ship are those of docs/, and their links lead to headings that there are."""

import re
import sys
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]


@pytest.fixture
def manual(monkeypatch):
    monkeypatch.setattr(sys, "path", [str(REPOSITORY / "tools"), *sys.path])
    import make_manual

    return make_manual


def test_pages_are_up_to_date_and_their_links_lead_somewhere(manual):
    pages = {}
    for name in manual.PAGES:
        pages[f"{name}.html"] = manual.target(name).read_text("utf-8")
        assert pages[f"{name}.html"] == manual.page(manual.source(name).read_text("utf-8")), (
            "run python tools/make_manual.py"
        )
    links = [
        (link or name, anchor)
        for name, page in pages.items()
        for link, anchor in re.findall(r'href="([a-z.]*)#?([a-z0-9-]*)"', page)
    ]
    assert ("retopology.html", "") in links
    for name, anchor in links:
        assert not anchor or f'id="{anchor}"' in pages[name], (name, anchor)
    assert not re.search(r"\]\(|```|<p>\|", "".join(pages.values())), "Markdown is left"


def test_captions_go_with_their_pictures_and_emphasis_stays(manual):
    text = "![A](a.png)\n\n*Of the picture,\ntwo lines.*\n\n*Clear* removes.\n\n*All of it.*"
    body = manual.page(text)
    assert "Of the picture" not in body
    assert "<p><i>Clear</i> removes.</p>\n<p><i>All of it.</i></p>" in body


def test_lists_code_and_tables(manual):
    blocks = ("1. one\n more\n2. two", '```json\n{"a": 1 < 2}\n```', "| a | |\n|--|--|\n| b | c |")
    body = manual.page("\n\n".join(blocks))
    assert "<ol>\n<li>one more</li>\n<li>two</li>\n</ol>" in body
    assert '<pre>{"a": 1 &lt; 2}</pre>' in body
    assert "<tr><th>a</th><th></th></tr>\n<tr><td>b</td><td>c</td></tr>" in body


@pytest.mark.parametrize("name", ["guide", "retopology"])
def test_pictures_are_there(name):
    text = (REPOSITORY / "docs" / f"{name}.md").read_text("utf-8")
    for picture in re.findall(r"\((figures/[^)]+)\)", text):
        assert (REPOSITORY / "docs" / picture).is_file(), picture
