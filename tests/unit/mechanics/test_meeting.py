"""Faces that are apart at the beginning act where blocks meet; edges that lie in each other."""

import numpy as np
import pytest

from drystone import Assembly, LoadCase, Model, Verdict, check, settle
from drystone.mechanics.corners import joint_ends
from drystone.mechanics.meeting import faces_apart
from drystone.models import box, wedge
from drystone.models.simple import prism
from drystone.settlement import Carrier, End, Outcome, push

WEIGHT = 2400.0 * 9.81


def before_a_stop(gap: float, width: float = 1.0, height: float = 1.0, tilt: float = 0.0) -> Model:
    """A block 1 m wide on a base that is tilted, and a fixed wall at a distance."""
    blocks = (
        box((4.0, 2.0, 1.0), (-1.0, -0.5, -1.0), "base"),
        box((0.5, 2.0, height + 1.0), (width + gap, -0.5, 0.0), "stop"),
        box((width, 1.0, height), (0.0, 0.0, 0.0), "block"),
    )
    assembly = Assembly(blocks).with_fixed(["base", "stop"])
    load = LoadCase.tilt(assembly, (0.0, 1.0, 0.0), tilt)
    return Model.of(assembly, friction=0.0, load=load)


def test_a_block_slides_until_it_meets_a_stop_which_then_carries_it() -> None:
    found = settle(before_a_stop(0.015, tilt=20.0))
    assert found.outcome is Outcome.RESTS
    assert "'stop' meets 'block'" in found.message
    path = found.path
    assert path.displacement[2] == pytest.approx([0.015, 0.0, 0.0, 0.0, 0.0, 0.0], abs=1e-5)
    last = path.met[-1]
    assert path.model.contacts[last].blocks == (1, 2)
    pressed = path.force[path.model.contacts.interface == last]
    assert pressed.sum(axis=0)[0] == pytest.approx(WEIGHT * np.sin(np.deg2rad(20.0)), rel=1e-6)
    assert path.residuals is not None
    assert path.residuals.largest < 1e-8
    # what it does not reach does not hold it
    assert settle(before_a_stop(0.4, tilt=20.0)).outcome is Outcome.FALLS
    assert settle(before_a_stop(0.4, tilt=20.0)).path.met == ()


def test_a_block_tips_against_a_wall() -> None:
    # its upper edge comes to the wall where 2 h sin(turn) = gap
    model = before_a_stop(0.02, height=2.0, tilt=30.0).with_friction(0.8)
    found = settle(model)
    assert found.outcome is Outcome.RESTS
    assert found.displacement[2, 4] == pytest.approx(np.arcsin(0.02 / 2.0), rel=1e-3)
    met = found.path.force[found.path.model.contacts.interface == found.path.met[-1]]
    assert np.count_nonzero(met[:, 0]) == 2


def before_a_leaning_wall(
    gap: float, reach: float = 1.5, begin: float = -1.0, friction: float = 0.9
) -> Model:
    """A block that tips to a wall whose face leans away from it by 45 degrees."""
    foot = 0.5 + gap - 2.0
    wall = [(foot, 4.0), (foot + 4.0, 0.0), (foot + 6.0, 0.0), (foot + 2.0, 4.0)]
    blocks = (
        box((8.0, 2.0, 1.0), (begin, -0.5, -1.0), "base"),
        prism(wall, (-0.5, reach), "wall"),
        box((0.5, 1.0, 2.0), name="block"),
    )
    assembly = Assembly(blocks).with_fixed(["base", "wall"])
    load = LoadCase.tilt(assembly, (0.0, 1.0, 0.0), 20.0)
    return Model.of(assembly, friction=friction, load=load)


def test_an_edge_meets_a_face_that_it_is_not_parallel_to() -> None:
    found = settle(before_a_leaning_wall(0.02))
    assert found.outcome is Outcome.RESTS
    assert "'wall' meets 'block'" in found.message
    path = found.path
    assert len(path.met) == 2
    # the upper edge is 2 m above the one about which the block tips
    assert path.displacement[2, 4] == pytest.approx(0.02 / 2.0, rel=0.01)
    assert path.residuals is not None
    assert path.residuals.largest < 1e-8


def test_what_comes_to_a_face_too_far_away_falls() -> None:
    assert settle(before_a_leaning_wall(2.0)).outcome is Outcome.FALLS


