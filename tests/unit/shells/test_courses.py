import itertools

import numpy as np
import pytest

from drystone import InputError
from drystone.shells import barrel_vault, dome, patch_from_function
from drystone.shells.courses import LEAST_LAP, lay_bond, lay_courses


def fan(u, v):
    """A plane patch, 3 m long at v = 0 and 7 m at v = 1."""
    return np.stack([(3.0 + 4.0 * v) * (u - 0.5), 6.0 * v, 0.0 * u], axis=-1)


FAN = patch_from_function(fan, name="fan")
BARREL = barrel_vault(6.0, 6.0).patches[0]
DOME = dome().patches[0]


def test_courses_have_equal_height_along_the_surface():
    stretched = patch_from_function(lambda u, v: np.stack([u**2 + u, v, 0.0 * u], axis=-1))
    courses = lay_courses(stretched, count=5)
    v = np.full(6, 0.3)
    u = courses.parameter(courses.share, v)
    assert np.allclose(np.diff(stretched.point(u, v)[:, 0]), 0.4, atol=1e-4)


def test_a_height_gives_the_number_of_courses_on_the_shorter_side():
    assert lay_courses(FAN, height=0.5).count == 6


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "one of count and height"),
        ({"count": 3, "height": 1.0}, "one of count and height"),
        ({"count": 0}, "one or more courses"),
        ({"height": -1.0}, "course height is -1"),
    ],
)
def test_impossible_courses_are_refused(options, message):
    with pytest.raises(InputError, match=message):
        lay_courses(BARREL, **options)


def test_head_joints_are_staggered_by_half_a_block():
    joints = lay_bond(lay_courses(BARREL, count=3), blocks=4)
    assert np.allclose(joints[0], [0, 0.25, 0.5, 0.75, 1])
    assert np.allclose(joints[1], [0, 0.125, 0.375, 0.625, 0.875, 1])
    assert np.allclose(joints[2], joints[0])


def test_rings_close_and_are_staggered():
    joints = lay_bond(lay_courses(DOME, count=2), blocks=10)
    assert np.allclose(joints[0], np.arange(11) / 10)
    assert np.allclose(joints[1], np.arange(11) / 10 + 0.05)


def test_head_joints_lap_where_the_number_of_blocks_changes():
    joints = lay_bond(lay_courses(DOME, count=8), width=1.0)
    assert len({len(x) for x in joints}) > 3
    for below, above in itertools.pairwise(joints):
        gap = np.abs(
            above[:-1, None] - np.concatenate([below[:-1] - 1, below[:-1], below[:-1] + 1])
        )
        assert gap.min() > 0.8 * LEAST_LAP * min(np.diff(above).min(), np.diff(below).min())


def test_unstaggered_joints_are_continuous():
    joints = lay_bond(lay_courses(BARREL, count=3), blocks=4, staggered=False)
    assert all(np.allclose(x, joints[0]) for x in joints)


@pytest.mark.parametrize(
    ("patch", "options", "message"),
    [
        (BARREL, {}, "one of blocks and width"),
        (BARREL, {"blocks": 2, "width": 1.0}, "one of blocks and width"),
        (BARREL, {"width": 0.0}, "block width is 0"),
        (BARREL, {"blocks": 0}, "0 blocks in a course are too few"),
        (BARREL, {"blocks": [4, 4]}, "2 numbers of blocks for 3 courses"),
        (DOME, {"blocks": 2}, "course 0: 2 blocks in a course are too few; give 3 or more"),
    ],
)
def test_impossible_bonds_are_refused(patch, options, message):
    with pytest.raises(InputError, match=message):
        lay_bond(lay_courses(patch, count=3), **options)


def test_unstaggered_joints_run_on_where_the_courses_differ_a_little():
    joints = lay_bond(lay_courses(FAN, count=5), blocks=6, staggered=False)
    assert all(np.array_equal(x, joints[0]) for x in joints)
