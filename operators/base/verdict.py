"""What is to be thought of a detection, in a line, and what would mend it."""

from __future__ import annotations

from dataclasses import dataclass

import bpy

from ... import core
from ...core.base.words import counted
from .words import counts_in_words

# What mends a detection; see `operators/mend.py`.
SUBDIVIDE, CREASES, MERGE, SMOOTH = "SUBDIVIDE", "CREASES", "MERGE", "SMOOTH"
LABELS = {
    SUBDIVIDE: "Add Subdivision",
    CREASES: "Hard Surface: Crease Angle 30°",
    MERGE: "Merge by Distance",
    SMOOTH: "Wider Scale",
}
_HELP = {
    SUBDIVIDE: "The mesh is too coarse for its shape.",
    CREASES: "The surface has creases: curvature is smeared across them.",
    MERGE: "Faces that look joined are not.",
    SMOOTH: "The noise is as strong as the shape.",
}
_FAIR = "trust fair"
_NOISY = "the noise is not small beside the shape"
# Finer than this a subdivided cage has more faces than anybody waits for.
_MOST_LEVELS = 4


@dataclass(frozen=True)
class Verdict:
    """A detection judged.

    Attributes
    ----------
    found:
        What was found, for example "31 umbilics, 7 regions".
    trust:
        How far that can be trusted, or what is wrong.
    is_good:
        The noise is known and small beside the shape, and nothing is wrong.
    remedy:
        What would mend it, one of the names above; empty where nothing would.
    """

    found: str
    trust: str
    is_good: bool
    remedy: str


def verdict(summary: bpy.types.PropertyGroup) -> Verdict:
    """The judgement of a detection by its `summary.UMBILICS_PG_summary`."""
    umbilics = sum(getattr(summary, kind) for kind in core.KINDS)
    found = counted(umbilics, "umbilic") if umbilics else "no umbilics"
    if summary.regions and not umbilics:
        # Of a sphere all points are.
        found = "no isolated umbilics"
    if summary.regions:
        found += f", {counted(summary.regions, 'region')}"
    remedy = _remedy(summary)
    if remedy:
        return Verdict(found, _HELP[remedy], False, remedy)
    if not summary.noise:
        return Verdict(found, "trust unknown: the noise could not be measured", False, "")
    if umbilics and summary.trust_ratio > core.TRUSTED:
        return Verdict(found, f"{_FAIR}: {_NOISY}", False, "")
    if summary.uncertain:
        sure = counts_in_words({core.KINDS[-1]: summary.uncertain})
        return Verdict(found, f"{_FAIR}: {sure}", False, "")
    return Verdict(found, "trust good", True, "")


def _remedy(summary: bpy.types.PropertyGroup) -> str:
    texts = [warning.text for warning in summary.warnings]
    if any("Merge by Distance" in text for text in texts):
        return MERGE
    if summary.is_coarse:
        return SUBDIVIDE
    if summary.is_hard:
        return CREASES
    if core.SMOOTH_MORE not in texts:
        return ""
    return SUBDIVIDE if _is_subdivided(summary) else SMOOTH


def _is_subdivided(summary: bpy.types.PropertyGroup) -> bool:
    """Whether what was analysed is made smooth by a modifier that has finer levels to give: then
    its noise is that of few faces."""
    return summary.source == "EVALUATED" and any(
        modifier.type == "SUBSURF" and modifier.show_viewport and modifier.levels < _MOST_LEVELS
        for modifier in summary.id_data.modifiers
    )
