"""Plans of models whose answer is known."""

import numpy as np
import pytest

from drystone.assembly import Assembly
from drystone.base.errors import InputError
from drystone.detection import find_contacts
from drystone.model import Model
from drystone.models import (
    arch,
    box,
    bridge,
    buttressed_arch,
    corbelled_bridge,
    corbelled_wall,
    overhang,
    snake,
    tower,
)
from drystone.results import Verdict
from drystone.sequence import (
    Order,
    Plan,
    PlanOptions,
    Rules,
    Status,
    Structure,
    check_both,
    margins,
    plan,
    sweep_friction,
)


def planned(assembly: Assembly, friction: float = 0.6, **options: object) -> Plan:
    contacts = find_contacts(assembly, friction=friction).contacts
    return plan(Model(assembly, contacts), options=PlanOptions(**options))  # type: ignore[arg-type]


def test_a_stack_is_built_from_below_block_by_block():
    found = planned(tower(5))
    assert found.order == ("block-1", "block-2", "block-3", "block-4")
    assert found.counts["free"] == 4
    assert found.verdict is Verdict.STABLE
    assert found.proved
    assert found.drop == 0.0


def test_every_block_is_put_in_from_above_in_a_stack():
    found = planned(tower(3))
    for step in found.steps:
        np.testing.assert_allclose(step.motion, [[0.0, 0.0, -1.0]], atol=1e-12)


def test_an_arch_with_one_hand_needs_centring_under_all_but_springers_and_key():
    # bed joints of 7 voussoirs dip 0, 25.7, 51.4, 77.1 degrees; friction 0.4 holds 21.8
    found = planned(arch(0.3, 7), 0.4, rules=Rules(hands=1))
    status = dict(zip(found.model.assembly.names, found.status, strict=True))
    propped = {name for name, one in status.items() if one is Status.PROPPED}
    free = {name for name, one in status.items() if one is Status.FREE}
    assert len(propped) == 4
    assert {"voussoir-00", "voussoir-06"} < free
    assert found.order[-1] in free
    assert all(prop.force > 0.0 and prop.stages >= 1 for prop in found.props)
    assert found.verdict is Verdict.STABLE


def test_two_hands_spare_an_arch_some_centring():
    one = planned(arch(0.3, 7), 0.4, rules=Rules(hands=1))
    two = planned(arch(0.3, 7), 0.4, rules=Rules(hands=2))
    assert two.counts["propped"] < one.counts["propped"]
    assert two.counts["held"] > 0


def test_a_prop_of_one_block_carries_what_the_block_weighs():
    # a plank beside its support, on nothing: only a prop holds it until the cantilever's tail is on
    base = box((1.0, 1.0, 1.0), name="base")
    plank = box((2.0, 1.0, 0.2), (0.0, 0.0, 1.0), name="plank")
    tail = box((0.9, 1.0, 1.0), (0.0, 0.0, 1.2), name="tail")
    tip = box((0.2, 1.0, 0.2), (1.8, 0.0, 1.2), name="tip")
    model = Assembly((base, plank, tail, tip), np.array([True, False, False, False]))
    found = planned(model, rules=Rules(hands=1, before=[("tip", "tail")]))
    assert found.counts["propped"] == 1
    (prop,) = found.props
    assert prop.force > 0.0
    assert found.order[-1] == "tail"


def test_a_corbelled_wall_needs_no_help():
    found = planned(corbelled_wall(4, 3))
    assert found.counts["free"] == len(found.model.assembly.free)


def test_what_does_not_stand_is_not_planned_unless_asked():
    leaning = Assembly(
        (box((1.0, 1.0, 1.0), name="base"), box((1.0, 1.0, 1.0), (0.7, 0.0, 1.0), name="top")),
        np.array([True, False]),
    )
    refused = planned(leaning)
    assert refused.steps == ()
    assert refused.verdict is Verdict.UNSTABLE
    assert "does not stand" in refused.message
    assert "top" in refused.message
    anyway = planned(leaning, anyway=True)
    assert [prop.block for prop in anyway.props] == [1]
    assert "without its props" in anyway.message


