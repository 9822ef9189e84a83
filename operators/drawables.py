"""What the overlay draws, as arrays: extracted here without a GPU, drawn elsewhere.

Every vertex is a place in the object's space with two directions, U and V, and how far to go
along them: some of it in lengths of the world, some in pixels of the screen. So one extraction
serves every view and zoom, and a moved object needs no new one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import bpy
import numpy as np

from .. import core
from ..core import point_layers
from . import guidance_results, live, mesh_data, record, results
from .glyphs import OUTLINES
from .preferences import Appearance

# A direction counts fully where the gap is this part of its median, and nothing at a fifth of it.
_CLEAR_GAP = 0.3
# Strokes drawn or left out together; smaller blocks of a layer fit a close view better.
_BLOCK = 2048
# Half the length of a stroke, in distances between strokes.
_STROKE = 0.42
# Rays and rims in sizes of a glyph; the ring around the chosen one.
_RAY, _RIM, _RING = 3.4, 1.28, 2.1
_CIRCLE = 32
# With more umbilics than these their glyphs would hide each other and hold up a drag of the
# slider: they are drawn as small diamonds, without rays and discs.
_CROWD = 1500
_DIAMOND = 0.5
# Opacity of what a filter leaves out.
_FAINT = 0.6
_DARK = (0.008, 0.008, 0.01)
# Pixels over which edges fade out: nothing else smooths them.
_SOFT = 0.5


@dataclass(frozen=True)
class Shape:
    """Triangles whose vertices the shader moves into place.

    Attributes
    ----------
    centre, u, v:
        (p, 3) float32 in the object's space.
    reach:
        (p, 4) float32: along U and V in world lengths, then along U and V in pixels.
    colour:
        (p, 4) float32 linear sRGB and opacity.
    triangles:
        (t, 3) int32.
    on_top:
        Seen through the surface.
    """

    centre: np.ndarray
    u: np.ndarray
    v: np.ndarray
    reach: np.ndarray
    colour: np.ndarray
    triangles: np.ndarray
    on_top: bool = False


@dataclass(frozen=True)
class Strokes:
    """Directions at the vertices, in layers from few to all.

    Attributes
    ----------
    places, d1, d2:
        (n, 3) float32 in the object's space, in the order of the layers.
    weight:
        (n,) float32 from 0, where a direction means nothing, to 1.
    blocks:
        Rows (first, end, layer) of points that lie near each other.
    sphere:
        (blocks, 4) float32 centre and radius of each.
    cell:
        Distance between the points of the first layer; it halves from layer to layer.
    """

    places: np.ndarray
    d1: np.ndarray
    d2: np.ndarray
    weight: np.ndarray
    blocks: np.ndarray
    sphere: np.ndarray
    cell: float


def read_field(obj: bpy.types.Object) -> tuple[np.ndarray, ...] | None:
    """Places, d1, d2 (n, 3) and gap (n,) at the vertices; None where there is nothing to draw."""
    if obj.mode != "OBJECT":
        return None
    names = ("umbilics_d1", "umbilics_d2", "umbilics_gap")
    found = [mesh_data.read_result(obj.data, name) for name in names]
    if any(values is None for values in found):
        return None
    return mesh_data.positions(obj.data), *found


def read_cross(obj: bpy.types.Object) -> tuple[np.ndarray, ...] | None:
    """As `read_field`, of the smoothed cross field; the gap is 1, since it means the same
    everywhere."""
    if obj.mode != "OBJECT":
        return None
    name = "umbilics_cross"
    d1 = mesh_data.read_result(obj.data, name, guidance_results.ATTRIBUTES)
    if d1 is None:
        return None
    # The arms are at right angles in the world, not in the space of a stretched object.
    matrix = np.array(obj.matrix_world)[:3, :3]
    back = np.linalg.inv(matrix)
    normal = mesh_data.unit(mesh_data.vertex_normals(obj.data) @ back)
    across = np.cross(normal, mesh_data.unit(d1 @ matrix.T))
    d2 = mesh_data.unit(across @ back.T).astype(np.float32)
    return mesh_data.positions(obj.data), d1, d2, np.ones(len(d1), np.float32)


def strokes(places: np.ndarray, d1: np.ndarray, d2: np.ndarray, gap: np.ndarray) -> Strokes:
    """Arrange what was read; touches arrays only, so that any thread may do it."""
    known = np.flatnonzero(d1.any(axis=1))
    layered = point_layers.layers(places[known])
    order = known[np.concatenate(layered.rows)]
    typical = float(np.median(gap[known])) if len(known) else 0.0
    ratio = gap[order] / (_CLEAR_GAP * typical) if typical > 0.0 else np.ones(len(order))
    weight = np.clip((ratio - 0.2) / 0.8, 0.0, 1.0)
    blocks, first = [], 0
    for layer, rows in enumerate(layered.rows):
        for start in range(0, len(rows), _BLOCK):
            end = min(start + _BLOCK, len(rows))
            blocks.append((first + start, first + end, layer))
        first += len(rows)
    places = places[order].astype(np.float32)
    spheres = np.zeros((len(blocks), 4), np.float32)
    for row, (start, end, _) in enumerate(blocks):
        low, high = places[start:end].min(axis=0), places[start:end].max(axis=0)
        spheres[row, :3] = 0.5 * (low + high)
        spheres[row, 3] = 0.5 * np.linalg.norm(high - low)
    return Strokes(
        places,
        d1[order],
        d2[order],
        (weight * weight * (3.0 - 2.0 * weight)).astype(np.float32),
        np.array(blocks, dtype=np.int64).reshape(-1, 3),
        spheres,
        layered.cell,
    )


def stroke_shape(
    found: Strokes, block: int, second: bool, width: float, colour: tuple[float, ...]
) -> Shape:
    """The strokes of one block, one unit long; the shader is told how long that is."""
    first, end, _ = found.blocks[block]
    rows = slice(int(first), int(end))
    along, across = found.d1[rows], found.d2[rows]
    if second:
        along, across = across, along
    half = 0.5 * width + _SOFT
    corners = np.array([(x, 0, 0, y) for y in (-half, 0, half) for x in (-_STROKE, _STROKE)])
    colours = np.tile(np.array(colour, np.float32), (end - first, 1))
    colours[:, 3] *= found.weight[rows]
    return _repeated(
        found.places[rows], along, across, corners, colours, _strips(3, 2), (0, 0, 1, 1, 0, 0)
    )


def umbilics(context: bpy.types.Context, obj: bpy.types.Object, faint: bool) -> list[Shape]:
    """Discs, rays and glyphs of the object's umbilics, in the order they are drawn.

    `faint`: the results are stale, and look it. What is in `crowds` is not among them.
    """
    kept = record.of(obj)
    if kept is None:
        return []
    display, look = context.scene.umbilics_display, Appearance(context)
    opacity = _opacity(faint)
    shapes = _left_out(obj, context.scene, look, opacity) if display.dropped else []
    rows = live.shown_rows(obj, context.scene)
    if not len(rows):
        return shapes
    back = np.linalg.inv(kept.matrix)
    if len(rows) <= _CROWD:
        chosen = kept.detection.candidates.select(rows)
        centre, u, v = _places(chosen, back)
        if display.discs:
            shapes.append(_discs(centre, u, v, chosen.uncertainty, look, opacity))
        if display.rays:
            shapes.append(_rays(chosen, centre, back, look, opacity))
        drawn = ~np.isin(rows, shown_by_empties(obj))
        for kind in core.KINDS if display.glyphs else ():
            of_kind = drawn & (chosen.kind == kind)
            if of_kind.any():
                place = centre[of_kind], u[of_kind], v[of_kind]
                shapes += _glyphs(kind, *place, look, opacity)
    active = rows[rows == obj.umbilics.active_row]
    if len(active):
        shapes.append(_ring(*_places(kept.detection.candidates.select(active), back), look))
    return shapes


def crowds(
    context: bpy.types.Context, obj: bpy.types.Object, faint: bool
) -> list[tuple[np.ndarray, float]]:
    """Rows (k,) of the candidates to be drawn by `diamonds`, since they are too many for glyphs,
    with their opacity; in the order they are drawn."""
    display = context.scene.umbilics_display
    found, opacity = [], _opacity(faint)
    if display.dropped:
        found.append((live.left_out_rows(obj, context.scene), _FAINT * opacity))
    if display.glyphs:
        found.append((live.shown_rows(obj, context.scene), opacity))
    return [
        (np.setdiff1d(rows, shown_by_empties(obj), assume_unique=True), opacity)
        for rows, opacity in found
        if len(rows) > _CROWD
    ]


def diamonds(kept: record.Record, look: Appearance) -> Shape:
    """A diamond at each candidate, in the colour of its kind.

    They are made once: `diamonds_of` chooses among them, which keeps up with a slider.
    """
    size = _DIAMOND * look.glyph_size
    corners = np.array([(0, 0, size, 0), (0, 0, 0, size), (0, 0, 0, -size), (0, 0, -size, 0)])
    colours = np.array([(*look.colours[kind][:3], 1.0) for kind in core.KINDS], np.float32)
    places = _places(kept.detection.candidates, np.linalg.inv(kept.matrix))
    return _repeated(*places, corners, colours[kept.kind_codes], _strips(2, 2))


def diamonds_of(rows: np.ndarray) -> np.ndarray:
    """(2 k, 3) int32 triangles of `diamonds` that belong to the candidates `rows` (k,)."""
    first = 4 * rows.astype(np.int32)
    return (first[:, None, None] + _strips(2, 2).astype(np.int32)).reshape(-1, 3)


def shown_by_empties(obj: bpy.types.Object) -> np.ndarray:
    """(k,) rows of candidates whose glyph a visible empty shows already."""
    empties = [empty for empty in results.empties_of(obj) if empty.empty_display_type == "IMAGE"]
    rows = [empty.get("umbilics_row", -1) for empty in empties if empty.visible_get()]
    return np.array(sorted(rows), dtype=int)


def _opacity(faint: bool) -> float:
    return 0.35 if faint else 1.0


def _places(
    chosen: core.Umbilics, back: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(k, 3) places and two directions on the surface; `back` (4, 4) leads from the world."""
    frames = results.frames_of(chosen)
    u, v = (frames[:, :3, axis] @ back[:3, :3].T for axis in (0, 1))
    return chosen.position @ back[:3, :3].T + back[:3, 3], u, v


