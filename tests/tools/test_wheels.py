"""The SciPy wheels that ship: pinned, one for each platform and Python, and never wrong ones."""

import pytest
import scipy_wheels

LINUX = [wheel.name for wheel in scipy_wheels.read_lock() if wheel.platform == "linux-x64"]


def test_the_lock_has_one_wheel_for_each_platform_and_python():
    lock = scipy_wheels.read_lock()
    assert sorted((w.platform, w.python) for w in lock) == sorted(scipy_wheels.TARGETS)
    for wheel in lock:
        assert scipy_wheels.target_of(wheel.name) == (wheel.platform, wheel.python)
        assert len(bytes.fromhex(wheel.sha256)) == 32


@pytest.mark.parametrize("platform", scipy_wheels.TAGS)
def test_the_lock_has_no_problem(platform):
    names = [wheel.name for wheel in scipy_wheels.read_lock() if wheel.platform == platform]
    assert scipy_wheels.problems(platform, names, names) == []


def test_a_listed_wheel_that_is_missing_is_a_problem():
    (problem,) = scipy_wheels.problems("linux-x64", LINUX, LINUX[:1])
    assert "not there" in problem


def test_an_unlisted_wheel_is_a_problem():
    found = scipy_wheels.problems("linux-x64", LINUX[:1], LINUX)
    assert any("not listed" in problem for problem in found)
    assert any("0 wheels instead of 1 for Python 3.13" in problem for problem in found)


def test_a_wheel_of_another_platform_is_a_problem():
    names = [*LINUX, "scipy-1.17.1-cp313-cp313-win_amd64.whl"]
    (problem,) = scipy_wheels.problems("linux-x64", names, names)
    assert "windows-x64" in problem


def test_two_wheels_for_one_python_are_a_problem():
    names = [*LINUX, "scipy-1.16.0-cp313-cp313-manylinux2014_x86_64.whl"]
    (problem,) = scipy_wheels.problems("linux-x64", names, names)
    assert "2 wheels instead of 1" in problem


def test_numpy_is_never_shipped():
    names = [*LINUX, "numpy-2.3.5-cp312-cp312-manylinux2014_x86_64.whl"]
    assert any("is not SciPy" in p for p in scipy_wheels.problems("linux-x64", names, names))


@pytest.mark.parametrize(
    "name",
    [
        "scipy-1.17.1-cp313-cp313t-win_amd64.whl",
        "scipy-1.17.1-py3-none-any.whl",
        "scipy-1.17.1-cp313-cp313-musllinux_1_2_x86_64.whl",
        "scipy-1.17.1-cp313-cp313-manylinux2014_aarch64.whl",
        "scipy-1.17.1.tar.gz",
    ],
)
def test_a_wheel_that_blender_would_load_wrongly_is_refused(name):
    with pytest.raises(ValueError, match="scipy"):
        scipy_wheels.target_of(name)
