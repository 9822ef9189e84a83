"""Make docs/command_line.md, all options of the command, of what --help says of them.

    tools/blender -b --python tools/make_command_page.py

A test inside Blender sees to it that the page is up to date.
"""

from __future__ import annotations

import argparse
import importlib
import sys
import tempfile
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[1]
PAGE = REPOSITORY / "docs" / "command_line.md"

_HEAD = """# All options

```
{usage}
```

{about} This page is what `--help` says, made by
`tools/make_command_page.py`. Results are described in [json.md](json.md), many files in
[batch.md](batch.md); what the settings are for is told in the
[README](../README.md#methods-and-settings), the [guide](guide.md) and [retopology](retopology.md).
"""


def page(parser: argparse.ArgumentParser) -> str:
    """Markdown: a table for each group of options."""
    usage = str(parser.usage).replace("%(prog)s", parser.prog)
    parts = [_HEAD.format(usage=usage, about=parser.description)]
    # `argparse` has no public way to its groups.
    for group in parser._action_groups:  # noqa: SLF001
        actions = group._group_actions  # noqa: SLF001
        shown = [one for one in actions if one.help != argparse.SUPPRESS]
        if not shown:
            continue
        about = f"{group.description}\n\n" if group.description else ""
        rows = "\n".join(f"| {_called(one)} | {_text(one)} |" for one in shown)
        title = str(group.title).capitalize()
        parts.append(f"## {title}\n\n{about}| option | meaning |\n|---|---|\n{rows}\n")
    return "\n".join([*parts, f"{parser.epilog}\n"])


def _called(action: argparse.Action) -> str:
    """The words that an option is called by, and what follows them."""
    if not action.option_strings:
        return f"`{action.metavar}`"
    value = action.metavar or (
        "{" + ",".join(map(str, action.choices)) + "}" if action.choices else ""
    )
    return ", ".join(f"`{name} {value}`".replace(" `", "`") for name in action.option_strings)


def _text(action: argparse.Action) -> str:
    # `argparse` fills in what stands behind percent signs; nothing here does, but for these.
    return str(action.help).replace("%%", "%").replace("|", "\\|").replace("*", "\\*")


def main() -> None:
    """Inside Blender, with the code of this folder, whatever is installed."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "umbilics").symlink_to(REPOSITORY)
        sys.path.insert(0, folder)
        found = importlib.import_module("umbilics.operators.command_line.arguments.parser")
        PAGE.write_text(page(found._parser()), encoding="utf-8")  # noqa: SLF001


if __name__ == "__main__":
    main()
