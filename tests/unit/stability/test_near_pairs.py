"""A proof of falling never rests on a pair of blocks that is near and was not joined."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drystone import (
    Assembly,
    Block,
    InputError,
    Model,
    Verdict,
    check,
    limits,
    plan,
    save_figure,
    settle,
    solve_rbe,
)
from drystone.answer import Role
from drystone.detection import DetectionOptions
from drystone.detection.tolerances import Reason
from drystone.models import box, stool, tower


def above(gap: float, second: float = 0.0) -> Assembly:
    """A cube above a cube, and a third one above both."""
    blocks = (
        box((1, 1, 1), name="base"),
        box((1, 1, 1), (0, 0, 1 + gap), name="middle"),
        box((1, 1, 1), (0, 0, 2 + gap + second), name="top"),
    )
    return Assembly(blocks).with_fixed([0])


def test_a_block_that_hangs_near_another_is_undecided_and_the_option_is_named() -> None:
    found = check(above(0.02))
    assert found.verdict is Verdict.UNDECIDED
    assert "'base' and 'middle' are 20 mm apart" in found.message
    assert "--gap 0.021" in found.message
    assert not found.falling
    assert found.mechanism is None


def test_no_plan_and_no_limit_takes_a_near_pair_for_a_fall() -> None:
    found = plan(above(0.02))
    assert found.complete.verdict is Verdict.UNDECIDED
    assert "'base' and 'middle' are 20 mm apart" in found.message
    told = limits.limit_tilt(above(0.02)).sentences()[0]
    assert told.role is Role.UNSURE
    assert "'base' and 'middle' are 20 mm apart" in told.text


def test_a_near_pair_that_has_no_part_in_a_fall_leaves_the_limit_decided() -> None:
    leaning = box((1.0, 1.0, 0.2), (0.7, 0.0, 1.0), "leaning")
    apart = box((0.2, 0.2, 0.2), (5.0, 0.0, 0.0)), box((0.2, 0.2, 0.2), (5.0, 0.0, 0.202), "near")
    model = Assembly((box((1.0, 1.0, 1.0), name="base"), leaning, *apart)).with_fixed([0, 2, 3])
    assert check(model, friction=0.7).falls
    limit = limits.limit_tilt(model, friction=0.7)
    assert limit.sentences()[0].role is Role.BAD
    assert limit.best.falls == 0.0


def test_a_limit_that_is_open_at_its_start_has_a_picture(tmp_path: Path) -> None:
    limit = limits.limit_tilt(above(0.02))
    assert (limit.best.stands, limit.best.falls) == (None, None)
    assert [stage.label for stage in limit.layers().stages] == ["not decided at 0°"]
    save_figure(limit, tmp_path / "open.png")
    with pytest.raises(InputError, match="no blocks touch"):
        limits.limit_friction(above(0.3, 0.3))


def test_a_block_that_touches_nothing_at_first_settles_onto_what_is_near() -> None:
    floor, cube = box((2.0, 2.0, 0.1)), box((0.1, 0.1, 0.1), (0.0, 0.0, 0.101), "cube")
    settled = settle(Assembly((floor, cube)).with_fixed([0]), friction=0.6)
    assert settled.rests
    assert settled.path.positions[-1, 1, 2] == pytest.approx(-1e-3, rel=0.1)


def test_the_option_that_is_named_joins_the_pair() -> None:
    found = check(above(0.02), detection=DetectionOptions(gap=0.021))
    assert found.stable
    assert found.model.notes == ("joints across gaps of up to 20 mm count as touching",)


def test_a_block_far_above_another_falls() -> None:
    assert check(above(0.3)).falls


def test_it_falls_where_touching_would_not_hold_it() -> None:
    blocks = (
        box((1, 1, 1), name="base"),
        box((1, 1, 1), (0.8, 0, 1.02), name="tips"),
    )
    found = check(Assembly(blocks).with_fixed([0]))
    assert found.falls
    assert found.falling_names == ("tips",)


def test_it_falls_where_the_near_pair_is_elsewhere() -> None:
    blocks = (
        *above(0.0, 0.02).blocks[:2],
        box((1, 1, 1), (5, 0, 3), name="dropped"),
        box((1, 1, 1), (10, 0, 0), name="a"),
        box((1, 1, 1), (11.02, 0, 0), name="b"),
    )
    found = check(Assembly(blocks).with_fixed(["base", "a", "b"]))
    assert found.falls
    assert found.falling_names == ("dropped",)


def test_the_near_pairs_stay_with_a_part_of_the_model() -> None:
    model = Model.of(above(0.02))
    (near,) = model.unjoined
    assert (near.block_a, near.block_b, near.reason) == (0, 1, Reason.GAP)
    part = model.subset(["middle", "base"])
    assert [(m.block_a, m.block_b) for m in part.unjoined] == [(1, 0)]
    assert model.subset(["middle", "top"]).unjoined == ()
    assert check(part).verdict is Verdict.UNDECIDED


@pytest.mark.parametrize("count", [2, 5])
def test_blocks_that_touch_exactly_have_no_near_pairs(count: int) -> None:
    assert Model.of(tower(count)).unjoined == ()


def test_equilibrium_is_not_denied_because_of_a_near_pair() -> None:
    found = solve_rbe(above(0.02))
    assert found.verdict is Verdict.UNDECIDED
    assert "--gap 0.021" in found.message
    assert solve_rbe(above(0.3)).verdict is Verdict.UNSTABLE


def test_the_tension_that_a_fall_needs_is_that_of_its_own_joints() -> None:
    near = box((1, 1, 1), (0.8, 1.02, 1), name="near")
    blocks = box((1, 1, 1), name="base"), box((1, 1, 1), (0.8, 0, 1), name="tips"), near
    model = Model.of(Assembly(blocks).with_fixed(["base", "near"]), friction=0.1)
    found = solve_rbe(model)
    assert found.verdict is Verdict.UNSTABLE
    assert found.model is model
    assert found.force is not None
    assert found.tension is not None
    assert len(found.force) == len(found.tension) == model.contacts.corner_count
    assert found.tension.max() > 0.0


def test_a_model_without_any_contact_has_no_equilibrium() -> None:
    blocks = (box((1, 1, 1), name="low"), box((1, 1, 1), (0, 0, 5), name="high"))
    found = solve_rbe(Assembly(blocks).with_fixed(["low"]))
    assert found.verdict is Verdict.UNSTABLE
    assert found.falling_names == ("high",)


def deep(shift: float) -> Assembly:
    """A cube that is so deep in another that nobody can say which faces are meant to touch."""
    blocks = (box((1, 1, 1), name="base"), box((1, 1, 1), (shift, 0, 0.91), name="top"))
    return Assembly(blocks).with_fixed(["base"])


def test_a_pair_that_is_too_deep_in_each_other_proves_no_fall() -> None:
    assert check(deep(0.1)).verdict is Verdict.UNDECIDED


def test_it_falls_where_it_would_whichever_faces_are_meant() -> None:
    blocks = (*deep(0.1).blocks, box((1, 1, 1), (0.9, 0.0, 1.91), name="tips"))
    found = check(Assembly(blocks).with_fixed(["base"]))
    assert found.falls
    assert found.falling_names == ("tips",)


def test_a_foot_that_is_too_deep_proves_no_fall_of_what_stands_on_others() -> None:
    exact = stool()
    floor, body = exact.blocks[:2]
    low, corner = body.vertices[:, 2].min(), body.vertices[:, :2].max(axis=0)
    foot = (body.vertices[:, 2] < low + 1e-9) & (
        np.abs(body.vertices[:, :2] - corner).max(axis=1) < 0.3
    )
    moved = body.vertices - np.where(foot[:, None], [0.0, 0.0, 0.1], 0.0)
    drawn = Assembly((floor, Block(moved, body.faces, body.name)))
    model = Model.of(drawn.with_fixed([0]))
    lean = model.with_load((2.0, 2.0, -9.81))  # over the foot that is too deep
    assert check(Model.of(exact.with_fixed([0])).with_load((2.0, 2.0, -9.81))).stable
    assert check(replace(lean, unjoined=())).falls
    assert check(lean).verdict is Verdict.UNDECIDED


def on_its_edge(size: tuple[float, float, float], degrees: float) -> Assembly:
    """A block that stands on one lower edge, tilted about it, on a wide floor."""
    turn = np.deg2rad(degrees)
    axes = np.array([[np.cos(turn), 0, np.sin(turn)], [0, 1, 0], [-np.sin(turn), 0, np.cos(turn)]])
    block = box(size, (0.0, 0.0, 0.0), "tilted")
    vertices = block.vertices @ axes.T
    vertices[:, 2] -= vertices[:, 2].min()
    tilted = Block(vertices, block.faces, "tilted")
    return Assembly((box((4.0, 4.0, 0.2), (0.0, 0.0, -0.2), "floor"), tilted)).with_fixed([0])


@pytest.mark.parametrize(
    ("size", "degrees"),
    [((1.0, 1.0, 0.1), 1.0), ((2.0, 0.3, 0.3), 1.0), ((1.0, 0.5, 0.02), 0.3)],
)
def test_a_wide_face_that_is_tilted_a_little_proves_no_fall(
    size: tuple[float, float, float], degrees: float
) -> None:
    found = check(on_its_edge(size, degrees))
    assert found.verdict is Verdict.UNDECIDED
    assert "'floor' and 'tilted' touch on a part of their faces" in found.message
    assert check(joined_as_told(on_its_edge(size, degrees), found.message)).stable


@pytest.mark.parametrize("degrees", [2.5, 4.0])
def test_the_options_named_for_steep_faces_join_them(degrees: float) -> None:
    model = on_its_edge((1.0, 1.0, 0.1), degrees)
    found = check(model)
    assert found.verdict is Verdict.UNDECIDED
    assert "--gap" in found.message
    assert "--angle" in found.message
    assert check(joined_as_told(model, found.message)).stable


def joined_as_told(assembly: Assembly, message: str) -> Model:
    """The model with the options that a message names."""
    named = re.findall(r"--(gap|angle) ([0-9.]+)", message)
    options = DetectionOptions(**{name: float(value) for name, value in named})
    return Model.of(assembly, detection=options)


def beam_on_piers(bearing: float, sunk: float) -> Assembly:
    """A beam of 2 m on two piers, so wide on each and so deep in them [m]."""
    left, right = (box((0.3, 0.2, 1.0), (x, 0.0, 0.0), name) for x, name in ((0, "l"), (2.3, "r")))
    beam = box((2.0 + 2.0 * bearing, 0.2, 0.3), (0.3 - bearing, 0.0, 1.0 - sunk), "beam")
    return Assembly((left, right, beam), np.array([True, True, False]))


@pytest.mark.parametrize(("bearing", "sunk"), [(0.001, 0.002), (0.002, 0.008), (0.005, 0.008)])
def test_a_beam_that_is_sunk_deeper_than_it_bears_is_not_said_to_fall(
    bearing: float, sunk: float
) -> None:
    assert check(beam_on_piers(bearing, 0.0), friction=0.6).stable
    found = check(beam_on_piers(bearing, sunk), friction=0.6)
    assert found.verdict is Verdict.UNDECIDED
    assert "'l' and 'beam' are" in found.message


def test_a_beam_between_walls_that_it_is_a_little_in_falls() -> None:
    assert check(beam_on_piers(0.001, 0.5), friction=0.6).verdict is Verdict.UNSTABLE
