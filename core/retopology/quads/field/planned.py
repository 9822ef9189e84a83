"""The cross field of the plan, on the surface that is mapped: the same steps, the same poles."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ....base.progress import Progress
from ....fields.planes import FaceFrames, lay_out
from ....mesh.half_edges import all_edges
from ...by_hand import planned_by_hand, pull_of, strokes_not_held, with_strokes
from ...crosses.cross_field import CrossField, cross_field
from ...features import BORDER, CREASE, MARK, Features
from ...field.planned import with_poles
from ...poles import Poles, plan_poles
from ...settings import GuidanceSettings
from ..surface.subdivision import MARK_BIT
from ..surface.working_surface import WorkingSurface
from .wishes import Wishes


@dataclass(frozen=True)
class PlannedField:
    """A field and its poles on a working surface.

    Attributes
    ----------
    cross:
        The field, whose singularities are the poles.
    poles:
        Their plan; triangles are those of the working surface, umbilics as in what was given.
    pulled:
        (n,) float64 how much strokes count at the vertices, 0 to 1.
    not_held:
        Sentences on strokes that the field does not follow.
    """

    cross: CrossField
    poles: Poles
    pulled: np.ndarray
    not_held: tuple[str, ...]


def planned_field(
    working: WorkingSurface, wishes: Wishes, most: float, progress: Progress
) -> PlannedField | None:
    """The field of a plan; None where it has more than `most` poles. How long it takes nobody
    knows; it asks `progress` whether to stop."""
    ask = progress.quiet()
    # Its own input, so that rows are its own.
    surface = replace(
        working.surface, source_triangle=np.arange(len(working.surface.triangles), dtype=np.int32)
    )
    features = _features(surface.twin, wishes.feature)
    strokes = wishes.strokes
    pull = None if strokes is None else pull_of(surface, strokes)
    if pull is not None:
        features = with_strokes(surface, features, pull)
    cross = cross_field(
        surface,
        working.field,
        GuidanceSettings(smoothness=wishes.smoothness),
        ask,
        undirected=wishes.undirected,
        features=features,
        # Parts have been divided to about the size of the quads.
        on_outlines=False,
    )
    planes: FaceFrames = lay_out(surface, working.field.lines, ask)
    if wishes.wanted is not None:
        poles = planned_by_hand(surface, [], wishes.wanted)
    else:
        poles = plan_poles(surface, planes, cross, wishes.umbilics, [], wishes.avoided)
        if len(poles.triangle) > most:
            return None
    cross = with_poles(
        surface, planes, cross, features, poles.triangle, 4 - poles.valence, ask, exact=False
    )
    pulled = np.zeros(len(surface.vertices))
    not_held: tuple[str, ...] = ()
    if strokes is not None and pull is not None:
        pulled[pull.vertex] = pull.share
        not_held = strokes_not_held(pull, len(strokes), cross.direction, cross.normal)
    return PlannedField(cross, poles, pulled, not_held)


def _features(twin: np.ndarray, feature: np.ndarray) -> Features:
    """Hard features from the kinds of half-edges (3 m,), borders among them."""
    edges = all_edges(twin)
    half = edges[(feature[edges] > 0) | (twin[edges] < 0)]
    kind = np.where(feature[half] & MARK_BIT > 0, MARK, CREASE)
    kind = np.where(twin[half] < 0, BORDER, kind).astype(np.int8)
    none = np.zeros(0)
    return Features(
        half,
        kind,
        np.full(len(half), -1),
        none.astype(np.int64),
        none.reshape(0, 3),
        none,
    )
