"""What a single block needs, from its own equilibrium among held neighbours."""

import numpy as np
import pytest

from drystone.assembly import Assembly
from drystone.model import Model
from drystone.models import arch, tower
from drystone.programs import RBEOptions, solve_rbe
from drystone.results import Verdict
from drystone.sequence import StagedModel
from drystone.sequence.stage_tree import LocalBalance
from drystone.sequence.stages import members


def local(assembly: Assembly, friction: float) -> LocalBalance:
    return LocalBalance(StagedModel(Model.of(assembly, friction=friction)))


@pytest.mark.parametrize("friction", [0.0, 0.2, 0.5, 1.0])
def test_a_block_holds_where_rigid_block_equilibrium_among_held_neighbours_exists(friction):
    found = local(arch(0.3, 9), friction)
    model, fixed = found.model.model, np.flatnonzero(found.model.assembly.fixed).tolist()
    rng = np.random.default_rng(1)
    answers = []
    for _ in range(6):
        placed = [b for b in found.model.assembly.free.tolist() if rng.random() < 0.7]
        for block in found.model.assembly.free.tolist():
            others = sorted({*fixed, *placed} - {block})
            alone = model.with_supports(others).subset(sorted([*others, block]))
            balanced = solve_rbe(alone, options=RBEOptions.feasibility()).verdict
            holds = found.holds(block, sum(1 << b for b in placed if b != block))
            answers.append((holds, balanced is not Verdict.UNSTABLE))
    assert all(ours is whole for ours, whole in answers)
    assert {ours for ours, _ in answers} >= ({True, False} if friction else {False})


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
