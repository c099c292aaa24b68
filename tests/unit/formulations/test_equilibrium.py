"""Rigid-block equilibrium: objectives, prices, friction rules, load factors, thrust bounds."""

import numpy as np
import pytest

from drystone import Assembly, Contacts, LoadCase
from drystone.formulations.equilibrium import (
    FrictionCone,
    FrictionRule,
    LoadFactors,
    Objective,
    Weights,
    solve_equilibrium,
    solve_extreme_force,
)
from drystone.geometry.frames import rotation_about
from drystone.mechanics.statics import Statics, build_statics
from drystone.model import Model
from drystone.models import arch, h_model, incline, stool, tower
from drystone.solvers.program import ConicStatus
from tests.oracle import touching_faces

EXACT = FrictionCone.exact()


def statics(assembly: Assembly, friction: float, load: LoadCase | None = None) -> Statics:
    contacts = touching_faces(assembly, friction)
    return build_statics(Model(assembly, contacts, load or LoadCase.gravity(assembly)))


def per_joint(problem: Statics, force: np.ndarray) -> np.ndarray:
    total = np.zeros((problem.interface.max() + 1, 3))
    np.add.at(total, problem.interface, force)
    return total


def test_quadratic_forces_share_a_stool_between_its_four_legs() -> None:
    problem = statics(stool(), 0.5)
    force = solve_equilibrium(problem, cone=EXACT).force
    np.testing.assert_allclose(per_joint(problem, force)[:, 0], 0.25, atol=1e-7)


def test_linear_forces_on_a_stool_balance_in_any_admissible_way() -> None:
    problem = statics(stool(), 0.5)
    solution = solve_equilibrium(problem, cone=EXACT, objective=Objective.LINEAR)
    legs = per_joint(problem, solution.force)[:, 0]
    assert legs.sum() == pytest.approx(1.0)
    assert (legs > -1e-9).all()
    assert np.abs(problem.wrench(solution.force) + problem.load).max() < 1e-8


@pytest.mark.parametrize("cone", [EXACT, FrictionCone(12)])
@pytest.mark.parametrize(
    "objective",
    [
        (Objective.QUADRATIC, Weights()),
        (Objective.QUADRATIC, Weights(friction=10.0)),
        (Objective.LINEAR, Weights()),
        (Objective.LINEAR, Weights(friction=2.0)),
    ],
)
def test_determinate_resultants_are_the_same_for_all_objectives(
    cone: FrictionCone, objective: tuple[Objective, Weights]
) -> None:
    problem = statics(tower(3), 0.6, LoadCase.tilt(tower(3), (1.0, 2.0, 0.0), 12.0))
    kind, weights = objective
    solution = solve_equilibrium(problem, cone=cone, objective=kind, weights=weights)
    total = per_joint(problem, solution.force)
    tilt = np.deg2rad(12.0)
    np.testing.assert_allclose(total[:, 0], [2.0 * np.cos(tilt), np.cos(tilt)], atol=1e-6)
    slide = np.linalg.norm(total[:, 1:], axis=1)
    np.testing.assert_allclose(slide, [2.0 * np.sin(tilt), np.sin(tilt)], atol=1e-6)


def friction_used(problem: Statics, weights: Weights, cone: FrictionCone = EXACT) -> float:
    solution = solve_equilibrium(problem, cone=cone, objective=Objective.LINEAR, weights=weights)
    return float(np.linalg.norm(solution.force[:, 1:], axis=1).sum())


def test_a_price_on_friction_gives_the_state_with_the_least_of_it() -> None:
    problem = statics(arch(0.25, 9), 0.8)
    with_cost = friction_used(problem, Weights(compression=0.0, friction=1.0))
    assert with_cost < friction_used(problem, Weights()) - 1e-3
    assert with_cost < friction_used(problem, Weights(compression=1.0, friction=0.1)) + 1e-7


