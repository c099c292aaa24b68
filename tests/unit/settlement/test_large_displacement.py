"""Loads that grow, supports that move and friction that decays, followed by finite amounts."""

import json
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from scipy.optimize import brentq

import drystone
from drystone import Assembly, Block, InputError, LoadCase, Model
from drystone.answer import Role
from drystone.base.units import quantity
from drystone.cli import main
from drystone.models import arch, box, tower
from drystone.settlement import (
    Drive,
    End,
    LargeDisplacement,
    SettlementOptions,
    move_supports,
    push,
    reduce_friction,
)

Capsys = pytest.CaptureFixture[str]
BASE = box((3.0, 3.0, 1.0), (-1.0, -1.0, -1.0), "base")


def stack(count: int, width: float = 1.0, height: float = 2.0, scale: float = 1.0) -> Assembly:
    """Blocks one upon the other, on a wide base."""
    blocks = [box((width, 1.0, height), (0.0, 0.0, i * height), f"block-{i}") for i in range(count)]
    made = [one.transformed(scale * np.eye(3)) for one in (BASE, *blocks)]
    return Assembly(tuple(made)).with_fixed(["base"])


@pytest.fixture(scope="module")
def rocked() -> LargeDisplacement:
    """A block that is pushed over an edge."""
    return push(stack(1), friction=1.0)


def test_a_block_that_rocks_keeps_the_closed_form(rocked: LargeDisplacement) -> None:
    # about an edge at the angle theta: H / W = tan(alpha - theta), until theta = alpha
    found = rocked
    alpha = float(np.arctan(0.5))
    turned = np.array([state.positions[1, 4] for state in found.states])
    load = np.array([state.load for state in found.states])
    rocking = turned > 1e-4
    assert rocking.sum() > 50
    np.testing.assert_allclose(
        load[rocking], np.tan(alpha - turned[rocking]), atol=0.01 * np.tan(alpha)
    )
    assert found.end is End.SPENT
    assert found.peak == pytest.approx(0.5, rel=1e-4)
    assert turned[-1] == pytest.approx(alpha, rel=0.01)
    # the centroid stands over the edge, half a width on
    assert found.capacity == pytest.approx(0.5, rel=0.01)
    assert all(state.hinges == (0,) for state in found.states[-50:])


def test_a_block_that_slides_keeps_friction_times_weight() -> None:
    found = push(stack(1), friction=0.3, to=0.8)
    assert found.end is End.REACHED
    assert found.capacity is None
    slid = found.displacement > 1e-4
    np.testing.assert_allclose(found.load[slid], 0.3, rtol=1e-4)
    assert found[-1].sliding == (0,)
    np.testing.assert_allclose(found[-1].positions[1], [0.8, 0, 0, 0, 0, 0], atol=1e-4)


def test_a_push_ends_where_the_block_that_moves_farthest_has_gone_so_far() -> None:
    blocks = [box((9.0, 3.0, 1.0), (-1.0, -1.0, -1.0), "base"), box((1, 1, 1), (4, 0, 0), "stop")]
    blocks += [box((1, 1, 1), (0, 0, 0), "slides"), box((1, 1, 1), (3, 0, 0), "held")]
    model = Model.of(Assembly(blocks).with_fixed(["base", "stop"]), friction=0.3)
    found = push(model, to=0.02)
    assert found[-1].positions[2:, 0] == pytest.approx([0.02, 0.0], abs=1e-5)
    assert "followed until 'slides' had moved by 20 mm" in found.message


def test_a_push_goes_on_where_blocks_balance_and_would_not_stay() -> None:
    """A wall turns and pushes a plate w along a shelf, and presses it down by friction f.

    (f - a) w / (1 - f^2) slides it: 72 (1.5 a - 0.25) = 3 (f - a) 15 / (1 - f^2), a = 2/7.
    """
    blocks = [box((9, 2, 1), (-1, 0, -1), "base"), box((4, 2, 2.5), (2, 0, 0), "shelf")]
    blocks += [box((0.5, 2, 3), (0, 0, 0), "wall", density=2400.0)]
    blocks += [box((3, 2, 0.5), (0.5, 0, 2.5), "plate", density=500.0)]
    model = Model.of(Assembly(blocks).with_fixed(["base", "shelf"]), friction=0.5)
    found = push(model, to=1e-3)
    assert found.end is End.REACHED
    assert found.peak == pytest.approx(2.0 / 7.0, rel=1e-3)
    assert "at most 0.2855 at 56" in found.message


