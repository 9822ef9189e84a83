"""Umbilical points of triangle meshes: NumPy and SciPy only, no Blender."""

from .base.errors import (
    CancelledError,
    ChartError,
    FormatError,
    GuidanceError,
    InvalidMeshError,
    InvalidSettingsError,
    MatchError,
    RemeshError,
    UmbilicsError,
)
from .base.options import AUTO, Choice, Option, check, setting
from .base.progress import Progress
from .base.settings import Settings, defaults, options
from .curvature.field import CurvatureField
from .curvature.surface_types import SURFACE_TYPES
from .formats.export import Written, export_guidance
from .formats.guidance import FILE_KINDS, QUAD_KINDS, Exported, guidance_paths, write_guidance
from .formats.off import read_off
from .formats.steering import Steering, read_steering
from .formats.usd_layer import up_axis, usd_names
from .formats.usda import UsdMesh, write_usda
from .formats.whole import whole_file
from .matching.align import Alignment, align
from .matching.identify import identify
from .matching.mirror import MirrorPlane
from .matching.rotation import RotationSymmetry, find_rotation
from .matching.shape import Shape
from .retopology.by_hand import Strokes, StrokeSettings, WantedPoles
from .retopology.crosses.cross_field import CrossField
from .retopology.guidance import Guidance
from .retopology.lines.edge_paths import edge_paths
from .retopology.lines.polylines import FAMILIES, Lines
from .retopology.lines.separatrices import Separatrices
from .retopology.planner import Guide
from .retopology.poles import Poles
from .retopology.quads.layout.lines import LINE_KINDS, QuadLayout
from .retopology.quads.remesh import quad_layout, remesh
from .retopology.quads.result import QuadMesh
from .retopology.quads.settings import RemeshSettings
from .retopology.ridges.on_edges import RidgeEdges, ridge_edges
from .retopology.ridges.ridge_lines import RidgeLines
from .retopology.settings import GuidanceSettings
from .retopology.topology_check import TopologyCheck, check_quads, check_topology
from .umbilics.compare import (
    BASELINES,
    METHODS,
    MethodResult,
    compare,
    comparison_rows,
    comparison_table,
)
from .umbilics.detect import USUAL_OPENING, detect
from .umbilics.filters import SMOOTH_MORE, TRUSTED, Selection, filtered, kept_rows, select
from .umbilics.numbering import numbers
from .umbilics.pairing.persistence import noise_multiple
from .umbilics.result import KINDS, Detection, Region, Umbilics
from .umbilics.storage import pack, unpack
from .umbilics.suitability import COARSE, SHARP, Suitability, suitability

__all__ = [
    "AUTO",
    "BASELINES",
    "COARSE",
    "FAMILIES",
    "FILE_KINDS",
    "KINDS",
    "LINE_KINDS",
    "METHODS",
    "QUAD_KINDS",
    "SHARP",
    "SMOOTH_MORE",
    "SURFACE_TYPES",
    "TRUSTED",
    "USUAL_OPENING",
    "Alignment",
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
    "MatchError",
    "MethodResult",
    "MirrorPlane",
    "Option",
    "Poles",
    "Progress",
    "QuadLayout",
    "QuadMesh",
    "Region",
    "RemeshError",
    "RemeshSettings",
    "RidgeEdges",
    "RidgeLines",
    "RotationSymmetry",
    "Selection",
    "Separatrices",
    "Settings",
    "Shape",
    "Steering",
    "StrokeSettings",
    "Strokes",
    "Suitability",
    "TopologyCheck",
    "Umbilics",
    "UmbilicsError",
    "UsdMesh",
    "WantedPoles",
    "Written",
    "align",
    "check",
    "check_quads",
    "check_topology",
    "compare",
    "comparison_rows",
    "comparison_table",
    "defaults",
    "detect",
    "edge_paths",
    "export_guidance",
    "filtered",
    "find_rotation",
    "guidance_paths",
    "identify",
    "kept_rows",
    "noise_multiple",
    "numbers",
    "options",
    "pack",
    "quad_layout",
    "read_off",
    "read_steering",
    "remesh",
    "ridge_edges",
    "select",
    "setting",
    "suitability",
    "unpack",
    "up_axis",
    "usd_names",
    "whole_file",
    "write_guidance",
    "write_usda",
]
