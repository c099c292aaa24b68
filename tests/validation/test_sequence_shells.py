"""A dome and a vault, planned course by course, and an arch on props."""

from itertools import combinations

import pytest

from benchmarks.niche import niche
from benchmarks.sequence import BY_COURSE, DOME_FRICTION, VAULT_FRICTION
from drystone import Assembly, Model, Verdict, find_contacts, plan
from drystone.models import arch
from drystone.reproduce.assembly_cases import ring_dome, tri_dome
from drystone.sequence import Evaluator, Plan, PlanOptions, Rules, Stage, Status, Structure


def planned(assembly: Assembly, friction: float) -> Plan:
    contacts = find_contacts(assembly, friction=friction).contacts
    return plan(Model(assembly, contacts), options=PlanOptions(rules=BY_COURSE))


def course(name: str) -> int:
    return int(name[1:3])


@pytest.fixture(scope="module")
def round_plan() -> Plan:
    return planned(ring_dome(), DOME_FRICTION)


def test_a_dome_is_built_of_free_blocks_and_pairs_without_props(round_plan):
    assert len(round_plan.model.assembly.free) == 60
    assert round_plan.counts["propped"] == 0
    assert round_plan.counts["free"] + round_plan.counts["held"] == 60
    assert {len(step.blocks) for step in round_plan.steps} == {1, 2}
    assert round_plan.verdict == "stable"


def test_every_ring_is_closed_before_the_next_is_begun(round_plan):
    courses = [course(name) for name in round_plan.order]
    assert courses == sorted(courses)


def test_the_first_blocks_of_the_steep_rings_are_the_held_ones(round_plan):
    names = round_plan.model.assembly.names
    held = {names[b] for b, one in enumerate(round_plan.status) if one is Status.HELD}
    steep = sorted({course(name) for name in held})
    assert steep
    assert steep == list(range(steep[0], 5))  # from some ring on, all of them
    for ring in steep:
        first = [name for name in round_plan.order if course(name) == ring][:2]
        assert set(first) == {name for name in held if course(name) == ring}


def test_on_a_foot_of_the_tri_dome_one_block_is_held_while_two_are_placed():
    """So two robots without a prop need one hold there that lasts longer than a placement."""
    feet = Structure(tri_dome().model(friction=0.66))
    foot = [f"p0-c01-b{number:02d}" for number in range(3)]
    some = [blocks for count in (1, 2) for blocks in combinations(foot, count)]
    assert {feet.stands(blocks).verdict for blocks in some} == {Verdict.UNSTABLE}
    assert feet.stands(foot).verdict is Verdict.STABLE


def test_deeper_wedges_need_less_help():
    shallow = planned(niche(0.2), VAULT_FRICTION).counts  # with 0.02 ten times the work
    assert shallow["free"] + shallow["held"] + shallow["propped"] == 37
    assert shallow["free"] < 37
    deep = planned(niche(0.3), VAULT_FRICTION).counts
    assert deep.pop("support") == 15
    assert deep.pop("free") == 37
    assert not any(deep.values())


def test_no_block_is_propped_that_stands_without_at_all_of_its_stages():
    helped = plan(arch(0.3, 7), options=PlanOptions(rules=Rules(hands=1)), friction=0.4)
    assert helped.props
    evaluator = Evaluator(helped.model)
    for prop in helped.props:
        without = [
            Stage(step.placed, sum(1 << block for block in step.props if block != prop.block))
            for step in helped.steps[prop.first : prop.last + 1]
        ]
        assert not all(evaluator.answer(stage).stands for stage in without)
