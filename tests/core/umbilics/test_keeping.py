"""A detection that was put away can be filtered again, as if it had just been made."""

import tracemalloc
import zlib
from dataclasses import fields, replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from surfaces.sampling import icosphere

import core
from core.base import rows


@cache
def detection():
    generator = np.random.default_rng(5)
    vertices, triangles = icosphere(3)
    noisy = vertices * (3.0, 2.0, 1.0) + 0.01 * generator.standard_normal(vertices.shape)
    return core.detect(noisy, triangles, core.Settings(scale=2, regions=False))


def test_filtering_what_was_put_away_gives_the_same():
    found = detection()
    kept = core.unpack(core.pack(found))
    levels = np.quantile(found.candidates.persistence, (0.0, 0.3, 0.6))
    for persistence in ("auto", *levels[np.isfinite(levels)]):
        for opening in (0, 2):
            settings = core.Settings(persistence=persistence, opening=opening)
            ours, wanted = core.filtered(kept, settings), core.filtered(found, settings)
            assert np.array_equal(ours.umbilics.position, wanted.umbilics.position)
            assert list(ours.umbilics.kind) == list(wanted.umbilics.kind)
            assert ours.trust_ratio == pytest.approx(wanted.trust_ratio)
            assert ours.index_sum == wanted.index_sum
            assert ours.warnings == wanted.warnings


def test_pinned_rows_stay_and_deleted_rows_go():
    found = detection()
    settings = core.Settings(persistence=1e9)
    rows = core.kept_rows(found, settings)
    dropped = np.setdiff1d(np.arange(len(found.candidates)), rows)[0]
    again = core.kept_rows(found, settings, pinned=[dropped, 10**6], deleted=[rows[0], -1])
    assert dropped in again
    assert rows[0] not in again
    assert len(core.filtered(found, settings, [dropped], [rows[0]]).umbilics) == len(again)


@pytest.mark.parametrize("data", [b"", b"PK\x03\x04 nothing", b"\x93NUMPY"])
def test_foreign_bytes_are_refused(data):
    with pytest.raises(ValueError):
        core.unpack(data)


@cache
def packed():
    found = detection()
    assert len(found.candidates) > 4
    return core.pack(found)


def changed_rows(**columns):
    """What `pack` makes of a detection some of whose columns hold other values."""
    found = detection()
    values = {name: np.array(getattr(found.candidates, name)) for name in columns}
    for name, value in columns.items():
        values[name][(0,) * values[name].ndim] = value
    return core.pack(replace(found, candidates=replace(found.candidates, **values)))


def changed_text(change):
    """What `pack` writes, with something else beside the candidates."""
    columns = rows.columns_of(core.Umbilics)
    text, arrays = rows.decode(columns, packed())
    change(text)
    return rows.encode(columns, arrays, text)


def test_every_number_is_kept():
    found = replace(detection(), crease_angle=40.0, borders_joined=False)
    kept = core.unpack(core.pack(found))
    kinds = ("int", "float", "bool")
    numbers = [item.name for item in fields(core.Detection) if item.type in kinds]
    assert len(numbers) == 9
    for name in numbers:
        assert getattr(kept, name) == pytest.approx(getattr(found, name), nan_ok=True), name


def test_every_field_of_the_umbilics_is_kept():
    found = detection()
    kept = core.unpack(core.pack(found)).candidates
    for item in fields(core.Umbilics):
        ours, wanted = getattr(kept, item.name), getattr(found.candidates, item.name)
        assert ours.dtype.kind == wanted.dtype.kind, item.name
        assert np.array_equal(ours, wanted, equal_nan=wanted.dtype.kind == "f"), item.name


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("partner", 10**6),
        ("partner", -2),
        ("position", np.nan),
        ("position", np.inf),
        ("triangle", -1),
        ("triangle", 2**40),
        ("vertex", -2),
        ("persistence", -1.0),
        ("index", np.nan),
        ("separatrix", np.inf),
    ],
)
def test_impossible_values_are_refused(name, value):
    with pytest.raises(ValueError):
        core.unpack(changed_rows(**{name: value}))


