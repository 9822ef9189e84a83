"""Collect all that the add-on says into operators/base/languages/template.pot, and bring the
languages beside it up to date.

    python tools/extract_texts.py          writes
    python tools/extract_texts.py --check  says what would change; exit code 1 if anything

Names, descriptions and labels are found where Blender is given them, sentences by reading like
one. A sentence that is made of parts, an f-string, becomes a template: what is filled in stands in
braces under its name in the code. German is to be complete; what is new there is left empty, and
a test says so. What is gone is dropped.
"""

from __future__ import annotations

import argparse
import ast
import re
import sys
from collections.abc import Iterator

from places import REPOSITORY

sys.path[:0] = [str(REPOSITORY / "operators" / "base"), str(REPOSITORY)]
import po  # noqa: E402

import core  # noqa: E402
import core.umbilics.result as core_result  # noqa: E402

FOLDER = REPOSITORY / "operators" / "base" / "languages"
TEMPLATE = FOLDER / "template.pot"
# Where the window's texts are; the command line speaks English, like the programs around it.
_HOUSES = ("ui", "operators", "core")
_SILENT = (
    "operators/command_line", "operators/base/po.py", "operators/base/translation.py",
    "core/formats/usd", "core/formats/ply", "core/fields", "core/base/rows.py",
    "ui/overlay/shader.py",
)  # fmt: skip
# Keywords and positions of calls that Blender or the user is given a text by.
_KEYWORDS = {"name", "description", "text", "heading", "label", "help", "title", "message"}
_POSITIONS = {
    "Choice": (1, 2), "FileKind": (1, 2), "line": (2, 3), "explained": (2,), "part": (0,),
    "label": (0,), "progress": (1,),
}  # fmt: skip
# Calls whose keywords mean something else.
_NOT = {"Thread", "new", "ExtensionError", "getattr", "unit", "field", "namedtuple"}
_CLASS = {"bl_label", "bl_description"}
# Errors of the programmer's, which no user reads.
_INTERNAL = {"ValueError", "TypeError", "AssertionError", "KeyError", "NotImplementedError"}
# Dictionaries of texts.
_TITLES = re.compile("TITLES|LABEL|WORDS|HELP|PLURAL")
# Names of data, which stay as they are in a file, and what only the code reads.
_NOT_SHOWN = {
    "Umbilics of {name}", "Guides of {name}", "Guidance of {name}", "Pole {valence}",
    "{name} Quads", "{name} Retopology", "Umbilics {name}", "Umbilics {kind}", "Umbilics Lift",
    "Umbilics Arrows", "Radius Top", "Radius Bottom", "umbilics reading", "umbilics strokes",
    "umbilics, going", "Origin | None", "gathered with edges", "{name_full} pole {name}",
    "{name_full} mark {number}", "Rotation Axis {order}",
    "settings = bpy.context.scene.umbilics", "only what has a record has a crowd",
    "{number} {capitalize}", "{index}", "{index_sum}", "{confidence} %", "{method}: {reason}",
    "{explained}. {click}", "{number} {translated}",
}  # fmt: skip
_WORD = re.compile(r"[^\W\d_]{2,}")


def texts() -> dict[tuple[str, str], str]:
    """Where each text is, by its context and itself, in the order of the files."""
    found: dict[tuple[str, str], str] = {}
    for house in _HOUSES:
        for path in sorted((REPOSITORY / house).rglob("*.py")):
            place = path.relative_to(REPOSITORY).as_posix()
            if not place.startswith(_SILENT):
                for context, text in _of_module(ast.parse(path.read_text("utf-8"))):
                    found.setdefault((context, text), place)
    for text in _put_together():
        found.setdefault(("*", text), "core/umbilics/result.py")
    return found


def _put_together() -> Iterator[str]:
    """What the code makes of the names of kinds: titles, and numbers of them."""
    for kind in core.KINDS:
        yield kind.capitalize()
        yield from (f"1 {kind}", f"{{count}} {kind}s")
        yield f"Colour of each {kind}"
    yield from (kind.capitalize() for kind in core.SURFACE_TYPES)
    yield from core_result.REGION_KINDS
    # Words that stand where a number or a place would.
    yield from ("none", "unknown", "moved", "deleted", "Matched", "Extra", "Missing")
    for settings in (core.Settings, core.GuidanceSettings, core.RemeshSettings):
        for option in core.options(settings).values():
            if option.automatic:
                yield f"Automatic {option.label}"
    for name in ("k1", "k2", "d1", "d2"):
        yield f"Vertex attribute that holds {name}"


