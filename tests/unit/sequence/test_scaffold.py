"""Struts push, ropes pull, clamps do both within limits, centring carries a face."""

from dataclasses import replace
from functools import cache, partial

import numpy as np
import pytest

from drystone import Assembly, Block, LoadCase, Model, Verdict, check, models
from drystone.base.errors import InputError
from drystone.geometry.solid import distance
from drystone.models import arch, box
from drystone.sequence import (
    Centring,
    Clamp,
    PlanOptions,
    Rope,
    Rules,
    ScaffoldOptions,
    Strut,
    compare_scaffolding,
    plan,
    scaffolding,
    with_scaffold,
)
from drystone.sequence.evaluation import Evaluator
from drystone.sequence.helping import mended, trimmed
from drystone.sequence.order_search import OrderSearch
from drystone.sequence.rules import RemovalTest, bind
from drystone.sequence.scaffold_places import Support
from drystone.sequence.scaffold_seats import surface_triangles
from drystone.sequence.scaffold_stages import ScaffoldedStages
from drystone.sequence.stage_tree import Node
from drystone.sequence.stages import Stage, StagedModel, check_both, mask_of, members
from drystone.shells.shell_families import shell_by_name

PIER = box((1.0, 1.0, 1.0), name="pier")
SLAB = box((2.4, 1.0, 0.2), (0.0, 0.0, 1.0), name="slab")
SLAB_ON_PIER = Model.of(Assembly((PIER, SLAB), [True, False]), friction=0.6)
WEIGHT = -SLAB_ON_PIER.load.wrench[1, 2]
END = (2.4, 0.5, 1.0)


def held(*items):
    found = with_scaffold(SLAB_ON_PIER, items)
    return found, check(found.model)


def test_a_strut_pushes_up_by_the_lever_and_a_strut_from_above_does_not_pull():
    """About the pier's edge at x = 1: F 1.4 is W 0.2 at least."""
    assert check(SLAB_ON_PIER).verdict is Verdict.UNSTABLE
    whole, result = held(Strut("slab", head=END, foot=(2.4, 0.5, 0.0)))
    assert result.stable
    assert whole.force(result)[0] >= WEIGHT * 0.2 / 1.4 * (1 - 1e-6)
    assert whole.force(result)[0] <= WEIGHT * 1.2 / 2.4 * (1 + 1e-6)
    above, fallen = held(Strut("slab", head=(2.4, 0.5, 1.2), foot=(2.4, 0.5, 3.0)))
    assert fallen.verdict is Verdict.UNSTABLE
    assert above.model.assembly.names[-1] == "scaffold-000"


def test_a_rope_pulls_up_and_a_rope_from_below_does_not_push():
    whole, result = held(Rope("slab", at=(2.4, 0.5, 1.2), anchor=(2.4, 0.5, 5.0)))
    assert result.stable
    assert whole.force(result)[0] >= WEIGHT * 0.2 / 1.4 * (1 - 1e-6)
    assert held(Rope("slab", at=END, anchor=(2.4, 0.5, 0.0)))[1].verdict is Verdict.UNSTABLE


def test_a_limit_that_is_exceeded_is_told():
    strong = Strut("slab", 1e6, head=END, foot=(2.4, 0.5, 0.0))
    weak = Strut("slab", 0.1 * WEIGHT, head=END, foot=(2.4, 0.5, 0.0))
    assert held(strong)[0].overloaded(held(strong)[1]) == ()
    assert held(weak)[0].overloaded(held(weak)[1]) == (0,)


def test_a_clamp_holds_with_limited_force():
    """A block in the air needs its weight."""
    alone = Model.of(Assembly((PIER, box((1, 1, 1), (5, 0, 3), "b")), [True, False]), friction=0.6)
    weight = -alone.load.wrench[1, 2]
    for share, over in ((1.01, ()), (0.99, (0,))):
        found = with_scaffold(alone, [Clamp("b", share * weight)])
        result = check(found.model)
        assert result.stable
        assert found.force(result) == pytest.approx([weight])
        assert found.moment(result) == pytest.approx([0.0], abs=1e-6 * weight)
        assert found.overloaded(result) == over


