"""Umbilical points of triangle meshes: NumPy and SciPy only, no Blender."""

from .comparison import MethodResult, compare, comparison_table
from .cross_field import CrossField
from .detection import KINDS, CurvatureField, Detection, Region, Umbilics
from .edge_paths import edge_paths
from .errors import (
    CancelledError,
    ChartError,
    FormatError,
    GuidanceError,
    InvalidMeshError,
    InvalidSettingsError,
    UmbilicsError,
)
from .filtering import TRUSTED, Selection, filtered, kept_rows, select
from .guidance import Guidance, Guide
from .formats.whole import whole_file
from .guidance_files import FILE_KINDS, Exported, guidance_paths, write_guidance
from .guidance_settings import GuidanceSettings
from .keeping import pack, unpack
from .lines import FAMILIES, Lines
from .persistence import noise_multiple
from .pipeline import USUAL_OPENING, detect
from .poles import Poles
from .progress import Progress
from .settings import AUTO, Choice, Option, Settings, defaults, options
from .surface_types import SURFACE_TYPES
from .symmetry import MirrorPlane

__all__ = [
    "AUTO",
    "FAMILIES",
    "FILE_KINDS",
    "KINDS",
    "SURFACE_TYPES",
    "TRUSTED",
    "USUAL_OPENING",
    "CancelledError",
    "ChartError",
    "Choice",
    "CrossField",
    "CurvatureField",
    "Detection",
    "Exported",
    "FormatError",
    "Guidance",
    "GuidanceError",
    "GuidanceSettings",
    "Guide",
    "InvalidMeshError",
    "InvalidSettingsError",
    "Lines",
    "MethodResult",
    "MirrorPlane",
    "Option",
    "Poles",
    "Progress",
    "Region",
    "Selection",
    "Settings",
    "Umbilics",
    "UmbilicsError",
    "compare",
    "comparison_table",
    "defaults",
    "detect",
    "edge_paths",
    "filtered",
    "guidance_paths",
    "kept_rows",
    "noise_multiple",
    "options",
    "pack",
    "select",
    "unpack",
    "whole_file",
    "write_guidance",
]
