"""A hundred random piles: no contradiction, no shrug."""

import numpy as np
import pytest

from drystone import Assembly, LoadCase, Model, Verdict, check, find_contacts, solve_rbe
from drystone.checks import check_forces, mechanism_defects
from drystone.models import box
from drystone.programs import RBEOptions
from drystone.settlement import UNDECIDED

BATCHES, PER_BATCH = 3, 25


def random_pile(rng):
    """One to three columns of boxes of random size on a fixed slab, some touching sideways."""
    blocks = [box((4.0, 1.5, 0.3), (-0.5, -0.25, -0.3), name="ground")]
    x = 0.0
    for column in range(rng.integers(1, 4)):
        width = rng.uniform(0.3, 1.0)
        z = 0.0
        for level in range(rng.integers(1, 5)):
            height = rng.uniform(0.2, 0.8)
            depth = rng.uniform(0.4, 1.0)
            y = rng.uniform(0.0, 1.0 - depth)
            blocks.append(
                box(
                    (width, depth, height),
                    (x, y, z),
                    name=f"{column}-{level}",
                    density=rng.uniform(500.0, 3000.0),
                )
            )
            z += height
        x += width + (0.0 if rng.random() < 0.5 else 0.2)
    return Assembly(tuple(blocks), np.arange(len(blocks)) == 0)


@pytest.mark.parametrize("batch", range(BATCHES))
def test_random_piles_get_verdicts_that_their_proofs_support(batch):
    rng = np.random.default_rng(100 + batch)
    seen = dict.fromkeys(Verdict, 0)
    for _ in range(PER_BATCH):
        model = random_pile(rng)
        contacts = find_contacts(model, friction=float(rng.uniform(0.1, 1.0))).contacts
        angle = rng.uniform(0.0, 2.0 * np.pi)
        axis = (np.cos(angle), np.sin(angle), 0.0)
        load = LoadCase.tilt(model, axis, float(rng.uniform(0.0, 40.0)))
        result = check(Model(model, contacts, load))
        balance = solve_rbe(Model(model, contacts, load), options=RBEOptions(tension=False))
        seen[result.verdict] += 1
        if result.verdict is Verdict.UNDECIDED:
            # two ways were followed to their ends, and differ
            assert result.settlement.outcome in UNDECIDED
        if balance.verdict is Verdict.UNSTABLE:
            assert result.verdict is Verdict.UNSTABLE
        if result.verdict is Verdict.STABLE:
            assert balance.verdict is Verdict.EQUILIBRIUM_EXISTS
            again = check_forces(Model(model, contacts, load), result.force, result.displacement)
            if result.samples.standing:
                assert again.largest <= 1e-8
            else:
                assert result.residuals is not None
                assert result.residuals.largest <= 1e-8
        if result.verdict is Verdict.UNSTABLE:
            closing = contacts.with_friction(0.0)
            violation, power = mechanism_defects(Model(model, closing, load), result.mechanism)
            assert violation <= 1e-5
            assert power > 0.0
    assert seen[Verdict.UNDECIDED] <= 1
    assert seen[Verdict.STABLE] >= 5
    assert seen[Verdict.UNSTABLE] >= 5