def test_centring_carries_a_face_by_pressure_and_friction():
    face = np.array([(2.4, 0.0, 1.0), (1.4, 0.0, 1.0), (1.4, 1.0, 1.0), (2.4, 1.0, 1.0)])
    whole, result = held(Centring("slab", face=face, friction=0.6))
    assert result.stable
    assert whole.model.contacts.frame[-1, 0] == pytest.approx([0.0, 0.0, 1.0])


def test_a_strut_on_another_block_loads_it():
    """The foot stands on a free block, which feels the force."""
    low = box((0.4, 1.0, 0.4), (2.0, 0.0, 0.0), "low")
    base = box((4.0, 1.0, 0.2), (0.0, 0.0, -0.2), "base")
    model = Model.of(Assembly((PIER, SLAB, low, base), [True, False, False, True]), friction=0.6)
    strut = Strut("slab", head=(2.2, 0.5, 1.0), foot=(2.2, 0.5, 0.4), on="low")
    whole = with_scaffold(model, [strut])
    result = check(whole.model)
    assert result.stable
    contacts = whole.model.contacts
    bears = [i for i in range(contacts.count) if set(contacts[i].blocks) == {2, 3}]
    own = -model.load.wrench[2, 2]
    carried = result.resultants.normal[bears].sum()
    assert carried == pytest.approx(own + whole.force(result)[0], rel=1e-6)


WEAK = ScaffoldOptions(limit=450.0)


@pytest.fixture(scope="module")
def arch_plan():
    return plan(arch(0.3, 5), friction=0.6, options=PlanOptions(rules=Rules(hands=1)))


@pytest.mark.parametrize("support", ["strut", "rope", "clamp", "centring"])
def test_an_arch_is_built_with_what_holds_it_sideways(arch_plan, support):
    assert arch_plan.counts["propped"] > 0
    found = scaffolding(arch_plan, support)
    assert found.works
    assert found.moves == len(arch_plan.props)
    assert found.peak_force > 0.0
    assert found.metre_stages == pytest.approx(sum(found.stages["length"]))
    assert found.cost == pytest.approx(found.metre_stages + found.moves)


def test_weak_ropes_do_not_hold_a_crown_that_slides_sideways(arch_plan):
    found = scaffolding(arch_plan, "rope", options=WEAK)
    assert found.failed == (3, 4)
    assert len(found.propped) == 2
    assert found.most_at_once == 1
    assert "2 of 5 blocks propped, at most 1 at once" in found.sentences()[1].text


@pytest.fixture(scope="module")
def balanced_plan():
    """A slab that tips until a counterweight is on it."""
    weight = box((0.5, 1.0, 1.5), (0.0, 0.0, 1.2), "weight")
    model = Model.of(Assembly((PIER, SLAB, weight), [True, False, False]), friction=0.6)
    found = plan(model, options=PlanOptions(rules=Rules(hands=1)))
    assert found.order == ("slab", "weight")
    assert found.counts["propped"] == 1
    return found


def test_ropes_of_the_highest_block_have_a_length_where_their_anchors_are_not_above_it():
    stages = ScaffoldedStages(SLAB_ON_PIER, "rope", ScaffoldOptions(clear=0.0))
    whole, result = stages.result(placed=0b10, held=0b10)
    assert result.stable
    assert min(rope.length for rope in whole.items) >= 1e-3 * SLAB.size


@pytest.mark.parametrize("support", ["strut", "rope", "clamp", "centring"])
def test_a_slab_waits_for_its_counterweight_on_each_kind(balanced_plan, support):
    found = scaffolding(balanced_plan, support)
    assert found.works
    assert found.moves == 1
    assert found.peak_force > 0.0


