"""Whether springs are too soft: one answer, however the way is divided, and whatever rounding."""

import numpy as np
import pytest

from drystone.base.arrays import Floats
from drystone.mechanics.bodies import build_bodies
from drystone.mechanics.corners import Carrier
from drystone.mechanics.soft_springs import FADING, SOFT_AT_MANY, SoftSprings
from drystone.model import Model
from drystone.models import tower


def too_soft(ways: Floats, shares: Floats) -> bool:
    """The answer for increments that end at ``ways``, by the way to where it is asked."""
    bodies = build_bodies(Model.of(tower(3)), Carrier.MOVING, overlap=1e-6, tangential=0.2)
    springs = SoftSprings(bodies, many=True, most=1.0)
    gap = np.zeros(len(bodies.block_a))
    for way, share in zip(ways * SOFT_AT_MANY, shares, strict=True):
        springs.pass_by(way, gap, share)
        if springs.told(way, gap):
            return True
    return False


def fading(ways: Floats, ratio: float) -> Floats:
    """Shares that fall with the way; the mean over the last quarter is ``ratio`` by the second."""
    middle = ways - 0.5 * np.diff(ways, prepend=0.0)
    slope = (1.0 - ratio) / 0.5
    share: Floats = 0.01 * (1.0 - slope * (middle - 0.375))
    return share


@pytest.mark.parametrize("number", [8, 12, 40, 200, 1000])
@pytest.mark.parametrize("ratio", [FADING - 0.01, FADING + 0.01])
def test_the_number_of_increments_does_not_matter(number: int, ratio: float) -> None:
    ways = np.append(np.linspace(1.0 / number, 1.0, number), 1.0001)
    assert too_soft(ways, fading(ways, ratio)) == (ratio < FADING)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("ratio", [FADING - 0.01, FADING + 0.01])
def test_the_share_of_single_increments_does_not_decide(seed: int, ratio: float) -> None:
    # a share of one increment of the Armadillo vault changes by a tenth with rounding
    random = np.random.default_rng(seed)
    ways = np.append(np.linspace(0.005, 1.0, 200), 1.0001)
    ways[:199] += random.uniform(-0.002, 0.002, 199)
    shares = fading(ways, ratio)
    assert too_soft(ways, shares * random.uniform(0.95, 1.05, 201)) == (ratio < FADING)
    for at in (0.5, 1.0):
        one = shares.copy()
        one[np.searchsorted(ways, at)] *= 1.5
        assert too_soft(ways, one) == (ratio < FADING)


def test_blocks_that_turn_back_are_not_counted_twice() -> None:
    ways = np.append(np.linspace(0.01, 1.0, 100), 1.0001)
    shares = fading(ways, FADING - 0.01)
    back = np.insert(ways, 40, (0.3, 0.35))
    large = np.insert(shares, 40, (1.0, 1.0))
    assert too_soft(back, large)


def test_a_single_increment_over_the_whole_way_is_no_sign_of_rest() -> None:
    assert not too_soft(np.array([1.5]), np.array([0.5]))


@pytest.mark.parametrize("grows", [False, True])
def test_forces_that_grow_while_contacts_carry_less_are_no_sign_of_rest(grows: bool) -> None:
    """As in domes that fall: thrust goes from one block to another.

    Two domes of 160 blocks, tilted by 42 and 43.3 degrees, were undecided for it.
    """
    bodies = build_bodies(Model.of(tower(3)), Carrier.MOVING, overlap=1e-6, tangential=0.2)
    springs = SoftSprings(bodies, many=True, most=1.0)
    ways = np.append(np.linspace(0.01, 1.0, 100), 1.0001)
    shares = np.interp(ways, [0.0, 0.6, 1.0], [0.05, 0.03, 0.04 if grows else 0.025])
    told = False
    for way, share in zip(ways * SOFT_AT_MANY, shares, strict=True):
        overlaps = 50.0 * way / SOFT_AT_MANY
        gap = np.full(len(bodies.block_a), -overlaps * bodies.overlap)
        springs.pass_by(way, gap, share)
        told = told or springs.told(way, gap)
    assert told != grows
