"""Models taken apart: every joint opens, supports stay, what is locked goes straight away."""

from __future__ import annotations

import numpy as np
import pytest

from drystone import Assembly, find_contacts
from drystone.models import arch, box, dome, tower, vault, wall
from drystone.view.exploded import exploded


def taken_apart(assembly: Assembly) -> tuple[np.ndarray, np.ndarray]:
    """The translations, and how fast each joint opens by the way of its blocks."""
    contacts = find_contacts(assembly).contacts
    bounds = assembly.bounds
    foot = 0.5 * (bounds[:, 0].min(axis=0) + bounds[:, 1].max(axis=0))
    foot[2] = bounds[:, 0, 2].min()
    way = exploded(assembly, contacts, foot)
    relative = way[contacts.block_b] - way[contacts.block_a]
    return way, (relative * contacts.frame[:, 0]).sum(axis=1)


@pytest.mark.parametrize("assembly", [arch(0.2, 8), dome(), vault(), wall(4, 4), tower(5)])
def test_joints_open_and_supports_stay(assembly):
    way, opening = taken_apart(assembly)
    assert not way[assembly.fixed].any()
    assert way[~assembly.fixed].any(axis=1).all()
    assert opening.min() > -1e-3 * assembly.size.max()


def test_a_block_in_a_channel_leaves_along_it_and_a_locked_one_straight_away():
    floor = box((3.0, 3.0, 1.0), (-1.5, -1.5, -1.0), "floor")
    sides = [box((1.0, 3.0, 1.0), (x, -1.5, 0.0), f"side{x}") for x in (-1.5, 0.5)]
    lid = box((3.0, 3.0, 1.0), (-1.5, -1.5, 1.0), "lid")
    inner = box((1.0, 1.0, 1.0), (-0.5, -0.4, 0.0), "inner")
    held = Assembly((floor, *sides, lid, inner), np.array([True, True, True, True, False]))
    way, _ = taken_apart(held)
    assert np.allclose(way[4, [0, 2]], 0.0, atol=1e-9)
    assert way[4, 1] > 0.0
    ends = [
        box((1.0, 1.1, 1.0), (-0.5, -1.5, 0.0), "a"),
        box((1.0, 0.9, 1.0), (-0.5, 0.6, 0.0), "b"),
    ]
    locked = Assembly((floor, *sides, lid, *ends, inner), np.array([True] * 6 + [False]))
    way, _ = taken_apart(locked)
    assert np.linalg.norm(way[6]) > 0.0
