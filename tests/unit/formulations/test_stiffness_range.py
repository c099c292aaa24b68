"""Rest on joints of unlike stiffness: the conditions of a state, and how unlike they must be."""

from __future__ import annotations

import numpy as np
import pytest

from drystone import LoadCase, models
from drystone.detection import find_contacts
from drystone.formulations.range_program import TrustRegion, elastic_forces
from drystone.formulations.stiffness_range import (
    rest_within_ratio,
    stiffness_ratio,
    with_reduced_ratio,
)
from drystone.model import Model
from drystone.stability.problem import Problem


def leaning_wedge(tilt):
    model = models.wedge("c")
    contacts = find_contacts(model, friction=0.84).contacts
    axis = (1.7320508075688772, 1.0, 0.0)
    return Problem.build(Model(model, contacts, LoadCase.tilt(model, axis, tilt))).statics


def settled(statics, spread, tries=40):
    """The first balanced state from random motions, or None."""
    rng = np.random.default_rng(2)
    for _ in range(tries):
        found = rest_within_ratio(statics, rng.standard_normal((1, 6)), spread)
        if found.unbalanced < 1e-8 * np.linalg.norm(statics.load):
            return found
    return None


@pytest.fixture(scope="module")
def statics():
    return leaning_wedge(48.0)


@pytest.fixture(scope="module")
def state(statics):
    found = settled(statics, 300.0)
    assert found is not None
    return found


def test_forces_balance_and_press_only_where_corners_overlap(statics, state):
    overlap = -statics.displacement(state.motion)[:, 0]
    assert np.abs(statics.wrench(state.force) + statics.load).max() < 1e-8
    assert state.force[:, 0].min() > -1e-12
    assert (state.force[overlap < 0.0] == 0.0).all()
    assert overlap.max() == pytest.approx(1.0)


def test_every_overlapping_corner_presses_within_the_range(statics, state):
    overlap = -statics.displacement(state.motion)[:, 0]
    closed = overlap > 1e-6
    stiffness = state.force[closed, 0] / overlap[closed]
    assert stiffness.min() > 0.0
    assert stiffness.max() / stiffness.min() <= 300.0 * (1.0 + 1e-6)
    assert stiffness_ratio(statics, state) == pytest.approx(
        stiffness.max() / stiffness.min(), rel=1e-3
    )


def test_friction_is_within_its_cone_and_against_the_slide(statics, state):
    slide = statics.displacement(state.motion)[:, 1:]
    shear = state.force[:, 1:]
    size = np.linalg.norm(shear, axis=1)
    assert (size <= statics.friction * state.force[:, 0] + 1e-9).all()
    work = (shear * slide).sum(axis=1)
    assert work == pytest.approx(-size * np.linalg.norm(slide, axis=1), abs=1e-8)


def test_stiffnesses_are_brought_closer_as_far_as_they_lead(statics, state):
    closer = with_reduced_ratio(statics, state)
    assert closer.unbalanced < 1e-8 * np.linalg.norm(statics.load)
    assert stiffness_ratio(statics, closer) < stiffness_ratio(statics, state)
    # half of what it takes there is too little from there
    within = 0.5 * stiffness_ratio(statics, closer)
    assert rest_within_ratio(statics, closer.motion, within).unbalanced > 1e-6


def test_the_size_of_the_start_does_not_matter(statics, state):
    found = [rest_within_ratio(statics, scale * state.motion, 200.0) for scale in (1e-3, 1.0, 1e3)]
    assert all(each.unbalanced < 1e-8 for each in found)


def test_no_range_helps_where_no_forces_balance():
    assert settled(leaning_wedge(52.0), 1e6, tries=10) is None


def test_a_motion_that_opens_all_corners_ends_unbalanced(statics):
    away = np.array([[0.0, 0.0, 1.0, 0.0, 0.0, 0.0]])
    found = rest_within_ratio(statics, away, 200.0)
    assert found.unbalanced == pytest.approx(np.linalg.norm(statics.load), rel=1.0)


def test_stopping_ends_the_steps(statics):
    motion = np.random.default_rng(3).standard_normal((1, 6))
    found = rest_within_ratio(statics, motion, 200.0, stop=lambda: True)
    assert found.iterations <= 1


def test_what_a_step_promises_comes_true_because_friction_turns_with_the_slide(statics, state):
    """The program's derivative against a finite difference, and against one without the turn."""
    rng = np.random.default_rng(8)
    motion = state.motion + 0.3 * rng.standard_normal((1, 6)) * np.abs(state.motion).mean()
    motion = motion * 1e-2 / np.abs(statics.displacement(motion)[:, 0]).max()
    moved = statics.displacement(motion)
    corner = np.flatnonzero(moved[:, 0] < 0.0)
    held = elastic_forces(statics, moved, corner, 1e4)
    assert held is not None
    slide = moved[corner, 1:]
    force = np.zeros((statics.corner_count, 3))
    force[corner, 1:] = -(held.shear / np.linalg.norm(slide, axis=1))[:, None] * slide

    def error(friction):
        step = elastic_forces(statics, moved, corner, 1e4, TrustRegion(friction, 0.1))
        assert step is not None
        after = elastic_forces(statics, statics.displacement(motion + step.change), corner, 1e4)
        assert after is not None
        return abs(after.infeasibility - step.infeasibility) / (
            held.infeasibility - step.infeasibility
        )

    assert error(force) < 0.01
    assert error(0.0 * force) > 0.1
