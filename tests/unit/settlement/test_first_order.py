"""Supports that move: which way the load goes and which joints open."""

import numpy as np
import pytest

from drystone import (
    Assembly,
    InputError,
    JointCapacity,
    LoadCase,
    Verdict,
    check,
    limit_load,
    limit_tilt,
    plan,
    solve_rbe,
)
from drystone.limits import thrust_bounds
from drystone.model import Model
from drystone.models import arch, box, segmental_bridge, tower, wall
from drystone.settlement import (
    SupportResponse,
    SupportResponseOptions,
    support_forces,
    support_response,
)
from drystone.view.palette import first_preset, is_shown
from drystone.virtual import shift
from tests.oracle import touching_faces


def beam() -> Assembly:
    """A beam of 4 m on three equal supports."""
    feet = [box((0.2, 1.0, 0.2), (x, 0.0, 0.0), n) for n, x in (("a", 0), ("b", 1.9), ("c", 3.8))]
    return Assembly((*feet, box((4.0, 1.0, 0.2), (0.0, 0.0, 0.2), "beam"))).with_fixed(list("abc"))


def settled(assembly: Assembly, block: str, motion: tuple[float, ...]) -> SupportResponse:
    answer = support_response(Model(assembly, touching_faces(assembly, 0.6)), {block: motion})
    assert answer.result.verdict is Verdict.STABLE
    return answer


def reactions(answer: SupportResponse) -> list[float]:
    """Normal forces at the three feet, by the weight of the beam."""
    result = answer.result
    normal = result.resultants.normal
    weight = result.assembly.mass[result.assembly.free].sum() * 9.81
    return [float(normal[result.contacts.block_a == i].sum() / weight) for i in range(3)]


@pytest.mark.parametrize("drop", [-0.01, 0.01])
def test_settlement_changes_nothing_where_the_forces_are_determinate(drop: float) -> None:
    # two beams end to end over three supports, each on two knife edges
    feet = beam().blocks[:3]
    beams = [box((1.99, 1.0, 0.2), (x, 0.0, 0.2), f"beam-{x:g}") for x in (0.0, 2.01)]
    assembly = Assembly((*feet, *beams)).with_fixed(list("abc"))
    edges = shift(touching_faces(assembly, 0.6), (1.0, 0.0, 0.0), 0.0)
    answer = support_response(Model(assembly, edges), {"b": (0.0, 0.0, drop)})
    assert answer.result.verdict is Verdict.STABLE
    left = (1.99 - 0.995) / (1.99 - 0.2)
    right = (4.0 - 3.005) / (4.0 - 2.1)
    expected = [left, 1.0 - left + right, 1.0 - right]
    np.testing.assert_allclose(np.array(reactions(answer)) * 2.0, expected, atol=1e-6)
    assert len(answer.open_joints()) == 0


def test_a_stiff_beam_leaves_the_support_that_goes_down() -> None:
    answer = settled(beam(), "b", (0.0, 0.0, -0.01))
    assert reactions(answer) == pytest.approx([0.5, 0.0, 0.5], abs=1e-6)
    assert answer.open_joints().tolist() == [1]


def test_a_stiff_beam_rides_on_the_support_that_comes_up() -> None:
    answer = settled(beam(), "b", (0.0, 0.0, 0.01))
    assert reactions(answer) == pytest.approx([0.0, 1.0, 0.0], abs=1e-6)
    assert answer.open_joints().tolist() == [0, 2]


@pytest.mark.parametrize(("move", "which"), [(0.01, "least"), (-0.01, "most")])
def test_spreading_supports_bring_an_arch_to_its_least_thrust_and_closing_to_its_largest(
    move: float, which: str
) -> None:
    assembly = arch(0.2, 20)
    contacts = touching_faces(assembly, 0.7)
    bounds = thrust_bounds(Model(assembly, contacts), "springer-right", (1.0, 0.0, 0.0))
    answer = support_response(Model(assembly, contacts), {"springer-right": (move, 0.0, 0.0)})
    assert answer.result.verdict is Verdict.STABLE
    resultants = answer.result.resultants
    foot = contacts.block_b == assembly.index("springer-right")
    assert resultants.force[foot][0, 0] == pytest.approx(getattr(bounds, which), rel=2e-3)


def test_friction_of_a_settled_wall_is_coulomb_and_opposes_the_slide() -> None:
    assembly = wall(4, 4)
    answer = support_response(
        Model(assembly, touching_faces(assembly, 0.6)), {"c00-b01": (0.0, 0.0, -0.01)}
    )
    residuals = answer.result.residuals
    assert residuals is not None
    assert residuals.largest < 1e-6
    assert answer.result.utilisation.max() < 1.0 + 1e-6
    assert len(answer.open_joints()) > 0