@pytest.fixture(scope="module")
def over_a_step():
    """The slab over a loose step of 0.4 m, on which its struts can stand."""
    weight = box((0.5, 1.0, 1.5), (0.0, 0.0, 1.2), "weight")
    step = box((1.4, 1.0, 0.4), (1.0, 0.0, 0.0), "step")
    far = box((0.3, 1.0, 0.4), (3.0, 0.0, 0.0), "far")
    floor = box((4.0, 1.0, 0.2), (0.0, 0.0, -0.2), "floor")
    bodies = Assembly((PIER, SLAB, weight, step, far, floor), [True] + 4 * [False] + [True])
    return Model.of(bodies, friction=0.6)


def on_step(model, **options):
    scaffold_options = ScaffoldOptions(**options)
    rules = Rules(hands=1)
    return plan(
        model,
        options=PlanOptions(rules=rules, scaffold="strut", scaffold_options=scaffold_options),
    )


def test_struts_stand_on_a_named_block_that_is_placed_first_and_bears_them(over_a_step):
    found = on_step(over_a_step, foot="step")
    assert found.verdict is Verdict.STABLE
    assert found.order.index("step") < found.order.index("slab")
    made = scaffolding(found, "strut", options=ScaffoldOptions(foot="step"))
    assert made.works
    assert made.stages["length"][0] == pytest.approx(4 * 0.6)  # from its top to the slab
    below = scaffolding(found, "strut")  # it is what struts meet on their way down
    assert below.stages["length"][0] == pytest.approx(4 * 0.6)
    assert {item.on for item in below.items} == {"step"}


def test_a_strut_is_not_taken_where_its_foot_slides_or_it_is_too_long(over_a_step):
    first = [("far", "slab"), ("step", "slab")]
    found = plan(over_a_step, options=PlanOptions(rules=Rules(hands=1, before=first)))
    for options, words in (
        ({"foot": "far"}, "would slide: it leans"),
        ({"foot": "slab"}, "it does not stand on itself"),
        ({"foot": "step", "longest": 0.5}, "its strut is 0.6 m long, more than 0.5 m"),
        ({"foot": "none"}, "no block is called 'none'"),
    ):
        with pytest.raises(InputError, match=words):
            scaffolding(found, "strut", options=ScaffoldOptions(**options))


def test_struts_wait_for_the_block_that_they_stand_on(over_a_step):
    rules = Rules(hands=1, before=[("weight", "step")])
    given = ScaffoldOptions(foot="step")
    options = PlanOptions(rules=rules, scaffold="strut", scaffold_options=given)
    found = plan(over_a_step, options=options)
    assert found.verdict is not Verdict.STABLE
    assert any("on which struts stand, is not in place" in one.answer.message for one in found)
    assert "weight" not in found.message  # no prop was asked for there


def test_a_plan_without_any_strut_is_not_the_cheapest(over_a_step):
    options = ScaffoldOptions(longest=0.1)
    found = on_step(over_a_step, longest=0.1)
    assert found.verdict is not Verdict.STABLE
    made = scaffolding(found, "strut", options=options)
    assert not made.works
    assert [found.order[i - 1] for i in made.failed] == ["slab"]


def test_weak_struts_fail_and_a_table_compares(balanced_plan):
    weak = scaffolding(balanced_plan, "strut", options=ScaffoldOptions(limit=1.0))
    assert weak.failed == (1,)
    assert weak.stages["overloaded"].tolist() == [4]
    table = compare_scaffolding(
        balanced_plan.model.model, ["strut", "clamp"], ["top", "fewest-props"]
    )
    assert sorted(table["support"].tolist()) == ["clamp", "clamp", "strut", "strut"]
    assert table["failed_stages"].tolist() == [0, 0, 0, 0]
    assert table["cost"] == pytest.approx(table["metre_stages"] + table["moves"])
    assert table["cost"].tolist() == sorted(table["cost"].tolist())


def test_the_search_avoids_stages_that_one_sided_help_does_not_carry(arch_plan):
    """Ideal props carry the crown from one side; weak ropes do not."""
    model = arch_plan.model.model
    options = PlanOptions(rules=arch_plan.rules, scaffold="rope", scaffold_options=WEAK)
    found = plan(model, options=options)
    assert scaffolding(arch_plan, "rope", options=WEAK).failed
    assert found.verdict is Verdict.STABLE
    assert scaffolding(found, "rope", options=WEAK).works


