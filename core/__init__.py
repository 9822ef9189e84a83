"""Umbilical points of triangle meshes: NumPy and SciPy only, no Blender."""

from .comparison import MethodResult, compare, comparison_table
from .detection import KINDS, CurvatureField, Detection, Region, Umbilics
from .errors import (
    CancelledError,
    ChartError,
    InvalidMeshError,
    InvalidSettingsError,
    UmbilicsError,
)
from .filtering import filtered, kept_rows
from .keeping import pack, unpack
from .pipeline import USUAL_OPENING, detect
from .progress import Progress
from .settings import AUTO, Choice, Option, Settings, defaults, options
from .surface_types import SURFACE_TYPES

__all__ = [
    "AUTO",
    "KINDS",
    "SURFACE_TYPES",
    "USUAL_OPENING",
    "CancelledError",
    "ChartError",
    "Choice",
    "CurvatureField",
    "Detection",
    "InvalidMeshError",
    "InvalidSettingsError",
    "MethodResult",
    "Option",
    "Progress",
    "Region",
    "Settings",
    "Umbilics",
    "UmbilicsError",
    "compare",
    "comparison_table",
    "defaults",
    "detect",
    "filtered",
    "kept_rows",
    "options",
    "pack",
    "unpack",
]
