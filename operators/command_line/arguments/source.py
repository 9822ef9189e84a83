"""Arguments that say what of an object is analysed, made from the one list of these choices."""

from __future__ import annotations

import argparse
from dataclasses import dataclass

from .... import core
from ...data.reading import GROUP_HELP, Reading
from ...mesh.scope import Scope


@dataclass(frozen=True)
class Source:
    """What of an object is analysed: its form and its part."""

    reading: Reading
    scope: Scope

    @property
    def evaluated(self) -> bool:
        return self.reading.source == "EVALUATED"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("what is analysed")
    for name, option in core.options(Reading).items():
        default = core.defaults(Reading)[name].lower()
        texts = [
            f"{choice.value.lower()}: {choice.help[0].lower()}{choice.help[1:]}"
            for choice in option.choices
        ]
        group.add_argument(
            f"--{name}",
            choices=[choice.value.lower() for choice in option.choices],
            default=default,
            help=f"{option.help} ({'; '.join(texts)}; default: {default})",
        )
    group.add_argument(
        "--scope-group", metavar="NAME", default="", help=f"--scope group: {GROUP_HELP}"
    )


def source_of(parser: argparse.ArgumentParser, found: argparse.Namespace) -> Source:
    """What the arguments ask for; wrong ones end the command."""
    if (found.scope == "group") != bool(found.scope_group):
        parser.error("--scope group and --scope-group NAME go together.")
    if found.frames and found.source == "base":
        parser.error("--frames needs --source evaluated: the mesh below modifiers has no frames.")
    reading = Reading(found.source.upper(), found.scope.upper())
    return Source(reading, Scope(reading.scope, found.scope_group))


def words_of(found: argparse.Namespace) -> list[str]:
    """Arguments that give another process the same choices."""
    words = [f"--source={found.source}", f"--scope={found.scope}"]
    return [*words, f"--scope-group={found.scope_group}"] if found.scope_group else words
