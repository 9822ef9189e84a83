"""Work shared out between threads."""

import pytest

from core import parallel


@pytest.mark.parametrize("threads", [1, 2, 8])
@pytest.mark.parametrize("count", [0, 1, 99, 100, 250, 1601, 12345])
def test_parts_are_equal_and_as_many_for_every_thread(count, threads, monkeypatch):
    monkeypatch.setattr(parallel, "threads", lambda: threads)
    firsts = parallel.even_parts(count, 50, 400)
    sizes = [min(first + firsts.step, count) - first for first in firsts]
    assert sum(sizes) == count
    assert max(sizes, default=0) <= 400
    assert len(sizes) <= 1 or min(sizes[:-1]) >= 50
    if count >= 50 * threads:
        assert len(sizes) % threads == 0
