"""The verdict does not depend on units, density, place, orientation or numbering."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings

from drystone import (
    Assembly,
    LoadCase,
    Model,
    Result,
    Verdict,
    check,
    find_contacts,
    models,
    solve_cra,
    solve_cra_penalty,
    solve_rbe,
)
from drystone.geometry.frames import rotation_about

STABLE, UNSTABLE = Verdict.STABLE, Verdict.UNSTABLE
ARCH_FRICTION = float(np.tan(np.deg2rad(43.0)))


@dataclass(frozen=True)
class Case:
    """A model tilted to one side of its limit."""

    name: str
    model: Assembly
    friction: float
    axis: tuple[float, float, float]
    tilt: float
    expected: Verdict


Y = (0.0, 1.0, 0.0)
CASES = (
    Case("block holds", models.incline(0.0), 0.6, Y, 30.9138, STABLE),
    Case("block slides", models.incline(0.0), 0.6, Y, 31.0138, UNSTABLE),
    Case("tower leans", models.tower(5), 0.8, Y, 13.986, STABLE),
    Case("tower topples", models.tower(5), 0.8, Y, 14.086, UNSTABLE),
    Case("arch leans", models.arch(0.15, 18), ARCH_FRICTION, Y, 7.0, STABLE),
    Case("arch opens", models.arch(0.15, 18), ARCH_FRICTION, Y, 9.0, UNSTABLE),
    Case("wedge holds", models.wedge("a"), 0.84, (1.0, 0.0, 0.0), 57.0, STABLE),
    Case("wedge rises", models.wedge("a"), 0.84, Y, 115.0, UNSTABLE),
    Case("H falls", models.h_model(), 0.9, Y, 0.0, UNSTABLE),
)
PRESTRESSED = ("wedge rises", "H falls")
"""Forces balance the loads there, but nothing would bring them about."""


@dataclass(frozen=True)
class Change:
    """Another way to write the same model down."""

    scale: float = 1.0
    density: float = 2400.0
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    turn: float = 0.0
    move: float = 0.0
    seed: int | None = None

    def apply(self, case: Case) -> tuple[Assembly, LoadCase]:
        rotation = rotation_about(np.array(self.axis), self.turn)
        place = self.move * self.scale * np.array([1.0, -0.7, 0.4])
        model = case.model.with_density(self.density).transformed(self.scale * rotation, place)
        if self.seed is not None:
            order = np.random.default_rng(self.seed).permutation(len(model))
            model = model.subset(order.tolist())
        down = rotation_about(np.array(case.axis), case.tilt).T @ np.array([0.0, 0.0, -1.0])
        return model, LoadCase.gravity(model, direction=rotation @ down)


def verdict(case: Case, change: Change) -> Verdict:
    model, load = change.apply(case)
    return check(Model(model, find_contacts(model, friction=case.friction).contacts, load)).verdict


NAMED = {
    "as it is": Change(),
    "scaled 0.001": Change(scale=1e-3),
    "scaled 1000": Change(scale=1e3),
    "density 1e-6": Change(density=1e-6),
    "far away": Change(move=1e4),
    "turned": Change(axis=(0.3, -0.5, 0.8), turn=127.0),
    "upside down": Change(axis=(1.0, 0.0, 0.0), turn=180.0),
    "renumbered": Change(seed=3),
}


@pytest.mark.parametrize("change", NAMED)
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_verdict_does_not_depend_on_how_the_model_is_written_down(case: Case, change: str) -> None:
    assert verdict(case, NAMED[change]) is case.expected


EVERY_WAY = Change(scale=25.4, density=7.0, axis=(0.3, -0.5, 0.8), turn=127.0, move=1e3, seed=3)


@pytest.mark.parametrize("change", [Change(), Change(scale=1e-3, density=1e-6), EVERY_WAY])
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
@pytest.mark.parametrize("solve", [solve_rbe, solve_cra, solve_cra_penalty])
def test_every_analysis_says_the_same_of_the_same_model(
    solve: Callable[..., Result], case: Case, change: Change
) -> None:
    model, load = change.apply(case)
    found = solve(Model(model, find_contacts(model, friction=case.friction).contacts, load))
    if solve is solve_rbe:
        balances = case.expected is STABLE or case.name in PRESTRESSED
        assert found.verdict is (Verdict.EQUILIBRIUM_EXISTS if balances else UNSTABLE)
    else:
        assert found.verdict is case.expected
    if solve is solve_cra and found.verdict is STABLE:
        assert found.method == "cra"
        assert found.residuals is not None
        assert found.residuals.largest <= 1e-6
    if solve is solve_cra_penalty and found.verdict is UNSTABLE:
        assert found.prop is not None
        assert found.falling
        first = found.falling[0]
        held = np.linalg.norm(found.prop[first, :3]) / np.linalg.norm(load.wrench[first, :3])
        assert 5e-4 < held < 1.5  # a block that slides needs sin(slope - angle of friction)


CHANGES = st.builds(
    Change,
    scale=st.floats(-3.0, 3.0).map(lambda e: 10.0**e),
    density=st.floats(-6.0, 4.0).map(lambda e: 10.0**e),
    axis=st.sampled_from([(1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.6, -0.3, 0.7)]),
    turn=st.floats(-180.0, 180.0),
    move=st.floats(0.0, 1e4),
    seed=st.integers(0, 1000),
)


@settings(max_examples=15, derandomize=True, deadline=None)
@given(case=st.sampled_from(CASES), change=CHANGES)
def test_verdict_does_not_depend_on_all_of_it_together(case: Case, change: Change) -> None:
    assert verdict(case, change) is case.expected


@pytest.fixture(scope="module")
def wedge_limit() -> float:
    """Tilt limit about x of a wedge in a steep groove, to 0.02 degree."""
    low, high = 59.0, 59.5
    while high - low > 0.02:
        middle = 0.5 * (low + high)
        if verdict(wedge(middle, STABLE), Change()) is STABLE:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def wedge(tilt: float, expected: Verdict) -> Case:
    return Case("wedge", models.wedge("a"), 0.84, (1.0, 0.0, 0.0), tilt, expected)


@pytest.mark.parametrize(
    "change",
    [
        Change(scale=0.1, density=1e-6),
        Change(scale=10.0, density=1.0, seed=2, turn=60.0),
    ],
    ids=lambda change: f"{change.scale} {change.density} {change.turn}",
)
def test_tilt_limit_of_a_wedge_does_not_move(change: Change, wedge_limit: float) -> None:
    """Where a solver with absolute tolerances moves by 50 degrees."""
    assert verdict(wedge(wedge_limit - 0.03, STABLE), change) is STABLE
    assert verdict(wedge(wedge_limit + 0.03, UNSTABLE), change) is not STABLE
