"""Many files over several Blender processes; docs/batch.md shows how it is used."""

from .lock import BusyError
from .plan import Plan, PlanError
from .runner import run, summarize

__all__ = ["BusyError", "Plan", "PlanError", "run", "summarize"]
