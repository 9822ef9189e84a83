"""Umbilical points of triangle meshes: NumPy and SciPy only, no Blender."""

from .detection import KINDS, CurvatureField, Detection, Region, Umbilics
from .errors import (
    CancelledError,
    ChartError,
    InvalidMeshError,
    InvalidSettingsError,
    UmbilicsError,
)
from .progress import Progress
from .settings import AUTO, Choice, Option, Settings, defaults, options

__all__ = [
    "AUTO",
    "KINDS",
    "CancelledError",
    "ChartError",
    "Choice",
    "CurvatureField",
    "Detection",
    "InvalidMeshError",
    "InvalidSettingsError",
    "Option",
    "Progress",
    "Region",
    "Settings",
    "Umbilics",
    "UmbilicsError",
    "defaults",
    "options",
]
