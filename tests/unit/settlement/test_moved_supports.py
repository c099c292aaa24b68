"""Supports that move by finite amounts, and the blocks that follow them."""

from collections.abc import Callable

import numpy as np
import pytest

from drystone import Assembly, InputError, LoadCase, Model, check, settle
from drystone.fall import fall
from drystone.models import arch, box, tower
from drystone.models.simple import prism
from drystone.settlement import (
    End,
    Outcome,
    Settlement,
    SettlementOptions,
    SupportResponseOptions,
    move_supports,
    push,
    reduce_friction,
    support_response,
)

LEAN = float(np.deg2rad(0.05))
RIGHT = "springer-right"


def moved(model: Model, motion: dict[int | str, tuple[float, ...]], overlap: float) -> Settlement:
    options = SettlementOptions(carrier="moving", overlap=overlap)  # type: ignore[arg-type]
    return settle(model, motion, options=options)


def plug() -> Assembly:
    """A plug that tapers by 0.05 degrees to either side, between two walls."""
    y, lean = (-0.5, 0.5), float(np.tan(LEAN))
    wall = [(0.5, 0.0), (1.5, 0.0), (1.5 + lean, 1.0), (0.5 + lean, 1.0)]
    between = [(-0.5, 0.0), (0.5, 0.0), (0.5 + lean, 1.0), (-0.5 - lean, 1.0)]
    blocks = (
        prism([(-x, z) for x, z in wall], y, "left"),
        prism(wall, y, "right"),
        prism(between, y, "plug"),
    )
    return Assembly(blocks, np.array([True, True, False]))


@pytest.mark.parametrize("overlap", [1e-6, 1e-8])
def test_what_friction_holds_goes_with_its_support(overlap: float) -> None:
    model = Model.of(tower(3), friction=0.4)
    found = moved(model, {0: (0.02, 0.0, 0.0)}, overlap)
    assert found.rests
    np.testing.assert_allclose(found.displacement[:, 0], 0.02, rtol=1e-9)
    # atan(0.4) = 21.8 degrees = 0.381
    turned = moved(model, {0: (0.0, 0.0, 0.0, 0.37, 0.0, 0.0)}, overlap)
    assert turned.rests
    np.testing.assert_allclose(turned.displacement[:, 3], 0.37, rtol=1e-4)


def test_what_friction_does_not_hold_slides_off_a_support_that_turns() -> None:
    found = moved(Model.of(tower(3), friction=0.4), {0: (0.0, 0.0, 0.0, 0.39, 0.0, 0.0)}, 1e-6)
    assert found.outcome is Outcome.FALLS


@pytest.mark.parametrize(("overlap", "agree"), [(1e-7, 2e-3), (1e-8, 4e-4)])
def test_voussoirs_move_as_to_first_order_where_the_support_moves_little(
    overlap: float, agree: float
) -> None:
    model, crown = Model.of(arch(0.2, 8), friction=0.7), 4
    motion = {RIGHT: (0.0005, 0.0, 0.0)}
    rigid = SupportResponseOptions(compliance=1e-6)
    first = support_response(model, motion, options=rigid).result.displacement
    assert first is not None
    found = moved(model, motion, overlap)
    assert found.displacement[crown, 4] == pytest.approx(first[crown, 4], rel=agree)


def test_two_ways_to_move_a_support_agree() -> None:
    model, to = Model.of(arch(0.2, 8), friction=0.7), 0.1
    found = moved(model, {RIGHT: (to, 0.0, 0.0)}, 1e-6)
    # voussoirs have moved by 0.35 of their size, and rest
    assert found.rests
    driven = move_supports(model, {RIGHT: (1.0, 0.0, 0.0)}, to=to).states[-1].positions
    np.testing.assert_allclose(found.displacement, driven, atol=2e-4 * to)
    np.testing.assert_allclose(found.displacement[model.assembly.index(RIGHT), :3], (to, 0, 0))


def test_a_wall_is_followed_to_the_end_on_a_foot_that_turns() -> None:
    """Its joints open and slide many times meanwhile; it was lost after 0.4 mm."""
    motion = (0.0, 0.0, 0.0, 0.0, -0.03, 0.0)
    feet = [box((1.0, 0.5, 0.5), (x, 0.0, -0.5), f"foot {x}") for x in (-1.0, 0.0)]
    courses = [
        box((0.5, 0.5, 0.25), (-1.0 + 0.25 * (c % 2) + 0.5 * i, 0.0, 0.25 * c), f"block {c} {i}")
        for c in range(4)
        for i in range(4 - c % 2)
    ]
    assembly = Assembly((*feet, *courses), np.arange(16) < 2)
    model = Model.of(assembly, friction=0.6)
    driven = move_supports(model, {1: motion})
    assert driven.end is End.REACHED
    found = moved(model, {1: motion}, 1e-6)
    assert found.rests
    np.testing.assert_allclose(driven.states[-1].positions, found.displacement, atol=2e-4)


