"""Operators that have settings of the panel as their own, for Adjust Last Operation."""

from __future__ import annotations

from contextlib import ExitStack
from typing import Any, ClassVar

import bpy

from ... import core
from ..base import layouts
from ..data import plans
from ..data.properties import annotations_of
from ..scene.transaction import Transaction
from . import retopology
from .modal import GuidanceOperator, Message


class Adjustable(GuidanceOperator):
    """A mixin of operators of whose properties those in `adjusted` are in the group `panel` of
    the scene too.

    What is not given comes from the panel. What was given, there or by Adjust Last Operation, is
    put into the panel together with what is made, so that it shows how.
    """

    panel: ClassVar[str]
    adjusted: ClassVar[tuple[str, ...]]
    # Blender's, of every operator.
    properties: ClassVar[Any]
    layout: ClassVar[bpy.types.UILayout]

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        self._take(context)
        return super().invoke(context, event)

    def execute(self, context: bpy.types.Context) -> set[str]:
        self._take(context)
        return super().execute(context)

    def draw(self, _context: bpy.types.Context) -> None:
        """What is adjusted; as in the panel, nothing that now has no effect."""
        layouts.all_of(layouts.split(self.layout), self.properties, self.idle())

    def idle(self) -> frozenset[str]:
        """Names of settings that change nothing as the others are."""
        return frozenset()

    def put(
        self,
        context: bpy.types.Context,
        job: retopology.Job,
        found: Any,
        whole: Transaction | None,
    ) -> list[Message]:
        group = getattr(context.scene, self.panel)
        changed = [name for name in self.adjusted if getattr(group, name) != getattr(self, name)]
        with ExitStack() as back:
            for name in changed:
                back.callback(setattr, group, name, getattr(group, name))
                setattr(group, name, getattr(self, name))
            told = super().put(context, job, found, whole)
            back.pop_all()
        return told

    def _take(self, context: bpy.types.Context) -> None:
        group = getattr(context.scene, self.panel)
        for name in self.adjusted:
            # Values of the last run, which Blender offers again, count as not given.
            if not self.properties.is_property_set(name):
                setattr(self, name, getattr(group, name))


class AdjustableGuidance(Adjustable):
    """A mixin of steps of the guidance that read the settings of these `names`."""

    panel = "umbilics_guidance"
    names: ClassVar[tuple[str, ...]]

    def settings(self, context: bpy.types.Context) -> core.GuidanceSettings:
        """Those of the scene with what the operator was given.

        Raises
        ------
        core.InvalidSettingsError
            A value is out of bounds.
        """
        return plans.to_guidance_settings(context.scene.umbilics_guidance, self, self.names)


def with_settings(operator: type[AdjustableGuidance], names: tuple[str, ...]) -> None:
    """Give an operator the settings of these names."""
    own = annotations_of(core.GuidanceSettings, names)
    operator.names, operator.adjusted = names, tuple(own)
    operator.__annotations__ = own | operator.__annotations__
