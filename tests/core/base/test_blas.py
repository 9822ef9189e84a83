"""One thread for the linear algebra, and as many as before afterwards."""

import threading

import numpy as np
import pytest

from core.base import blas


def built_on_openblas() -> bool:
    """What NumPy says of itself, from 1.26 on and before."""
    said = vars(np.__config__)
    now = said.get("CONFIG", {}).get("Build Dependencies", {}).get("blas", {}).get("name", "")
    return "openblas" in now or any(said[name] for name in said if "openblas" in name)


on_openblas = pytest.mark.skipif(
    not blas.libraries(), reason="NumPy and SciPy stand on something else than OpenBLAS here"
)


@pytest.mark.skipif(not built_on_openblas(), reason="NumPy was built on something else")
def test_the_library_is_found_that_numpy_was_built_on():
    """Else all the others would be left out, unseen."""
    found = blas.libraries()
    assert found
    assert all(get() >= 1 for get, _ in found)


def test_a_package_that_is_not_there_calls_no_library():
    assert blas._files("no_such_package.linalg") == []


def counts() -> list[int]:
    return [get() for get, _ in blas.libraries()]


@pytest.fixture
def several():
    """Three threads, as on a machine that has them."""
    before = [(set_, get()) for get, set_ in blas.libraries()]
    for set_, _ in before:
        set_(3)
    yield
    for set_, count in before:
        set_(count)


@on_openblas
def test_one_thread_within_and_as_many_as_before_after(several):
    @blas.one_blas_thread()
    def work():
        """Words."""
        with blas.one_blas_thread():
            assert set(counts()) == {1}
        assert set(counts()) == {1}
        raise ValueError

    for _ in range(2):
        with pytest.raises(ValueError):
            work()
        assert set(counts()) == {3}
    assert work.__doc__ == "Words."


@on_openblas
def test_the_last_to_leave_sets_back(several):
    inside, leave = threading.Event(), threading.Event()

    def work():
        with blas.one_blas_thread():
            inside.set()
            leave.wait(10.0)

    other = threading.Thread(target=work)
    with blas.one_blas_thread():
        other.start()
        assert inside.wait(10.0)
    assert set(counts()) == {1}
    leave.set()
    other.join()
    assert set(counts()) == {3}


@on_openblas
def test_sums_do_not_hang_on_the_number_of_threads(several):
    # Long enough to be divided: with one, two and four threads three different sums come of it.
    one, other = np.random.default_rng(0).normal(size=(2, 100_001))
    values = one + 1j * other
    found = set()
    for count in (1, 2, 4):
        for _, set_ in blas.libraries():
            set_(count)
        with blas.one_blas_thread():
            found.add(np.vdot(values, values).tobytes())
    assert len(found) == 1
