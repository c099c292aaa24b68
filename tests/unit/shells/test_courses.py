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
    u = courses.parameter(courses.line(v[:1])[0], v)
    assert np.allclose(np.diff(stretched.point(u, v)[:, 0]), 0.4, atol=1e-4)


def test_given_heights_are_kept_in_proportion():
    courses = lay_courses(BARREL, heights=[1.0, 2.0, 1.0])
    assert np.allclose(courses.line(np.array([0.5]))[0], [0.0, 0.25, 0.75, 1.0])


def test_a_height_gives_the_number_of_courses_on_the_shorter_side():
    assert lay_courses(FAN, height=0.5).count == 6


def test_partial_courses_even_out_the_heights():
    courses = lay_courses(FAN, height=0.5, partial=None)
    assert courses.count == 14
    ends = np.array([0.0, 1.0])
    present = courses.present(ends).sum(axis=1)
    assert present.tolist() == [6, 14]


def test_partial_courses_begin_with_no_height():
    courses = lay_courses(FAN, height=0.5, partial=2)
    partial = np.flatnonzero(courses.start > 0.0)
    assert len(partial) == 2
    for course in partial:
        tip = courses.start[[course]]
        line = courses.line(tip)[0]
        assert line[course] == line[course + 1]


def test_bed_lines_never_cross():
    courses = lay_courses(FAN, height=0.5, partial=None)
    assert (np.diff(courses.line(np.linspace(0, 1, 101)), axis=1) >= 0.0).all()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "one of count, height and heights"),
        ({"count": 3, "height": 1.0}, "one of count, height and heights"),
        ({"count": 0}, "one or more courses"),
        ({"height": -1.0}, "course height is -1"),
        ({"heights": [1.0, 0.0]}, "height above zero"),
        ({"count": 4, "partial": 1}, "no side is longer"),
        ({"count": 4, "partial": -1}, "number of partial courses is -1"),
    ],
)
def test_impossible_courses_are_refused(options, message):
    with pytest.raises(InputError, match=message):
        lay_courses(BARREL, **options)


def test_partial_courses_in_a_closed_patch_are_refused():
    with pytest.raises(InputError, match="no longer side"):
        lay_courses(DOME, count=4, partial=1)


def test_head_joints_are_staggered_by_half_a_block():
    _, joints = lay_bond(lay_courses(BARREL, count=3), blocks=4)
    assert np.allclose(joints[0], [0, 0.25, 0.5, 0.75, 1])
    assert np.allclose(joints[1], [0, 0.125, 0.375, 0.625, 0.875, 1])
    assert np.allclose(joints[2], joints[0])


def test_rings_close_and_are_staggered():
    _, joints = lay_bond(lay_courses(DOME, count=2), blocks=10)
    assert np.allclose(joints[0], np.arange(11) / 10)
    assert np.allclose(joints[1], np.arange(11) / 10 + 0.05)


def test_head_joints_lap_where_the_number_of_blocks_changes():
    _, joints = lay_bond(lay_courses(DOME, count=8), width=1.0)
    assert len({len(x) for x in joints}) > 3
    for below, above in itertools.pairwise(joints):
        gap = np.abs(
            above[:-1, None] - np.concatenate([below[:-1] - 1, below[:-1], below[:-1] + 1])
        )
        assert gap.min() > 0.8 * LEAST_LAP * min(np.diff(above).min(), np.diff(below).min())


def test_unstaggered_joints_are_continuous():
    _, joints = lay_bond(lay_courses(BARREL, count=3), blocks=4, staggered=False)
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


def test_partial_courses_do_not_end_on_a_head_joint_of_the_course_below():
    courses, joints = lay_bond(lay_courses(FAN, height=0.5, partial=None), width=0.6)
    partial = [c for c in range(1, courses.count) if courses.start[c] > 0.0]
    assert len(partial) == 8
    for course in partial:
        tip = courses.start[course]
        reached = [c for c in range(course) if courses.start[c] < tip]
        assert np.abs(joints[reached[-1]][1:-1] - tip).min() > 0.3 * courses.taper


def test_unstaggered_joints_run_on_where_the_courses_differ_a_little():
    _, joints = lay_bond(lay_courses(FAN, count=5), blocks=6, staggered=False)
    assert all(np.array_equal(x, joints[0]) for x in joints)