@pytest.mark.parametrize("name", ["persistence", "noise", "uncertainty", "curvature", "normal"])
def test_what_is_unknown_is_no_damage(name):
    kept = core.unpack(changed_rows(**{name: np.nan}))
    assert np.isnan(getattr(kept.candidates, name).ravel()[0])
    # A filter goes on with it.
    core.select(kept, core.Settings(persistence=0.1))


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text["numbers"].update(euler_characteristic="2"),
        lambda text: text["numbers"].update(euler_characteristic=2**40),
        lambda text: text["numbers"].update(euler_characteristic=2.5),
        lambda text: text["numbers"].update(noise=-1.0),
        lambda text: text["numbers"].pop("scale"),
        lambda text: text.update(median_gap=None),
        lambda text: text.update(median_gap=10**400),
        lambda text: text.update(numbers=[]),
        lambda text: text.update(warnings="word"),
        lambda text: text.update(warnings=[1]),
        lambda text: text.update(timings=[]),
        lambda text: text.update(regions=[[1.0, 0.5, "green", 0.0]]),
        lambda text: text.update(regions=[1]),
        lambda text: text.update(regions={"a": 1}),
        lambda text: text.pop("regions"),
    ],
)
def test_impossible_words_beside_the_candidates_are_refused(change):
    with pytest.raises(ValueError):
        core.unpack(changed_text(change))


@pytest.mark.parametrize("text", [[], "text", 3.0, None, [[[]]]])
def test_a_text_of_another_form_is_refused(text):
    columns = rows.columns_of(core.Umbilics)
    _, arrays = rows.decode(columns, packed())
    with pytest.raises(ValueError):
        core.unpack(rows.encode(columns, arrays, text))


def test_nothing_is_unfolded_that_claims_too_much(monkeypatch):
    """2^32 - 1 rows in a few bytes, and a stream that unfolds to a thousand times its size."""
    data = packed()
    huge = bytearray(data)
    huge[20:24] = b"\xff" * 4
    monkeypatch.setattr(rows, "_unfold", lambda *_: pytest.fail("it was unfolded"))
    with pytest.raises(ValueError, match="more than it can hold"):
        core.unpack(bytes(huge))


def test_a_stream_that_goes_on_is_not_followed():
    data = packed()
    header, bomb = data[:24], zlib.compress(bytes(1 << 27))
    tracemalloc.start()
    with pytest.raises(ValueError):
        core.unpack(header + bomb)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 1 << 24


def test_deep_text_is_refused():
    columns = rows.columns_of(core.Umbilics)
    words = b"[" * 10**5
    empty = zlib.compress(words)
    header = rows._HEADER.pack(b"umbilics", rows._layout(columns), len(words), 0)
    with pytest.raises(ValueError):
        core.unpack(header + empty)


def test_another_set_of_columns_is_another_version():
    columns = dict(list(rows.columns_of(core.Umbilics).items())[:-1])
    _, arrays = rows.decode(rows.columns_of(core.Umbilics), packed())
    with pytest.raises(ValueError, match="another version"):
        core.unpack(rows.encode(columns, arrays, {}))


@given(data=st.data())
def test_damaged_bytes_are_refused_or_say_the_same(data):
    """Cut, flipped, doubled, or any bytes at all."""
    whole = _WHOLE
    kind = data.draw(st.sampled_from(["cut", "flip", "more", "any"]))
    if kind == "cut":
        damaged = whole[: data.draw(st.integers(0, len(whole) - 1))]
    elif kind == "flip":
        at = data.draw(st.integers(0, 8 * len(whole) - 1))
        damaged = bytearray(whole)
        damaged[at // 8] ^= 1 << at % 8
    elif kind == "more":
        damaged = whole + data.draw(st.binary(min_size=1))
    else:
        damaged = data.draw(st.binary())
    try:
        found = core.unpack(bytes(damaged))
    except ValueError:
        return
    # A compressed stream has bits that fill up a byte, and other ways to say the same.
    assert kind == "flip" and core.pack(found) == core.pack(core.unpack(whole))


_WHOLE = packed()