def _left_out(
    obj: bpy.types.Object, scene: bpy.types.Scene, look: Appearance, opacity: float
) -> list[Shape]:
    """Hollow, faint glyphs of what the opening leaves out."""
    kept, rows = record.of(obj), live.left_out_rows(obj, scene)
    if len(rows) > _CROWD:
        return []
    candidates = kept.detection.candidates.select(rows)
    back = np.linalg.inv(kept.matrix)
    shapes = []
    for kind in core.KINDS:
        of_kind = candidates.kind == kind
        if of_kind.any():
            places = _places(candidates.select(of_kind), back)
            shapes.append(_hollow(kind, *places, look, _FAINT * opacity))
    return shapes


def _hollow(
    kind: str,
    centre: np.ndarray,
    u: np.ndarray,
    v: np.ndarray,
    look: Appearance,
    opacity: float,
) -> Shape:
    """Only the line around a glyph."""
    outline = OUTLINES[kind]
    count = len(outline)
    size = 0.75 * look.glyph_size
    # As wide as a stroke, however large glyphs are.
    half = (0.5 * look.stroke_width + _SOFT) / (0.62 * size)
    corners = np.zeros((3 * count, 4), np.float32)
    corners[:, 2:] = size * np.vstack([outline * grown for grown in (1.0 - half, 1.0, 1.0 + half)])
    opacities = np.repeat((0.0, 1.0, 0.0), count)
    colours = np.tile(np.array([*look.colours[kind][:3], opacity], np.float32), (len(centre), 1))
    return _repeated(centre, u, v, corners, colours, _bands(3, count), opacities)


