"""Ways for charges to cancel: each set out for the nearest others until their sum is zero.

As union-find decoders do with the defects of a surface code (Delfosse & Nickerson 2021,
10.22331/q-2021-12-02-595): every cluster of charges whose sum is not zero takes up the nearest
other one, all at once, until none is left. Charges then move along the tree that joined them,
each over as few edges as balance it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ...base.subsets import places_in
from ...umbilics.pairing.merge_tree import label_roots, lowest_edges, lowest_passes
from .turns import Turns


@dataclass(frozen=True)
class Paths:
    """How charges move.

    Attributes
    ----------
    flow:
        (e,) int64 charge that goes over each edge of the turns from left to right.
    edge, path:
        (p,) the edges of the paths, and which path each belongs to.
    reach:
        (q,) how many edges each path has.
    begin, end, amount:
        (q,) places that each path leads from and to, and how many charges go along it, at least
        one. The outside comes after all other places.
    """

    flow: np.ndarray
    edge: np.ndarray
    path: np.ndarray
    reach: np.ndarray
    begin: np.ndarray
    end: np.ndarray
    amount: np.ndarray


def joined_places(turns: Turns, usable: np.ndarray) -> np.ndarray:
    """(places + 1,) label of the places that charges can reach from each other, and of the
    outside."""
    return _joined(*_ends(turns, usable), turns.places + 1)


def charge_paths(turns: Turns, usable: np.ndarray, charge: np.ndarray) -> Paths:
    """Paths along which charges cancel.

    Parameters
    ----------
    usable:
        (e,) bool, edges that charges may cross.
    charge:
        (places,) int; the sum over places that are joined is zero, or the outside is among them.
    """
    outside = turns.places
    left, right = _ends(turns, usable)
    name = np.flatnonzero(usable)
    cost = turns.cost[name]
    source = np.append(np.flatnonzero(charge), outside)
    amount = np.append(charge[source[:-1]], 0)
    distance, before, owner = csgraph.dijkstra(
        _graph(left, right, cost, outside + 1),
        indices=source,
        min_only=True,
        return_predecessors=True,
    )
    edge = _arriving(left, right, cost, name, distance, before)
    row = places_in(source, outside + 1)
    # -9999 stands for none.
    cell = np.where(owner >= 0, row[np.maximum(owner, 0)], -1)
    first, second = cell[left], cell[right]
    bridge = np.flatnonzero((first != second) & (first >= 0) & (second >= 0))
    way = distance[left[bridge]] + cost[bridge] + distance[right[bridge]]
    bridge = bridge[np.argsort(way, kind="stable")]
    bridge = bridge[_clustered(first[bridge], second[bridge], amount)]
    moved = _balanced(first[bridge], second[bridge], amount)
    going = np.flatnonzero(moved)
    bridge, moved = bridge[going], moved[going]
    flow = np.zeros(len(turns.tail), np.int64)
    np.add.at(flow, name[bridge], moved)
    walked = [np.arange(len(bridge))]
    passed = [name[bridge]]
    hops = np.ones(len(bridge), np.int64)
    for at, towards in ((left[bridge], -1), (right[bridge], 1)):
        path = np.arange(len(bridge))
        while True:
            going = before[at] >= 0
            path, at = path[going], at[going]
            if not len(at):
                break
            number = edge[at]
            # On the left the charge comes from the source, on the right it goes to it.
            forward = np.where(turns.left[number] == np.where(at == outside, -1, at), 1, -1)
            np.add.at(flow, number, towards * forward * moved[path])
            hops += np.bincount(path, minlength=len(hops))
            walked.append(path)
            passed.append(number)
            at = before[at]
    path = np.concatenate(walked)
    ends = source[first[bridge]], source[second[bridge]]
    begin, end = (np.where(moved > 0, *way) for way in (ends, ends[::-1]))
    return Paths(flow, np.concatenate(passed), path, hops, begin, end, np.abs(moved))


def staying(paths: Paths, charge: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """(places,) the charges that stay where they are if some paths are not to be: of each such path
    one charge, and another one that it would cancel with, where the paths before and after lead.

    Parameters
    ----------
    charge:
        (places,) int that the paths are for.
    wanted:
        (w,) rows of the paths not to be.
    """
    outside = len(charge)
    amount = paths.amount.copy()
    rest = np.append(charge, 0)
    into, out = (
        {place: np.flatnonzero(ends == place) for place in np.unique(ends).tolist()}
        for ends in (paths.end, paths.begin)
    )
    for path in wanted.tolist():
        if not amount[path]:
            continue
        amount[path] -= 1
        for sign, ends, others in ((1, paths.begin, into), (-1, paths.end, out)):
            place = int(ends[path])
            while place != outside and sign * rest[place] <= 0:
                rows = others[place]
                on = rows[amount[rows] > 0][0]
                amount[on] -= 1
                place = int(ends[on])
            rest[place] -= sign
    return charge - rest[:outside]


def _ends(turns: Turns, usable: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places on both sides of the usable edges, the outside after all others."""
    left, right = turns.left[usable], turns.right[usable]
    left = np.where(left < 0, turns.places, left).astype(np.int64)
    return left, np.where(right < 0, turns.places, right).astype(np.int64)


