"""The page that ships is the guide, and every entry of the manual leads to a heading of it."""

import re
import sys
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]


def test_page_is_up_to_date_and_has_every_heading_that_is_pointed_to(monkeypatch):
    monkeypatch.setattr(sys, "path", [str(REPOSITORY / "tools"), *sys.path])
    import make_manual

    page = make_manual.PAGE.read_text("utf-8")
    assert page == make_manual.page(make_manual.SOURCE.read_text("utf-8")), (
        "run python tools/make_manual.py"
    )
    wanted = re.findall(r'"#([a-z-]+)"', (REPOSITORY / "ui" / "manual.py").read_text("utf-8"))
    assert wanted
    assert set(wanted) <= set(re.findall(r'id="([a-z0-9-]+)"', page))


def test_pictures_of_the_guide_are_there():
    text = (REPOSITORY / "docs" / "guide.md").read_text("utf-8")
    for picture in re.findall(r"\((figures/[^)]+)\)", text):
        assert (REPOSITORY / "docs" / picture).is_file(), picture