def test_precedence_is_kept():
    model = Assembly(
        tuple(box((1.0, 1.0, 1.0), (1.5 * i, 0.0, z), name=f"{n}{i}")
              for n, z in (("base", 0.0), ("top", 1.0)) for i in range(3)),
        np.arange(6) < 3,
    )  # fmt: skip
    free = planned(model, rules=Rules(before=[("top2", "top0"), ("top0", "top1")]))
    assert free.order == ("top2", "top0", "top1")
    reach = planned(model, rules=Rules(reach=[["top1"], ["top2", "top0"]]))
    assert reach.order[0] == "top1"
    given = planned(model, rules=Rules(order=["top1", "top0", "top2"]))
    assert given.order == ("top1", "top0", "top2")


@pytest.mark.parametrize("order", list(Order))
def test_every_order_ends_with_every_block_placed(order):
    found = planned(corbelled_wall(3, 2), rules=Rules(order=order))
    assert sorted(found.order) == sorted(
        found.model.assembly.names[b] for b in found.model.assembly.free
    )
    assert found.verdict is Verdict.STABLE


@pytest.mark.parametrize(
    ("rules", "words"),
    [
        (Rules(before=[("block-1", "block-9")]), "no block is called 'block-9'"),
        (Rules(before=[("block-1", "block-2"), ("block-2", "block-1")]), "contradicts itself"),
        (Rules(before=[("block-1", "block-0")]), "which is a support"),
        (Rules(reach=[["block-1"], ["block-1"]]), "two groups"),
        (Rules(order=["block-1", "block-1"]), "twice"),
    ],
)
def test_contradictory_rules_are_refused_in_one_line(rules, words):
    with pytest.raises(InputError, match=words):
        planned(tower(3), rules=rules)


def test_a_block_too_heavy_for_all_hands_is_impossible():
    found = planned(tower(3), rules=Rules(hands=1, payload=1000.0))
    assert found.counts["impossible"] == 2
    assert "too heavy" in found.impossible[2]


def test_a_block_that_two_hands_carry_is_told():
    told = [one.text for one in planned(tower(3), rules=Rules(payload=1300.0)).sentences()]
    assert "2 hands carry one block: block-1, block-2; up to 2400 kg, payload 1300 kg" in told
    able = planned(tower(3), rules=Rules(payload=2500.0)).sentences()
    assert not any("hands carry" in one.text for one in able)


def test_a_plan_is_neither_true_nor_false():
    with pytest.raises(TypeError, match="verdict"):
        bool(planned(tower(2)))


def test_hands_that_can_lift_next_to_nothing_place_nothing():
    found = planned(tower(3), rules=Rules(payload=1e-300))
    assert found.counts["impossible"] == 2
    assert "too heavy" in found.impossible[1]


def test_a_small_plan_that_needs_help_is_proved_with_the_usual_patience():
    quick, best = (
        planned(arch(0.3, 7), 0.4, rules=Rules(hands=1), patience=patience)
        for patience in (None, float("inf"))
    )
    assert len(quick.props) == len(best.props) == 4
    assert quick.proved
    assert best.proved
    assert not planned(arch(0.3, 7), 0.4, rules=Rules(hands=1), patience=1.0).proved


def test_props_that_stay_for_good_are_not_proved_to_be_the_fewest():
    # each of two planks beyond its support needs a prop
    blocks = [box((1.0, 1.0, 1.0), (0.0, y, 0.0), f"base-{y}") for y in (0, 2)]
    blocks += [box((1.0, 1.0, 0.2), (0.6, y, 1.0), f"plank-{y}") for y in (0, 2)]
    two = Assembly(tuple(blocks), np.array([True, True, False, False]))
    found = planned(two, anyway=True, patience=float("inf"))
    assert found.counts["propped"] == 2
    assert not found.proved
    assert planned(two.without(["plank-2"]), anyway=True).proved


def test_what_stands_alone_is_not_placed_together():
    # the key of this bridge slides out, but its arms lie flat, each block on the one below
    found = planned(corbelled_bridge(), 0.1, anyway=True)
    assert found.counts["held"] == 0
    assert found.counts["free"] == 6
    assert [found.model.assembly.names[prop.block] for prop in found.props] == ["key"]


