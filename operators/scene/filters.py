"""Results are filtered again as soon as a filter changes; nothing is computed anew."""

from __future__ import annotations

import bpy
import numpy as np

from ... import core
from ..base import caches, changes
from ..data import pins, record, summary
from ..data.preferences import Appearance
from ..mesh.fingerprint import digest
from . import empties, selection, targets
from .transaction import Transaction, all_or_nothing

AUTOMATIC = -1.0


def with_results(context: bpy.types.Context) -> list[bpy.types.Object]:
    """The active and the selected objects that have results and can be changed."""
    objects = [selection.shown(context), *context.view_layer.objects.selected]
    return [
        obj
        for obj in dict.fromkeys(objects)
        if obj is not None and obj.umbilics.detected and targets.is_local(obj)
    ]


def shown_rows(obj: bpy.types.Object, scene: bpy.types.Scene) -> np.ndarray:
    """(k,) rows of the candidates that are to be seen; none if nothing is kept."""
    kept = record.of(obj)
    if kept is None:
        return np.empty(0, dtype=int)
    return _shown(obj, scene, kept, used_filters(obj))


def left_out_rows(obj: bpy.types.Object, scene: bpy.types.Scene) -> np.ndarray:
    """(k,) rows of the candidates that only the opening keeps from being seen."""
    kept, filters = record.of(obj), used_filters(obj)
    if kept is None or not filters.opening:
        return np.empty(0, dtype=int)
    unopened = core.Settings(persistence=filters.persistence, at_most=filters.at_most)
    everything = _shown(obj, scene, kept, unopened)
    return np.setdiff1d(everything, shown_rows(obj, scene))


def kept_digest(obj: bpy.types.Object) -> str:
    """Of the umbilics that filters, pins and deletions keep; nothing without results."""
    kept = record.of(obj)
    if kept is None:
        return ""
    settings = used_filters(obj)

    def find() -> str:
        rows = core.kept_rows(kept.detection, settings, *pins.rows(obj))
        return digest_of(kept.detection.candidates.select(rows))

    return caches.ROWS.of((*_key(obj, settings), "digest"), find)


def digest_of(umbilics: core.Umbilics) -> str:
    """Differs where umbilics lie elsewhere in their triangles, however these are counted."""
    return digest(umbilics.barycentric, umbilics.index)


def without_empty(context: bpy.types.Context, obj: bpy.types.Object | None) -> int:
    """How many of the object's umbilics are too many for an empty; 0 if none is wanted."""
    if obj is None or not context.scene.umbilics_display.empties:
        return 0
    count = len(obj.umbilics.items) + obj.umbilics.hidden_items
    return max(count - Appearance(context).most_empties, 0)


def apply(context: bpy.types.Context, settings: core.Settings) -> None:
    """Bring summary, list and empties of the active and the selected objects in line with the
    filters of `settings`."""
    with all_or_nothing() as transaction:
        for obj in with_results(context):
            # While a slider is dragged there is no time to read the list item by item.
            transaction.on_failure(summary.put_columns, obj, summary.columns_of(obj))
            transaction.keep_properties(obj, "umbilics", but=("items",))
            write(context, obj, settings, transaction, fresh=False)


def put_rows(context: bpy.types.Context, obj: bpy.types.Object, name: str, text: str) -> None:
    """Put candidates into the object's list `name`, "pinned" or "deleted", and filter anew."""
    with all_or_nothing() as transaction:
        transaction.keep_properties(obj, "umbilics")
        setattr(obj.umbilics, name, text)
        write(context, obj, used_filters(obj), transaction, fresh=False)


def write(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    settings: core.Settings,
    transaction: Transaction,
    fresh: bool,
) -> None:
    """As `apply`, in a transaction that takes back the empties; numbers and list are its owner's.

    `fresh`: the empties that there are belong to an earlier detection and are all replaced.
    """
    kept = record.of(obj)
    if kept is None:
        return
    scene = context.scene
    summary.store(obj, kept, core.select(kept.detection, settings, *pins.rows(obj)))
    automatic = settings.persistence == core.AUTO
    obj.umbilics.used_persistence = AUTOMATIC if automatic else settings.persistence
    obj.umbilics.used_opening = settings.opening > 0
    obj.umbilics.used_at_most = settings.at_most
    rows = _shown(obj, scene, kept, settings)
    summary.list_items(obj, kept, rows)
    most = Appearance(context).most_empties if scene.umbilics_display.empties else 0
    with_empty = kept.most_persistent(rows, most)
    put = empties.replace if fresh else empties.update
    put(context, obj, kept, with_empty, transaction)


def chosen_filters(scene: bpy.types.Scene) -> core.Settings:
    """The scene's filters; what a detection itself was made with counts for nothing here."""
    group = scene.umbilics
    persistence = core.AUTO if group.persistence_auto else float(group.persistence)
    return core.Settings(persistence=persistence, opening=group.opening, at_most=group.at_most)


def used_filters(obj: bpy.types.Object) -> core.Settings:
    """The filters that the object's results went through."""
    kept = obj.umbilics
    persistence = core.AUTO if kept.used_persistence < 0.0 else float(kept.used_persistence)
    return core.Settings(
        persistence=persistence, opening=int(kept.used_opening), at_most=kept.used_at_most
    )


def _shown(
    obj: bpy.types.Object,
    scene: bpy.types.Scene,
    kept: record.Record,
    settings: core.Settings,
) -> np.ndarray:
    kinds = frozenset(scene.umbilics_display.kinds)

    def find() -> np.ndarray:
        rows = core.kept_rows(kept.detection, settings, *pins.rows(obj))
        wanted = np.isin(core.KINDS, list(kinds))
        return rows[wanted[kept.kind_codes[rows]]]

    # Every redraw of a view asks.
    return caches.ROWS.of((*_key(obj, settings), kinds), find)


def _key(obj: bpy.types.Object, settings: core.Settings) -> tuple[object, ...]:
    """All that decides which umbilics of the object pass the filters."""
    mine = obj.umbilics
    chosen = settings.persistence, settings.opening > 0, settings.at_most
    return mine.stamp, chosen, mine.pinned, mine.deleted


def _filter_changed(context: bpy.types.Context) -> None:
    apply(context, chosen_filters(context.scene))
    changes.notify("view", context)


def register() -> None:
    changes.listen("filter", _filter_changed)


def unregister() -> None:
    changes.forget("filter", _filter_changed)
