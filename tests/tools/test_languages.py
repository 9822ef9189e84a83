"""The texts that translators get are those of the code, and German has all of them."""

import re
import sys
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
LANGUAGES = REPOSITORY / "operators" / "base" / "languages"
_HOLES = re.compile(r"\{([^}]*)\}")


@pytest.fixture(scope="module")
def extraction():
    sys.path[:0] = [str(REPOSITORY / "tools")]
    import extract_texts

    return extract_texts


@pytest.fixture(scope="module")
def german(extraction):
    return extraction.po.read((LANGUAGES / "de.po").read_text("utf-8"))


def test_template_and_languages_are_up_to_date(extraction, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["extract_texts.py", "--check"])
    assert extraction.main() == 0, "run python tools/extract_texts.py, and translate what is new"


def test_german_has_every_text(german):
    assert [text for (_, text), translation in german.items() if not translation] == []


def test_a_translation_has_no_hole_that_its_text_has_not(german):
    for (_, text), translation in german.items():
        missing = set(_HOLES.findall(translation)) - set(_HOLES.findall(text))
        assert not missing, text


def test_blanks_at_the_ends_are_kept(german):
    for (_, text), translation in german.items():
        ends = text[:1].isspace(), text[-1:].isspace()
        assert (translation[:1].isspace(), translation[-1:].isspace()) == ends, text


def test_a_file_is_read_as_it_was_written(extraction):
    texts = {("*", 'a "quoted" \\ text\nof two lines'): "ä", ("Operator", "Clear"): "Löschen"}
    places = dict.fromkeys(texts, "somewhere.py")
    assert extraction.po.read(extraction.po.written(texts, places)) == texts


def test_f_strings_become_templates_with_the_names_of_what_is_filled_in(extraction):
    code = (
        "class UMBILICS_OT_x:\n"
        "    bl_label = 'Do It'\n"
        "    def f(self, obj, items, error):\n"
        "        'A docstring is no text.'\n"
        "        raise ObjectError(f'{obj.name} has {len(items)} of {obj.name}: {error}')\n"
    )
    import ast

    assert list(extraction._of_module(ast.parse(code))) == [
        ("Operator", "Do It"),
        ("*", "{name} has {count} of {name2}: {error}"),
    ]


def test_whatever_an_operator_reports_is_translated():
    import ast

    told = []
    for path in (REPOSITORY / "operators").rglob("*.py"):
        if "command_line" in path.parts:
            continue
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            name = getattr(getattr(node, "func", None), "attr", "")
            reports = name == "report" and getattr(node.func.value, "id", "") == "self"
            if isinstance(node, ast.Call) and (reports or name == "poll_message_set"):
                called = getattr(getattr(node.args[-1], "func", None), "id", "")
                if called != "reported":
                    told.append(f"{path.relative_to(REPOSITORY)}:{node.lineno}")
    assert told == [], "give the text to operators.base.translation.reported"