def test_stiffness_tells_how_much_of_a_settlement_the_blocks_follow() -> None:
    whole = beam()
    contacts = touching_faces(whole, 0.6)
    soft = support_response(
        Model(whole, contacts),
        {"b": (0.0, 0.0, -0.01)},
        options=SupportResponseOptions(compliance=10.0),
    )
    # three springs of four corners each, stiffness 1 / 10 per corner, the middle one let down by 1
    assert reactions(soft)[1] == pytest.approx(1.0 / 3.0 - 2.0 / 3.0 * 4.0 / 10.0, abs=1e-6)


def test_a_motion_may_come_with_the_load_and_adds_to_the_one_that_is_named() -> None:
    whole = beam()
    contacts = touching_faces(whole, 0.6)
    case = LoadCase.gravity(whole) + LoadCase.settlement(whole, "b", (0.0, 0.0, -0.004))
    answer = support_response(Model(whole, contacts, case), {"b": (0.0, 0.0, -0.006)})
    assert answer.size == pytest.approx(0.01)
    assert reactions(answer) == pytest.approx([0.5, 0.0, 0.5], abs=1e-6)
    assert support_forces(answer.before)[:, 2].sum() == pytest.approx(0.8 * 2400.0 * 9.81)
    assert answer.change().sum(axis=0) == pytest.approx([0.0, 0.0, 0.0], abs=1e-3)


def test_every_other_analysis_refuses_a_load_that_moves_supports() -> None:
    whole = beam()
    contacts = touching_faces(whole, 0.6)
    case = LoadCase.gravity(whole) + LoadCase.settlement(whole, "b", (0.0, 0.0, -0.01))
    for ask in (
        lambda: check(Model(whole, contacts, case)),
        lambda: solve_rbe(Model(whole, contacts, case)),
        lambda: limit_tilt(Model(whole, contacts, case), "x"),
        lambda: limit_load(Model(whole, contacts), case),
        lambda: plan(Model(whole, contacts, case)),
    ):
        with pytest.raises(InputError, match="moves supports"):
            ask()


def test_joints_between_supports_neither_open_nor_slide() -> None:
    feet = [box((1.0, 1.0, 1.0), (x, 0.0, 0.0), f"foot-{x:g}") for x in (0.0, 1.0)]
    whole = Assembly((*feet, box((1.8, 1.0, 1.0), (0.0, 0.0, 1.0), "top"))).with_fixed([0, 1])
    answer = settled(whole, "foot-1", (0.0, 0.0, -0.01))
    names = [whole.names[answer.result.contacts.block_a[i]] for i in answer.open_joints()]
    assert names == ["foot-1"]
    assert len(answer.sliding_joints()) == 0


def test_a_joint_that_opens_little_by_the_motion_is_told() -> None:
    """A pier of a bridge goes down by 20 mm: four of six joints open by less than 5 % of that.

    The middle of a span opens by what both ends do together.
    """
    held = "springer-left-*,springer-right-*,pier-*-ground"
    bridge = segmental_bridge(spans=2, pier=1.2, height=4.0, voussoirs=6)
    answer = support_response(bridge, {"pier-1-ground": (0.0, 0.0, -0.02)}, supports=held)
    assert len(answer.open_joints(0.05)) == 2
    assert len(answer.open_joints()) == len(answer.open_joints(1e-4)) == 6
    most = [answer.opening[answer.contacts.interface == i].max() for i in answer.open_joints()]
    assert most[0] + most[1] == pytest.approx(most[2], rel=1e-3)
    told = " ".join(one.text for one in answer.sentences())
    for words in (
        "open: 6 by more than 100 µm",
        "widest by 1.48 mm",
        "to first order",
        "--to LENGTH",
    ):
        assert words in told


@pytest.mark.parametrize("voussoirs", [20, 60])
def test_the_hinges_of_an_arch_that_spreads_open_as_its_halves_turn(voussoirs: int) -> None:
    """Each half turns by half of the spread over the height between its hinges.

    Springs that press took up to six sevenths of it at the haunches, more of more voussoirs.
    """
    model = Model.of(arch(0.15, voussoirs), friction=0.7)
    answer = support_response(model, {"springer-right": (0.001, 0.0, 0.0)})
    rows = [np.flatnonzero(model.contacts.interface == i) for i in answer.open_joints()]
    assert len(rows) == 3
    edges = [
        model.contacts.point[own[[answer.opening[own].argmin(), answer.opening[own].argmax()]]]
        for own in rows
    ]
    turn = 0.0005 / (edges[1][0, 2] - edges[0][0, 2])
    opened = [float(answer.opening[own].max()) for own in rows]
    long = [float(np.hypot(*np.diff(one[:, [0, 2]], axis=0)[0])) for one in edges]
    assert opened == pytest.approx(np.array([1.0, 2.0, 1.0]) * turn * long, rel=0.01)