def test_a_stage_of_a_small_pile_is_checked_and_not_only_looked_at():
    # a quick look finds no rest state of half of these stages, and does not tell which blocks fall
    corners = [
        ((-4.0, -1.0, -0.5), (4.0, 3.0, 0.0)),
        ((-0.88, 0.72, 0.0), (-0.08, 1.51, 0.32)),
        ((-0.16, 0.66, 0.32), (0.6, 1.54, 0.71)),
        ((-0.74, 0.62, 0.71), (1.19, 1.51, 1.14)),
        ((-1.85, 0.57, 1.14), (0.09, 1.54, 1.46)),
        ((-0.78, 0.53, 1.46), (0.86, 1.55, 1.96)),
    ]
    blocks = [
        box(tuple(np.subtract(high, low)), low, f"b{i}") for i, (low, high) in enumerate(corners)
    ]
    pile = Assembly(tuple(blocks), np.arange(6) == 0)
    quick, best = (
        planned(pile, 0.2, rules=Rules(hands=1), patience=patience)
        for patience in (None, float("inf"))
    )
    assert len(quick.props) == len(best.props) == 2


def test_blocks_are_propped_after_a_check_and_not_after_a_quick_look():
    found = planned(arch(0.3, 26), 0.6)
    assert found.stable
    assert len(found.props) <= 9  # 13 where a quick look decides


def needs(found: Plan) -> tuple[int, int]:
    """Props, and blocks that are placed together with another one."""
    return len(found.props), sum(len(step.blocks) - 1 for step in found.steps)


@pytest.mark.parametrize("friction", [0.66, 0.9, 1.0])
def test_the_bridge_is_checked_in_full_before_help_is_given(friction):
    # a quick look finds no rest state of some of its stages, and the check does
    found = planned(bridge(), friction)
    assert found.counts["free"] == 9
    assert found.proved


def test_states_without_help_are_tried_for_longer():
    # each counts a third of a state with help
    model = Model.of(bridge(load=True), friction=0.34)
    some = [name for name in model.assembly.names if name not in LATER]
    found = plan(model.subset(some), options=PlanOptions(patience=12.0))
    assert needs(found) == (0, 0)


LATER = ("load-12", "load-13", "load-14", "block-9", "block-10")
"""Blocks that are placed last, and free, in every plan of the loaded bridge."""


def test_structures_that_do_not_touch_need_what_each_needs_alone():
    bodies, fixed = list(bridge().blocks), bridge().fixed.tolist()
    for number in range(2):
        stack = tower(9)
        for block in stack.blocks:
            moved = block.transformed(None, (20.0 + 3.0 * number, 0.0, 0.0))
            bodies.append(moved.renamed(f"{number}-{block.name}"))
        fixed += stack.fixed.tolist()
    found = planned(Assembly(tuple(bodies), fixed=fixed), 0.66)
    assert found.counts["free"] == 9 + 8 + 8


def test_an_order_of_the_user_in_which_every_stage_stands_needs_no_help():
    order = [f"block-{i}" for i in (3, 2, 5, 7, 4, 6, 8, 9, 10)]
    found = planned(bridge(), 0.66, rules=Rules(order=order))
    assert found.order == tuple(order)
    assert needs(found) == (0, 0)
    assert found.message == "every stage stands"


def test_blocks_that_an_imposed_order_does_not_name_follow_in_the_default_order():
    given = ["block-3", "block-2", "block-5"]
    found = planned(bridge(), 0.6, rules=Rules(order=given))
    assert list(found.order[:3]) == given
    assert needs(found) == (0, 0)
    assert found.message.startswith("every stage stands")


def test_an_imposed_order_that_cannot_be_kept_is_told():
    found = planned(tower(3), rules=Rules(order=["block-2", "block-1"]))
    assert found.order == ("block-1", "block-2")
    assert found.message == (
        "every stage stands; the given order is not kept: 'block-1' is placed before 'block-2'"
    )