def _glyphs(
    kind: str,
    centre: np.ndarray,
    u: np.ndarray,
    v: np.ndarray,
    look: Appearance,
    opacity: float,
) -> list[Shape]:
    """A dark rim, then the glyph in its colour: it stands out from any background."""
    shapes = []
    outline = OUTLINES[kind]
    reach = np.linalg.norm(outline, axis=1, keepdims=True)
    size = 0.75 * look.glyph_size
    # A middle, the outline, and the outline once more where its edge has faded out.
    opacities = np.repeat((1.0, 1.0, 0.0), (1, *(len(outline),) * 2))
    triangles = np.vstack([_fan(len(outline)), 1 + _bands(2, len(outline))])
    for grown, colour in (
        (outline * (1.0 + (_RIM - 1.0) / np.maximum(reach, 0.3)), _DARK),
        (outline, look.colours[kind][:3]),
    ):
        faded = grown * (1.0 + 2.0 * _SOFT / (size * np.linalg.norm(grown, axis=1)))[:, None]
        corners = np.zeros((2 * len(outline) + 1, 4), np.float32)
        corners[1:, 2:] = size * np.vstack([grown, faded])
        colours = np.tile(np.array([*colour, opacity], np.float32), (len(centre), 1))
        shapes.append(_repeated(centre, u, v, corners, colours, triangles, opacities))
    return shapes


