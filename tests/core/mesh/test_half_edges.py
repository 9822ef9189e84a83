"""Names of edges: what their ends are, and each once."""

import numpy as np
import pytest

from core.mesh.half_edges import all_edges, edge_keys, ends_of, inner_edges, link

# Two triangles that share the edge from 2 to 1, seen from either side.
TRIANGLES = np.array([[0, 1, 2], [2, 1, 3]], np.int32)


def test_half_edges_go_from_corner_to_corner() -> None:
    tail, head = ends_of(TRIANGLES)
    assert tail.tolist() == [0, 1, 2, 2, 1, 3]
    assert head.tolist() == [1, 2, 0, 1, 3, 2]
    some = np.array([5, 0, 2])
    assert [end.tolist() for end in ends_of(TRIANGLES, some)] == [[3, 0, 2], [2, 1, 0]]


def test_every_edge_is_named_once() -> None:
    twin = link(TRIANGLES, 4).twin
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