def test_the_price_of_friction_does_not_depend_on_the_frame() -> None:
    assembly = arch(0.25, 7)
    contacts = touching_faces(assembly, 0.8)
    spun = contacts.frame.copy()
    for i, frame in enumerate(spun):
        spun[i] = frame @ rotation_about(frame[0], 33.0).T
    turned = Contacts(
        contacts.block_a, contacts.block_b, spun, contacts.area, contacts.friction,
        contacts.point, contacts.interface,
    )  # fmt: skip
    weights = Weights(compression=0.5, friction=1.0)
    used = [
        friction_used(build_statics(Model(assembly, each, LoadCase.gravity(assembly))), weights)
        for each in (contacts, turned)
    ]
    assert used[0] == pytest.approx(used[1], abs=1e-6)


def test_friction_on_net_compression_can_be_infeasible_where_friction_plus_is_not() -> None:
    problem = statics(incline(40.0), 0.3)
    plus = solve_equilibrium(problem, cone=EXACT, tension=True, rule=FrictionRule.PLUS)
    net = solve_equilibrium(problem, cone=EXACT, tension=True, rule=FrictionRule.NET)
    assert plus.raw.status is ConicStatus.SOLVED
    assert plus.tension.sum() > 0.1
    assert net.raw.status is ConicStatus.INFEASIBLE


@pytest.mark.parametrize("angle", [38.0, 44.5, 45.5, 53.0])
def test_friction_on_net_compression_is_feasible_exactly_where_no_pull_is_needed(
    angle: float,
) -> None:
    # a net pull has no friction cone at all: |ft| <= mu (fn+ - fn-) keeps every corner pressed
    problem = statics(tower(2), 2.0, LoadCase.tilt(tower(2), (1.0, 0.0, 0.0), angle))
    free = solve_equilibrium(problem, cone=EXACT).raw.status
    net = solve_equilibrium(problem, cone=EXACT, tension=True, rule=FrictionRule.NET).raw.status
    assert free is net


def test_a_load_factor_has_a_mechanism_on_which_the_live_load_does_unit_work() -> None:
    assembly = tower(2)
    problem = statics(assembly, 2.0)
    live = np.zeros((1, 6))
    live[0, 0] = 1.0
    solution = LoadFactors(problem, EXACT)(live)
    assert solution.factor == pytest.approx(1.0)  # topples over the edge of a cube
    assert abs(float((live * solution.state.multiplier).sum())) == pytest.approx(1.0)


def test_load_factors_tell_what_cannot_be_reached_and_what_never_balances() -> None:
    standing, sliding = statics(tower(2), 0.5), statics(incline(45.0), 0.5)
    down, across = np.zeros((2, 1, 6))
    down[0, 2], across[0, 1] = -1.0, 1.0
    assert LoadFactors(standing, EXACT)(down).factor == float("inf")
    assert LoadFactors(sliding, EXACT)(across).factor == float("-inf")


def test_each_live_load_has_the_factor_that_it_has_alone_whichever_came_before() -> None:
    problem = statics(tower(2), 0.7)
    largest = LoadFactors(problem, EXACT)
    loads = {  # a cube of unit weight slides three times, is pressed and is lifted
        (1.0, 0.0, 0.0): 0.7,
        (0.5, 0.0, 0.0): 1.4,
        (0.0, 0.0, -1.0): np.inf,
        (0.0, 2.0, 0.0): 0.35,
        (0.0, 0.0, 1.0): 1.0,
    }
    for force, factor in loads.items():
        live = np.zeros((1, 6))
        live[0, :3] = force
        assert largest(live).factor == pytest.approx(factor), force


def test_prestress_between_walls_is_bounded_below_only() -> None:
    problem = statics(h_model(), 0.5)
    price = np.zeros((problem.corner_count, 3))
    price[:, 0] = 1.0
    least = solve_extreme_force(problem, price, cone=EXACT)
    assert float((price * least.force).sum()) == pytest.approx(2.0, rel=1e-6)  # weight over 0.5
    most = solve_extreme_force(problem, -price, cone=EXACT)
    assert most.raw.status is ConicStatus.UNBOUNDED


@pytest.mark.parametrize("friction", [0.0, 1e-9, 1e-3])
def test_joints_without_friction_do_not_pull(friction: float) -> None:
    lifted = LoadCase(-LoadCase.gravity(tower(2)).wrench)
    problem = statics(tower(2), friction, lifted)
    assert solve_equilibrium(problem, cone=EXACT).raw.status is ConicStatus.INFEASIBLE