def test_an_imposed_order_that_needs_help_without_need_is_told():
    order = [f"block-{i}" for i in (10, 9, 8, 6, 4, 7, 5, 2, 3)]
    model = Model.of(bridge(), friction=0.6)
    found = plan(model, options=PlanOptions(patience=1.0, rules=Rules(order=order)))
    assert any(found.help)
    assert "a plan without help exists in another order" in found.message


@pytest.mark.parametrize("make", [lambda: (arch(0.3, 9), 0.6), lambda: (arch(0.3, 7), 0.4)])
def test_no_order_needs_fewer_held_blocks_than_a_proved_plan(make):
    assembly, friction = make()
    found = planned(assembly, friction)
    others = [planned(assembly, friction, rules=Rules(order="course"))]
    others.append(planned(assembly, friction, patience=float("inf")))
    assert all(found.help <= one.help for one in others)
    assert found.proved


@pytest.mark.parametrize(("blocks", "patience"), [(9, 2.0), (13, 10.0)])
def test_less_help_is_searched_below_a_first_order(blocks, patience):
    # the first order props a block more: after its patience it gives help without looking back
    rules = Rules(hands=3)
    found = planned(arch(0.3, blocks), 0.5, rules=rules, patience=patience)
    assert not found.proved
    assert found.help == planned(arch(0.3, blocks), 0.5, rules=rules).help
    assert found.verdict is Verdict.STABLE


def test_no_hands_are_refused_at_once():
    with pytest.raises(InputError, match="payload is 0; give a number above zero"):
        Rules(payload=0.0)
    with pytest.raises(InputError, match="give 1 or more"):
        Rules(hands=0)


@pytest.mark.parametrize(
    ("assembly", "frictions"),
    [
        (bridge(), (0.35, 0.5)),  # more friction: above
        (arch(0.3, 7), (0.3, 0.4, 0.5, 0.84)),
        (snake(), (0.66, 0.84, 1.0)),
        (buttressed_arch(voussoirs=7, courses=3), (0.34, 0.5, 0.84)),
        (corbelled_bridge(), (0.34, 0.66, 1.0)),
    ],
)
def test_what_a_plan_needs_does_not_grow_with_friction(assembly, frictions):
    help_at = [needs(planned(assembly, friction)) for friction in frictions]
    assert help_at == sorted(help_at, reverse=True)


def test_a_step_that_needs_help_tells_why():
    found, standing = planned(arch(0.3, 7), 0.4), set()
    for step in found.steps:
        new = set(step.props) - standing
        standing = set(step.props)
        assert ("without help" in step.why) == (len(step.blocks) > 1 or bool(new))
    told = {one["block"]: one["why"] for one in found.to_dict()["blocks"]}
    assert all(told[name] for name in ("voussoir-02", "voussoir-03"))


def test_a_plan_says_its_first_word_before_anything_is_checked():
    said = []

    def spy(model, **how):
        said.append("check")
        return check_both(model, **how)

    plan(Model.of(tower(4)), check=spy, progress=lambda what, *_: said.append(what))
    assert said[:2] == ["planning", "check"]


def test_a_plan_that_is_stopped_keeps_the_verdict_of_the_complete_structure():
    asked = []
    found = plan(Model.of(tower(4)), stop=lambda: bool(asked.append(1)) or len(asked) > 1)
    assert found.complete.stands
    assert found.steps == ()
    assert found.stopped == "it was interrupted"
    assert "before an order was found" in found.message
    assert found.verdict.value == "undecided"
    late = plan(Model.of(tower(4)), time_limit_s=0.0)
    assert (late.complete.stands, late.stopped) == (True, "the time was up")