def _rays(
    chosen: core.Umbilics, centre: np.ndarray, back: np.ndarray, look: Appearance, opacity: float
) -> Shape:
    """From the umbilic outwards, thinning out."""
    known = np.isfinite(chosen.separatrix).all(axis=2)
    which, ray = np.nonzero(known)
    # The line runs into the point along the separatrix: it is seen on the side it comes from.
    along = chosen.separatrix[which, ray]
    across = np.cross(chosen.normal[which], along)
    u, v = along @ back[:3, :3].T, across @ back[:3, :3].T
    length, half = _RAY * look.glyph_size, 0.75 * look.stroke_width + _SOFT
    corners = np.array([(0, 0, x, y) for y in (-half, 0, half) for x in (0, length)])
    corners[[1, 5], 3] = -_SOFT, _SOFT
    colours = np.zeros((len(which), 4), np.float32)
    for kind in core.KINDS:
        of_kind = chosen.kind[which] == kind
        colours[of_kind] = (*look.colours[kind][:3], opacity)
    return _repeated(
        centre[which], u, v, corners, colours, _strips(3, 2), (0.0, 0.0, 1.0, 0.4, 0.0, 0.0)
    )


def _discs(
    centre: np.ndarray,
    u: np.ndarray,
    v: np.ndarray,
    radius: np.ndarray,
    look: Appearance,
    opacity: float,
) -> Shape:
    """Translucent discs as wide as the standard error of the place."""
    angle = np.linspace(0.0, 2.0 * np.pi, _CIRCLE, endpoint=False)
    corners = np.zeros((_CIRCLE + 1, 4), np.float32)
    corners[1:, :2] = np.column_stack([np.cos(angle), np.sin(angle)])
    colours = np.tile(np.array([1.0, 1.0, 1.0, 0.35 * opacity], np.float32), (len(centre), 1))
    shape = _repeated(centre, u, v, corners, colours, _fan(_CIRCLE))
    shape.reach[:, :2] *= np.repeat(np.nan_to_num(radius), _CIRCLE + 1)[:, None]
    return shape


def _ring(centre: np.ndarray, u: np.ndarray, v: np.ndarray, look: Appearance) -> Shape:
    """A white ring around the umbilic that is active in the list, wherever it hides."""
    angle = np.linspace(0.0, 2.0 * np.pi, _CIRCLE, endpoint=False)
    around = np.column_stack([np.cos(angle), np.sin(angle)])
    radii = _RING * look.glyph_size + np.array((-1.0 - _SOFT, -0.5, 0.5, 1.0 + _SOFT))
    corners = np.zeros((4 * _CIRCLE, 4), np.float32)
    corners[:, 2:] = (radii[:, None, None] * around).reshape(-1, 2)
    colours = np.ones((len(centre), 4), np.float32)
    opacities = np.repeat((0.0, 1.0, 1.0, 0.0), _CIRCLE)
    ring = _repeated(centre, u, v, corners, colours, _bands(4, _CIRCLE), opacities)
    return replace(ring, on_top=True)


def _repeated(
    centre: np.ndarray,
    u: np.ndarray,
    v: np.ndarray,
    corners: np.ndarray,
    colours: np.ndarray,
    triangles: np.ndarray,
    opacities: Sequence[float] | np.ndarray = 1.0,
) -> Shape:
    """The same corners (c, 4) and triangles (t, 3) at each of k places.

    `opacities` (c,) multiply that of the colours (k, 4).
    """
    count, size = len(centre), len(corners)
    first = (np.arange(count) * size)[:, None, None]
    each = [np.repeat(values, size, axis=0).astype(np.float32) for values in (centre, u, v)]
    each_colour = np.repeat(colours, size, axis=0).astype(np.float32)
    each_colour[:, 3] *= np.tile(np.broadcast_to(opacities, size), count)
    return Shape(
        *each,
        np.tile(corners, (count, 1)).astype(np.float32),
        each_colour,
        (triangles[None] + first).reshape(-1, 3).astype(np.int32),
    )


def _strips(rows: int, columns: int) -> np.ndarray:
    """(t, 3) triangles between rows of as many corners each."""
    number = np.arange(rows * columns).reshape(rows, columns)
    return _between(number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:])


def _bands(rings: int, corners: int) -> np.ndarray:
    """(t, 3) triangles between closed rings of as many corners each."""
    number = np.arange(rings * corners).reshape(rings, corners)
    after = np.roll(number, -1, axis=1)
    return _between(number[:-1], after[:-1], number[1:], after[1:])


def _between(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> np.ndarray:
    first = np.column_stack([values.ravel() for values in (a, b, c)])
    second = np.column_stack([values.ravel() for values in (b, d, c)])
    return np.vstack([first, second])


def _fan(corners: int) -> np.ndarray:
    """(t, 3) triangles around corner 0 to those from 1 on."""
    here = np.arange(corners)
    return 1 + np.column_stack([np.full(corners, -1), here, np.roll(here, -1)])