def _graph(
    left: np.ndarray, right: np.ndarray, cost: np.ndarray, count: int
) -> sparse.csr_array:
    """The symmetric graph of places; two may have several edges."""
    # From a place to itself leads no way.
    apart = left != right
    left, right, cost = left[apart], right[apart], cost[apart]
    ends = np.concatenate([left, right]), np.concatenate([right, left])
    graph = sparse.coo_array((np.concatenate([cost, cost]), ends), shape=(count, count))
    # Ways are looked for along each of several edges: they must not be summed.
    graph.has_canonical_format = True
    return graph.tocsr()


def _arriving(
    left: np.ndarray,
    right: np.ndarray,
    cost: np.ndarray,
    name: np.ndarray,
    distance: np.ndarray,
    before: np.ndarray,
) -> np.ndarray:
    """(places + 1,) the edge over which the shortest way comes to each place, -1 where none."""
    edge = np.full(len(distance), -1)
    for here, there in ((left, right), (right, left)):
        last = np.flatnonzero(before[there] == here)
        # Of several edges from there the one that is as short as the way.
        last = last[distance[here[last]] + cost[last] == distance[there[last]]]
        edge[there[last]] = name[last]
    return edge


def _joined(first: np.ndarray, second: np.ndarray, count: int) -> np.ndarray:
    """(count,) label of the nodes that edges join."""
    graph = sparse.coo_array((np.ones(len(first)), (first, second)), shape=(count, count))
    return csgraph.connected_components(graph, directed=False)[1]


def _clustered(first: np.ndarray, second: np.ndarray, amount: np.ndarray) -> np.ndarray:
    """Rows of edges (b,) between charges, cheapest first, that join them to clusters whose sum is
    zero. The last of these is the outside, which balances any."""
    count = len(amount)
    cluster, clusters = np.arange(count, dtype=np.int32), count
    edge = np.arange(len(first))
    used = np.zeros(len(first), bool)
    while True:
        net = np.bincount(cluster, weights=amount, minlength=clusters)
        net[cluster[-1]] = 0
        active = net != 0
        hook, over = lowest_passes(first, second, lowest_edges(first, second, clusters), active)
        if not len(over):
            return np.flatnonzero(used)
        used[edge[over]] = True
        label, clusters = label_roots(hook)
        cluster = label[cluster]
        first, second = label[first], label[second]
        kept = np.flatnonzero(first != second)
        first, second, edge = first[kept], second[kept], edge[kept]


def _balanced(first: np.ndarray, second: np.ndarray, amount: np.ndarray) -> np.ndarray:
    """(t,) int charge that goes over each edge of a forest from first to second, so that nothing
    is left at any node but the last."""
    count = len(amount)
    label = _joined(first, second, count)
    # One more node, joined to one of each tree, the last node rather than others.
    _, root = np.unique(label[::-1], return_index=True)
    root = count - 1 - root
    joined = sparse.coo_array(
        (
            np.ones(len(first) + len(root)),
            (np.append(first, np.full(len(root), count)), np.append(second, root)),
        ),
        shape=(count + 1, count + 1),
    )
    _, above = csgraph.breadth_first_order(joined.tocsr(), count, directed=False)
    above[count] = count
    depth, ancestor = np.zeros(count + 1, np.int64), above.astype(np.int64)
    depth[:count] = 1
    while (ancestor != count).any():
        depth = depth + depth[ancestor]
        ancestor = ancestor[ancestor]
    total = np.append(amount, 0).astype(np.int64)
    order = np.argsort(-depth[:count], kind="stable")
    ends = np.searchsorted(-depth[order], -np.arange(1, depth.max(initial=1) + 1), side="right")
    starts = np.searchsorted(-depth[order], -np.arange(1, depth.max(initial=1) + 1), side="left")
    for begin, end in zip(starts[::-1], ends[::-1], strict=True):
        level = order[begin:end]
        np.add.at(total, above[level], total[level])
    down = above[first] == second
    return np.where(down, total[first], -total[second])
