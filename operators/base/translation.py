"""The add-on in the user's language, by Blender's own translations.

Names, tooltips and labels are looked up by Blender itself, in the texts that `register` gives it.
A sentence with numbers and names in it is made in English, wherever it comes from: a result, a
file, an error of the core, which knows no Blender. `translated` finds the template that it was
made of by the words of it, and fills what was filled in into the template's translation. The
texts are in languages/, one file for each language, collected by tools/extract_texts.py.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache, lru_cache, partial
from pathlib import Path

import bpy

from . import po

_FOLDER = Path(__file__).with_name("languages")
# What is filled in under these names is the user's own: it stays as it is.
_VERBATIM = re.compile(
    r"_?(name|names|object_name|path|parent|text|value|strerror|group|checked|error)\d*"
)
# What a hole of these names is filled with: a number; numbers of things.
_NUMBER = r"[-+]?[\d.,]+(?:e[-+]?\d+)?"
_FILLED = {"count": f"({_NUMBER})", "several": f"({_NUMBER} .*?)"}
_HOLE = re.compile(r"\{([^}]*)\}")
# Sentences that stand together in one text; the parts of one; parts of a part.
_BETWEEN = (r"(?<=[.!])( )(?=\S)", r"(: )", r"(; )", r"(, )")
_REMEMBERED = 512
# Letters of a template that are not met by chance; with fewer it may only be all of a part.
_CLEAR = 12

# Finds the translation of a whole text, or gives the text back.
_Look = Callable[[str], str]


@dataclass(frozen=True)
class _Template:
    """A sentence with holes: what it looks like filled, the names of the holes, and its letters."""

    text: str
    looks: re.Pattern[str]
    holes: tuple[str, ...]
    words: int


def translated(text: str) -> str:
    """A label or sentence that was made in English in the user's language, as far as it is known;
    for what the panels show."""
    return _translated(text, _language(), _label)


def reported(text: str) -> str:
    """As `translated`, for messages: they may be wanted in English where labels are not."""
    return _translated(text, _language(), _message)


def languages() -> dict[str, dict[po.Key, str]]:
    """For each language that there is, the translations of its texts, by context and text."""
    return {path.stem: _of_file(path) for path in sorted(_FOLDER.glob("*.po"))}


@cache
def _of_file(path: Path) -> dict[po.Key, str]:
    return {key: text for key, text in po.read(path.read_text("utf-8")).items() if text}


def _language() -> str:
    """The language that Blender speaks, as far as we do; else nothing."""
    language = (bpy.app.translations.locale or "").partition("_")[0]
    return language if (_FOLDER / f"{language}.po").is_file() else ""


def _label(text: str) -> str:
    return str(bpy.app.translations.pgettext_iface(text))


def _message(text: str) -> str:
    return str(bpy.app.translations.pgettext_rpt(text))


@lru_cache(_REMEMBERED)
def _translated(text: str, language: str, look: _Look) -> str:
    return _found(text, _templates(language), look) if language and text else text


def _found(text: str, templates: tuple[_Template, ...], look: _Look) -> str:
    """The translation of a text: as it is, by a template that says enough, of its parts, or by
    one that says little."""
    exact = look(text)
    if exact != text:
        return exact
    clear = (template for template in templates if template.words >= _CLEAR)
    filled = _filled(text, clear, templates, look)
    if filled is not None:
        return filled
    for between in _BETWEEN:
        parts = re.split(between, text)
        if len(parts) > 1:
            parts[::2] = [_found(part, templates, look) for part in parts[::2]]
            return "".join(parts)
        if between == _BETWEEN[1] and text.endswith("."):
            return f"{_found(text[:-1], templates, look)}."
    loose = (template for template in templates if template.words < _CLEAR)
    return _filled(text, loose, templates, look) or text


def _filled(
    text: str, among: Iterable[_Template], templates: tuple[_Template, ...], look: _Look
) -> str | None:
    """The translation by the first of some templates that fits; None if none does."""
    for template in among:
        filled = template.looks.fullmatch(text)
        if filled is not None:
            given = {
                hole: part if _VERBATIM.fullmatch(hole) else _found(part, templates, look)
                for hole, part in zip(template.holes, filled.groups(), strict=True)
            }
            return _HOLE.sub(partial(_fill, given), look(template.text))
    return None


def _fill(given: dict[str, str], hole: re.Match[str]) -> str:
    return given.get(hole[1], hole[0])


@cache
def _templates(language: str) -> tuple[_Template, ...]:
    """The templates of a language, those of the most words first: the others fit more loosely."""
    texts = {text for _, text in _of_file(_FOLDER / f"{language}.po")}
    made = [_template(text) for text in texts if _HOLE.search(text)]
    return tuple(sorted(made, key=lambda template: (-template.words, template.text)))


def _template(text: str) -> _Template:
    pieces = _HOLE.split(text)
    looks = "".join(
        _FILLED.get(piece.rstrip("0123456789"), "(.*?)") if number % 2 else re.escape(piece)
        for number, piece in enumerate(pieces)
    )
    words = sum(letter.isalpha() for letter in "".join(pieces[::2]))
    return _Template(text, re.compile(looks, re.DOTALL), tuple(pieces[1::2]), words)


def register() -> None:
    bpy.app.translations.register(__package__, languages())


def unregister() -> None:
    bpy.app.translations.unregister(__package__)
    _translated.cache_clear()
