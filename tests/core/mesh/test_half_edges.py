"""Half-edges: links between them, the same in one part and in many, which threads look at; names of
their edges."""

import numpy as np
import pytest
from surfaces import icosphere

from core.mesh import half_edges
from core.mesh.half_edges import (
    all_edges,
    edge_keys,
    ends_of,
    has_pinched_vertex,
    inner_edges,
    link,
)

POINTS, TRIANGLES = icosphere(2)
OPEN = TRIANGLES[5:]


@pytest.fixture(params=[7, half_edges.PART], ids=["many parts", "one part"])
def parts(request, monkeypatch):
    monkeypatch.setattr(half_edges, "PART", request.param)


def test_long_fans_that_are_open_are_one_each(monkeypatch):
    monkeypatch.setattr(half_edges, "LONG", 2)
    assert not has_pinched_vertex(OPEN, link(OPEN.astype(np.int32), len(POINTS)))


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


@pytest.mark.parametrize("long", [1, 5, half_edges.LONG])
@pytest.mark.parametrize("vertex", [0, 100, len(POINTS) - 1])
def test_a_vertex_of_two_fans_is_found_in_whichever_part_it_is(parts, monkeypatch, vertex, long):
    """Two spheres that touch in one vertex, whether its fans are walked or counted."""
    monkeypatch.setattr(half_edges, "LONG", long)
    assert not has_pinched_vertex(TRIANGLES, link(TRIANGLES, len(POINTS)))
    other = TRIANGLES + len(POINTS)
    other[other == len(POINTS) + vertex] = vertex
    both = np.concatenate([TRIANGLES, other]).astype(np.int32)
    assert has_pinched_vertex(both, link(both, 2 * len(POINTS)))


# Two triangles that share the edge from 2 to 1, seen from either side.
PAIR = np.array([[0, 1, 2], [2, 1, 3]], np.int32)


def test_half_edges_go_from_corner_to_corner() -> None:
    tail, head = ends_of(PAIR)
    assert tail.tolist() == [0, 1, 2, 2, 1, 3]
    assert head.tolist() == [1, 2, 0, 1, 3, 2]
    some = np.array([5, 0, 2])
    assert [end.tolist() for end in ends_of(PAIR, some)] == [[3, 0, 2], [2, 1, 0]]


def test_every_edge_is_named_once() -> None:
    twin = link(PAIR, 4).twin
    assert inner_edges(twin).tolist() == [1]
    assert all_edges(twin).tolist() == [0, 1, 2, 4, 5]


@pytest.mark.parametrize("kind", [np.int32, np.int64])
def test_the_key_of_an_edge_is_the_same_from_both_ends(kind: type) -> None:
    """Also where int32 could not hold it: three billion."""
    one, other = np.array([3, 60_000], kind), np.array([7, 50_000], kind)
    keys = edge_keys(one, other, 60_001)
    assert keys.dtype == np.int64
    assert keys.tolist() == [3 * 60_001 + 7, 50_000 * 60_001 + 60_000]
    assert edge_keys(other, one, 60_001).tolist() == keys.tolist()