def test_a_stage_that_no_scaffolding_within_its_limit_carries_is_told(arch_plan):
    options = PlanOptions(
        rules=arch_plan.rules, scaffold="strut", scaffold_options=ScaffoldOptions(limit=1.0)
    )
    found = plan(arch_plan.model.model, options=options)
    assert found.verdict is not Verdict.STABLE
    assert "could not be shown to stand, the first when" in found.message
    assert any("N, its limit is 1 N" in step.answer.message for step in found.steps)
    assert "a strut carries" in found.message


def test_what_stays_is_tried_with_other_contact_stiffnesses() -> None:
    found = plan(SLAB_ON_PIER, options=PlanOptions(anyway=True, scaffold="strut"))
    told = scaffolding(found, "strut").sentences()[-1].text
    assert told == "4 struts stay: with them the whole stands for 5 of 5 contact stiffnesses tried"
    assert "prop_goes" not in found.table().hidden


def test_what_stays_and_is_held_after_settling_only_is_told_so() -> None:
    """No contact stiffness holds the upper slab in place: it settles on its ropes."""
    slabs = (
        box((1.0, 1.0, 0.3), (0.6, 0.0, 1.0), "slab"),
        box((1.0, 1.0, 0.3), (1.2, 0.0, 1.3), "top"),
    )
    model = Model.of(Assembly((PIER, *slabs), [True, False, False]), friction=0.9)
    found = plan(model, options=PlanOptions(anyway=True))
    told = scaffolding(found, "rope", check=check).sentences()[-1].text
    assert told.startswith("16 ropes stay: with them the whole stands after settling: ")


def test_where_one_more_strut_does_not_carry_a_leaning_strip_all_that_falls_is_propped():
    """An ideal prop at the tip of half an arch holds all of it; a strut pushes and does not."""
    whole = shell_by_name("barrel", courses=12, blocks=1).model(friction=0.6)
    strip = whole.subset([i for i, name in enumerate(whole.assembly.names) if name < "c07"])
    model = StagedModel(strip, check_both)
    bound = bind(Rules(hands=1), model, RemovalTest(model))
    with Evaluator(model) as evaluator:
        given = (evaluator, bound, 40.0, 16)
        ideal = OrderSearch(*given, scaffold=ScaffoldedStages(strip, "strut"), carried=False)
        on_struts = OrderSearch(*given, scaffold=ideal.scaffold)
        complete = evaluator.answer(Stage(model.everything))
        order = trimmed(ideal.run(ideal.prop(Node(model.everything, 0), complete)), ideal)
        assert on_struts.failure(order.path[-1].placed, order.props[-1]) is not None
        found = mended(order, on_struts)
    assert not any(found.failures)
    assert found.cost == order.cost


def test_where_no_prop_carries_no_more_blocks_are_propped_than_with_ideal_props():
    """Else the search props one ring of neighbours after the other."""
    sizes = {"courses": 3, "width": 1.8, "thickness": 0.3, "wedge": 0.3, "ground": "springers"}
    model = shell_by_name("free-edge", **sizes).model(friction=0.6)
    options = PlanOptions(rules=Rules(hands=1, order="course"), patience=0.0)
    weak = replace(options, scaffold="strut", scaffold_options=WEAK)
    ideal, found = plan(model, options=options), plan(model, options=weak)
    assert found.counts["propped"] == ideal.counts["propped"] == 1
    assert "could not be shown to stand" in found.message


