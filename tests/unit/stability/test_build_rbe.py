"""The programs of rigid-block equilibrium, for those who want its matrices."""

import numpy as np
import pytest

import drystone
from benchmarks.workloads import random_pile
from drystone import InputError, Verdict
from drystone.models import shelf, vault
from drystone.programs import FrictionCone, FrictionRule, Objective, RBEOptions, Weights


def test_its_solution_is_that_of_solve_rbe() -> None:
    model = drystone.Model.of(vault(), friction=0.6)
    program, result = drystone.programs.build_rbe(model), drystone.solve_rbe(model)
    assert result.verdict is Verdict.EQUILIBRIUM_EXISTS
    x = program.solve(RBEOptions().conic).x
    assert result.force is not None
    inside = model.active[model.contacts.interface]  # not between two fixed blocks
    force = program.value(x, "force").reshape(-1, 3)
    assert force == pytest.approx(result.force[inside], abs=1e-6)
    balance = program.rows["equilibrium"]
    left = program.matrix[balance] @ x - program.right[balance]
    assert np.abs(left).max() < 1e-7


def test_its_penalised_form_is_what_solve_rbe_answers_with_where_nothing_balances() -> None:
    model = drystone.Model.of(shelf(), friction=0.05)
    result = drystone.solve_rbe(model)
    assert result.verdict is Verdict.UNSTABLE
    assert result.tension is not None
    assert drystone.programs.build_rbe(model).solve().status.value == "infeasible"
    program = drystone.programs.build_rbe(model, tension=True)
    x = program.solve(RBEOptions().conic).x
    largest = result.tension.max()
    assert largest > 0.0
    assert program.value(x, "tension") == pytest.approx(result.tension, abs=1e-6 * largest)


@pytest.mark.parametrize("cone", [FrictionCone.exact(), FrictionCone.octagon()])
@pytest.mark.parametrize("rule", list(FrictionRule))
def test_rows_and_variables_have_names(cone: FrictionCone, rule: FrictionRule) -> None:
    weights = Weights(friction=1.0)
    options = RBEOptions(cone=cone, rule=rule, objective=Objective.LINEAR, weights=weights)
    program = drystone.programs.build_rbe(vault(), friction=0.6, options=options, tension=True)
    assert list(program.variables) == ["force", "length", "tension"]
    assert set(program.rows) == {
        "equilibrium", "no pull", "tension", "length of friction", "friction",
    }  # fmt: skip
    assert set(program.unit.values()) == {program.unit["force"]}
    pull = program.linear[program.variables["tension"]]
    push = program.linear[program.variables["force"]][::3]
    assert pull / push == pytest.approx(1e6)  # the source's ratio of costs


def test_bad_input_is_refused_as_by_solve_rbe() -> None:
    with pytest.raises(InputError):
        drystone.programs.build_rbe(3)  # type: ignore[arg-type]


@pytest.mark.parametrize("seed", range(6))
def test_whether_any_forces_balance_a_pile_is_the_same_as_whether_the_least_do(seed: int) -> None:
    model = random_pile(seed)
    least = drystone.solve_rbe(model)
    some = drystone.solve_rbe(model, options=RBEOptions.feasibility())
    assert some.verdict is least.verdict
    assert (some.force is None) is (some.mechanism is not None)
    if some.residuals is not None:
        assert max(some.residuals.equilibrium, some.residuals.cone) < 1e-8


def test_a_joint_that_pulls_may_hold_what_falls_apart() -> None:
    model = drystone.Model.of(shelf(), friction=0.05)
    much = np.full(model.contacts.count, 1e9)
    strong = model.with_capacity(drystone.JointCapacity(tension=much, cohesion=much))
    options = RBEOptions.feasibility()
    assert drystone.solve_rbe(model, options=options).verdict is Verdict.UNSTABLE
    assert drystone.solve_rbe(strong, options=options).verdict is Verdict.EQUILIBRIUM_EXISTS
