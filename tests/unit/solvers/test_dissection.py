"""Cuts of a graph in space."""

from itertools import pairwise

import numpy as np
import pytest

from drystone.solvers import multifrontal
from drystone.solvers.multifrontal import LEAST_SIDE, adjacency, dissect


@pytest.fixture(autouse=True)
def small_parts(monkeypatch):
    """Cut small graphs too."""
    monkeypatch.setattr(multifrontal, "WHOLE", 0)
    monkeypatch.setattr(multifrontal, "PART", 20)


def a_tube(around, along):
    """Nodes on a tube that widens and narrows every 8 rings, and pairs of neighbours."""
    node = np.arange(around * along)
    turn, height = 2.0 * np.pi * (node % around) / around, node // around
    radius = 1.0 + 0.5 * np.sin(np.pi * height / 8.0)
    place = np.stack([radius * np.cos(turn), radius * np.sin(turn), 1.0 * height], axis=1)
    beside = (node // around) * around + (node + 1) % around
    row = np.concatenate([node, node[:-around]])
    column = np.concatenate([beside, node[around:]])
    return place, np.concatenate([row, column]), np.concatenate([column, row])


@pytest.mark.parametrize("shape", [(6, 20), (12, 7), (5, 31)])
def test_a_separator_is_the_smallest_of_all_cuts_near_the_middle(shape):
    """Every cut across every axis, on either side, counted one by one."""
    place, row, column = a_tube(*shape)
    count = len(place)
    top = dissect(place, adjacency(count, row, column), 6)[-1][0]
    fewest = count
    for axis in range(3):
        order = np.argsort(place[:, axis], kind="stable")
        rank = np.argsort(order)
        least = int(LEAST_SIDE * count)
        for cut in range(least, count - least + 1):
            across = (rank[row] < cut) & (rank[column] >= cut)
            fewest = min(fewest, len(set(row[across])), len(set(column[across])))
    assert len(top) == fewest


def test_parts_on_both_sides_of_a_separator_do_not_touch():
    place, row, column = a_tube(7, 40)
    tree = dissect(place, adjacency(len(place), row, column), 6)
    below = [nodes for nodes, _ in tree]
    for number, (nodes, children) in enumerate(tree):
        below[number] = np.concatenate([nodes, *(below[child] for child in children)])
        for one, two in pairwise(children):
            assert not (np.isin(row, below[one]) & np.isin(column, below[two])).any()
    assert sorted(below[-1].tolist()) == list(range(len(place)))


def test_nodes_without_neighbours_are_fronts_of_their_own():
    none = np.zeros(0, dtype=int)
    tree = dissect(np.random.default_rng(0).random((60, 3)), adjacency(60, none, none), 6)
    assert sorted(np.concatenate([nodes for nodes, _ in tree]).tolist()) == list(range(60))
    assert not any(children for _, children in tree)
