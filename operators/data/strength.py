"""The slider of the filter: it spans the persistences that there are, on a logarithmic scale."""

from __future__ import annotations

import math

import bpy

from . import record
from .belonging import active_mesh

_DECADES = 4.0


def strength_of(level: float, top: float) -> float:
    """Where a persistence is on the slider, whose end is just above the largest one, `top`."""
    if top <= 0.0 or level <= 0.0:
        return 0.0
    return min(max(1.0 + math.log10(level / (1.001 * top)) / _DECADES, 0.0), 1.0)


def get_strength(self: bpy.types.PropertyGroup) -> float:
    """Where the slider stands for the active object."""
    settings = self.id_data.umbilics
    kept = record.of(active_mesh())
    top = kept.top if kept else 0.0
    level = settings.persistence
    if settings.persistence_auto:
        level = kept.automatic_level if kept else 0.0
    return strength_of(level, top)


def put_strength(self: bpy.types.PropertyGroup, value: float) -> None:
    """Take the persistence at which the slider was put for the active object."""
    settings = self.id_data.umbilics
    kept = record.of(active_mesh())
    top = kept.top if kept else 0.0
    # In this order the first change has no effect while the switch is on.
    settings.persistence = (
        1.001 * top * 10.0 ** (_DECADES * (value - 1.0)) if value > 0.0 else 0.0
    )
    if settings.persistence_auto:
        settings.persistence_auto = False