def _of_module(tree: ast.Module) -> Iterator[tuple[str, str]]:
    parents = {child: node for node in ast.walk(tree) for child in ast.iter_child_nodes(node)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and _called(node) == "counted":
            yield from (("*", text) for text in _counts(node))
            continue
        text = _text(node)
        if text is None or isinstance(parents[node], (ast.JoinedStr, ast.FormattedValue)):
            continue
        where = _use(node, parents)
        if where is None or text in _NOT_SHOWN or not _WORD.search(text):
            continue
        if where == "prose" and not _is_prose(text):
            continue
        yield ("Operator" if where == "operator" else "*"), text


def _counts(call: ast.Call) -> list[str]:
    """What `core.base.words.counted` makes: one of a thing, and several."""
    nouns = [_text(one) for one in call.args[1:]]
    if not nouns or nouns[0] is None:
        return []
    plural = nouns[1] if len(nouns) > 1 else f"{nouns[0]}s"
    return [f"1 {nouns[0]}", f"{{count}} {plural}"]


def _text(node: ast.AST) -> str | None:
    """The text of a string or the template of an f-string."""
    if isinstance(node, ast.Constant):
        return node.value if isinstance(node.value, str) else None
    return template_of(node) if isinstance(node, ast.JoinedStr) else None


def template_of(node: ast.JoinedStr) -> str:
    """An f-string with the last name of each expression in braces; doubles are numbered."""
    parts, used = [], {}
    for value in node.values:
        if isinstance(value, ast.Constant):
            parts.append(str(value.value))
            continue
        name = _name(value.value)
        used[name] = used.get(name, 0) + 1
        parts.append(f"{{{name}{used[name] if used[name] > 1 else ''}}}")
    return "".join(parts)


def _name(node: ast.AST) -> str:
    names = [one for one in ast.walk(node) if isinstance(one, (ast.Name, ast.Attribute))]
    if isinstance(node, ast.Attribute):
        return node.attr
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "len":
        return "count"
    if not names:
        return "value"
    first = names[0]
    return (first.attr if isinstance(first, ast.Attribute) else first.id).strip("_").lower()


def _use(node: ast.AST, parents: dict[ast.AST, ast.AST]) -> str | None:
    """What a text is for: "label", "operator" (a button's), "prose" where only its look tells, or
    None if it is not for the user."""
    child, parent = node, parents[node]
    if isinstance(parent, (ast.Expr, ast.Compare, ast.Subscript)):
        return None
    while isinstance(parent, (ast.IfExp, ast.BoolOp)):
        child, parent = parent, parents[parent]
    if isinstance(parent, ast.keyword):
        call = parents[parent]
        if isinstance(call, ast.Call) and _called(call) not in _NOT and parent.arg in _KEYWORDS:
            if _called(call).endswith("Property") and not _is_shown(call):
                return None
            is_button = _called(call).startswith("operator") and parent.arg == "text"
            return "operator" if is_button else "label"
        return "prose" if parent.arg == "default" else None if parent.arg else "prose"
    if isinstance(parent, ast.Assign) and isinstance(parents[parent], ast.Module):
        name = getattr(parent.targets[0], "id", "")
        return "label" if _TITLES.search(name) else "prose"
    if isinstance(parent, ast.Assign) and isinstance(parents[parent], ast.ClassDef):
        names = {one.id for one in parent.targets if isinstance(one, ast.Name)}
        if names & _CLASS:
            of = parents[parent].name
            return "operator" if "bl_label" in names and "_OT_" in of else "label"
    if isinstance(parent, ast.Call):
        name = _called(parent)
        if child in parent.args and parent.args.index(child) in _POSITIONS.get(name, ()):
            return "label"
        if name == "counted":
            return None
        if name in _INTERNAL or name in ("write", "info", "encode", "split", "strip"):
            return None
    if isinstance(parent, ast.Dict) and child in parent.values:
        holder = parents[parent]
        names = [one.id for one in ast.walk(holder) if isinstance(one, ast.Name)]
        if isinstance(holder, (ast.Assign, ast.AnnAssign)) and _TITLES.search(names[0]):
            return "label"
    if isinstance(parent, ast.Tuple) and _is_item(parent) and parent.elts.index(child) in (1, 2):
        return "label"
    return "prose"


def _is_shown(call: ast.Call) -> bool:
    """Whether a property has a name: without one it is in no panel."""
    return any(one.arg == "name" for one in call.keywords)


def _is_item(node: ast.Tuple) -> bool:
    """Whether a tuple is an item of an enumeration: name, label, help and perhaps more."""
    strings = [one for one in node.elts[:3] if isinstance(one, (ast.Constant, ast.Subscript))]
    return 3 <= len(node.elts) <= 5 and len(strings) >= 2 and _is_prose(_text(node.elts[2]) or "")


def _called(call: ast.Call) -> str:
    return call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")


def _is_prose(text: str) -> bool:
    """Whether a text reads like a sentence or a part of one."""
    bare = re.sub(r"\{[^}]*\}", "", text)
    words = _WORD.findall(bare)
    if re.search(r"[=;<>]\s*$|^[a-z_]+$|\bvec[34]\b|://|\\", bare) or "\n" in text:
        return False
    return " " in text.strip() and len(words) >= (1 if "{" in text else 2)


def main() -> int:
    parser = argparse.ArgumentParser(description="Collect the add-on's texts for translators.")
    parser.add_argument("--check", action="store_true", help="write nothing")
    check = parser.parse_args().check
    found, changed = texts(), False
    for path in (TEMPLATE, *sorted(FOLDER.glob("*.po"))):
        known = po.read(path.read_text("utf-8")) if path.exists() else {}
        text = po.written({key: known.get(key, "") for key in found}, found)
        if not path.exists() or path.read_text("utf-8") != text:
            changed = True
            print(f"{path.relative_to(REPOSITORY)} {'is old' if check else 'written'}")
            if not check:
                path.write_text(text, "utf-8")
    return int(check and changed)


if __name__ == "__main__":
    sys.exit(main())
