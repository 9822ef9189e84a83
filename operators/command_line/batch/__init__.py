"""Many files over several Blender processes; docs/batch.md shows how it is used."""

from .plan import Plan, PlanError
from .runner import run, summarize

__all__ = ["Plan", "PlanError", "run", "summarize"]