def test_a_stage_on_struts_that_a_look_finds_at_rest_is_followed_where_it_slides_far():
    """A wedge tilted by 41.5 degrees: it slides far, and the ends of its joints decide."""
    parts = models.wedge("b")
    assembly = Assembly((
        *parts.blocks,
        box((1.0, 1.0, 1.0), (6.0, 0.0, 0.0), "pier"),
        box((1.0, 0.5, 1.2), (6.0, -0.5, 0.0), "stop"),
        box((2.4, 1.0, 0.2), (6.0, 0.0, 1.0), "slab"),
    )).with_fixed(["left", "right", "pier", "stop"])  # fmt: skip
    load = LoadCase.tilt(assembly, (1.0, 0.0, 0.0), 41.5)
    stages = ScaffoldedStages(Model.of(assembly, friction=0.84, load=load), "strut")
    placed, held = (mask_of(assembly.indices(names)) for names in (["wedge", "slab"], ["slab"]))
    assert stages.answer(placed, held).stands
    answer = stages.answer(placed, held, followed=True)
    assert answer.verdict is Verdict.UNDECIDED
    assert "on strut: the ends of the joints decide" in answer.message


def test_a_stage_on_struts_that_a_look_leaves_open_is_followed_as_one_with_ideal_props_is():
    """A look at a ring that is begun finds no rest state with uniform stiffness; it falls."""
    sizes = {"courses": 5, "blocks": 12, "thickness": 0.4, "ground": "springers"}
    model = shell_by_name("dome", **sizes).model(friction=0.58)
    below = [name for name in model.assembly.names if "c01" <= name < "c03" and name != "c02-b05"]
    begun = [f"c03-b{number:02d}" for number in range(4)]
    placed, held = (
        mask_of(model.assembly.indices(names).tolist())
        for names in ([*below, *begun], ["c02-b04", "c03-b03"])
    )
    stages = ScaffoldedStages(model, "strut")
    assert stages.answer(placed, held).verdict is Verdict.UNDECIDED
    answer = stages.answer(placed, held, followed=True)
    assert answer.verdict is Verdict.UNSTABLE
    assert "on strut: forces could balance the loads" in answer.message
    assert "it falls: 'c03-b00'" in answer.message


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (
            lambda: Strut("slab", -1.0, head=END, foot=(2.4, 0.5, 0.0)),
            "limit is -1; give a number above zero",
        ),
        (lambda: Strut("slab", "5kN", head=END, foot=(2.4, 0.5, 0.0)), "limit is '5kN'"),
        (lambda: Strut("slab", head=END, foot=END), "it has no length"),
        (lambda: Strut("slab", head="top", foot=(2.4, 0.5, 0.0)), "head is 'top'"),
        (lambda: Strut("slab", head=(2.0, 0.5, 1.1), foot=(2.0, 0.5, 0.0)), "0.1 m away"),
        (
            lambda: Centring("slab", face=np.array([END, (2.0, 0.0, 0.0), (2.0, 1.0, 1.0)])),
            "1 m away",
        ),
        (lambda: Strut("slab", head=(50.0, 0.0, 1.0), foot=(50.0, 0.0, 0.0)), "47.6 m away"),
        (lambda: Strut("slab", head=END, foot=(2.4, 0.5, 0.0), on="slab"), "stands on the block"),
        (lambda: Rope("nothing", at=END, anchor=(0, 0, 9)), "nothing"),
        (lambda: Clamp("slab", moment=-3.0), "moment is -3; give a number above zero"),
        (lambda: Clamp("slab", moment=float("nan")), "moment is nan"),
        (lambda: Centring("slab"), "its face"),
        (lambda: "a stick", "give a list of items"),
    ],
)
def test_bad_items_are_refused(make, words):
    with pytest.raises(InputError, match=words):
        with_scaffold(SLAB_ON_PIER, [make()])


def test_a_kind_that_is_not_known_is_refused(arch_plan):
    with pytest.raises(InputError, match="'crane'; give one of 'strut', 'rope', 'clamp'"):
        scaffolding(arch_plan, "crane")


