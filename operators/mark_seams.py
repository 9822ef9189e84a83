"""Operator: lines to seams, sharp edges or creases of the active mesh."""

import bpy
import numpy as np
from bpy.props import EnumProperty

from .jobs import retopology, works
from .jobs.modal import GuidanceOperator
from .scene import selection
from .scene.retopology import marked_edges

_WORK = {
    "SEPARATRICES": works.separatrices,
    "LINES": works.lines,
    "RIDGES": works.ridges,
}
_MARK = {"SEAM": "seam", "SHARP": "edge_sharp", "CREASE": "crease"}


class UMBILICS_OT_mark_seams(GuidanceOperator, bpy.types.Operator):
    bl_idname = "umbilics.mark_seams"
    bl_label = "Mark Edges"
    bl_description = (
        "Mark the edges nearest to the lines as seams, sharp edges or creases, which remeshers and "
        "subdivision follow; marks of your own stay"
    )

    lines: EnumProperty(
        name="Lines",
        items=[
            ("SEPARATRICES", "Separatrices", "The lines that run into umbilics"),
            ("LINES", "Lines of Curvature", "The evenly spaced lines"),
            ("RIDGES", "Ridges", "Ridges and ravines"),
        ],
    )
    mark: EnumProperty(
        name="Mark As",
        items=[
            ("SEAM", "Seam", "Mark seams"),
            ("SHARP", "Sharp", "Mark sharp edges"),
            ("CREASE", "Crease", "Give edges a full crease"),
        ],
    )

    def job(self, context: bpy.types.Context) -> retopology.Job:
        work = works.edges_along(_WORK[self.lines])
        return retopology.gather(context, selection.shown(context), work, with_edges=True)

    def done(self, context: bpy.types.Context, job: retopology.Job, found: np.ndarray) -> str:
        with retopology.written(context, job) as (obj, transaction):
            count = marked_edges.mark(obj, found, _MARK[self.mark], transaction)
        return f"{count} edge{'' if count == 1 else 's'} marked."


register, unregister = bpy.utils.register_classes_factory((UMBILICS_OT_mark_seams,))
