"""Virtual interfaces: the joints that they leave, and the states of equilibrium they find."""

import numpy as np
import pytest

from drystone import (
    Contacts,
    InputError,
    JointCapacity,
    Model,
    Verdict,
    limit_shrink,
    solve_rbe,
)
from drystone.geometry.kern import kern_ratio, sections
from drystone.models import arch, tower
from drystone.virtual import (
    joint_sections,
    local_corners,
    section_centroids,
    shift,
    shrink,
    to_kern,
)
from tests.oracle import touching_faces

TOWER = touching_faces(tower(3), 0.6)
ARCH = arch(0.15, 12)
JOINTS = touching_faces(ARCH, 0.7)


def test_shrinking_scales_area_and_keeps_centroids() -> None:
    small = shrink(TOWER, 0.5)
    np.testing.assert_allclose(small.area, 0.25)
    np.testing.assert_allclose(section_centroids(small), section_centroids(TOWER))
    np.testing.assert_array_equal(small.frame, TOWER.frame)


def test_what_a_joint_bears_shrinks_with_its_area() -> None:
    strong = JointCapacity.of_stress(TOWER, tension=1e4, compression=1e6)
    small = shrink(TOWER.with_capacity(strong), 0.5, [1]).capacity
    assert small is not None
    np.testing.assert_allclose(small.compression, [1e6, 0.25e6])
    np.testing.assert_allclose(small.tension, [1e4, 0.25e4])
    np.testing.assert_array_equal(small.shear, strong.shear)  # no limit stays none


def test_joints_shrink_until_the_stone_crushes() -> None:
    model = Model.of(tower(3), friction=0.6)
    weight = 9.81 * float(model.assembly.mass[1:].sum())
    strong = JointCapacity.of_stress(model.contacts, compression=4.0 * weight)  # faces of 1 m2
    found = limit_shrink(model.with_capacity(strong))
    assert found.falls < 0.5 <= found.stands < 0.502


def test_only_chosen_interfaces_change_and_the_input_never() -> None:
    before = TOWER.point.copy()
    part = shrink(TOWER, 0.5, [1])
    np.testing.assert_allclose(part.area, [1.0, 0.25])
    np.testing.assert_array_equal(TOWER.point, before)


def test_a_point_a_line_and_a_polygon_are_what_shrinking_and_shifting_leave() -> None:
    assert np.diff(shrink(TOWER, 0.0).start).tolist() == [1, 1]
    edge = shift(TOWER, (1.0, 0.0, 0.0), 0.0)
    assert np.diff(edge.start).tolist() == [2, 2]
    np.testing.assert_allclose(edge.point[:, 0], 1.0)
    assert edge.area.tolist() == [0.0, 0.0]
    half = shift(TOWER, (1.0, 0.0, 0.0), 0.5)
    assert half.point[:, 0].min() == pytest.approx(0.5)
    np.testing.assert_allclose(half.area, 0.5)


def test_corners_towards_a_corner_reduce_a_square_to_that_corner() -> None:
    with pytest.raises(InputError, match="normal to the interface"):
        shift(TOWER, (0.0, 0.0, 1.0), 0.5)
    diagonal = shift(TOWER, (1.0, 1.0, 0.0), 0.0)
    np.testing.assert_allclose((diagonal.point @ [1.0, 1.0, 0.0]), 2.0)


def test_the_kern_of_a_square_joint_is_its_rhombus() -> None:
    small = to_kern(TOWER)
    np.testing.assert_allclose(small.area, 1.0 / 18.0)
    np.testing.assert_allclose(np.linalg.norm(local_corners(small)[1], axis=1), 1.0 / 6.0)


def test_intrados_and_extrados_lie_on_their_circles() -> None:
    for sign, radius in ((-1.0, 0.925), (1.0, 1.075)):
        edge = shift(JOINTS, sign * section_centroids(JOINTS) * (1.0, 0.0, 1.0), 0.0)
        np.testing.assert_allclose(np.linalg.norm(edge.point[:, [0, 2]], axis=1), radius)


@pytest.mark.parametrize("factor", [-0.1, 1.1, float("nan")])
def test_a_factor_outside_zero_to_one_is_refused(factor: float) -> None:
    with pytest.raises(InputError, match="factor is"):
        shrink(TOWER, factor)


def test_an_interface_that_does_not_exist_is_refused() -> None:
    with pytest.raises(InputError, match="no such interface"):
        shrink(TOWER, 0.5, [7])


def test_no_interfaces_stay_no_interfaces() -> None:
    assert to_kern(Contacts.empty()).count == 0


def test_forces_on_the_kern_stay_within_the_kern_of_the_whole_joint() -> None:
    thick = arch(0.6, 12)
    joints = touching_faces(thick, 0.9)
    result = solve_rbe(Model(thick, to_kern(joints)))
    assert result.verdict is Verdict.EQUILIBRIUM_EXISTS
    origin, corners, made = joint_sections(joints)
    position = result.resultants.position - origin
    at = np.einsum("mij,mj->mi", joints.frame[:, 1:], position)
    assert kern_ratio(made, corners, joints.start, at).max() <= 1.0 + 1e-6


def test_a_thin_arch_leaves_its_kern_and_the_penalised_form_shows_where() -> None:
    result = solve_rbe(Model(ARCH, to_kern(JOINTS)))
    assert result.verdict is Verdict.UNSTABLE
    assert result.tension is not None
    pulled = np.bincount(result.contacts.interface, result.tension, minlength=JOINTS.count)
    assert (pulled > 0.01 * pulled.max()).tolist().count(True) < JOINTS.count


def test_sections_of_shrunk_joints_are_those_of_the_corners() -> None:
    small = shrink(JOINTS, 0.3)
    np.testing.assert_allclose(small.area, sections(local_corners(small)[1], small.start).area)
