"""The examples in the docstrings of the front door are true."""

import doctest
import inspect

import pytest
from surfaces import ellipsoid

import core

# The functions, and of the classes those that a script begins with.
FRONT_DOOR = (
    *(name for name in core.__all__ if inspect.isfunction(getattr(core, name))),
    "Guide",
)
# These take more than a second.
LONG = {"identify", "find_rotation", "check_quads", "check_topology", "export_guidance", "remesh"}


@pytest.fixture(scope="module")
def once():
    """Most examples are of one ellipsoid, of which detection and quads are always the same."""
    known = {}

    def remembering(work):
        def remembered(*arguments):
            key = work, *(getattr(one, "tobytes", one.__repr__)() for one in arguments)
            if key not in known:
                known[key] = work(*arguments)
            return known[key]

        return remembered

    return remembering


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=pytest.mark.slow if name in LONG else ()) for name in FRONT_DOOR],
)
def test_an_example_is_true(name, tmp_path, monkeypatch, once):
    monkeypatch.chdir(tmp_path)
    mesh = ellipsoid(subdivisions=3)
    (test,) = doctest.DocTestFinder(recurse=False).find(getattr(core, name), name)
    for work in ("detect", "remesh"):
        monkeypatch.setattr(core, work, once(getattr(core, work)))
    assert test.examples
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