def test_two_blocks_rock_as_one_where_friction_holds_them_together() -> None:
    found = push(stack(2), friction=1.0)
    alpha = float(np.arctan(0.25))
    assert found.peak == pytest.approx(np.tan(alpha), rel=1e-4)
    assert found.capacity == pytest.approx(0.5, rel=0.01)
    # the upper one alone would need 0.5
    assert set(found.events()["joint"]) == {0}
    turned = np.array([state.positions[1:, 4] for state in found.states])
    np.testing.assert_allclose(turned[:, 0], turned[:, 1], atol=1e-4)


def test_lengths_scale_and_load_factors_stay(rocked: LargeDisplacement) -> None:
    large = push(stack(1, scale=20.0), friction=1.0)
    assert large.peak == pytest.approx(rocked.peak, rel=1e-6)
    assert large.capacity == pytest.approx(20.0 * rocked.capacity, rel=1e-3)


def test_a_load_on_one_block_has_its_own_displacement() -> None:
    assembly = stack(1)
    weight = 2.0 * 2400.0 * 9.81
    load = LoadCase.point_load(assembly, "block-0", (weight, 0.0, 0.0))
    found = push(assembly, load, friction=1.0)
    assert found.peak == pytest.approx(0.5, rel=1e-4)
    assert found.capacity == pytest.approx(0.5, rel=0.01)


class Spread(NamedTuple):
    """Half an arch on supports that move apart, between a crown hinge and one at a joint.

    Attributes
    ----------
    thrust : [N]
    margin : (j,)
        Where the thrust line crosses the joints below the crown, 0 at the intrados and 1 at the
        extrados.
    """

    thrust: float
    margin: np.ndarray


def spread(assembly: Assembly, joint: int, motion: float) -> Spread:
    """Statics of an arch of which three hinges are open: at the crown and at two joints.

    The crown is a hinge at the extrados, the joints are hinges at the intrados. Between them half
    an arch is a rigid body; what is below moves with its support. Source: Ochsendorf 2002,
    chapter 4.
    """
    middle = len(assembly) // 2  # the first block right of the crown
    blocks = assembly.blocks[middle:]
    crown = max(blocks[0].vertices, key=lambda v: (v[2], -v[0]))[[0, 2]]
    joints = []
    for one, after in pairwise(blocks):
        apart = np.linalg.norm(one.vertices[:, None] - after.vertices, axis=2).min(axis=1)
        shared = one.vertices[apart < 1e-9][:, [0, 2]]
        radius = np.linalg.norm(shared, axis=1)
        joints.append((shared[radius.argmin()], shared[radius.argmax()]))
    run = joints[joint - 1][0] - crown
    across = run[0] + 0.5 * motion
    fall = np.sqrt(run @ run - across**2)
    turn = np.arctan2(-fall, across) - np.arctan2(run[1], run[0])
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    # the upper part turns about the crown hinge; the lower one goes out, and the crown comes down
    lowered = np.array([0.5 * motion, -run[1] - fall])
    weight = 9.81 * assembly.mass[middle:-1]
    centre = assembly.centroid[middle:-1][:, [0, 2]] - crown
    centre = np.where(
        np.arange(len(weight))[:, None] < joint, centre @ rotation.T, centre + lowered
    )
    thrust = weight[:joint] @ (across - centre[:joint, 0]) / fall
    margin = []
    for number, ends in enumerate(joints, start=1):
        arm = np.array(ends) - crown
        arm = arm @ rotation.T if number <= joint else arm + lowered
        above = slice(number)
        inner, outer = (thrust * z - weight[above] @ (centre[above, 0] - x) for x, z in arm)
        margin.append(inner / (inner - outer))
    return Spread(float(thrust), np.array(margin))


def test_an_arch_on_spreading_supports_turns_about_three_hinges_and_falls_about_five() -> None:
    assembly = arch(0.12, 12)
    thrust = {joint: spread(assembly, joint, 0.0).thrust for joint in range(2, 6)}
    joint = max(thrust, key=lambda one: thrust[one])

    def beyond(motion: float) -> float:
        others = np.delete(spread(assembly, joint, motion).margin, joint - 1)
        return float(np.abs(others - 0.5).max() - 0.5)

    # it falls where the thrust line meets an edge of one more joint on each side
    last = float(brentq(beyond, 0.0, 0.1))
    right = {"springer-right": (1.0, 0.0, 0.0)}
    found = move_supports(assembly, right, to=0.1, friction=1.5)
    assert found.drive is Drive.SUPPORTS
    assert found.end is End.FALLS
    assert found.displacement[-1] == pytest.approx(last, rel=0.003)
    # crown and two joints as far from it, in the terms of contacts; at last both feet
    crown = len(assembly) // 2 - 1
    expected = {crown - joint, crown, crown + joint}
    held = [s for s in found.states if set(s.hinges) == expected and s.displacement > 1e-3]
    assert len(held) > 10
    for state in held:
        now = spread(assembly, joint, state.displacement).thrust
        assert state.load == pytest.approx(now, rel=0.01)
    first = found.load[found.displacement > 1e-3][0]
    assert first == pytest.approx(max(thrust.values()), rel=0.01)
    assert set(found[-1].hinges) == expected | {0, len(assembly) - 2}


