"""Margins of stages, sweeps over friction, and the table."""

import numpy as np
import pytest

from drystone.answer import State
from drystone.assembly import Assembly
from drystone.base.errors import InputError
from drystone.detection import find_contacts
from drystone.limits import LimitOptions, tilt_sweep
from drystone.model import Model
from drystone.models import arch, box, leaning_column, tower
from drystone.results import Result
from drystone.sequence import (
    Margins,
    Plan,
    PlanOptions,
    Rules,
    ScaffoldOptions,
    check_once,
    margins,
    plan,
    sweep_friction,
)
from drystone.sequence.margins import Margin, at_other_friction


@pytest.fixture(scope="module")
def stack() -> Plan:
    assembly = tower(4)
    return plan(Model.of(assembly, friction=0.6))


def test_each_stage_of_a_stack_tilts_to_its_closed_form(stack):
    # i free cubes topple at atan(1 / i), and slide at atan(0.6) = 31.0 degrees
    found = margins(stack, tilt_width=0.2, directions=2)
    expected = [min(np.degrees(np.arctan(1.0 / i)), 30.96) for i in (1, 2, 3)]
    np.testing.assert_allclose([one.tilt for one in found.stages], expected, atol=0.3)
    assert found.weakest == 2
    assert found.least_friction < 0.02
    assert found.sentences()[-1].text == "found to 0.01 of friction and 0.2 degrees of tilt"


def test_the_stage_is_told_that_needs_more_friction_than_the_whole(stack):
    whole = Margin(0.0078, 30.0)
    told = Margins(stack, (whole, Margin(0.4063, 9.0), whole)).sentences()[-1].text
    assert told == "step 2 needs more friction than the complete structure, which needs 0.0078"
    even = Margins(stack, (whole, Margin(0.0156, 9.0), whole)).sentences()[-1].text
    assert even.startswith("found to")


def test_directions_are_searched_below_the_least_tilt_that_is_known() -> None:
    asked = []

    def counted(model: Model) -> Result:
        asked.append(model)
        return check_once(model)

    order = plan(Model.of(arch(0.15, 7), friction=0.7), check=counted)
    asked.clear()
    found = margins(order, friction_width=1.0)
    mine = len(asked)
    wide = LimitOptions(width=0.5, scan=2)
    for number, one in enumerate(found.stages):
        stage = order.stage(number)
        sweep = tilt_sweep(stage, 4, upper=45.0, check=counted, options=wide)
        least = min(each.best.stands or 0.0 for each in sweep.limits)
        assert one.tilt == pytest.approx(least, abs=0.5)
    assert mine < 0.9 * (len(asked) - mine)
    assert len(order.stage(-1).assembly) == len(order.model.assembly)
    with pytest.raises(InputError, match="no step 9; they are counted from 0 to"):
        order.stage(9)


def test_a_stage_that_floats_stands_at_no_friction_and_no_tilt():
    """The upper block is placed first, and no strut is long enough to carry it."""
    first = PlanOptions(
        rules=Rules(hands=1, before=[("block-2", "block-1")]),
        scaffold="strut",
        scaffold_options=ScaffoldOptions(longest=0.1),
    )
    found = margins(plan(tower(3), options=first))
    assert found.plan.order == ("block-2", "block-1")
    assert (found.plan.counts["free"], found.plan.counts["unsure"]) == (1, 1)
    assert (found.stages[0].least_friction, found.stages[0].tilt) == (np.inf, 0.0)
    assert found.sentences()[-1].text == "a stage of this order stands at no friction"
    shown = {layer.key for layer in found.plan.layers().stages[-1].layers}
    assert "unsure" in shown
    assert found.plan.layers().stages[0].state[2] == State.FALLING


def test_the_table_has_a_row_per_block_with_its_margins(stack):
    found = margins(stack, tilt_width=1.0, directions=1)
    table = found.table()
    assert table["block"].tolist() == ["block-1", "block-2", "block-3"]
    assert (table["tilt"] > 10.0).all()
    assert table.units == {"hold_force": "N", "prop_force": "N", "tilt": "deg"}
    assert list(stack.table().columns) == list(table.columns)[:-2]


def test_a_leaning_column_is_built_above_the_tangent_of_its_lean_only():
    assembly = leaning_column(3, 10.0)
    model = Model(assembly, find_contacts(assembly, friction=0.6).contacts)
    least = np.tan(np.deg2rad(10.0))
    sweep = sweep_friction(model, [least + 0.01, least - 0.01], plan)
    assert sweep.table()["stands"].tolist() == [False, True]
    assert sweep.table()["free"].tolist() == [None, 3]


def test_what_cannot_be_put_in_is_built_at_no_friction():
    places = np.concatenate([np.eye(3), -np.eye(3)])
    sides = tuple(box((1.0, 1.0, 1.0), tuple(at), f"side-{i}") for i, at in enumerate(places))
    top = box((1.0, 1.0, 1.0), (0.0, 0.0, 2.0), "top")
    closed = Assembly((*sides, box((1.0, 1.0, 1.0), name="core"), top), np.arange(8) < 6)
    model = Model.of(closed)
    for friction in (0.0, 0.6):
        found = plan(model.with_friction(friction))
        assert found.order == ("top",)
        assert len(found.impossible) == 1


def test_help_does_not_grow_with_friction_where_the_better_order_stands():
    """A planner that is worse at more friction is corrected by the order of less friction."""
    model = Model.of(arch(0.3, 5), friction=0.6)

    def plan_at(some: Model) -> Plan:
        hands = 1 if some.contacts.friction[0] > 0.5 else 2
        return plan(some, options=PlanOptions(rules=Rules(hands=hands)))

    swept = sweep_friction(model, [0.6, 0.45], plan_at)
    assert plan_at(model).help > swept.plans[0].help == swept.plans[1].help
    assert swept.plans[1].verdict == "stable"
    assert swept.why_more == ("", "")


def test_a_step_that_fails_at_another_friction_is_told_with_its_stage():
    model = Model.of(leaning_column(3, 10.0), friction=0.6)
    found, why = at_other_friction(plan(model), plan(model.with_friction(0.1)))
    assert found is None
    assert why.startswith("stage 1 does not stand: c01-block falls; no contact forces")
