"""Options that would count for nothing are refused: who gives one expects something of it."""

from __future__ import annotations

import argparse

from .... import core
from ...data.properties import GIVEN_NAMES
from .. import guidance, steering


def refuse(
    parser: argparse.ArgumentParser,
    found: argparse.Namespace,
    guide: guidance.GuidanceRequest | None,
) -> None:
    """End the command where an option is given without the one that it belongs to."""
    makes_quads = guide is not None and guide.makes_quads
    has_plan = guide is not None or found.check_topology is not None
    remeshing = [guidance.quad_setting(name) for name in core.options(core.RemeshSettings)]
    strokes = [steering.setting_name(name) for name in core.options(core.StrokeSettings)]
    plan = "a plan: --guide DIR, --quads N or --check-topology MESH"
    for names, counts, needed in (
        (["guide_files"], guide is not None, "--guide DIR, or --quads N with --out DIR"),
        (remeshing, makes_quads, "quads: --quads N"),
        (list(core.options(core.GuidanceSettings)), has_plan, plan),
        (strokes, found.strokes is not None, "--strokes FILE"),
        (list(GIVEN_NAMES), found.curvature == "given", "--curvature given"),
    ):
        for name in names:
            if not counts and getattr(found, name) != parser.get_default(name):
                parser.error(f"--{name.replace('_', '-')} needs {needed}.")
