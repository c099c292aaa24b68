"""What the benchmarks hold answers against: forces and velocities, in lines of their own."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.any_forces import fault_of_forces, proven_none
from drystone import Contacts, LoadCase, Model, check
from drystone.base.arrays import Floats
from drystone.models import tower
from drystone.results import Result


@pytest.mark.parametrize(("degrees", "none"), [(30.0, False), (32.0, True)])
def test_a_tilt_above_the_angle_of_friction_leaves_no_forces(degrees: float, none: bool) -> None:
    load = LoadCase.tilt(tower(2), (0.0, 1.0, 0.0), degrees)
    assert proven_none(Model.of(tower(2), friction=0.6, load=load)) is none


def test_blocks_without_contacts_have_no_forces() -> None:
    assert proven_none(Model(tower(2), Contacts.empty())) is True


@pytest.fixture(scope="module")
def stands() -> Result:
    return check(tower(2), friction=0.6)


FORCES = {
    "": np.zeros((4, 3)),
    "do not balance": np.diag([10.0, 0.0, 0.0, 0.0])[:, :3],
    "outside of its cone": np.outer([1.0, -1.0, 1.0, -1.0], [0.0, 5e3, 0.0]),
    "pulls": np.outer([1.0, -1.0, 1.0, -1.0], [9e3, 0.0, 0.0]),
}


@pytest.mark.parametrize("words", FORCES)
def test_forces_that_cannot_be_are_told(words: str, stands: Result) -> None:
    def fault(added: Floats) -> str:
        assert stands.force is not None
        return fault_of_forces(replace(stands, force=stands.force + added))

    told = fault(FORCES[words])
    assert words in told
    assert bool(told) == bool(words)
