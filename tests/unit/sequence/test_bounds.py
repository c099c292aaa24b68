"""What a single block needs, from its own equilibrium among held neighbours."""

import numpy as np
import pytest

from drystone.assembly import Assembly
from drystone.model import Model
from drystone.models import arch, tower
from drystone.sequence import Structure
from drystone.sequence.local_balance import LocalBalance
from drystone.sequence.stages import members


def local(assembly: Assembly, friction: float) -> LocalBalance:
    return LocalBalance(Structure(Model.of(assembly, friction=friction)))


@pytest.mark.parametrize("friction", [0.0, 0.2, 0.5, 1.0])
def test_rays_about_the_cones_say_nothing_else_than_the_cones_themselves(friction):
    found = local(arch(0.3, 9), friction)
    rng = np.random.default_rng(1)
    answers = []
    for _ in range(6):
        placed = sum(1 << b for b in found.model.assembly.free.tolist() if rng.random() < 0.7)
        for block in found.model.assembly.free.tolist():
            around = found.model.neighbours[block] & placed
            answers.append((found._carried(block, around), found._balanced(block, around)))
    assert all(rays is whole for rays, whole in answers if rays is not None)
    assert {rays for rays, _ in answers} >= ({True, False} if friction else {False})


def test_a_block_of_a_tower_rests_on_the_one_below_and_not_on_the_one_above():
    found = local(tower(4), 0.6)
    below, above = 1 << 1, 1 << 3
    assert found.holds(2, below)
    assert not found.holds(2, above)


def test_helpless_pairs_are_neighbours_and_disjoint():
    found = local(arch(0.3, 9), 0.4)
    pairs = found.helpless_pairs()
    assert pairs
    union = 0
    for pair in pairs:
        a, b = members(pair)
        assert found.model.neighbours[a] >> b & 1
        assert not union & pair
        union |= pair