def test_an_arch_on_a_spreading_support_falls_at_its_capacity() -> None:
    model = Model.of(arch(0.15, 4), friction=1.5)
    capacity = move_supports(model, {RIGHT: (1.0, 0.0, 0.0)}).capacity
    assert capacity == pytest.approx(0.1001, rel=1e-3)
    for share, outcome in ((0.98, Outcome.RESTS), (1.02, Outcome.FALLS)):
        assert moved(model, {RIGHT: (share * capacity, 0.0, 0.0)}, 1e-6).outcome is outcome


def test_a_support_that_turns_does_work_until_blocks_slide() -> None:
    model, radius = Model.of(tower(2), friction=0.4), float(np.sqrt(0.5))
    # the corners of a cube turn about its centroid
    found = move_supports(model, {0: (0.0, 0.0, 0.0, 0.45, 0.0, 0.0)})
    assert found.end is End.FALLS
    assert found.displacement[-1] == pytest.approx(radius * np.arctan(0.4), rel=1e-3)
    held = move_supports(model, {0: (0.0, 0.0, 0.0, 0.35, 0.0, 0.0)})
    done = np.trapezoid(held.load, held.displacement)
    lowered = held.states[-1].positions[1:, 2] - held.states[0].positions[1:, 2]
    # forces are those of the position before an increment of a thousandth of a block
    assert done == pytest.approx(-9.81 * model.assembly.mass[1:] @ lowered, rel=5e-3)


@pytest.mark.parametrize("analysis", [push, reduce_friction, check, fall])
def test_an_analysis_whose_supports_stay_refuses_a_load_that_moves_them(
    analysis: Callable[[Model], object],
) -> None:
    block = tower(2)
    load = LoadCase.gravity(block) + LoadCase.settlement(block, 0, (0.01, 0.0, 0.0))
    model = Model.of(block, friction=0.5, load=load)
    with pytest.raises(InputError, match=r"moves supports.*ask 'settle'"):
        analysis(model)
    assert move_supports(model).displacement[-1] == pytest.approx(0.01)


def test_the_states_that_are_kept_of_a_long_way_are_evenly_spaced() -> None:
    # the beginning was lost, with the hinges that come and go there: the second state was at 0.13 m
    arched = Model.of(arch(0.2, 16), friction=1.5)
    found = move_supports(arched, {RIGHT: (1.0, 0.0, 0.0)}, to=0.2)
    number = {pair: i for i, pair in enumerate(zip(found.displacement, found.load, strict=True))}
    kept = [number[one.displacement, one.load] for one in found.states]
    assert kept[0] == 0
    assert kept[-1] == len(found.load) - 1
    assert int(np.argmax(found.load)) in kept
    assert np.diff(kept).max() <= 2 * len(found.load) / len(kept)


def test_what_is_told_of_moved_supports() -> None:
    model = Model.of(tower(2), friction=0.5)
    lifted = settle(model, {0: (0.0, 0.0, 0.5)})
    assert lifted.message == (
        "it comes to rest on the moved supports, blocks moved by 0.5 m at most"
    )
    # the force along the motion is rounding
    aside = move_supports(model, {0: (0.3, 0.0, 0.0)})
    assert aside.message == "at most 0 N; followed to 300 mm, where it is 0 N"
    weight = f"{9.81 * model.assembly.mass[1]:.4g}"
    down = move_supports(model, {0: (0.0, 0.0, 0.3)})
    assert down.message.startswith(f"from -{weight} to -{weight} N; followed to 300 mm")


def test_a_plug_that_tapers_is_driven_on_stiffer_springs() -> None:
    model = Model.of(plug(), friction=0.01)
    without = reduce_friction(model)
    assert without.end is not End.FALLS
    assert without.load[-1] == 0.0
    # without friction its weight lifts it out
    drawn = push(Model.of(plug(), friction=0.0), (0.0, 0.0, 1.0))
    assert drawn.peak == pytest.approx(1.0, rel=1e-5)
    dropped = [
        moved(Model.of(plug(), friction=0.0), {"right": (out, 0.0, 0.0)}, 1e-6) for out in (0, 1e-4)
    ]
    fall = dropped[0].displacement[2, 2] - dropped[1].displacement[2, 2]
    assert fall == pytest.approx(1e-4 / (2.0 * np.tan(LEAN)), rel=1e-2)


def test_loads_stay_where_they_act_while_supports_move() -> None:
    """A roof and a tank on a post turn with its top, as by hand: it fell at 0.79 of that."""
    feet = (box((2, 2, 1), (x, -1, -1), f"foot {x}") for x in (-1.7, 0.3))
    assembly = Assembly((*feet, box((0.6, 0.6, 1), (0, -0.3, 0), "post"))).with_fixed([0, 1])
    mass, at = assembly.mass[2], (0.4, 0.0, 1.0)
    load = (
        LoadCase.gravity(assembly)
        + LoadCase.point_load(assembly, 2, (0, 0, -9.81 * mass / 2), at=at)
        + LoadCase.extra_mass(assembly, 2, mass / 2, at=at)
    )
    model = Model.of(assembly, friction=2.0, load=load)
    by_hand = 0.3 * np.sin(np.arctan((0.3 + 0.2) / (0.5 + 1.0)))
    quick = SettlementOptions(pace=5.0)
    assert move_supports(model, {1: (0, 0, -1)}, to=0.9 * by_hand, options=quick).end is End.REACHED