@pytest.mark.parametrize(
    ("reach", "friction", "outcome", "resting"),
    [(0.2, 0.2, Outcome.FALLS, 1), (1.5, 0.1, Outcome.DISPLACED, 2)],
)
def test_what_falls_with_the_vertices_that_meet_a_face_is_followed_with_both_carriers_only_then(
    reach: float, friction: float, outcome: Outcome, resting: int
) -> None:
    ended = []
    model = before_a_leaning_wall(0.02, reach, 0.0, friction)  # two faces end flush
    found = settle(model, progress=lambda stage, done, total: ended.append((stage, done == total)))
    assert found.outcome is outcome
    assert [one.carrier for one in found.paths] == [Carrier.MOVING, Carrier.RESTING]
    assert all(one.met for one in found.paths)
    runs = [stage for stage, end in ended if end and "following" in stage]
    assert sum("resting" in stage for stage in runs) == resting
    assert sum("moving" in stage for stage in runs) == 2


def test_joints_of_the_model_and_faces_that_touch_are_not_met() -> None:
    model = before_a_stop(0.015)
    assert len(faces_apart(model, 0.3).contacts) == 1
    # found with a gap of half a percent of a block's size, the joint is halfway between the faces
    close = before_a_stop(0.004)
    assert close.active.sum() == 2
    assert len(faces_apart(close, 0.3).contacts) == 0
    # left out on purpose
    none = model.with_contacts(model.contacts.select(np.zeros(len(model.contacts), dtype=bool)))
    assert [one.blocks for one in faces_apart(none, 0.3).contacts] == [(1, 2)]


def test_check_tells_who_met_and_gives_forces_that_balance() -> None:
    groove = wedge("b", longer=0.2)
    plate = box((0.4, 0.1, 1.2), (-0.2, -0.11, 1.5), "plate")
    assembly = Assembly((*groove.blocks, plate)).with_fixed([0, 1, 3])
    load = LoadCase.tilt(assembly, (1.0, 0.0, 0.0), 60.0)
    found = check(Model.of(assembly, friction=0.84, load=load))
    assert found.verdict is Verdict.STABLE
    assert "meets 'plate'" in found.message
    assert len(found.model.contacts) == 4
    alone = Model.of(groove, friction=0.84, load=load.wrench[2, :3] / (WEIGHT * 0.1))
    assert check(alone).verdict is Verdict.UNSTABLE


def test_what_is_pushed_against_a_wall_is_held() -> None:
    found = push(before_a_stop(0.1).with_friction(0.3))
    assert found.end is End.HELD
    assert found.message.startswith("nothing gives way at 10")
    free = (found.displacement > 1e-4) & (found.displacement < 0.0999)
    assert found.load[free] == pytest.approx(0.3, rel=1e-4)
    assert found.capacity is None


@pytest.mark.parametrize("carrier", Carrier)
@pytest.mark.parametrize(("ridge", "owner"), [(0.5, 0.0), (-0.5, 1.0)])
def test_in_a_re_entrant_edge_the_convex_one_carries_the_corners(
    carrier: Carrier, ridge: float, owner: float
) -> None:
    joint = [(-1.0, 0.0), (0.0, ridge), (1.0, 0.0)]
    blocks = (
        prism([(-1.0, -2.0), (1.0, -2.0), *joint[::-1]], (0.0, 1.0), "lower"),
        prism([*joint, (1.0, 2.0), (-1.0, 2.0)], (0.0, 1.0), "upper"),
    )
    model = Model.of(Assembly(blocks).with_fixed(["lower"]), friction=0.5)
    contacts = model.contacts
    assert [one.blocks for one in contacts] == [(0, 1), (0, 1)]
    none = np.zeros((contacts.corner_count, 2))
    ends = joint_ends(model.assembly, contacts, carrier, none)
    middle = 0.5 * (contacts.point + contacts.point[ends.after])
    at_ridge = np.abs(middle[:, 0]) < 1e-9
    assert at_ridge.sum() == 2
    assert (ends.share[at_ridge, 0] == owner).all()
    # where both are convex and end flush either may carry them
    outer = np.abs(middle[:, 0]) > 1.0 - 1e-9
    assert (ends.share[outer, 0] == (carrier is not Carrier.RESTING)).all()
