"""Links between half-edges: the same in one part and in many, which threads look at."""

import numpy as np
import pytest
from surfaces import icosphere

from core.mesh import half_edges
from core.mesh.half_edges import has_pinched_vertex, link

POINTS, TRIANGLES = icosphere(2)
OPEN = TRIANGLES[5:]


@pytest.fixture(params=[7, half_edges.PART], ids=["many parts", "one part"])
def parts(request, monkeypatch):
    monkeypatch.setattr(half_edges, "PART", request.param)


@pytest.mark.parametrize("triangles", [TRIANGLES, OPEN], ids=["closed", "open"])
def test_a_twin_runs_the_other_way_along_the_same_edge(parts, triangles):
    links = link(triangles.astype(np.int32), len(POINTS))
    tails, heads = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
    paired = np.flatnonzero(links.twin >= 0)
    np.testing.assert_array_equal(links.twin[links.twin[paired]], paired)
    np.testing.assert_array_equal(tails[links.twin[paired]], heads[paired])
    np.testing.assert_array_equal(heads[links.twin[paired]], tails[paired])
    ways = set(zip(tails, heads, strict=True))
    alone = [edge for edge, pair in enumerate(links.twin) if pair < 0]
    assert all((heads[edge], tails[edge]) not in ways for edge in alone)
    assert bool(alone) == (triangles is OPEN)
    assert not has_pinched_vertex(triangles, links)


def test_two_half_edges_that_run_the_same_way_are_not_linked(parts):
    twice = np.concatenate([TRIANGLES, TRIANGLES[-1:, [1, 2, 0]]])
    assert link(twice.astype(np.int32), len(POINTS)) is None


@pytest.mark.parametrize("vertex", [0, 100, len(POINTS) - 1])
def test_a_vertex_of_two_fans_is_found_in_whichever_part_it_is(parts, vertex):
    """Two spheres that touch in one vertex."""
    other = TRIANGLES + len(POINTS)
    other[other == len(POINTS) + vertex] = vertex
    both = np.concatenate([TRIANGLES, other]).astype(np.int32)
    assert has_pinched_vertex(both, link(both, 2 * len(POINTS)))
