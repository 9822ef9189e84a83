"""The examples in the docstrings of the front door are true."""

import doctest

import pytest
from surfaces import ellipsoid

import core

# What a script begins with.
FRONT_DOOR = (
    "detect", "select", "compare", "Guide", "remesh", "read_off", "read_steering",
    "export_guidance", "unpack", "align", "check_topology",
)  # fmt: skip


def examples_of(name):
    found = getattr(core, name)
    (test,) = (
        each for each in doctest.DocTestFinder(recurse=False).find(found, name) if each.examples
    )
    return test


@pytest.mark.parametrize("name", FRONT_DOOR)
def test_an_example_is_true(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    mesh = ellipsoid(subdivisions=3)
    test = examples_of(name)
    test.globs = {"core": core, "vertices": mesh.vertices, "triangles": mesh.triangles}
    said = []
    doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(test, out=said.append)
    assert not said, "".join(said)


def test_whatever_has_an_example_is_tested():
    public = {name: getattr(core, name) for name in core.__all__}
    with_examples = {
        name for name, found in public.items() if callable(found) and ">>>" in str(found.__doc__)
    }
    assert with_examples == set(FRONT_DOOR)