def test_a_load_that_falls_at_once_through_zero_ends_there() -> None:
    # hinges change while nothing is driven: the load falls from 0.034 to -0.056 at 0.0428 m
    # of the voussoirs that move before
    found = push(arch(0.2, 16), friction=0.9)
    assert found.end is End.SPENT
    assert found.load[-2] > 0.0 >= found.load[-1]
    assert found.capacity == pytest.approx(0.0428, abs=2e-4)
    assert found.displacement[-2] <= found.capacity <= found.displacement[-1]


def test_a_vault_that_settles_on_four_hinges_is_pushed_until_one_closes_and_on() -> None:
    """Its symmetric hinges let it sway a few nanometres at no load, and less than none."""
    angle, blocks = np.linspace(np.pi, 0.0, 12), []
    for x, side in ((-3.7, "left"), (2.5, "right")):
        blocks.append(box((2.2, 1.0, 0.5), (x - 0.5, 0.0, -0.5), f"{side} ground"))
        blocks.append(box((1.2, 1.0, 4.0), (x, 0.0, 0.0), side))
    for i, ends in enumerate(pairwise(angle)):
        ring = [(r, a) for a in ends for r in (2.5, 2.85)]
        points = [(r * np.cos(a), y, 4.0 + r * np.sin(a)) for r, a in ring for y in (0.0, 1.0)]
        faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
        blocks.append(Block(np.array(points), faces, name=f"v{i}"))
    vault = Assembly(blocks, [one.name.endswith("ground") for one in blocks])
    found = push(vault)
    limit = drystone.limit_load(vault, LoadCase.seismic(vault, 1.0, 0.0)).stands
    assert found.peak == pytest.approx(limit, rel=1e-3)
    assert found.capacity > 0.01


def test_a_column_ends_where_it_tips_wherever_another_block_slid_before() -> None:
    """A block on a slope slides to a stop, 4 cm on; a column 4 cm wide tips when moved by 2 cm."""
    turn = np.array([[1.0, 0.0, 1.0], [0.0, np.sqrt(2.0), 0.0], [-1.0, 0.0, 1.0]]) / np.sqrt(2.0)
    slope = [
        box((6.0, 1.0, 0.5), (-1.0, 0.0, -0.5), "plane").transformed(turn),
        box((0.5, 1.0, 1.0), (2.0, 0.0, 0.0), "stop").transformed(turn),
        box((1.0, 1.0, 1.0), (0.97, 0.0, 0.0), "block").transformed(turn),
    ]
    column = box((0.04, 0.04, 1.6), (11.0, 1.0, 0.0), "column")
    ground = box((2.0, 2.0, 1.0), (10.0, 0.0, -1.0), "ground")
    blocks = Assembly((*slope, column, ground)).with_fixed(["plane", "stop", "ground"])
    found = push(blocks, friction=0.6)
    share = blocks.mass[3] / blocks.mass[[2, 3]].sum()  # of the mean displacement
    assert found.load[-2] > 0.0 >= found.load[-1]
    assert found.capacity == pytest.approx(0.02 * share, rel=0.01)


def test_friction_decays_to_the_slope(rocked: LargeDisplacement) -> None:
    # a block on a slope slides where the friction is the slope
    load = LoadCase.tilt(stack(1), (0.0, 1.0, 0.0), 15.0)
    found = reduce_friction(Model.of(stack(1), friction=0.6, load=load))
    assert found.end is End.FALLS
    assert found.load[-1] * 0.6 == pytest.approx(np.tan(np.deg2rad(15.0)), rel=0.01)
    still = reduce_friction(tower(2), friction=0.6)
    assert still.end is End.REACHED
    assert "without any friction" in still.message
    assert found.layers().stages[0].role is Role.BAD
    assert still.layers().stages[0].role is Role.GOOD
    assert rocked.message.endswith("it falls without this load")
    roles = [one.sentences()[0].role for one in (found, still, rocked)]
    assert roles == [Role.BAD, Role.GOOD, Role.UNSURE]  # the colours of the page
    assert [one.code for one in (found, still, rocked)] == [0, 0, 0]


