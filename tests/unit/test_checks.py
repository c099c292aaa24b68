"""What a first motion does at the joints, and claims that prove nothing."""

import numpy as np
import pytest

from drystone import Model
from drystone.checks import check_forces, moving_joints
from drystone.models import tower


def motion(**of_top: tuple[float, float, float]) -> np.ndarray:
    out = np.zeros((2, 6))
    out[1, :3] = of_top.get("move", (0.0, 0.0, 0.0))
    out[1, 3:] = of_top.get("turn", (0.0, 0.0, 0.0))
    return out


def test_a_block_that_turns_about_its_edge_has_a_hinge_in_the_middle_of_that_edge() -> None:
    model = Model.of(tower(2))
    # about the edge x = 1, y = any, z = 1 of unit cubes: the centroid is at (0.5, 0.5, 1.5)
    hinge, slide, place = moving_joints(model, motion(turn=(0, 0.1, 0), move=(0.05, 0, 0.05)))
    assert (hinge.tolist(), slide.tolist()) == ([True], [False])
    np.testing.assert_allclose(place, [[1.0, 0.5, 1.0]])


def test_a_block_that_slides_is_no_hinge() -> None:
    model = Model.of(tower(2), friction=0.5)
    for upward in (0.0, 0.05):  # without and with the dilation of associated friction
        hinge, slide, _ = moving_joints(model, motion(move=(0.1, 0.0, upward)))
        assert (hinge.tolist(), slide.tolist()) == ([False], [True])


def test_a_block_that_lifts_off_and_one_at_rest_are_neither() -> None:
    model = Model.of(tower(2))
    for moved in (motion(move=(0.0, 0.0, 0.1)), motion()):
        hinge, slide, _ = moving_joints(model, moved)
        assert not hinge.any()
        assert not slide.any()


@pytest.mark.parametrize("odd", [1e200, np.inf, np.nan])
def test_forces_or_motions_too_large_to_be_squared_prove_nothing(odd: float) -> None:
    model = Model.of(tower(2))
    force = np.zeros((model.contacts.corner_count, 3))
    assert check_forces(model, force + odd).largest == np.inf
    assert check_forces(model, force, np.full((2, 6), odd)).largest == np.inf


@pytest.mark.parametrize(("share", "proven"), [(2e-7, True), (1e-4, False)])
def test_a_corner_that_only_just_touches_may_press_in_proportion(
    share: float, proven: bool
) -> None:
    """Of the tens of thousands of corners of a pile one overlaps by 3e-8 of what others do."""
    model = Model.of(tower(2))
    overlap = np.array([3e-8, 0.5, 1.0, 0.5])
    # the top turns about its diagonal and goes down
    turned = motion(turn=(-0.5, 0.5, 0.0), move=(0.0, 0.0, -0.5 - 1.5e-8))
    weight = -float(model.load.wrench[1, 2])
    force = np.zeros((4, 3))
    force[:, 0] = 0.5 * weight * overlap
    force[0, 0] = 2.0 * weight * share
    assert (check_forces(model, force, turned).complementarity == 0.0) == proven


def test_the_place_of_a_hinge_is_its_end_that_an_eye_sees() -> None:
    model = Model.of(tower(2), friction=0.6)
    turned = motion(turn=(0, 0.1, 0), move=(0.05, 0, 0.05))
    (_, _, middle), (hinge, _, end) = (
        moving_joints(model, turned, toward) for toward in (None, np.array([0.7, -0.7, 0.1]))
    )
    assert hinge.tolist() == [True]
    assert np.ptp([middle[0], end[0]], axis=0) == pytest.approx([0.0, 0.5, 0.0])
    assert end[0, 1] < middle[0, 1]
