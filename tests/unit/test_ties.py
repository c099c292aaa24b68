"""Ties with a strength, in checks and limits: closed forms on both sides of each threshold."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import drystone
from drystone import Assembly, Block, InputError, Model, io
from drystone.base.arrays import lengths
from drystone.checks import mechanism_defects
from drystone.cli import main
from drystone.friction_use import spread_where_turned
from drystone.geometry.frames import rotations
from drystone.io.opening import as_model
from drystone.limits import LimitOptions, limit_shrink, limit_train
from drystone.loads import Fill
from drystone.loads.fill import Tops
from drystone.mechanics.bodies import build_bodies
from drystone.mechanics.corners import Carrier
from drystone.mechanics.increments import Increments
from drystone.mechanics.law import respond
from drystone.models import box, incline, segmental_bridge
from drystone.report import write_report
from drystone.seismic import local_mechanism
from drystone.settlement import End, Outcome, move_supports, push
from drystone.ties import joint_words, with_tie_words
from drystone.virtual import shrink, to_kern

G = 9.81


def held_on_a_slope(angle: float) -> Assembly:
    """A block on a slope, and a fixed anchor up the slope from its centroid."""
    plane, block = incline(angle).blocks
    away = np.array([-np.cos(np.radians(angle)), 0.0, np.sin(np.radians(angle))])
    anchor = box((0.2, 0.2, 0.2), block.centroid + 3.0 * away - 0.1, "anchor")
    return Assembly((plane, block, anchor), [True, False, True])


def tied_wall() -> Assembly:
    """A wall of 0.5 x 1 x 2 m on a base, and a fixed anchor beside it at half its height."""
    base = box((1.5, 1.0, 0.5), (-0.5, 0.0, -0.5), "base")
    wall = box((0.5, 1.0, 2.0), (0.0, 0.0, 0.0), "wall")
    anchor = box((0.2, 0.2, 0.2), (-2.0, 0.4, 0.9), "anchor")
    return Assembly((base, wall, anchor), [True, False, True])


def test_a_rod_holds_what_slides_up_to_its_strength() -> None:
    """A block of weight W slides where W sin(a) exceeds mu W cos(a) and the pull."""
    blocks, slope = held_on_a_slope(40.0), np.radians(40.0)
    needed = G * blocks.mass[1] * (np.sin(slope) - 0.5 * np.cos(slope))
    assert drystone.check(blocks, friction=0.5).falls
    assert drystone.check(blocks, friction=0.5, tie="block:anchor").stable
    weak = drystone.check(blocks, friction=0.5, tie=f"block:anchor:{0.99 * needed}N")
    assert weak.falls
    assert weak.message.startswith("ties yield: no contact forces within the strength of its ties")
    assert "the tie of 'anchor' and 'block' yields most" in weak.message
    strong = drystone.check(blocks, friction=0.5, tie=f"block:anchor:{1.01 * needed / 1e3}kN")
    assert strong.stable
    (ties,) = [one for one in strong.tables() if one.title == "ties"]
    assert ties["pull"][0] == pytest.approx(needed, rel=1e-6)
    assert ties["strength_use"][0] == pytest.approx(1.0 / 1.01, rel=1e-6)
    assert strong.strength_use[-1] == pytest.approx(1.0 / 1.01, rel=1e-6)
    assert strong.asked.ties == {"block:anchor": pytest.approx(1.01 * needed)}
    assert strong.asked.joint_capacity == {}


def test_a_tie_has_no_friction_whatever_the_joints_have() -> None:
    """Without the pull T the block needs ``mu = tan(a) - T / (W cos(a))``."""
    blocks, slope = held_on_a_slope(40.0), np.radians(40.0)
    expected = np.tan(slope) - 1000.0 / (G * blocks.mass[1] * np.cos(slope))
    model = Model.of(blocks, friction=0.9)
    found = drystone.limit_friction(model, tie="block:anchor:1kN")
    assert found.falls <= expected <= found.stands
    assert any("yielding governs" in one.text for one in found.sentences())
    assert found.stands - found.falls < 2e-3
    assert model.contacts.count == 1  # the input is not changed


def test_a_wall_and_its_tie_overturn_at_the_multiplier_of_the_kinematic_method() -> None:
    """Moments about the toe: ``a = b / h + T / W`` with a tie at half the height."""
    blocks, pull = tied_wall(), 4000.0
    weight = G * blocks.mass[1]
    expected = 0.5 / 2.0 + pull / weight
    tie = f"wall:anchor:{pull}N"
    hand = local_mechanism(blocks, part="wall", direction="x", tie=tie, friction=2.0)
    assert hand.oscillator.multiplier == pytest.approx(expected)
    for share, stands in ((0.98, True), (1.02, False)):
        found = drystone.check(
            blocks, friction=2.0, tie=f"wall:anchor:{pull}N", seismic=f"{share * expected},0"
        )
        assert (found.stable, found.falls) == (stands, not stands)
    all_of_it = local_mechanism(blocks, direction="x", tie=tie, friction=2.0)
    assert all_of_it.oscillator.multiplier == pytest.approx(expected, rel=1e-3)


def test_a_tie_between_two_points_holds_by_its_lever_arm() -> None:
    """Moments about the toe: ``a = b / h + T z / (W h / 2)``, pulled at z at the outer face."""
    blocks, pull = tied_wall(), 4000.0
    expected = 0.25 + pull * 1.9 / (G * blocks.mass[1])
    for share, stands in ((0.98, True), (1.02, False)):
        found = drystone.check(
            blocks,
            friction=2.0,
            tie=f"wall@500mm,500mm,1900mm:base@-3,0.5,1.9:{pull}N",
            seismic=f"{share * expected},0",
        )
        assert (found.stable, found.falls) == (stands, not stands)
        (drawn,) = (one for one in found.layers().stages[0].layers if one.key == "tie-forces")
        np.testing.assert_allclose(drawn.position[0] + drawn.vector[0], [0.5, 0.5, 1.9])
        assert drawn.vector[0] @ [1.0, 0.0, 0.0] == pytest.approx(np.linalg.norm(drawn.vector))
        assert drawn.label.startswith("a tie, which pulls" if stands else "a tie of 4 kN")


def prism(name: str, *corners: tuple[float, float]) -> Block:
    """A block of 1 m along y over corners (x, z) that run around y."""
    count = len(corners)
    ends = [[(x, y, z) for x, z in corners] for y in (0.0, 1.0)]
    sides = [(i, (i + 1) % count, (i + 1) % count + count, i + count) for i in range(count)]
    caps = (tuple(range(count))[::-1], tuple(range(count, 2 * count)))
    return Block(np.vstack(ends), (*caps, *sides), name)


def test_a_tie_between_springings_that_slide_takes_their_thrust() -> None:
    """A wedge of weight W and half-angle a drives them apart by ``W / (2 tan(a))`` on each side."""
    ground = box((8.0, 1.0, 0.2), (-4.0, 0.0, -0.2), "ground")
    left = [(-3.0, 0.0), (-3.0, 2.0), (-1.0, 2.0), (-0.2, 1.2), (-0.2, 0.0)]
    wedge = prism("wedge", (-1.0, 2.0), (1.0, 2.0), (0.0, 1.0))
    blocks = (ground, prism("left", *left), prism("right", *[(-x, z) for x, z in left[::-1]]))
    arch = Assembly((*blocks, wedge), [True, False, False, False])
    thrust = 0.5 * G * arch.mass[3]
    assert drystone.check(arch, friction=0.0).falls
    for share, stands in ((0.98, False), (1.02, True)):
        tie = f"left@-1,0.5,0.1:right@1,0.5,0.1:{share * thrust}N"
        found = drystone.check(arch, friction=0.0, tie=tie)
        assert (found.stable, found.falls) == (stands, not stands)
        if stands:
            (ties,) = [one for one in found.tables() if one.title == "ties"]
            assert ties["pull"][0] == pytest.approx(thrust, rel=1e-6)


def test_joints_that_crush_leave_a_tie_its_strength() -> None:
    blocks, slope = held_on_a_slope(40.0), np.radians(40.0)
    needed = G * blocks.mass[1] * (np.sin(slope) - 0.5 * np.cos(slope))
    how = {"friction": 0.5, "strength": "5MPa"}
    for tie, stands in (("", True), (f":{0.99 * needed}N", False), (f":{1.01 * needed}N", True)):
        found = drystone.check(blocks, tie=f"block:anchor{tie}", **how)
        assert (found.stable, found.falls) == (stands, not stands)


@pytest.mark.parametrize(
    ("tie", "words"),
    [
        ("block", "is no tie; write BLOCK:BLOCK:20kN"),
        ("block:nobody", "no block is called 'nobody'"),
        ("plane:anchor", "nothing is tied; name two blocks, one of them free"),
        ("block:block", "nothing is tied"),
        ("block@0,0,1:anchor@0,0,1:2kN", "has no length; give two different points"),
        ("block@0,0:anchor:2kN", "'0,0' is not three finite numbers"),
        ("block:anchor:0kN", "strength is 0kN; give a force above zero"),
        ("fill", "no load is fill that resists; give fill:cover=0.3m,weight=20kN/m3,passive=1"),
        ("block:anchor:5", "is not a number with a unit"),
        ("block:anchor:5kg", "unit 'kg' is not known"),
    ],
)
def test_what_is_no_tie_is_refused_in_one_line(tie: str, words: str) -> None:
    with pytest.raises(InputError, match="tie") as refused:
        drystone.check(held_on_a_slope(20.0), tie=tie)
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(("pull", "ends"), [(500.0, "wall:anchor"), (4000.0, "anchor:wall")])
def test_a_wall_that_is_pushed_keeps_the_strength_of_its_tie(pull: float, ends: str) -> None:
    """Moments about the toe at every angle: ``a = x / z + T / W``, the centroid at x before it."""
    blocks = tied_wall()
    more = pull / (G * blocks.mass[1])
    found = push(blocks, friction=5.0, tie=f"{ends}:{pull}N", to=0.6)
    assert found.peak == pytest.approx(0.25 + more, rel=1e-3)
    before = 0.25 - found.displacement
    height = np.sqrt(0.25**2 + 1.0 - before**2)
    moved = found.displacement > 0.01
    assert np.abs(found.load - before / height - more)[moved].max() < 2e-3
    # it falls where the centroid has passed the toe by as much as the tie holds back
    assert found.capacity == pytest.approx(0.25 + more * height[-1], rel=2e-2)


def test_a_rod_that_yields_lets_its_block_slide_and_one_that_does_not_holds_it() -> None:
    blocks, slope = held_on_a_slope(40.0), np.radians(40.0)
    needed = G * blocks.mass[1] * (np.sin(slope) - 0.5 * np.cos(slope))
    ends = [
        drystone.settle(blocks, friction=0.5, tie=f"block:anchor:{share * needed}N").outcome
        for share in (0.99, 1.01)
    ]
    assert ends == [Outcome.FALLS, Outcome.RESTS]


def test_a_rod_without_a_limit_is_as_stiff_as_its_plate() -> None:
    found = push(tied_wall(), (1.0, 0.0, 0.0), friction=2.0, tie="wall:anchor")
    assert found.end is End.HELD
    assert np.interp(1.0, found.load, found.displacement) < 1e-4


def test_an_anchor_that_moves_away_drags_a_block_or_draws_out_its_tie() -> None:
    """The block goes up the slope at ``W (sin a + mu cos a)``; what was drawn out stays so."""
    blocks, slope = held_on_a_slope(40.0), np.radians(40.0)
    up = np.array([-np.cos(slope), 0.0, np.sin(slope)])
    drags = G * blocks.mass[1] * (np.sin(slope) + 0.5 * np.cos(slope))
    for share, way in ((0.99, 0.0), (1.01, 0.05)):
        tie = f"block:anchor:{share * drags}N"
        found = move_supports(blocks, {"anchor": 0.05 * up}, friction=0.5, tie=tie)
        assert found.load[-1] == pytest.approx(-min(share, 1.0) * drags, rel=1e-3)
        assert found.states[-1].positions[1, :3] @ up == pytest.approx(way, abs=1e-4)


def test_a_tie_that_was_drawn_out_is_slack_on_the_way_back() -> None:
    """Of springs and positions alone: the blocks are put there and back."""
    blocks = Assembly((*tied_wall().blocks[1:],), [False, True])
    model = with_tie_words(Model.of(blocks), ["wall:anchor:4kN"])
    bodies = build_bodies(model, Carrier.MOVING, overlap=1e-6, tangential=0.1)
    followed, begin = Increments(bodies), Increments(bodies).pose
    most = 4000.0 / bodies.force_unit

    def pull_at(way: float) -> float:
        followed.place(begin.moved(bodies.free, np.array([[way, 0.0, 0.0, 0.0, 0.0, 0.0]])))
        response = respond(bodies.springs, followed.placed.gap, np.zeros((4, 2)))
        return float(response.force[:, 0].sum())

    limit = most / bodies.normal.sum()  # of the elastic way
    assert pull_at(0.5 * limit) == pytest.approx(0.5 * most)
    assert pull_at(5.0 * limit) == pytest.approx(most)
    assert pull_at(4.5 * limit) == pytest.approx(0.5 * most)
    assert pull_at(3.0 * limit) == 0.0
    assert pull_at(5.0 * limit) == pytest.approx(most)


def test_a_tie_acts_from_end_to_end_wherever_its_blocks_turn() -> None:
    """Its line goes through both ends, which stay on their blocks; it is as long as they are apart.

    A force that acts at one end on both blocks had another arm about the other, once that turned.
    """
    blocks = Assembly(tied_wall().blocks[1:], [False, False])
    ends = np.array([[0.1, 0.2, 1.6], [3.0, 0.4, 0.9]])
    named = [
        f"{name}@{','.join(map(str, at))}"
        for name, at in zip(("wall", "anchor"), ends, strict=True)
    ]
    for first, second in ((0, 1), (1, 0)):
        model = with_tie_words(Model.of(blocks), [f"{named[first]}:{named[second]}"])
        bodies = build_bodies(model, Carrier.MOVING, overlap=1e-6, tangential=0.1)
        followed, unit = Increments(bodies), bodies.length_unit
        moved = np.array([[0.2, -0.1, 0.3, 0.4, -0.2, 0.3], [-0.5, 0.1, 0.0, 0.1, 0.6, -0.3]])
        followed.place(followed.pose.moved(bodies.free, moved))
        turned = rotations(moved[:, 3:]) @ (ends - blocks.centroid)[..., None]
        there = (
            blocks.centroid - blocks.centroid.mean(axis=0) + unit * moved[:, :3] + turned[..., 0]
        )
        placed = followed.placed
        way = there - unit * placed.point.mean(axis=0)
        assert np.abs(np.cross(way, placed.axes[:, 0].mean(axis=0))).max() < 1e-2
        longer = np.diff(lengths(np.stack([np.diff(one, axis=0)[0] for one in (ends, there)])))
        assert -unit * placed.gap == pytest.approx(np.full(4, longer[0]), abs=1e-2)


def test_only_what_follows_blocks_knows_how_a_rod_yields() -> None:
    with pytest.raises(InputError, match="takes no strength of a tie"):
        drystone.solve_cra(held_on_a_slope(20.0), friction=0.5, tie="block:anchor:1kN")


def test_joints_that_shrink_leave_a_tie_its_strength() -> None:
    """A wall of half width b and weight W, with 0.2 W along x: W b s + T h = 0.3 W H / 2."""
    wall = tied_wall()
    weight, pull = G * wall.mass[1], 2000.0
    asked = {"friction": 0.6, "seismic": (0.3, 0.0)}
    found = limit_shrink(wall, **asked, tie=f"wall@0.25,0.5,1:anchor:{pull}N")
    needed = (0.3 * weight * 1.0 - pull * 1.0) / (0.25 * weight)
    assert found.stands >= needed >= found.falls
    contacts = with_tie_words(Model.of(wall), [f"wall:anchor:{pull}N"]).contacts
    for smaller in (shrink(contacts, 0.5, [0]), to_kern(contacts), shrink(contacts, 0.0, [1])):
        assert smaller.tie_strength == pytest.approx([np.inf, pull])


def test_equal_ties_share_a_pull_and_are_told_apart() -> None:
    """Two rods of one place carry 0.15 W each at the height of the middle of the wall."""
    wall = tied_wall()
    weight = G * wall.mass[1]
    needed = (0.5 * 0.3 * 2.0 - 0.25) * weight  # moments about the foot, 1 m below the rods
    for share, stands in ((0.49, False), (0.51, True)):
        tie = f"wall@0.25,0.5,1:anchor:{share * needed}N"
        found = drystone.check(wall, friction=0.6, seismic=(0.3, 0.0), tie=[tie, tie])
        assert found.stable is stands
        assert found.asked.ties == pytest.approx(
            {"wall:anchor": share * needed, "wall:anchor (2)": share * needed}
        )
        assert found.asked.joints == 3


def test_ties_of_blocks_whose_names_have_brackets_are_told_apart() -> None:
    base, _, anchor = tied_wall().blocks
    blocks = (base, box((0.5, 1.0, 2.0), (0.0, 0.0, 0.0), "wall (2)"), anchor)
    ties = ["wall (2):anchor:1kN", "wall (2):anchor:2kN"]
    found = drystone.check(Assembly(blocks, [True, False, True]), friction=0.6, tie=ties)
    told = {"wall (2):anchor": 1000.0, "wall (2):anchor (2)": 2000.0}
    assert found.asked.ties == pytest.approx(told)


@pytest.mark.parametrize("name", ["Basic wall:brick:1234", "w@1", "wall"])
def test_a_tie_finds_a_block_whose_name_has_colons_and_notes_an_end_beside_it(name: str) -> None:
    base, _, anchor = tied_wall().blocks
    named = box((0.5, 1.0, 2.0), (0.0, 0.0, 0.0), name)
    blocks = Assembly((base, named, anchor), [True, False, True])
    found = drystone.check(blocks, friction=0.6, tie=f"{name}@0.25,0.5,1:anchor@-5,0,1:3kN")
    assert found.asked.ties == {f"{name}:anchor": pytest.approx(3000.0)}
    assert not found.asked.notes
    off = drystone.check(blocks, friction=0.6, tie=f"anchor@-5,0,1:{name}@250,500,1000")
    assert f"m off block '{name}'" in off.asked.notes[0]


def test_what_resists_as_ties_is_not_said_to_be_left_out() -> None:
    bridge = segmental_bridge(voussoirs=6)
    load = "fill:cover=0.4m,weight=19kN/m3,k=0.3,passive=1.5"
    said = "what fill resists beyond k"
    assert any(said in note for note in as_model(bridge, load=load).notes)
    assert not any(said in note for note in as_model(bridge, load=load, tie="fill").notes)


def test_fill_is_told_whole_and_its_ties_in_one_line(tmp_path: Path) -> None:
    """What was given and what is assumed, in the name of the load; the ties are 6."""
    words = "cover=0.4,weight=19kN/m3,k=0.3,passive=1.5"
    bridge = segmental_bridge(voussoirs=6)
    told = "fill of 19 kN/m3 to 0.4 m above the crown with K 0.3, passive 1.5"
    name = f"gravity + {told} (a load spreads 0.5 by depth, evenly)"
    for tie in ((), ("fill",)):
        found = drystone.check(bridge, load=f"fill:{words}", tie=tie)
        assert found.asked.facts()["Load"] == name
        assert name in found.asked.line()
    ties = found.asked.facts()["Ties"]
    assert ties.startswith("fill: 6 horizontal ties of blocks 'voussoir-00', 'voussoir-01'")
    assert ties.count("fill") == 1
    write_report(found, tmp_path / "sheet.html")
    sheet = (tmp_path / "sheet.html").read_text(encoding="utf-8")
    assert told in sheet
    train = limit_train(found.model, steps=2, options=LimitOptions(equilibrium_only=True))
    assert told in train.sentences()[2].text + train.sentences()[3].text


def test_what_fill_resists_is_named_fill_and_carries_all_of_its_strength() -> None:
    bridge = segmental_bridge(voussoirs=6)
    load = "fill:cover=0.4m,weight=19kN/m3,k=0.3,passive=1.5"
    model = as_model(bridge, load=load, tie=["fill", "voussoir-02:springer-left:20kN"])
    assert model.contacts.of_fill.sum() == model.contacts.ties.sum() - 1
    found = drystone.check(model)
    named = found.asked.ties
    assert named["voussoir-02:springer-left"] == pytest.approx(20e3)
    (row,) = [one for one in found.tables() if one.title == "ties"]
    beside = row["block_b"] == "(fill)"
    told = {f"fill beside '{name}'" for name in row["block_a"][beside]}
    assert told == set(named) - {"voussoir-02:springer-left"}
    fill = Fill(cover=0.4, weight=19e3, k=0.3, passive=1.5)
    resisted = lengths(Tops.of(model.assembly, fill).resisting[:, :3])
    assert row["strength"][beside] == pytest.approx(resisted[resisted > 0.0], rel=1e-9)
    weak = found.contacts.of_fill & (found.contacts.block_b == bridge.indices(["voussoir-00"])[0])
    (at,) = np.flatnonzero(weak)
    assert joint_words(bridge, found.contacts, at)[1:] == ("fill beside 'voussoir-00'", "yields")


@pytest.mark.parametrize(
    ("tie", "loads"),
    [
        ("fill", {"load": "voussoir-08:216kN"}),
        ("fill", {"load": "voussoir-08:1000kN"}),
        ("fill", {"seismic": 1.2}),
        ("fill", {"seismic": -1.2}),
        ("voussoir-24:springer-right:40kN", {"load": "voussoir-08:300kN"}),
    ],
)
def test_ties_that_yield_are_proven_to_beyond_their_limit(tie: str, loads: dict[str, Any]) -> None:
    """Fill yields at 212.15 kN, and alone at 0.7346 g; blocks beside a springer hardly move."""
    load = [
        "fill:cover=0.4m,weight=20kN/m3,k=0.3,passive=1.5",
        *np.atleast_1d(loads.get("load", [])),
    ]
    found = drystone.check(
        segmental_bridge(5.0, 1.5), friction=0.6, **{**loads, "load": load}, tie=tie
    )
    assert found.falls
    assert found.message.endswith("yields most")
    assert found.mechanism is not None
    violation, power = mechanism_defects(found.model, found.mechanism)
    assert violation < 1e-5
    assert power > 1e-3


def test_ties_that_are_not_needed_may_have_no_strength() -> None:
    load = "fill:cover=0.4m,weight=19kN/m3,k=0.3,passive=1.5"
    limit = drystone.limit_strength(
        segmental_bridge(voussoirs=6), load=load, friction=0.6, tie="fill", seismic=0.1
    )
    assert limit.stands == 0.0


def test_inspect_takes_ties(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = str(tmp_path / "wall.json")
    io.write(tied_wall(), path)
    assert main(["inspect", path, "--tie", "wall:anchor:20kN"]) == 0
    assert "ties wall:anchor 20 kN" in capsys.readouterr().out
    assert main(["inspect", path, "--tie", "fill"]) == 2
    assert "tie fill: inspect takes no loads; ask 'drystone check'" in capsys.readouterr().err


def test_an_inspection_tells_the_ties_of_a_file(tmp_path: Path) -> None:
    model = with_tie_words(Model.of(tied_wall(), friction=0.6), ["wall:anchor:20kN", "wall:base"])
    io.write(model, tmp_path / "tied.json")
    assert io.inspect(tmp_path / "tied.json").notes == (
        "ties of the file: wall:anchor 20 kN, wall:base",
    )
    broken = json.loads((tmp_path / "tied.json").read_text("utf-8"))
    broken["contacts"]["block_a"][0] = 99
    (tmp_path / "broken.json").write_text(json.dumps(broken))
    assert io.inspect(tmp_path / "broken.json").notes == ()


def wall_before_another() -> Assembly:
    """A facade of 5 x 0.6 x 5 m; behind it, not bonded, a wall of 0.5 x 3 x 5 m; on a ground."""
    ground = box((8.0, 10.0, 1.0), (-1.0, -4.0, -1.0), "ground")
    facade = box((5.0, 0.6, 5.0), (0.0, 0.0, 0.0), "facade")
    return Assembly(
        (ground, facade, box((0.5, 3.0, 5.0), (2.0, 0.6, 0.0), "wall")), [True, False, False]
    )


@pytest.mark.parametrize(("share", "stands"), [(0.99, True), (1.01, False), (1.1, False)])
def test_a_wall_that_jams_by_friction_only_does_not_help_a_tie_that_yields(
    share: float, stands: bool
) -> None:
    """The facade overturns at a W h / 2 = W t / 2 + the moment of the tie, as if it were alone.

    Forces balance 1.22 times that: the wall behind would hold its back down by friction.
    """
    blocks, strength = wall_before_another(), 20e3
    weight, along = G * blocks.mass[1], np.array([5.0, -4.5]) / np.hypot(5.0, 4.5)
    moment = strength * (4.5 * along[0] - 0.6 * along[1])
    multiplier = (0.3 * weight + moment) / (2.5 * weight)
    tie = f"facade@2.5,0.6,4.5:ground@2.5,5.6,0:{strength}N"
    found = drystone.check(blocks, friction=0.6, seismic=(0.0, -share * multiplier), tie=tie)
    assert (found.stable, found.falls) == (stands, not stands)


def test_what_an_interruption_leaves_undecided_of_ties_says_so() -> None:
    """Stopped while it is followed by finite steps, as 44 to 374 of its questions are."""
    tie, left = "facade@2.5,0.6,4.5:ground@2.5,5.6,0:20kN", iter(range(80))
    model = as_model(wall_before_another(), friction=0.6, seismic=(0.0, -0.21), tie=tie)
    found = drystone.check(model, stop=lambda: next(left, None) is None)
    assert "is not known: it was interrupted after" in found.message
    assert found.stopped == "it was interrupted"


@pytest.mark.parametrize(("share", "stands"), [(0.99, True), (1.01, False), (1.1, False)])
def test_a_wall_that_jams_by_friction_only_does_not_help_a_foot_that_crushes(
    share: float, stands: bool
) -> None:
    """It turns about the middle of a stress block of width W / (f l): no verdict, as not known."""
    blocks, strength = wall_before_another(), 0.5e6
    multiplier = (0.3 - 0.5 * G * blocks.mass[1] / (strength * 5.0)) / 2.5
    shaken = (0.0, -share * multiplier)
    found = drystone.check(blocks, friction=0.6, seismic=shaken, strength=strength)
    assert found.stable == stands
    assert not found.falls


@pytest.mark.parametrize(("share", "stands"), [(0.99, True), (1.01, False)])
def test_columns_that_touch_do_not_help_one_that_crushes(share: float, stands: bool) -> None:
    """The foot carries f A, its own weight too: nothing presses the sides, so none rub there."""
    ground = box((5.0, 3.0, 1.0), (-1.0, -1.0, -1.0), "ground")
    columns = [box((1.0, 1.0, 2.0), (x, 0.0, 0.0), f"c{x}") for x in range(3)]
    blocks, strength = Assembly((ground, *columns), [True, False, False, False]), 0.2e6
    most = strength - G * blocks.mass[2]
    found = drystone.check(blocks, friction=0.6, load=f"c1:{share * most}N", strength=strength)
    assert found.stable == stands
    assert not found.falls


@pytest.mark.parametrize(("share", "stands"), [(0.65, True), (0.99, True), (1.01, False)])
def test_a_wall_with_two_ties_turns_about_a_stress_block(share: float, stands: bool) -> None:
    """a W h / 2 = W t / 2 + what the ties give - N^2 / (2 f l): 0.2685 g, once 0.1552."""
    ground, strength = box((20.0, 30.0, 1.0), (-5.0, -10.0, -1.0), "ground"), 0.12e6
    blocks = Assembly((ground, box((6.0, 0.5, 4.0), (0.0, 0.0, 0.0), "wall")), [True, False])
    weight, pull = G * blocks.mass[1], 40e3 * np.array([13.5, 3.5]) / np.hypot(13.5, 3.5)
    moment = 0.25 * weight + 3.5 * pull[0] + 0.5 * pull[1]
    moment -= 0.5 * (weight + pull[1]) ** 2 / (strength * 6.0)
    ties = [f"wall@{x},0.5,3.5:ground@{x},14,0:20kN" for x in (1, 5)]
    shaken = (0.0, -share * moment / (2.0 * weight))
    found = drystone.check(blocks, friction=0.6, seismic=shaken, tie=ties, strength=strength)
    assert found.stable == stands


def test_what_a_tie_beside_the_middle_does_not_hold_has_a_verdict() -> None:
    """The loads turn it about a vertical axis: points are spread over its faces on the way.

    Near the limit it settles by 3 mm: the rod swings, and holds it back by 5 N.
    """
    ground = box((4.0, 4.0, 1.0), (-1.0, -1.0, -1.0), "ground")
    lower, upper = box((1.0, 1.4, 0.5), (0, 0, 0), "a"), box((1.0, 1.4, 1.5), (0, 0, 0.5), "b")
    blocks = Assembly((ground, lower, upper), [True, False, False])
    tie = "b@1,0.2,1.8:ground@4,0.2,0:5kN"
    rests = drystone.check(blocks, friction=0.6, seismic=(0.0, 0.6193), tie=tie)
    assert rests.stable
    spread = spread_where_turned(rests.contacts, rests.resultants)
    assert spread is not None
    assert spread[0].rod[spread[0].ties] == pytest.approx(np.hypot(3.0, 1.8))  # no other rod
    assert drystone.check(blocks, friction=0.6, seismic=(0.0, 0.6196), tie=tie).falls
