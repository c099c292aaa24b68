"""Friction laws: inside the cone, against the slide, with right derivatives."""

from dataclasses import replace

import numpy as np
import pytest

from drystone.mechanics.law import Compliance, FrictionBound, SlipLength, StickSlip, respond

K = 40
RNG = np.random.default_rng(2)
FRICTION = RNG.uniform(0.1, 1.2, K)
NORMAL = RNG.uniform(0.1, 3.0, K)
SLIDE = RNG.normal(size=(K, 2)) * 10.0 ** RNG.uniform(-3, 3, (K, 1))
LAWS = [
    SlipLength(FrictionBound(FRICTION), RNG.uniform(0.1, 2.0, K)),
    StickSlip(FrictionBound(FRICTION), RNG.uniform(0.1, 2.0, K)),
]


@pytest.mark.parametrize("law", LAWS)
def test_friction_stays_inside_the_cone_and_points_along_the_slide(law):
    force = law(NORMAL, SLIDE).force
    assert (np.linalg.norm(force, axis=1) <= FRICTION * NORMAL * (1.0 + 1e-12)).all()
    cross = force[:, 0] * SLIDE[:, 1] - force[:, 1] * SLIDE[:, 0]
    assert np.allclose(cross, 0.0, atol=1e-12 * np.abs(SLIDE).max())
    assert ((force * SLIDE).sum(axis=1) > 0.0).all()


@pytest.mark.parametrize("law", LAWS)
def test_derivatives_agree_with_central_differences(law):
    by_slide, by_normal = law(NORMAL, SLIDE).slope()
    step = 1e-6 * np.linalg.norm(SLIDE, axis=1)
    for axis in range(2):
        shift = np.zeros((K, 2))
        shift[:, axis] = step
        numeric = (law(NORMAL, SLIDE + shift).force - law(NORMAL, SLIDE - shift).force) / (
            2.0 * step[:, None]
        )
        scale = np.abs(by_slide).max(axis=(1, 2))
        assert np.allclose((numeric - by_slide[:, :, axis]) / scale[:, None], 0, atol=1e-6)
    more, less = law(NORMAL + 1e-6, SLIDE).force, law(NORMAL - 1e-6, SLIDE).force
    assert np.allclose((more - less) / 2e-6, by_normal, atol=1e-7)


def test_a_corner_that_does_not_slide_feels_no_friction():
    for law in LAWS:
        assert not law(NORMAL, np.zeros((K, 2))).force.any()


def test_a_corner_that_neither_presses_nor_slides_yet_is_as_stiff_as_one_that_sticks():
    law = StickSlip(FrictionBound(FRICTION), RNG.uniform(0.1, 2.0, K))
    by_slide, by_normal = law(np.zeros(K), np.zeros((K, 2))).slope()
    np.testing.assert_allclose(by_slide, law.stiffness[:, None, None] * np.eye(2))
    assert not by_normal.any()


@pytest.mark.parametrize("tension", [None, RNG.uniform(0.1, 2.0, K)])
@pytest.mark.parametrize("before", [None, RNG.normal(size=(K, 2))])
def test_the_tangent_is_the_derivative_of_the_force(tension, before):
    # corners that press, pull, stick and slide, some after friction that was there before
    bound = FrictionBound(FRICTION)
    if tension is not None:
        bound = FrictionBound(FRICTION, RNG.uniform(0.1, 1.0, K), np.full(K, 2.0))
    springs = Compliance(
        RNG.uniform(0.5, 2.0, K), StickSlip(bound, RNG.uniform(0.1, 2.0, K)), tension=tension
    )
    moved = RNG.normal(size=(K, 3))

    def force(at):
        return respond(springs, at[:, 0], at[:, 1:], before).force

    tangent = respond(springs, moved[:, 0], moved[:, 1:], before).tangent
    for axis in range(3):
        shift = np.zeros((K, 3))
        shift[:, axis] = 1e-7
        change = (force(moved + shift) - force(moved - shift)) / 2e-7
        np.testing.assert_allclose(-change, tangent[:, :, axis], atol=1e-6)


def test_friction_that_was_there_before_goes_on_from_there():
    springs = Compliance(np.ones(1), StickSlip(FrictionBound(np.ones(1)), np.ones(1)))
    once = respond(springs, np.array([-1.0]), np.array([[0.5, 0.0]]))
    first = respond(springs, np.array([-1.0]), np.array([[0.2, 0.0]]))
    second = respond(springs, np.array([-1.0]), np.array([[0.3, 0.0]]), -first.force[:, 1:])
    np.testing.assert_allclose(second.force, once.force)
    slid = respond(springs, np.array([-1.0]), np.array([[5.0, 0.0]]), -first.force[:, 1:])
    np.testing.assert_allclose(slid.force, [[1.0, -1.0, 0.0]])


@pytest.mark.parametrize("tension", [None, np.array([2.0, 2.0, 2.0, 0.0])])
def test_a_corner_is_found_where_its_force_has_it(tension):
    springs = Compliance(np.full(4, 3.0), StickSlip(FrictionBound(np.ones(4)), np.ones(4)))
    springs = replace(springs, tension=tension)
    gap = np.array([-0.5, 0.2, 0.9, 0.1])
    force = respond(springs, gap, np.zeros((4, 2))).force[:, 0]
    np.testing.assert_allclose(springs.gap_of(force, gap), gap)
