"""Scaffolding is drawn at the stages at which it is set up, and what fails with it is said."""

import math

import numpy as np
import pytest

from drystone import Assembly, models
from drystone.answer import Role, State
from drystone.models import arch
from drystone.sequence import Plan, PlanOptions, Rules, ScaffoldOptions, plan, scaffolding


@pytest.fixture(scope="module")
def found() -> Plan:
    return plan(arch(0.3, 5), friction=0.6, options=PlanOptions(rules=Rules(hands=1)))


def test_struts_are_drawn_from_their_feet_to_the_blocks_that_they_prop(found: Plan) -> None:
    made = scaffolding(found, "strut")
    scene = made.layers()
    for step, stage in zip(found.steps, scene.stages, strict=False):
        drawn = [layer for layer in stage.layers if layer.key == "scaffold"]
        held = [found.model.assembly.names[block] for block in step.props]
        items = [one for one in made.items if one.block in held]
        assert sum(layer.count for layer in drawn) == len(items)
        for layer in drawn:
            np.testing.assert_allclose(layer.position, [one.foot for one in items])
            np.testing.assert_allclose(layer.position + layer.vector, [one.head for one in items])
    (every,) = [layer for layer in scene.stages[-1].layers if layer.key == "scaffold"]
    assert (every.count, every.label) == (len(made.items), f"{len(made.items)} struts in all")


def test_clamps_of_the_step_before_are_drawn_while_a_hand_holds_and_forces_are_ideal() -> None:
    made = scaffolding(plan(arch(0.15, 4), friction=0.7), "clamp")
    stages = made.layers().stages[:-1]
    drawn = [any(one.key == "scaffold" for one in stage.layers) for stage in stages]
    assert drawn == [State.PROPPED in stage.state for stage in stages]
    assert sum(drawn) > sum(bool(step.props) for step in made.plan.steps)
    labels = [one.label for stage in stages for one in stage.layers if one.key == "help"]
    assert labels
    assert all(one.startswith("ideal props and hands") for one in labels)
    assert all(one.endswith(" (in place of props: clamps)") for one in labels)


def test_a_title_says_which_stages_were_only_looked_at() -> None:
    circle = [(math.cos(t), math.sin(t)) for t in np.linspace(0.0, 2.0 * math.pi, 800, False)]
    disc = models.prism(circle, (0.0, 0.5)).transformed(((1, 0, 0), (0, 0, -1), (0, 1, 0)))
    places = ((0.0, 0.0, 0.0), (0.1, 0.0, 0.5), (1.2, 0.0, 1.0))
    blocks = [disc.transformed(translation=at).renamed(f"z {at[2]}") for at in places]
    pile = Assembly(blocks, [True, False, False])
    order = plan(pile, friction=0.6, options=PlanOptions(anyway=True))
    made = scaffolding(order, "clamp")
    assert made.works
    assert made.title == "Every stage stands with clamps; 1 stage only looked at, not followed"


def test_a_stage_that_slides_off_its_centring_is_not_shown_to_stand(found: Plan) -> None:
    smooth = ScaffoldOptions(friction=0.0)
    made, ideal = scaffolding(found, "centring", options=smooth), found.layers()
    scene = made.layers()
    assert made.failed == (3, 4)
    fails = [stage.role is not Role.GOOD for stage in scene.stages]
    assert fails == [i in made.failed for i in range(1, len(found.steps) + 1)] + [True]
    assert scene.stages[2].headline == "Step 3 of 5: does not stand with centring"
    assert scene.stages[-1].headline.startswith("Not every stage stands with centring")
    assert all(stage.role is Role.GOOD for stage in ideal.stages[:-1])


@pytest.mark.parametrize(("kind", "mark"), [("clamp", "1 clamp"), ("centring", "1 centring")])
def test_clamps_and_centring_are_drawn_and_every_stage_stands(
    found: Plan, kind: str, mark: str
) -> None:
    made = scaffolding(found, kind)
    scene = made.layers()
    for answer in (made, found):  # the title and the colour of the picture are those of the answer
        last, first = answer.layers().stages[-1], answer.sentences()[0]
        assert (last.headline, last.role) == (answer.title, first.role)
    labels = [layer.label for stage in scene.stages for layer in stage.layers]
    assert mark in labels
    assert all(stage.role is Role.GOOD for stage in scene.stages)


def test_a_strut_that_carries_too_much_is_named(found: Plan) -> None:
    made = scaffolding(found, "clamp", options=ScaffoldOptions(limit=1.0))
    headlines = [stage.headline for stage in made.layers().stages]
    assert any("clamp" in one for one in headlines[:-1])
    assert headlines[-1].startswith("Not every stage stands with clamps")
