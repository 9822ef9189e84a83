"""What the pages lead to is there: other pages, chapters of them, files of the repository."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
# What the tools leave behind, in .gitignore, is there or not.
MADE = {"dist", "wheels", "umbilics-output"}
FOLDERS = {path.name for path in ROOT.iterdir() if path.is_dir()} - MADE


def chapters(page):
    """The anchors of a page, as GitHub makes them of its headings."""
    headings = re.findall(r"^#+ (.*)$", page.read_text("utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", text.lower()).replace(" ", "-") for text in headings}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page):
    lost = []
    for link in re.findall(r"\]\(([^)\s]+)\)", page.read_text("utf-8")):
        name, _, chapter = link.partition("#")
        place = page.parent / name if name else page
        if "://" not in link and not (
            place.exists() and (not chapter or chapter in chapters(place))
        ):
            lost.append(link)
    assert lost == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_files_that_are_named_are_there(page):
    named = re.findall(r"`([\w.-]+(?:/[\w.-]+)*/?)[ `]", page.read_text("utf-8"))
    lost = []
    for name in named:
        # A test is named by its place in tests/.
        is_test = re.search(r"(^|/)test_\w+\.py$", name) and not name.startswith("tests/")
        place = ROOT / "tests" / name if is_test else ROOT / name
        if (is_test or ("/" in name and name.split("/")[0] in FOLDERS)) and not place.exists():
            lost.append(name)
    assert lost == []
