"""A detection that was put away can be filtered again, as if it had just been made."""

import numpy as np
import pytest
from surfaces.sampling import icosphere

import core


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
