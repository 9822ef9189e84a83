"""Texts and their translations in files as gettext has them (.po, .pot), as far as it is needed."""

from __future__ import annotations

import ast

# A context and a text.
Key = tuple[str, str]
# Blender's name for no particular context, which a file leaves out.
DEFAULT = "*"


def read(text: str) -> dict[Key, str]:
    """The translation of each text in a file, "" where there is none; the header is left out."""
    found: dict[Key, str] = {}
    entry = {"msgctxt": "", "msgid": "", "msgstr": ""}
    field = ""
    for line in (*text.splitlines(), ""):
        name, _, rest = line.partition(" ")
        if name in entry:
            field = name
            entry[field] = str(ast.literal_eval(rest))
        elif line.startswith('"') and field:
            entry[field] += str(ast.literal_eval(line))
        elif not line.strip():
            if entry["msgid"]:
                found[entry["msgctxt"] or DEFAULT, entry["msgid"]] = entry["msgstr"]
            entry, field = dict.fromkeys(entry, ""), ""
    return found


def written(translations: dict[Key, str], places: dict[Key, str]) -> str:
    """A file of these translations; `places` says where in the code each text is."""
    blocks = ['msgid ""\nmsgstr "Content-Type: text/plain; charset=UTF-8\\n"\n']
    for (context, text), translation in translations.items():
        lines = [f"#: {places[context, text]}"]
        if context != DEFAULT:
            lines.append(f"msgctxt {_quoted(context)}")
        lines += [f"msgid {_quoted(text)}", f"msgstr {_quoted(translation)}", ""]
        blocks.append("\n".join(lines))
    return "\n".join(blocks)


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'