@pytest.mark.parametrize("order", [Order.TOP, Order.COURSE])
def test_a_plan_with_scaffolding_that_is_stopped_keeps_the_blocks_placed_last(order):
    model, done = Model.of(arch(0.3, 9), friction=0.4), []
    found = plan(
        model, options=PlanOptions(rules=Rules(hands=1, order=order), scaffold="strut"),
        progress=lambda _stage, blocks, _all: done.append(blocks), stop=lambda: 3 in done,
    )  # fmt: skip
    assert (found.steps, found.stopped) == ((), "it was interrupted")
    *_, last = found.ends_with
    propped = [name for name in last["propped"] if name not in last["blocks"]]
    left = [name for step in found.ends_with for name in step["blocks"]]
    assert 0 < len(left) < 9
    assert f"the last {len(left)} of 9 blocks are known" in found.message
    others = [name for name in model.assembly.names if name not in last["blocks"]]
    assert Structure(model).stands(others, held=propped).verdict is Verdict.STABLE
    assert found.to_dict()["ends_with"] == found.ends_with
    assert [len(table) for table in found.tables()] == [len(found.ends_with)]


def test_a_plan_that_is_stopped_while_less_help_is_searched_for_is_kept():
    told = []
    found = plan(
        arch(0.3, 7), friction=0.4, options=PlanOptions(patience=4.0),
        progress=lambda what, *_: told.append(what),
        stop=lambda: "searching for less help" in told,
    )  # fmt: skip
    assert "searching for less help" in told
    assert len(found.order) == 7
    assert found.stable
    assert not found.proved
    assert found.message.endswith("interrupted before less help was searched for to the end")


def test_a_plan_is_its_steps():
    found = plan(tower(4))
    assert len(found) == 3
    assert [step.blocks for step in found] == [step.blocks for step in found.steps]


def test_a_friction_of_a_sweep_whose_plan_was_stopped_is_left_out():
    def plan_at(model):
        return plan(model, stop=lambda: model.contacts.friction[0] > 0.45)

    sweep = sweep_friction(Model.of(tower(4)), [0.4, 0.5], plan_at)
    assert sweep.friction == (0.4,)


def test_margins_that_are_stopped_keep_the_stages_that_are_known():
    found = plan(Model.of(tower(4)))
    asked = []
    some = margins(found, stop=lambda: bool(asked.append(1)) or len(asked) > 1)
    assert some.stopped == "it was interrupted"
    assert len(some.stages) == 3
    assert some.stages[0] == margins(found).stages[0]
    assert np.isnan([one.tilt for one in some.stages[1:]]).all()
    assert some.weakest == 0
    sweep = sweep_friction(Model.of(tower(2)), [0.4, 0.5], plan, stop=lambda: True)
    assert (sweep.friction, sweep.plans) == ((), ())


def test_a_plan_whose_stages_were_only_looked_at_says_so(monkeypatch):
    for module in ("planner", "stages"):
        monkeypatch.setattr(f"drystone.sequence.{module}.CHECKED", 7)
    assert planned(tower(2)).message == "every stage stands"  # 4 corners
    assert planned(tower(3)).message == (
        "every stage stands with uniform contact stiffness; above 7 corners a stage is only looked "
        "at, and not followed (--thorough, or check=check_both in Python, checks it)"
    )
    contacts = find_contacts(tower(3), friction=0.6).contacts
    assert plan(Model(tower(3), contacts), check=check_both).message == "every stage stands"


def test_no_number_of_hands_is_advised_that_no_plan_was_found_with():
    found = planned(arch(0.3, 7), 0.4, rules=Rules(hands=1))
    assert found.props
    assert not [one.text for one in found.sentences() if "without props it takes" in one.text]


def test_a_step_that_ends_exactly_on_an_edge_says_so():
    found = plan(overhang([0.25, 0.5]), friction=0.6)
    assert [*found.on_edge] == [1]
    words = "the margin is zero: 'brick-01' stands exactly above an edge of its joint with"
    assert any(words in one.text for one in found.sentences())
    assert found.title == "Can be assembled without help, 1 step without margin"
    assert found.table()["margin"].tolist() == ["", "zero"]
    assert words in found.numbers()["steps"][1]["on_edge"]
    assert words in found.layers().stages[1].message
    assert not plan(overhang([0.2, 0.4]), friction=0.6).on_edge


def test_a_plan_of_one_step_says_step():
    assert plan(tower(2)).told == "1 step: 1 free, 0 held, 0 propped"