def test_it_ends_early_and_says_so() -> None:
    late = push(stack(1), friction=1.0, time_limit_s=0.0)
    assert (late.end, late.stopped) == (End.STOPPED, "the time was up")
    calls = iter(range(10**6))
    some = push(stack(1), friction=1.0, stop=lambda: next(calls) > 60)
    assert (some.end, some.stopped) == (End.STOPPED, "it was interrupted")
    assert 2 < len(some.displacement) < 60
    few = push(stack(1), friction=1.0, options=SettlementOptions(step_limit=40))
    assert few.stopped == "40 steps were made"
    assert few.title == f"Push, ended early: at most {few.peak:.4g} at 16.1 µm"
    assert f"followed to {quantity(few.displacement[-1], 'm')}, where" in few.message
    told: list[tuple[str, int, int]] = []
    push(stack(1), friction=0.3, to=0.01, progress=lambda *one: told.append(one))
    assert told[-1] == ("pushing", 100, 100)


def test_what_does_not_stand_is_not_pushed() -> None:
    falls = Model.of(stack(1), friction=0.1, load=(1.0, 0.0, -1.0))
    found = push(falls)
    assert found.message == "it does not stand before the load grows"
    assert found.end is End.FALLS
    assert reduce_friction(falls).message == "it does not stand with all of its friction"


def test_bad_input_is_told() -> None:
    with pytest.raises(InputError, match="no force on a free block"):
        push(tower(2), LoadCase.point_load(tower(2), 1, (0.0, 0.0, 0.0)))
    with pytest.raises(InputError, match="the load that grows is zero"):
        push(tower(2), (0.0, 0.0, 0.0))
    with pytest.raises(InputError, match="to is -1"):
        push(tower(2), to=-1.0)
    with pytest.raises(InputError, match="no support moves"):
        move_supports(tower(2))
    with pytest.raises(InputError, match="'block-1' is not fixed"):
        move_supports(tower(2), {"block-1": (0.0, 0.0, 1.0)})
    with pytest.raises(InputError, match="no support moves"):
        move_supports(tower(2), {"block-0": (0, 0, 0, 0, 0, 0)})
    with pytest.raises(InputError, match="to is -1"):
        move_supports(tower(2), {"block-0": (0, 0, 1)}, to=-1.0)
    with pytest.raises(InputError, match="every block is fixed"):
        reduce_friction(tower(2).with_fixed([0, 1]))


@pytest.fixture(scope="module")
def short() -> LargeDisplacement:
    return push(stack(1), friction=0.3, to=0.01)


def test_it_is_a_table_a_frame_and_plain_values(short: LargeDisplacement, tmp_path: Path) -> None:
    assert repr(short).startswith("LargeDisplacement(load, ")
    assert "\n" not in repr(short)
    assert repr(short[-1]).endswith("load 0.3, 0 hinges, 1 sliding joint)")
    table = short.table()
    assert table.headings() == ["displacement [m]", "load"]
    assert len(short.to_pandas()) == len(short.displacement)
    told = json.loads(json.dumps(short.to_dict()))
    assert told["end"] == "as far as asked for"
    assert told["events"][0]["event"] == "slides"
    joints = short[-1].joints(short.assembly.names)
    assert joints["friction_use"][0] == pytest.approx(1.0, rel=1e-6)
    drystone.view.save_figure(short, tmp_path / "curve.svg")
    assert (tmp_path / "curve.svg").read_text(encoding="utf-8").startswith("<?xml")
    drystone.save_page(short, tmp_path / "page.html")
    assert "Load against displacement" in (tmp_path / "page.html").read_text(encoding="utf-8")


@pytest.fixture
def file(tmp_path: Path) -> str:
    path = tmp_path / "block.json"
    drystone.write(Model.of(stack(1), friction=0.3), path)
    return str(path)


