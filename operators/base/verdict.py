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
_MOST_LEVELS, _MOST_FACES = 4, 1_000_000
# Corners for each face above which most faces have four: somebody has modelled them.
_QUADS = 3.5


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
    return SUBDIVIDE if _is_modelled(summary) else SMOOTH


def _is_modelled(summary: bpy.types.PropertyGroup) -> bool:
    """Whether what was analysed is a cage that a modifier makes smooth, or could: then its noise is
    that of few faces, and finer levels have less of it.

    With one level the ratio of noise to shape fell from 1.6 to 0.15 on MakeHuman's base, from 0.87
    to 0.18 on a torso and from 1.5 to 0.23 on a sword, all of quads; with two from 1.8 to 0.17 on
    Suzanne.
    """
    obj = summary.id_data
    levels = [
        modifier.levels
        for modifier in obj.modifiers
        if modifier.type == "SUBSURF" and modifier.show_viewport
    ]
    if levels and summary.source == "EVALUATED":
        return min(levels) < _MOST_LEVELS
    faces, corners = len(obj.data.polygons), len(obj.data.loops)
    return corners > _QUADS * faces and 4 * faces <= _MOST_FACES