def test_a_settlement_is_drawn_with_its_joints_open() -> None:
    answer = settled(beam(), "b", (0.0, 0.0, -0.01))
    scene = answer.layers()
    assert scene.stages[0].headline == "Settled: 1 joint opens, by up to 10 mm"
    assert scene.stages[0].layers[-1].key == "opening"
    moved = answer.figure().assembly
    fall = moved.centroid[:, 2] - beam().centroid[:, 2]
    assert fall[1] == pytest.approx(-0.3 * np.median(beam().size))
    assert fall[[0, 2]] == pytest.approx([0.0, 0.0])
    assert fall[3] == pytest.approx(0.0, abs=1e-2 * abs(fall[1]))


def test_hinges_of_a_settlement_are_marked_on_the_moved_blocks() -> None:
    ring = arch(0.2, 12)
    answer = settled(ring, ring.names[-1], (0.03, 0.0, 0.0))
    scene = answer.figure()
    (marks,) = scene.stages[0].layers
    assert len(marks.position) == len(answer.open_joints()) == 3
    assert "the motion is drawn" in marks.label
    assert is_shown(marks, first_preset(scene))
    corners = np.concatenate([block.vertices for block in scene.assembly.blocks])
    edge = np.linalg.norm((corners - marks.position[:, None])[:, :, [0, 2]], axis=2).min(axis=1)
    assert edge.max() < 1e-3 * answer.size


def test_what_falls_on_the_way_of_a_support_has_not_settled() -> None:
    """A lintel loses its bearing of 100 mm by a motion that is small beside it."""
    posts = [box((0.5, 2.0, 1.0), (x, 0.0, 0.0), name) for x, name in ((0.0, "a"), (1.5, "b"))]
    lintel = box((1.2, 2.0, 2.0), (0.4, 0.0, 1.0), "lintel")
    model = Model.of(Assembly((*posts, lintel)).with_fixed(list("ab")))
    answer = support_response(model, {"b": (0.12, 0.0, 0.0)})
    assert answer.result.falls
    assert (answer.code, answer.to_dict()["verdict"]) == (1, "unstable")
    assert answer.title.startswith("Falls when the supports have moved by 1")


def test_what_turns_with_its_support_by_a_large_angle_stays_on_it() -> None:
    base, block = box((3, 3, 1), (-1, -1, -1), "base"), box((1, 1, 1), name="block")
    model = Model.of(Assembly((base, block)).with_fixed(["base"]), friction=0.8)
    angle = np.deg2rad(10.0)
    answer = support_response(model, {"base": (0.0, 0.0, 0.0, 0.0, angle, 0.0)})
    assert answer.model.assembly is model.assembly
    weight = 9.81 * model.assembly.mass[1]
    assert support_forces(answer.result)[0] == pytest.approx([0.0, 0.0, weight], abs=1e-3 * weight)
    assert answer.change() == pytest.approx(np.zeros((1, 3)), abs=1e-3 * weight)
    for moved in (answer.opening, answer.slide):
        assert moved == pytest.approx(np.zeros(4), abs=1e-4)
    joint = answer.result.joints()
    assert joint["friction_use"][0] == pytest.approx(np.tan(angle) / 0.8, rel=1e-2)


@pytest.mark.parametrize("kind", ["tension", "compression"])
def test_joints_that_carry_more_than_friction_are_refused(kind: str) -> None:
    model = Model.of(beam())
    glued = model.with_capacity(JointCapacity.of_stress(model.contacts, **{kind: 1e6}))
    with pytest.raises(InputError, match="takes dry joints only"):
        support_response(glued, {"b": (0.0, 0.0, -0.01)})


def test_without_weight_nothing_settles() -> None:
    case = LoadCase.settlement(beam(), "b", (0.0, 0.0, -0.01))
    with pytest.raises(InputError, match="nothing loads the free blocks"):
        support_response(Model(beam(), touching_faces(beam(), 0.6), case))


def test_a_structure_without_equilibrium_is_undecided() -> None:
    slope = tower(2).transformed([[0.6, 0.0, 0.8], [0.0, 1.0, 0.0], [-0.8, 0.0, 0.6]])
    answer = support_response(Model(slope, touching_faces(slope, 0.3)), {0: (0.0, 0.0, -0.01)})
    assert answer.result.verdict is Verdict.UNDECIDED
    assert "balance" in answer.result.message
    assert answer.title == answer.layers().stages[0].headline == answer.result.title
    assert answer.title.startswith("Not decided")


@pytest.mark.parametrize(
    ("motion", "words"),
    [
        ({"block-1": (0.0, 0.0, 1.0)}, "'block-1' is not fixed"),
        ({"block-0": (0.0, 0.0, 0.0)}, "no support moves"),
        ({"block-0": (0.0, 1.0)}, "does not have 3 or 6 numbers"),
        ({"other": (0.0, 0.0, 1.0)}, "no block is called"),
    ],
)
def test_motions_that_cannot_be_used_are_refused(motion, words) -> None:  # type: ignore[no-untyped-def]
    assembly = tower(2)
    with pytest.raises(InputError, match=words):
        support_response(Model(assembly, touching_faces(assembly, 0.6)), motion)
