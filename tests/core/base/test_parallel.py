"""Blocks of work in threads."""

import threading

import pytest

from core.base.parallel import at_once, beside, run
from core.base.progress import Progress


def test_every_block_is_done_and_the_first_error_is_raised():
    done = []
    run(done.append, range(100), Progress())
    assert sorted(done) == list(range(100))

    def fails(first):
        raise ValueError(first)

    with pytest.raises(ValueError, match="3"):
        run(fails, [3], Progress())


def test_a_thread_that_cannot_start_is_a_lack_of_memory(monkeypatch):
    def start(thread):
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(threading.Thread, "start", start)
    with pytest.raises(MemoryError, match="thread"):
        run(print, [1, 2], Progress())


def test_one_block_is_done_where_it_is_asked_for():
    """Without a thread, and told when it is done."""
    told, where = [], []

    def report(fraction, _):
        told.append(fraction)

    run(lambda _: where.append(threading.current_thread()), [7], Progress(report))
    assert where == [threading.current_thread()] and told == [1.0]


def test_works_at_once_give_what_each_does_and_ask_for_no_more_threads():
    def one():
        where = []
        run(lambda _: where.append(threading.current_thread()), range(9), Progress())
        assert set(where) == {threading.current_thread()}
        return "one"

    def fails():
        raise ValueError("two")

    assert at_once(one, one) == ["one", "one"]
    with pytest.raises(ValueError, match="two"):
        at_once(one, fails)
    # Afterwards all is as before.
    where = []
    run(lambda _: where.append(threading.current_thread()), range(9), Progress())
    assert threading.current_thread() not in where


def test_works_beside_others_are_waited_for_where_asked_and_at_the_end():
    go, done = threading.Event(), []

    def one():
        go.wait(10.0)
        where = []
        run(lambda _: where.append(threading.current_thread()), range(9), Progress())
        assert set(where) == {threading.current_thread()}
        done.append("one")
        return "one"

    def fails():
        raise ValueError("two")

    with beside() as begin:
        first, second = begin(one), begin(fails)
        assert not done
        go.set()
        assert first() == "one"
        with pytest.raises(ValueError, match="two"):
            second()
    go.clear()
    with pytest.raises(ValueError, match="here"), beside() as begin:
        begin(one)
        go.set()
        raise ValueError("here")
    assert done == ["one", "one"]


def test_a_thread_beside_that_cannot_start_is_a_lack_of_memory(monkeypatch):
    def start(thread):
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(threading.Thread, "start", start)
    with pytest.raises(MemoryError, match="thread"), beside() as begin:
        begin(print)
