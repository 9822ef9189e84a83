"""Figure 6, the hand: S, I and C on charts of several kinds."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

import core
from core.umbilics.compare import within_edges

from . import pictures, unfoldings
from .model import TRIVIAL, Model, clusters, comparison
from .page import Page

BASELINES = """The rows below C are what the paper starts from (its section 2.1), which look at
vertices
alone: k1-k2 and H2-K are least there among their neighbours (H and K by Meyer et al. 2003), ratio:
the curvatures are of one sign and alike to 5 %. They tell no index."""

_SHRUNKEN = (0.97, 0.70, 0.55, 1.0)
_LOST = (0.85, 0.30, 0.25, 1.0)


def write(page: Page, model: Model) -> None:
    arrays = model.arrays
    seam, wrist = _seam_around_wrist(model)
    page.text(
        f"""{len(arrays.triangles):,} triangles, closed. For method C a seam of {len(seam)}
        edges around the wrist cuts it into the hand, a disk of
        {np.count_nonzero(~wrist):,} triangles, and the cap of the wrist. S needs no cut."""
    )
    along = replace(TRIVIAL, charts="seams")
    results = core.compare(arrays.vertices, arrays.triangles, along, seams=seam)
    by_shape, by_index, by_tensor = (result.detection for result in results[:3])
    heading, rows = comparison(results)
    alone = core.compare(arrays.vertices, arrays.triangles, TRIVIAL)[2]
    (row,) = comparison((alone,))[1]
    page.table(heading, [*rows[:3], ["C, automatic seams", *row[1:]], *rows[3:]])
    page.text(BASELINES)
    clusters(page, model, by_index, "hand")
    shrunken = _Shrunken.of(model, by_shape, by_tensor)
    shrunken.describe(page, by_tensor)
    false = unfoldings.write(page, model, by_shape, seam, shrunken.low < 0.1)
    _figure(page, model, by_shape, by_index, by_tensor, shrunken.low)
    page.differences.append(shrunken.difference(false))
    page.differences.append(
        f"""Charts of their own for each finger are not needed: with automatic seams the unfolding
        of the hand shrinks lengths to {_least(alone.detection):.2g} at the worst (1 % of its area
        to less than {_least(alone.detection, 1.0):.2g}), along the wrist alone to
        {_least(by_tensor):.0e}; C then misses {alone.missed} umbilics of S and has
        {alone.unmatched} elsewhere, with the wrist alone {results[2].missed} and
        {results[2].unmatched}."""
    )


@dataclass(frozen=True)
class _Shrunken:
    """How far an unfolding shrinks lengths in the triangles, `low` (m,), and at the k umbilics of
    S, `there` (k,), and which of these C finds, `hit` (k,) bool."""

    low: np.ndarray
    there: np.ndarray
    hit: np.ndarray

    @classmethod
    def of(cls, model: Model, by_shape: core.Detection, by_tensor: core.Detection) -> _Shrunken:
        vertices, triangles = model.arrays.vertices, model.arrays.triangles
        own, other = by_shape.umbilics, by_tensor.umbilics
        low = np.nanmin(by_tensor.conformal_scale[triangles], axis=1)
        hit = within_edges(vertices, triangles, own.triangle, own.position, other.position)
        return cls(low, low[own.triangle], hit)

    def describe(self, page: Page, by_tensor: core.Detection) -> None:
        """The distortion in words, and a table of what C misses by it."""
        page.text(f"The unfolding, in the words of the extension: “{_distortion(by_tensor)}”")
        rows = []
        for least, most in pairwise((0.0, 0.01, 0.03, 0.1, 0.3, np.inf)):
            mask = (self.there >= least) & (self.there < most)
            triangles = np.count_nonzero((self.low >= least) & (self.low < most))
            label = f"{least:g} to {most:g}" if np.isfinite(most) else f"above {least:g}"
            missed = np.count_nonzero(mask & ~self.hit)
            rows.append([label, f"{triangles:,}", mask.sum(), missed])
        page.text(
            f"""By how much the unfolding shrinks lengths (to {_least(by_tensor):.0e} at the
            worst), and where C misses umbilics of S:"""
        )
        page.table(["conformal scale", "triangles", "umbilics of S", "of them missed by C"], rows)

    def difference(self, false: dict[str, int]) -> str:
        """What is to be said of the fingers; `false` counts false points there by solver."""
        small = self.there < 0.1
        missed, wide = (np.count_nonzero(part & ~self.hit) for part in (small, ~small))
        if missed > 0.3 * small.sum():
            return f"""C on the hand misses {missed} of the {small.sum()} umbilics of S on the
            fingers, as in the paper."""
        return f"""C on the hand: of the {small.sum()} umbilics of S on the fingers, where the
        unfolding shrinks lengths to less than a tenth, C misses {missed}, of the
        {np.count_nonzero(~small)} others {wide}, if the map is solved in double precision; scale
        as such does no harm. The same map in single precision gives
        {false["single precision"]} false points on the fingers, by an iterative solver
        {false["iterative"]}: the paper's failure near the fingertips is one of the solver."""


def _figure(
    page: Page,
    model: Model,
    by_shape: core.Detection,
    by_index: core.Detection,
    by_tensor: core.Detection,
    low: np.ndarray,
) -> None:
    arrays = model.arrays
    opened = model.detect(replace(TRIVIAL, opening=2))
    path = page.figure(
        "hand",
        """The hand: (a) I, (b) C with the wrist cut off, (c) S, (d) S with the opening (n = 2).
        In (b) the unfolding shrinks lengths below 0.1 in the light red and below 0.03 in the
        dark red triangles. In (d) the opened elliptic part is green and dropped points are
        grey.""",
    )
    tints = [(np.flatnonzero((low >= 0.03) & (low < 0.1)), _SHRUNKEN),
             (np.flatnonzero(low < 0.03), _LOST)]  # fmt: skip
    elliptic = pictures.elliptic_rows(arrays.vertices, arrays.triangles, opened, 2)
    shown = replace(by_index, umbilics=pictures.by_index(by_index.umbilics))
    pictures.write(
        path,
        [
            model.panel(shown, "(a) I"),
            model.panel(by_tensor, "(b) C", tints=tints),
            model.panel(by_shape, "(c) S"),
            model.panel(
                opened,
                "(d) S, opening",
                tints=[(elliptic, pictures.ELLIPTIC)],
                dropped=model.dropped(opened),
            ),
        ],
        2,
    )


def _least(found: core.Detection, percent: float = 0.0) -> float:
    """The least conformal scale, or that of which so many percent of the vertices have less."""
    scale = found.conformal_scale
    return float(np.nanpercentile(scale, percent))


def _distortion(found: core.Detection) -> str:
    return next((text for text in found.warnings if text.startswith("Method C")), "nothing")


def _seam_around_wrist(model: Model) -> tuple[np.ndarray, np.ndarray]:
    """Edges (s, 2) around the wrist, and the triangles (m,) below them: those whose middle lies
    in the lowest twelfth of the hand's height."""
    vertices, triangles = model.arrays.vertices, model.arrays.triangles
    height = vertices[:, 1]
    level = height.min() + np.ptp(height) / 12
    below = height[triangles].mean(axis=1) < level
    start, end = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    base = len(vertices)
    forward = set((start * base + end)[np.repeat(below, 3)].tolist())
    edges = [
        (key // base, key % base)
        for key in forward
        if (key % base) * base + key // base not in forward
    ]
    return np.array(edges), below