def test_the_command_pushes_and_writes_the_curve(file: str, tmp_path: Path, capsys: Capsys) -> None:
    target = tmp_path / "curve.csv"
    assert main(["push", file, "--to", "0.01", "--csv", str(target), "--json"]) == 1
    told = json.loads(capsys.readouterr().out)
    assert told["peak"] == pytest.approx(0.3, rel=1e-4)
    assert target.read_text(encoding="utf-8").startswith("displacement [m],load\n")
    assert main(["push", file, "block-0:10000,0,0", "--to", "0.01"]) == 1
    out = " ".join(capsys.readouterr().out.split())
    assert "slides" in out
    load = "10000, 0, 0 N on 'block-0'"
    assert f"the load is {load} times the factor that is told" in out
    assert f"gravity, and {load} times a factor" in out
    assert main(["limit", "decay", file]) == 0
    assert "at rest without any friction" in " ".join(capsys.readouterr().out.split())
    assert main(["push", file, "--gravity", "9,0,-9"]) == 1
    assert "does not stand before the load grows" in capsys.readouterr().out
    assert main(["push", file, ""]) == 2
    assert "no load case is called ''" in capsys.readouterr().err


def test_settle_follows_supports_to_a_length(file: str, tmp_path: Path, capsys: Capsys) -> None:
    page = tmp_path / "page.html"
    asked = ["settle", file, "--move", "base:1,0,0", "--to", "0.01", "--html", str(page)]
    assert main([*asked, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["curve"]["displacement"][-1] == pytest.approx(0.01)
    assert "'base' moved by 1, 0, 0 m" in told["asked"]["load"]
    assert told["positions"]["blocks"]["block-0"][-1][0] == pytest.approx(0.01, rel=1e-3)
    assert page.exists()
    curve = tmp_path / "curve.csv"
    assert main([*asked[:4], "--to", "0.01", "--csv", str(curve), "--time-limit", "1e-9"]) == 1
    assert "time was up" in capsys.readouterr().out
    assert curve.read_text(encoding="utf-8").startswith("displacement [m],load [N]\n")
    for more, told in (
        (["--to", "1", "--joints", "a.csv"], "no table of joints"),
        (["--to", "1", "--corners", "a.csv"], "no table of joints"),
    ):
        assert main([*asked[:4], *more]) == 2
        assert told in capsys.readouterr().err
    assert main([*asked[:4], "--time-limit", "1e-9"]) == 1
    assert "time was up" in capsys.readouterr().out


def test_a_plank_falls_when_its_support_has_left_it() -> None:
    # the plank ends 0.6 m behind the edge of the support that goes away below it
    left, right = box((1, 1, 1), name="left"), box((1, 1, 1), (1.4, 0, 0), name="right")
    plank = box((1.4, 0.5, 0.2), (0.6, 0.2, 1.0), name="plank")
    model = drystone.Model.of(drystone.Assembly((left, right, plank)).with_fixed([0, 1]))
    found = move_supports(model.with_friction([0.9, 0.05]), {"right": (1.5, 0.0, 0.0)})
    assert found.end is End.FALLS
    assert found.capacity == pytest.approx(0.6, abs=0.01)
    assert found.fallen is not None
    assert found.fallen.positions[2, 4] > 1e-3  # it tips about the edge of the other one
    assert not found.fallen.positions[0].any()


def test_what_stands_beside_a_wall_that_overturns_has_no_part_in_its_displacement() -> None:
    beside = box((4.0, 4.0, 1.0), (5.0, 0.0, 0.0), "beside")
    base = box((12.0, 6.0, 1.0), (-1.0, -1.0, -1.0), "base")
    wall = box((0.6, 1.0, 3.0), (0.0, 0.0, 0.0), "wall")
    found = push(Model.of(Assembly((base, wall, beside)).with_fixed(["base"]), friction=0.8))
    assert found.capacity == pytest.approx(0.3, rel=0.02)
    assert found.capacity == pytest.approx(found.states[-1].positions[1, 0], rel=0.05)


def test_a_block_that_falls_at_once_from_another_leaves_the_curve_of_both() -> None:
    """Both turn by 0.065 rad: b alone then needs no more push than both, 0.0099.

    14.93 - 202 t kN m hold where 1 g turns by 170, about the foot of a; 3.93 - 54.6 t and 37.7,
    about that of b. The mean displacement is 1.8 sin t + 0.26 (1 - cos t).
    """
    blocks = box((0.6, 2.0, 2.0), (0, 0, 0), "a"), box((0.4, 2.0, 2.0), (0.2, 0, 2), "b")
    made = Assembly((BASE, *blocks)).with_fixed(["base"])
    load = LoadCase.point_load(made, "b", (3e3, 0.0, -8e3), (0.3, 1.0, 4.0))
    model = Model.of(made, friction=0.8)
    found = push(model.with_load(model.load + load), options=SettlementOptions(pace=6.0))
    assert found.end is End.SPENT
    assert found.capacity == pytest.approx(0.1176, rel=0.01)
