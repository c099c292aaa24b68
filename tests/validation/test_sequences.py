"""Designs that are built without props, against their closed forms."""

import numpy as np
import pytest

from drystone import Model, find_contacts, plan
from drystone.models import corbelled_bridge, leaning_column, winding_column


def least_friction_of_bridge() -> float:
    """Half the key's weight W leans on each arm; the arm must not slide on the one below.

    The reaction at an end of the key is inclined by up to ``batter + phi`` to the horizontal, so
    the thrust is at least ``W / 2 / tan(batter + phi)``, and ``mu (W / 2 + weight of the top
    corbel)`` holds it. Solved for mu = tan(phi) by bisection.
    """
    batter, height, gap, reach, tail = np.deg2rad(12.0), 0.4, 1.0, 0.45, 1.2
    rise = np.tan(batter) * height
    half_key = 0.5 * (gap + rise)
    corbel = 3.0 * reach + tail - 0.5 * rise
    low, high = 0.0, 1.0
    while high - low > 1e-9:
        mu = 0.5 * (low + high)
        thrust = half_key / np.tan(batter + np.arctan(mu))
        low, high = (mu, high) if thrust > mu * (half_key + corbel) else (low, mu)
    return high


@pytest.mark.parametrize(
    ("family", "least"),
    [
        (leaning_column, np.tan(np.deg2rad(8.0))),
        (winding_column, 2.0 * np.pi * 0.25 / 4.0),
        (corbelled_bridge, least_friction_of_bridge()),
    ],
)
def test_it_is_built_block_by_block_above_its_least_friction_and_not_below(family, least):
    assembly = family()
    contacts = find_contacts(assembly).contacts
    enough = plan(Model(assembly, contacts.with_friction(1.03 * least)))
    assert enough.counts["free"] == len(assembly.free)
    assert enough.verdict == "stable"
    assert plan(Model(assembly, contacts.with_friction(0.97 * least))).steps == ()
