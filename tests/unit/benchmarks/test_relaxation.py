"""The explicit relaxation that settlement is compared with."""

import numpy as np

from benchmarks.relaxation import Trial, relaxed, trials
from drystone import Model
from drystone.models import tower
from drystone.settlement import Carrier


def test_a_block_rests_below_its_angle_of_friction_and_slides_above() -> None:
    model = Model.of(tower(2), friction=0.5)
    block = Trial("block", model, (1.0, 0.0, 0.0), Carrier.MOVING)
    limit = float(np.rad2deg(np.arctan(0.5)))
    asked = [(block, limit - 1.5), (block, limit + 3.0)]
    assert relaxed(asked, steps=20_000, overlap=1e-3) == ["rests", "falls"]


def test_the_random_models_are_closed_free_on_one_block_and_repeatable() -> None:
    every = trials(6, 1)
    assert [trial.carrier for trial in every[:2]] == [Carrier.MOVING, Carrier.RESTING]
    for trial, again in zip(every, trials(6, 1), strict=True):
        assert len(trial.model.assembly.free) == 1
        assert trial.model.contacts.count >= 2
        np.testing.assert_array_equal(trial.model.assembly.centroid, again.model.assembly.centroid)
