"""The order of elimination within a part of a graph."""

import numpy as np
import pytest

from drystone.solvers.multifrontal import adjacency, part_fronts


def graph_of(pairs, count):
    """Neighbours of each node, from pairs of nodes."""
    one, two = np.array(pairs).T
    return adjacency(count, np.concatenate([one, two]), np.concatenate([two, one]))


def a_grid(columns, rows):
    """Pairs of neighbours in a grid."""
    node = np.arange(columns * rows).reshape(rows, columns)
    across = zip(node[:, :-1].ravel(), node[:, 1:].ravel(), strict=True)
    along = zip(node[:-1].ravel(), node[1:].ravel(), strict=True)
    return [*across, *along]


def boundaries(tree, neighbours):
    """The nodes outside of each front that are coupled with it when it is eliminated."""
    start, other = neighbours
    reached = []
    for nodes, children in tree:
        met = {int(i) for node in nodes for i in other[start[node] : start[node + 1]]}
        met = met.union(*(reached[child] for child in children)) - set(nodes.tolist())
        done = {int(i) for before in _below(tree, children) for i in tree[before][0]}
        reached.append(met - done)
    return reached


def _below(tree, children):
    return [n for child in children for n in (child, *_below(tree, tree[child][1]))]


def test_a_star_is_eliminated_from_its_points():
    neighbours = graph_of([(0, i) for i in range(1, 8)], 8)
    tree = part_fronts(np.arange(8), neighbours, 6, overhead=0.0)
    assert [len(boundary) for boundary in boundaries(tree, neighbours)][:6] == [1] * 6
    assert 0 in tree[-1][0]


def test_a_chain_adds_no_coupling():
    neighbours = graph_of([(i, i + 1) for i in range(29)], 30)
    tree = part_fronts(np.arange(30), neighbours, 6, overhead=0.0)
    assert max(len(boundary) for boundary in boundaries(tree, neighbours)) == 1


@pytest.mark.parametrize("overhead", [0.0, 1e5, 1e9])
def test_each_node_is_in_one_front_after_the_fronts_that_it_is_coupled_with(overhead):
    neighbours = graph_of(a_grid(9, 7), 63)
    tree = part_fronts(np.arange(63), neighbours, 6, overhead)
    assert sorted(np.concatenate([nodes for nodes, _ in tree]).tolist()) == list(range(63))
    front_of = {int(node): number for number, (nodes, _) in enumerate(tree) for node in nodes}
    parent = {child: number for number, (_, below) in enumerate(tree) for child in below}
    for number, boundary in enumerate(boundaries(tree, neighbours)):
        assert all(front_of[node] > number for node in boundary)
        if boundary:
            assert parent[number] == min(front_of[node] for node in boundary)


def test_a_front_that_costs_much_is_shared():
    neighbours = graph_of(a_grid(9, 7), 63)
    fronts = [len(part_fronts(np.arange(63), neighbours, 6, cost)) for cost in (0.0, 1e5, 1e9)]
    assert fronts[0] > fronts[1] > fronts[2] == 1


def test_neighbours_outside_of_the_part_come_later():
    neighbours = graph_of(a_grid(9, 7), 63)
    part = np.arange(27)  # three rows; the fourth one is outside
    tree = part_fronts(part, neighbours, 6, overhead=1e5)
    assert sorted(np.concatenate([nodes for nodes, _ in tree]).tolist()) == part.tolist()
    children = {child for _, below in tree for child in below}
    tops = [
        boundary
        for number, boundary in enumerate(boundaries(tree, neighbours))
        if number not in children
    ]
    assert set().union(*tops) == set(range(27, 36))


def test_a_grid_takes_less_arithmetic_than_row_by_row():
    def work(tree, neighbours):
        coupled = [len(boundary) for boundary in boundaries(tree, neighbours)]
        return sum(len(nodes) * each**2 for (nodes, _), each in zip(tree, coupled, strict=True))

    neighbours = graph_of(a_grid(15, 15), 225)
    rows = [(np.arange(15 * i, 15 * i + 15), [i - 1] if i else []) for i in range(15)]
    tree = part_fronts(np.arange(225), neighbours, 6, overhead=0.0)
    assert work(tree, neighbours) < 0.4 * work(rows, neighbours)


@pytest.mark.parametrize("points", [60, 400])
def test_the_points_of_a_star_and_nodes_alone_share_fronts(points):
    star = graph_of([(0, i) for i in range(1, points)], points)
    none = np.zeros(0, dtype=int)
    for neighbours in (star, adjacency(points, none, none)):
        tree = part_fronts(np.arange(points), neighbours, 6, overhead=4e5)
        assert sorted(np.concatenate([nodes for nodes, _ in tree]).tolist()) == list(range(points))
        assert len(tree) < points / 8