@pytest.mark.parametrize(("degrees", "faces"), [(25.0, 1), (40.0, 2)])
def test_centring_stops_a_block_below_where_its_face_is_steeper_than_friction(degrees, faces):
    """The angle of friction is 31 degrees."""
    turn = np.radians(degrees)
    about_y = np.array(
        [[np.cos(turn), 0, np.sin(turn)], [0, 1, 0], [-np.sin(turn), 0, np.cos(turn)]]
    )
    leaning = box((2.0, 1.0, 0.5), name="leaning")
    leaning = Block(leaning.vertices @ about_y.T + (5.0, 0.0, 3.0), leaning.faces, leaning.name)
    stages = ScaffoldedStages(Model.of(Assembly((PIER, leaning), [True, False])), "centring")
    whole, result = stages.result(placed=0b10, held=0b10)
    assert result.stable
    assert len(whole.items) == faces


SHELLS = {
    "barrel": {"courses": 5, "blocks": 2, "thickness": 0.6, "wedge": 0.2},
    "dome": {"courses": 3, "blocks": 6, "thickness": 0.5},
    "tri-dome": {"courses": 4, "width": 1.8, "thickness": 0.5, "keystone": True},
    "free-edge": {"courses": 4, "width": 1.8, "thickness": 0.3, "wedge": 0.2},
    "three-vaults": {"courses": 3, "width": 4.0, "thickness": 0.3, "wedge": -0.1},
}
"""Small shells: rows, rings, patches that meet, an edge without a support."""

FAMILIES = {
    "dome of slices": partial(models.dome, slices=6, rings=4),
    "lune": partial(models.lune, 0.1, rings=8, angle=20.0),
    "corbelled bridge": models.corbelled_bridge,
}
"""Small vaults that are no shells of a surface."""

TAKES = {
    "barrel": (12, 8, 12, 12, 12),
    "dome": (18, 12, 12, 18, 12),
    "tri-dome": (22, 22, 22, 22, 22),
    "free-edge": (16, 16, 16, 16, 16),
    "three-vaults": (27, 27, 27, 27, 27),
    "dome of slices": (18, 12, 18, 18, 18),
    "lune": (8, 1, 6, 8, 6),
    "corbelled bridge": (7, 7, 3, 7, 7),
}
"""Free blocks of each, and how many have a face for a strut, a rope, a clamp and centring."""


@pytest.mark.parametrize("surface", TAKES)
def test_every_item_touches_the_true_surface_of_the_blocks_of_a_shell(surface):
    """Faces are warped: their planes are centimetres away. An item off the surface is refused."""
    if surface in FAMILIES:
        model = Model.of(FAMILIES[surface](), friction=0.6)
    else:
        model = shell_by_name(surface, **SHELLS[surface], ground="blocks").model(friction=0.6)
    size = model.assembly.size
    told = [len(model.assembly.free)]
    surface_of = cache(lambda block: surface_triangles(model.assembly.blocks[block])[0])
    for kind in Support:
        stages = ScaffoldedStages(model, kind)
        made = {block: stages.items(block) for block in members(stages.takes)}
        with_scaffold(model, [item for items in made.values() for item in items])
        for block, items in made.items():
            for item in items:
                point = {"strut": "head", "rope": "at", "centring": "face"}.get(kind.value)
                if point is not None:
                    off = distance(np.reshape(getattr(item, point), (-1, 3)), surface_of(block))
                    assert off.max() < 1e-6 * size[block]
        told.append(len(made))
    assert tuple(told) == TAKES[surface]


def test_a_plan_is_kept_when_the_time_ends_while_its_scaffolding_is_tried():
    """Each call of ``stop`` is counted: those after the ideal plan's are of the scaffolding."""
    asked = []

    def planned(kind, most):
        asked.clear()
        options = PlanOptions(rules=Rules(hands=1), scaffold=kind)
        late = lambda: asked.append(None) or len(asked) > most  # noqa: E731
        return plan(arch(0.3, 5), friction=0.6, options=options, stop=late)

    ideal = planned(None, np.inf)
    before = len(asked)
    cut = planned("rope", before)
    assert (cut.order, cut.counts) == (ideal.order, ideal.counts)
    assert cut.message.endswith("before ropes were tried in place of ideal props")
