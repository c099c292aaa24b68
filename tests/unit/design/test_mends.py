"""Changes that make structures stand: found by themselves, checked again from their files."""

import json
import re
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

import drystone
from drystone import Assembly, Block, InputError, LoadCase, Model, Result, Verdict, check
from drystone.answer import Role, State
from drystone.cli import main
from drystone.design import (
    DesignMargin,
    MendOptions,
    Mends,
    diagnose,
    find_mends,
    margin,
    mend,
    still_edge,
    turn_joint,
)
from drystone.design.bench import Bench
from drystone.design.changes import Change
from drystone.joint_capacity import JointCapacity
from drystone.limits.bounds import with_margins
from drystone.loads import Earth, Train
from drystone.models import (
    arch,
    barrel_vault,
    box,
    dome,
    h_model,
    segmental_bridge,
    shelf,
    tower,
    wall,
    wedge,
)
from drystone.models.simple import prism

SLOPE = np.rad2deg(np.arctan2(0.676163 - 0.627729, 0.284267 - 0.243736))
"""[degrees] Of the lower joint of block 10 of the shelf."""


def again(model: Model, folder: Path) -> drystone.Result:
    """The check of a model as it is read from its file."""
    path = folder / "mended.json"
    drystone.write(model, path)
    return drystone.check(drystone.read(path))


@pytest.fixture(scope="module")
def fallen() -> Mends:
    """What is found for the shelf of the source after its first fix: one piece still falls."""
    kinds = ("support", "prop", "turn", "wedge", "let-in")
    return find_mends(shelf(1), friction=0.9, options=MendOptions(kinds=kinds))


def test_a_piece_of_the_shelf_is_supported_or_one_of_its_joints_is_changed(fallen: Mends) -> None:
    found = fallen.of(["block-10"])
    assert {"support", "prop", "wedge", "let-in"} <= {one.change.kind for one in found}
    changes = [one.change for one in found]
    joints = [one.description for one in changes if one.kind in ("turn", "wedge", "let-in")]
    for joint in ("the lower joint of 'block-10', with 'block-8'", "the upper joint of 'block-10'"):
        assert any(text.startswith(joint) for text in joints)
    assert [one.cost for one in changes] == sorted(one.cost for one in changes)


def test_a_slab_is_slid_back_and_a_mend_that_jams_comes_last(fallen: Mends, tmp_path: Path) -> None:
    """It tips 0.15 m beyond the edge, 0.175 m from the middle of its joint."""
    base, slab = box((1.0, 1.0, 1.0), name="base"), box((0.4, 1.0, 0.15), (0.95, 0.0, 1.0), "slab")
    model = Model.of(Assembly((base, slab)).with_fixed([0]), friction=0.6)
    kinds = ("turn", "merge", "slide", "support")
    found = find_mends(model, options=MendOptions(kinds=kinds))
    slid, held, jams = found.mends
    assert [one.change.kind for one in found.mends] == ["slide", "merge", "turn"]
    assert slid.change.value == pytest.approx(0.9 * 0.175)
    moved = 10.0 * 0.9 * 0.175 / np.linalg.norm((0.4, 1.0, 0.15))
    assert (slid.change.cost, slid.change.volume) == pytest.approx((1.0 + moved, 0.0))
    moved = slid.model.assembly.centroid - model.assembly.centroid
    assert moved == pytest.approx(np.array([[0.0, 0.0, 0.0], [-0.1575, 0.0, 0.0]]))
    assert again(slid.model, tmp_path).stable
    assert held.change.cost > jams.change.cost
    weight = 9.81 * float(model.assembly.mass[1])
    forces = np.linalg.norm(jams.result.resultants.force, axis=1)
    assert jams.change.jams == pytest.approx(forces.max() / weight, rel=0.02)
    assert jams.change.description.endswith("times the weight, and falls with 1 % less friction")
    assert check(jams.model.with_friction(0.594)).falls
    assert "turned by 17 degrees (which jams)" in found.diagnosis.reasons[0]
    assert not any(one.change.jams for one in (slid, held, *fallen.mends))
    (prop,) = diagnose(model).regions[0].needs.props.props  # of which no mend was asked
    assert prop.force == pytest.approx([0.0, 0.0, 736.0], abs=1.0)  # 686 N, which lean, hold too
    assert prop.point == pytest.approx([1.304, 0.5, 1.0], abs=1e-3)
    ((_, support),) = found.tried
    assert "the supports 'ground' lay a plane below" in support.what


def test_a_block_that_falls_only_once_another_one_is_held_is_in_the_way_of_no_mend(
    tmp_path: Path,
) -> None:
    # at 0.6 no forces balance block 10; block 9 is balanced, and falls as well
    (one,) = find_mends(shelf(2), friction=0.6, options=MendOptions(kinds=("prop",))).mends
    assert (one.change.blocks, one.change.held) == (("block-10",), ("block-9",))
    fixed = one.model.assembly.indices(["block-9"]).tolist()
    fixed += np.flatnonzero(one.model.assembly.fixed).tolist()
    assert again(one.model.with_supports(fixed), tmp_path).stable
    assert "block-9" in drystone.check(one.model).falling_names


def test_every_mend_of_the_shelf_stands_when_it_is_read_from_its_file(
    fallen: Mends, tmp_path: Path
) -> None:
    for one in fallen.mends:
        path = tmp_path / "one.json"
        drystone.write(one.model, path)
        read = drystone.read(path)
        fixed = [read.assembly.names[i] for i in np.flatnonzero(read.assembly.fixed)]
        result = drystone.check(read.with_supports([*fixed, *one.change.held]))
        assert result.stable, one.change.description
        robust = result.samples.standing == result.samples.tried
        assert robust or "after settling" in result.message, one.change.description
        assert robust != one.change.description.endswith(", which holds only after settling")


@pytest.mark.parametrize(("patience", "kinds"), [(100, []), (1200, ["prop"])])
def test_a_search_that_is_stopped_ends_within_the_check_that_is_under_way(
    monkeypatch: pytest.MonkeyPatch, patience: int, kinds: list[str]
) -> None:
    asked, after = 0, 0

    def stop() -> bool:
        nonlocal asked
        asked += 1
        return asked > patience

    def counted(*given: object, **how: object) -> drystone.Result:
        nonlocal after
        after += asked > patience
        return drystone.check(*given, **how)

    monkeypatch.setattr(margin, "check", counted)
    found = find_mends(h_model(), friction=0.9, stop=stop)
    assert patience < asked < patience + 50
    assert after == 0
    assert {*kinds} <= {one.change.kind for one in found.mends}
    assert bool(kinds) == bool(found.mends)


def test_the_least_turn_is_that_of_a_scan_and_that_of_the_friction_angle(fallen: Mends) -> None:
    (turned,) = [one for one in fallen.of(["block-10"]) if one.change.kind == "turn"]
    assert turned.change.value == pytest.approx(SLOPE - np.rad2deg(np.arctan(0.9)), abs=0.1)
    blocks = fallen.diagnosis.model.assembly
    model = fallen.diagnosis.model.with_supports([i for i in range(len(blocks)) if i != 10])
    (joint,) = [i for i in range(model.contacts.count) if model.contacts[i].blocks == (8, 10)]

    def stands(angle: float) -> bool:
        pivot = still_edge(model, joint, angle)
        return drystone.check(turn_joint(model, joint, angle, pivot=pivot)).stable

    scanned = [round(0.1 * k, 1) for k in range(79, 84)]
    standing = [angle for angle in scanned if stands(angle) or stands(-angle)]
    assert min(standing) == pytest.approx(turned.change.value, abs=0.1)


def test_a_partial_fix_of_the_source_is_mended(tmp_path: Path) -> None:
    model = Model.of(shelf(3), friction=0.9)
    made = mend(model, options=MendOptions(kinds=("turn",)))
    assert [step.blocks for step in made.changes] == [("block-10",)]
    assert made.stands
    assert again(made.model, tmp_path).stable
    assert model.assembly.volume.sum() == pytest.approx(made.model.assembly.volume.sum(), rel=1e-6)


def test_regions_are_mended_one_after_the_other_until_all_stands(tmp_path: Path) -> None:
    base = box((1.0, 1.0, 1.0), name="base")
    right = box((1.0, 1.0, 0.2), (0.7, 0.0, 1.0), "right")
    left = box((0.8, 1.0, 0.2), (-0.7, 0.0, 1.0), "left")
    model = Model.of(Assembly((base, right, left)).with_fixed([0]), friction=0.6)
    made = mend(model, options=MendOptions(kinds=("glue",)))
    assert [step.blocks for step in made.changes] == [("right",), ("left",)]
    assert made.stands
    assert made.log[-1].startswith("it stands: ")
    assert again(made.model, tmp_path).stable


def test_the_friction_for_a_margin_of_tilt_is_its_tangent() -> None:
    options = MendOptions(margin=DesignMargin(tilt=35.0), kinds=("friction",))
    (found,) = find_mends(tower(2), friction=0.6, options=options).mends
    assert found.change.value == pytest.approx(np.tan(np.deg2rad(35.0)), abs=0.011)
    assert found.change.value >= np.tan(np.deg2rad(35.0))


def test_diagnosis_and_mend_tell_one_friction_that_is_enough() -> None:
    load = LoadCase.tilt(tower(2), (1.0, 0.0, 0.0), 35.0)
    model = Model.of(tower(2), friction=0.6, load=load)
    found = find_mends(model, options=MendOptions(kinds=("friction",)))
    assert found.diagnosis.regions[0].needs.friction == found.mends[0].change.value == 0.71
    assert "friction of 0.71 there" in found.diagnosis.reasons[0]


def test_glue_has_the_strength_that_the_moment_asks_for(tmp_path: Path) -> None:
    """The inner half of the joint carries half of the pull, 0.3 m from the edge it turns about."""
    base, out = box((1.0, 1.0, 1.0), name="base"), box((1.0, 1.0, 0.2), (0.7, 0.0, 1.0), "out")
    model = Model.of(Assembly((base, out)).with_fixed([0]), friction=0.6)
    weight = 9.81 * float(model.assembly.mass[1])
    mends = find_mends(model, options=MendOptions(kinds=("glue",)))
    (found,) = mends.mends
    assert found.change.value == pytest.approx(0.2 * weight / (0.5 * 0.3), abs=0.015 * weight)
    (glue,) = mends.diagnosis.regions[0].needs.glue
    assert glue.value == found.change.value
    assert found.change.description in mends.diagnosis.reasons[0]
    enough, half = (
        JointCapacity(
            np.full(1, share * found.change.value),
            np.full(1, share * found.change.value),
            brittle=False,
        )
        for share in (1.0, 0.5)
    )
    assert drystone.check(model.with_capacity(enough)).stable
    assert drystone.check(model.with_capacity(half)).falls
    assert "between" in found.change.description
    assert again(found.model, tmp_path).stable


def test_a_thin_arch_is_glued_in_the_joints_that_pull(tmp_path: Path) -> None:
    model = Model.of(arch(0.06, voussoirs=6), friction=0.5)
    mends = find_mends(model, options=MendOptions(kinds=("glue",)))
    (found,) = mends.mends
    assert any("brittle may crack" in one.text for one in mends.sentences())
    assert found.change.joints == 5
    assert found.change.description.startswith("glue in the 5 joints that pull, each of which")
    assert again(found.model, tmp_path).stable
    options = MendOptions(kinds=("turn", "glue"), keep=("voussoir-02",))
    (turned, glued) = find_mends(model, options=options).tried
    for _, one in (turned, glued):
        assert "may not be changed (kept: 'voussoir-02')" in one.what


def test_a_tie_carries_what_keeps_two_blocks_from_turning_apart(tmp_path: Path) -> None:
    """Each block turns about an edge 0.1 m inside its centroid; the tie is 0.25 m above."""
    base = box((1.0, 1.0, 1.0), (0.0, 0.0, -1.0), "base")
    sides = (box((1.2, 1.0, 0.5), (-0.7, 0.0, 0.0), "left"),
             box((1.2, 1.0, 0.5), (0.5, 0.0, 0.0), "right"))  # fmt: skip
    model = Model.of(Assembly((base, *sides)).with_fixed([0]), friction=0.6)
    weight = 9.81 * float(model.assembly.mass[1])
    (found,) = find_mends(model, options=MendOptions(kinds=("tie",))).mends
    assert found.change.value == pytest.approx(0.1 * weight / 0.25, rel=0.01)
    assert found.change.added == 1
    assert again(found.model, tmp_path).stable


def flat_arch(stones: int, pier: float = 0.5) -> Model:
    """On piers of a width [m], 1.8 m apart."""
    edge, depth = np.linspace(-0.9, 0.9, stones + 1), (0.0, 0.4)
    rows = [box((4.0, 1.0, 0.2), (-2.0, -0.3, -0.2), "ground")]
    for x, out, name in ((-0.9, -0.9 - pier, "left"), (0.9, 0.9 + pier, "right")):
        rows.append(prism([(x, 0.0), (out, 0.0), (out, 1.4), (x, 1.4)], depth, f"pier-{name}"))
        cap = (x, 1.4), (out, 1.4), (out, 1.8), (1.24 * x, 1.8)
        rows.append(prism(cap, depth, f"cap-{name}"))
    rows += [
        prism([(a, 1.4), (b, 1.4), (1.24 * b, 1.8), (1.24 * a, 1.8)], depth, f"stone-{i}")
        for i, (a, b) in enumerate(pairwise(edge))
    ]
    return Model.of(Assembly(rows).with_fixed([0]), friction=0.7)


def test_a_flat_arch_that_spreads_is_tied_from_side_to_side() -> None:
    """By 676 N; a tie from one side to the voussoir next to the middle took 1.22 kN."""
    (found,) = find_mends(flat_arch(5), options=MendOptions(kinds=("tie",))).mends
    assert "between the middles of 'cap-left' and 'cap-right'" in found.change.description
    assert found.change.value < 700.0


def test_abutments_that_slide_get_thicker_with_the_piers_below_that_do_not_move() -> None:
    sliding = flat_arch(1, 0.7).with_friction(0.3)
    found = find_mends(sliding, options=MendOptions(kinds=("thicker",)))
    told = " ".join(tried.what for _, tried in found.tried)
    assert "more thickness of 'cap-left' and 'cap-right', along x; " in told
    assert (
        "more thickness of 'cap-left', 'cap-right', 'pier-left' and 'pier-right', along x" in told
    )


def test_weights_are_tried_on_the_stones_that_rise_most_and_above_piers_that_spread() -> None:
    ((_, tried),) = find_mends(flat_arch(9, 0.4), options=MendOptions(kinds=("ballast",))).tried
    assert tried.what.startswith("no weight up to 10 times the 20.3 kN of the region holds it in ")
    ends = "each of 'stone-0' and 'stone-8', or of each of 'cap-left' and 'cap-right'; "
    assert ends in tried.what


@pytest.mark.parametrize(
    ("behind", "pull"),
    [
        ({"back": box((3.0, 0.5, 4.0), (-1.5, 2.5, 0.0))}, "m to 'back' at (0, 2.5, 3) m"),
        (
            {x: box((0.5, 2.0, 4.0), (at, 0.8, 0.0)) for x, at in (("left", -1.5), ("right", 1.0))},
            "from (-1.35, 0.25, 3) m to 'left' at (-1.35, 0.8, 3) m",
        ),
    ],
)
def test_a_facade_that_a_roof_pushes_is_tied_back_at_its_top(
    behind: dict[str, Block], pull: str
) -> None:
    """By a wall behind it, or two beside that it does not touch.

    It shakes a little, too, and the ties are level all the same. About the foot of the upper
    course: 12 kN x 2 m + weight / 100 x 1 m = weight x 0.25 m + pull x 1 m.
    """
    facade = [box((3.0, 0.5, 2.0), (-1.5, 0.0, z), f"facade-{z:g}") for z in (0.0, 2.0)]
    back = [block.renamed(name) for name, block in behind.items()]
    blocks = Assembly((box((6.0, 8.0, 1.0), (-3.0, -4.0, -1.0), "ground"), *facade, *back))
    push = LoadCase.point_load(blocks, 2, (0.0, -12e3, 0.0), (0.0, 0.25, 4.0))
    model = Model.of(blocks.with_fixed(["ground", *behind]), friction=0.6)
    model = model.with_load(model.load + push + LoadCase.seismic(blocks, 0.0, -0.01))
    mends = find_mends(model, options=MendOptions(kinds=("tie",)))
    (found,) = mends.mends
    assert any(
        "where it is as stiff as a joint and never yields" in x.text for x in mends.sentences()
    )
    (other,) = DesignMargin().remarks(model)
    assert "ask for the other, --seismic 0,0.01 in its place, too" in other
    held = "with the blocks around what falls held; the ties below have that with all blocks free"
    assert any(held in x.text for x in found.sentences())
    least = 24e3 - 0.24 * 9.81 * float(blocks.mass[1])
    assert 0.999 * least < found.change.value < 1.5 * least
    assert pull in found.change.description
    assert found.change.added == len(behind)
    if len(behind) == 1:
        assert f"pulls by a steady {least / 1e3:.3g} kN" in found.change.description


def test_of_ties_that_hold_alike_that_in_the_middle_of_a_wall_is_tried_first() -> None:
    """Earth pushes a wall over its edge; a stone at its end stands out by 0.1 mm."""
    blocks = wall(courses=3, length=3, size=(1.0, 0.3, 0.3))
    stones = list(blocks.blocks)
    end = blocks.index("c02-b00")
    stones[end] = stones[end].transformed(translation=(0.0, -1e-4, 0.0))
    assembly = Assembly(stones, blocks.fixed)
    load = LoadCase.gravity(assembly) + Earth("-y", 18e3, 1.05).on(assembly)
    (found,) = find_mends(
        Model.of(assembly, friction=0.8, load=load), options=MendOptions(kinds=("tie",))
    ).mends
    assert "between the middles of 'c02-b01' and 'c00-b01'" in found.change.description


def test_a_mend_under_a_train_is_asked_of_all_its_places() -> None:
    """A thicker ring carries the axle everywhere; a prop below one haunch not over the other.

    With 6 % more it carries 0.9955 of the axle, once that lies on the thicker ring.
    """
    bridge = segmental_bridge(span=4.0, rise=1.0, ring=0.3, voussoirs=3)
    model, axle = Model.of(bridge, friction=0.7), Train("axle", (0.0,), (42e3,))
    options = MendOptions(kinds=("thicker", "prop"), train=axle)
    found = find_mends(model, options=options)
    assert found.case == f"under {found.model.load.each[0].words}"
    ring, prop = found.mends
    alone = ring.model.with_load(ring.model.load.without(ring.model.load.each))
    assert np.allclose(alone.load.wrench, LoadCase.gravity(alone.assembly).wrench)
    assert ring.stands
    assert ring.change.value == pytest.approx(0.08)
    assert "of all places: stands under 'axle' up to load factor 1.0" in ring.change.description
    assert not prop.stands
    assert "of all places: does not carry 'axle', only 0.8" in prop.change.description
    backwards = replace(found, mends=(prop, ring))
    for one, told in ((found, False), (backwards, True)):
        assert any(x.text.startswith("listed by cost; behind") for x in one.sentences()) is told
    assert not found.together([2], options=options).stands
    fewer = find_mends(model, options=replace(options, steps=1), regions=0)
    assert fewer.case != found.case
    with pytest.raises(InputError, match="places of a train; give a train too"):
        MendOptions(steps=5)


def test_a_train_that_is_carried_is_asked_at_the_margin_and_a_stopped_one_is_not_carried() -> None:
    """A slab that overhangs its pier by 0.2 m: weight x 0.5 m = axle x 0.2 m."""
    slab = box((1.4, 1.0, 0.3), (-0.2, 0.0, 1.0), "slab")
    model = Model.of(Assembly((box((1.0, 1.0, 1.0)), slab)).with_fixed([0]), friction=0.7)
    tips, places = 2.5 * 9.81 * float(model.assembly.mass[1]), list[int]()
    half, more = (Train("axle", (0.0,), (share * tips,)) for share in (0.5, 1.2))
    options = MendOptions(kinds=("ballast",), train=half, margin=DesignMargin(load=2.1))
    found = find_mends(model, options=options, regions=0)
    multiplied = "under axle at x = -0.2 m, under 2.1 times axle at x = -0.2 m"
    assert found.case == multiplied
    push = (0.0, 0.0, -tips / 2.5), (0.5, 0.5, 1.3)  # doubles what holds the slab, if not times 2.1
    held = model.with_load(model.load + LoadCase.point_load(model.assembly, "slab", *push))
    whole = replace(options, train=Train("axle", (0.0,), (tips,)))
    assert find_mends(held, options=whole, regions=0).case == multiplied
    (mend,) = find_mends(
        model, options=MendOptions(kinds=("ballast",), train=more),
        progress=lambda _, done, __: places.append(done), stop=lambda: places.count(2) > 1,
    ).mends  # fmt: skip
    assert not mend.stands


def test_in_place_of_a_level_prop_a_buttress_of_the_size_that_is_told_stands() -> None:
    """A wall that is pushed over at its top; with a buttress a third as deep it falls."""
    ground, wall = box((6.0, 6.0, 1.0), (-3.0, -3.0, -1.0), "ground"), box((2.0, 0.5, 2.0))
    blocks = Assembly((ground, wall.renamed("wall"))).with_fixed(["ground"])
    push = (0.0, -9e3, 0.0), (1.0, 0.25, 2.0)

    def model(*more: Block) -> Model:
        made = Model.of(Assembly((*blocks.blocks, *more)).with_fixed(["ground"]), friction=0.6)
        return made.with_load(made.load + LoadCase.point_load(made.assembly, "wall", *push))

    (found,) = find_mends(model(), options=MendOptions(kinds=("prop",))).mends
    told = re.search(r"buttress .*, (\S+) m wide, (\S+) m deep and as high", found.words)
    high = float(re.search(r"at \(\S+ \S+ (\S+)\) m", found.words)[1])  # type: ignore[index]
    wide, deep = map(float, told.groups())  # type: ignore[union-attr]
    for share, stands in ((1.0, True), (0.3, False)):
        stone = box((wide, share * deep, high), (0.5, -share * deep, 0.0), "buttress")
        assert check(model(stone)).stable is stands


def test_a_dome_whose_cracked_foot_slides_apart_gets_a_ring_of_ties() -> None:
    shell, ground = dome(3.0, 0.5, slices=6, rings=2), box((8.0, 8.0, 0.5), (-4.0, -4.0, -0.5))
    blocks = Assembly((ground.renamed("ground"), *shell.blocks)).with_fixed(["ground"])
    model = Model.of(blocks, friction=0.2)
    foot = np.array([name.startswith("r00") for name in blocks.names])
    whole = ~(foot[model.contacts.block_a] & foot[model.contacts.block_b])
    cracked = model.with_contacts(model.contacts.select(whole))
    ring = find_mends(cracked, options=MendOptions(kinds=("tie",))).mends[-1]
    assert ring.words.startswith("a ring of 6 ties between the middles of 'r00-b0")
    pulls = np.linalg.norm(ring.result.resultants.force[-6:], axis=1)
    assert f"each pulls at most {pulls.max():.3g} N" in ring.words
    assert pulls.min() > 0.8 * pulls.max()
    assert (ring.change.cost, ring.change.added) == (2.0, 1)


def test_two_blocks_that_nothing_presses_need_two_props(tmp_path: Path) -> None:
    walls = box((1.0, 1.0, 3.0), name="left"), box((1.0, 1.0, 3.0), (3.0, 0.0, 0.0), "right")
    loose = (box((1.0, 1.0, 1.0), (1.0, 0.0, 1.0), "one"),
             box((1.0, 1.0, 1.0), (2.0, 0.0, 1.0), "two"))  # fmt: skip
    model = Model.of(Assembly((*walls, *loose)).with_fixed([0, 1]), friction=0.6)
    (found,) = find_mends(model, options=MendOptions(kinds=("prop",))).mends
    assert found.change.added == 2
    assert found.change.value == pytest.approx(
        9.81 * float(model.assembly.mass[2:].sum()), rel=1e-3
    )
    assert found.change.description.startswith("2 props: ")
    assert again(found.model, tmp_path).stable


def stair(steps: int, rise: float = 0.2, turn: float = 22.5) -> Model:
    """Treads round a newel, each of which lies on half of the one below it."""

    def ring(radius: float, degrees: list[float]) -> np.ndarray:
        angle = np.deg2rad(degrees)
        return radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)

    def upright(plan: np.ndarray, low: float, high: float, name: str) -> Block:
        count = len(plan)
        ends = [np.column_stack([plan, np.full(count, z)]) for z in (low, high)]
        sides = [(i, (i + 1) % count, (i + 1) % count + count, i + count) for i in range(count)]
        faces = (tuple(reversed(range(count))), tuple(range(count, 2 * count)), *sides)
        return Block(np.concatenate(ends), faces, name)

    newel = upright(ring(0.15, [turn * i for i in range(16)]), 0.0, rise * steps + 0.3, "newel")
    blocks = [box((4.0, 4.0, 0.3), (-2.0, -2.0, -0.3), "slab"), newel]
    for i in range(steps):
        across = [turn * (i + k) for k in range(3)]
        plan = np.concatenate([ring(1.0, across), ring(0.15, across[::-1])])
        blocks.append(upright(plan, (i + 1) * rise, (i + 2) * rise, f"tread-{i:02d}"))
    return Model.of(Assembly(tuple(blocks)).with_fixed([0]), friction=0.6)


def test_diagnosis_and_mend_name_the_same_props_of_a_stair(tmp_path: Path) -> None:
    once = DesignMargin(robust=False)
    found = find_mends(stair(7), options=MendOptions(once, kinds=("prop",)))
    (mended,) = found.mends
    point, force = found.diagnosis.props
    assert len(point) == mended.change.added > 1
    assert np.linalg.norm(force, axis=1).sum() == pytest.approx(mended.change.value, rel=1e-6)
    assert not len(found.diagnosis.missing[0])
    assert f"{mended.change.added} supports on 'tread-00'" in found.diagnosis.reasons[0]
    assert again(mended.model, tmp_path).stable


def test_two_blocks_made_one_stand(tmp_path: Path) -> None:
    base, out = box((1.0, 1.0, 1.0), name="base"), box((1.0, 1.0, 0.2), (0.7, 0.0, 1.0), "out")
    model = Model.of(Assembly((base, out)).with_fixed([0]), friction=0.6)
    (found,) = find_mends(model, options=MendOptions(kinds=("merge",))).mends
    assert len(found.model) == 1
    assert again(found.model, tmp_path).stable


def test_what_tips_on_both_sides_is_held_by_two_weights(tmp_path: Path) -> None:
    places = {"pier-l": 0.0, "pier-r": 2.2, "slab-l": 0.4, "slab-r": 1.8}
    sides = [
        box((1.0, 0.5, 0.2), (x, 0.0, 0.2 * name.startswith("slab")), name)
        for name, x in places.items()
    ]
    lintel = box((0.8, 0.5, 1.2), (1.2, 0.0, 0.4), "lintel")
    model = Model.of(Assembly((*sides, lintel)).with_fixed([0, 1]), friction=0.6)
    (found,) = find_mends(model, options=MendOptions(kinds=("ballast",))).mends
    assert "on each of 'slab-l' and 'slab-r'" in found.sentences()[-1].text
    assert again(found.model, tmp_path).stable


def test_a_corbel_is_held_by_a_weight_on_its_tail_or_a_dowel_through_the_stone_between() -> None:
    """About the edge of the pier, at 1 m: weight x (0.25 m - 0.2 m) = ballast x 0.475 m."""
    places = {"pier": (0.0, 0.0), "low": (0.3, 0.3), "high": (0.75, 0.6)}
    stones = [box((1.0, 0.5, 0.3), (x, 0.0, z), name) for name, (x, z) in places.items()]
    model = Model.of(Assembly(stones).with_fixed(["pier"]), friction=0.6)
    ballast, dowel = find_mends(model, options=MendOptions(kinds=("tie", "ballast"))).mends
    own = 9.81 * float(model.assembly.mass[1])
    assert ballast.change.value == pytest.approx(0.05 / 0.475 * own, rel=0.02)
    assert "on 'low' at (0.5" in ballast.change.description
    assert ballast.change.cost == pytest.approx(2.0 + 10.0 * ballast.change.value / (2.0 * own))
    assert dowel.change.description.startswith("a dowel that pulls")
    assert dowel.change.description.endswith("m apart through 'low'")
    assert (dowel.change.joints, dowel.change.cost) == (2, 4.0)


def test_the_haunches_of_a_thin_arch_are_weighted_though_they_slope_by_45_degrees() -> None:
    model = Model.of(arch(0.08, 6), friction=0.84)
    (found,) = find_mends(model, options=MendOptions(kinds=("ballast",))).mends
    assert "on each of 'voussoir-01' and 'voussoir-04'" in found.words


def test_mends_come_before_reasons_and_what_failed_is_one_line(fallen: Mends) -> None:
    said = [one.text for one in fallen.sentences()]
    rows = [k for k, one in enumerate(said) if one.startswith("mend ")]
    assert rows == list(range(rows[0], rows[0] + len(rows)))
    assert said.index(fallen.diagnosis.reasons[0]) > rows[-1]
    alike = [said[k].partition("; like it ")[2] for k in rows]
    told = [re.match(r"mend (\d+)", said[k])[1] for k in rows] + re.findall(r"\d+", " ".join(alike))
    assert sorted(map(int, told)) == list(range(1, len(fallen.mends) + 1))
    listed = [one for one in fallen.failures() if one.startswith("mend ")]
    assert len(rows) + len(listed) == len(fallen.mends) > len(rows)
    (failed,) = [one for one in said if "tried without success" in one]
    assert failed.startswith(f"{len(fallen.tried)} combination")


def test_what_holds_a_region_but_not_the_whole_is_told_beside_what_would_hold_it(
    fallen: Mends,
) -> None:
    names, one = fallen.tried[0]
    what = "a prop holds the region, but the whole still falls: it falls"
    failed = replace(one, kind="prop", what=what, only="the whole still falls")
    found = replace(fallen, mends=(), tried=((names, failed),))
    reason = next(text for text in found.diagnosis.reasons if "would hold" in text)
    told = f"{reason} (prop: the whole still falls)"
    said = [sentence.text for sentence in found.sentences()]
    assert told in said
    assert f"1 combination was tried without success: prop: {what}" in said


def test_no_value_below_the_lowest_of_a_change_is_tried() -> None:
    """The other side of a joint, where one side stands with the flattest wedge already."""
    flat = Change("wedge", lambda _, model, *__: model, str, (5.0, 10.0), close=0.25, low=5.0)
    bench = Bench(Model.of(tower(2), friction=0.6), [1], np.zeros((3, 6)))
    assert bench.smallest([flat, flat]) == (flat, 5.0)


def test_the_page_has_a_stage_for_each_mend_and_a_list_of_them(fallen: Mends) -> None:
    scene = fallen.layers()
    assert [one.label for one in scene.stages[1:]] == [
        f"mend {k}" for k in range(1, len(fallen.mends) + 1)
    ]
    assert scene.charts[0].caption.count("--apply ") == len(fallen.mends)
    titles = [one.headline for one in scene.stages[1:]]
    lines = [one.text for one in fallen.sentences()] + fallen.failures()
    words = {word for line in lines for word in line.split()}
    cut = [one for one in titles if one.endswith(" ...")]
    assert cut
    assert all(set(one[4:-4].split()) <= words for one in cut)
    assert all(len(one) <= 120 and "(cost" not in one for one in titles)  # two lines on a page
    standing = [one for one in scene.stages[1:] if one.role is Role.GOOD]
    assert len(standing) == len(fallen.mends)


def test_what_stands_already_is_said_to_stand() -> None:
    found = find_mends(tower(2), friction=0.6)
    assert found.mends == ()
    assert found.message.startswith("it stands already: ask for a margin")
    assert mend(tower(2), friction=0.6).changes == ()


def test_what_stands_after_settling_only_is_mended_to_stand_for_all_stiffnesses() -> None:
    block = wedge("b", longer=0.2)
    load = LoadCase.tilt(block, (1.0, 0.0, 0.0), 55.0)
    model = Model.of(block, friction=0.84, load=load)
    (found,) = find_mends(model, options=MendOptions(kinds=("prop",))).mends
    assert found.result.stable
    assert found.result.samples.standing == found.result.samples.tried


def test_what_was_tried_is_told_where_nothing_holds() -> None:
    made = mend(h_model(), friction=0.9, options=MendOptions(kinds=("friction", "ballast")))
    assert not made.stands
    assert made.changes == ()
    assert (
        "no mend of the list holds block: friction: it falls up to a coefficient of 4 in all its "
        "joints; 100 % of its load is then still not carried" in made.log[0]
    )
    assert made.log[1:] == ("it still falls: block",)


def test_what_nothing_holds_is_passed_over_and_the_next_region_is_mended() -> None:
    base = box((1.0, 1.0, 1.0), name="base")
    right = box((1.0, 1.0, 0.2), (0.7, 0.0, 1.0), "right")
    left = box((0.8, 1.0, 0.2), (-0.7, 0.0, 1.0), "left")
    model = Model.of(Assembly((base, right, left)).with_fixed([0]), friction=0.6)
    made = mend(model, options=MendOptions(kinds=("glue",), keep=("right",)))
    assert [step.blocks for step in made.changes] == [("left",)]
    assert not made.stands
    assert [text.partition(":")[0] for text in made.log] == [
        made.log[0], "no mend of the list holds right", "it still falls"
    ]  # fmt: skip
    assert made.log[0].startswith("glue between 'base' and 'left' that carries ")
    assert made.log[-1] == "it still falls: right"


def test_of_equal_cost_the_smaller_value_comes_first() -> None:
    base, out = box((1.0, 1.0, 1.0), name="base"), box((1.0, 1.0, 0.2), (0.7, 0.0, 1.0), "out")
    post = box((1.0, 1.0, 1.0), (-0.3, 0.0, 1.0), "post")
    model = Model.of(Assembly((base, out, post)).with_fixed([0, 2]), friction=0.6)
    found = find_mends(model, options=MendOptions(kinds=("glue",))).mends
    assert [one.change.description.split("that")[0] for one in found] == [
        "glue between 'out' and 'post' ", "glue between 'base' and 'out' "
    ]  # fmt: skip
    assert found[0].change.cost == found[1].change.cost == 3.0
    assert found[0].change.value < found[1].change.value


def test_the_force_of_a_prop_is_the_largest_one_at_the_margin() -> None:
    base, out = box((1.0, 1.0, 1.0), name="base"), box((1.0, 1.0, 0.2), (0.7, 0.0, 1.0), "out")
    model = Model.of(Assembly((base, out)).with_fixed([0]), friction=0.6)
    plain, firm = (
        find_mends(model, options=MendOptions(margin=margin, kinds=("prop",))).mends[0]
        for margin in (DesignMargin(), DesignMargin(load=1.5))
    )
    assert firm.change.value == pytest.approx(1.5 * plain.change.value, rel=1e-6)
    assert "N (up) under 'out' at " in firm.change.description
    assert firm.change.description.endswith(" m: the largest force at the margin")
    told = plain.change.description  # 4.71 kN, 0.2 m beyond the edge, on a lever of 0.603 m
    assert "; a jack that pushes by a steady 1.56 kN holds it; " in told
    assert told.endswith("; a post that does not give bears 1.56 kN")
    assert "margin" not in plain.change.description


def test_the_load_of_a_margin_is_what_acts_beside_weight() -> None:
    """An arch under 0.6 of what it carries; weight grew with it, and then nothing ever fell."""
    ring = arch(0.15)
    own, one = LoadCase.gravity(ring), LoadCase.point_load(ring, "voussoir-17", (0.0, 0.0, -1e3))
    carries = drystone.limit_load(Model.of(ring, friction=0.7), one).best.stands
    loaded = Model.of(ring, friction=0.7, load=own + 0.6 * carries * one)
    assert DesignMargin(load=1.6).holds(loaded).stable
    more = DesignMargin(load=1.75)
    found = more.holds(loaded)
    assert found.falls
    assert more.case_of(found, loaded) == "under 1.75 times what loads it beside its weight"
    (alone,) = more.remarks(Model.of(ring, friction=0.7))
    assert alone.endswith("no other load acts")
    assert more.holds(loaded.with_supports(ring.names)).stable  # no block is free
    assert more.remarks(loaded) == DesignMargin().remarks(loaded) == []
    thrust = LoadCase.point_load(ring, "voussoir-17", (0.0, 5e2, -1e3))
    (also,) = more.remarks(loaded.with_load(own + thrust))
    assert also == "load=1.75 also multiplies the 1 kN that press down, which may help"


def test_a_margin_grows_loads_off_blocks_and_shaking_where_they_act() -> None:
    """Twice what acts beside weight, as the sum of its parts has it; arms stayed those of one."""
    blocks = tower(3)
    own = LoadCase.gravity(blocks)
    off = LoadCase.point_load(blocks, "block-2", (0.0, 0.0, -1e3), at=(2.0, 0.5, 5.0))
    more = off + LoadCase.seismic(blocks, 0.1)
    (case,) = DesignMargin(load=2.0).cases(Model.of(blocks, friction=0.6, load=own + more))
    twice = own + 2.0 * more
    assert case.load.wrench == pytest.approx(twice.wrench)
    for name in ("given", "acceleration", "shake"):
        assert getattr(case.load, name) == pytest.approx(getattr(twice, name)), name


def test_of_a_kind_that_misses_the_margin_the_part_that_it_keeps_is_told() -> None:
    """At a friction of 0.6 a plate on a prop slides beyond 31 degrees: 30 is 12 parts of 16."""
    base, out = box((1.0, 1.0, 1.0), name="base"), box((1.0, 1.0, 0.2), (0.7, 0.0, 1.0), "out")
    model = Model.of(Assembly((base, out)).with_fixed([0]), friction=0.6)
    options = MendOptions(margin=DesignMargin(tilt=40.0), kinds=("prop",))
    found = find_mends(model, options=options)
    assert found.mends == ()
    (note,) = [one.text for one in found.sentences() if one.text.startswith("less than the margin")]
    assert note.startswith("less than the margin: with tilt=30deg: a prop of ")


def test_of_many_blocks_the_least_value_that_the_whole_needs_is_told() -> None:
    """A vault made 14 % thicker stands; of one made 12 % thicker no forces balance the loads."""

    def vault(thicker: float) -> Model:
        thickness = 0.18 * (1.0 + thicker)
        thin = barrel_vault(thickness=thickness, courses=13, blocks=4, length=3.0, staggered=False)
        return Model.of(thin.with_fixed([]), friction=0.6, supports="ground")

    only = find_mends(vault(0.0), options=MendOptions(kinds=("thicker",))).mends[0]
    assert only.change.value == pytest.approx(0.14)
    assert only.result.samples.standing == only.result.samples.tried
    assert check(vault(0.12)).falls
    assert check(vault(0.14)).stable


def test_a_pier_gets_thicker_where_it_overturns_and_its_foot_with_it() -> None:
    """A pier 3 m high and 0.3 m wide tips at 5.7 degrees; at 8 its foot needs 0.42 m, 41 % more."""
    courses = [box((0.3, 0.8, 1.0), (0.0, 0.0, z), f"course-{z}") for z in range(-1, 3)]
    model = Model.of(Assembly(tuple(courses)).with_fixed([0]), friction=0.7)
    options = MendOptions(margin=DesignMargin(tilt=8.0), kinds=("thicker",))
    (only,) = find_mends(model, options=options).mends
    assert only.change.value == pytest.approx(3.0 * np.tan(np.deg2rad(8.0)) / 0.3 - 1.0, abs=0.03)
    assert "and 'course--1' thicker by" in only.change.description
    assert "along x" in only.change.description
    assert "overhang" not in only.change.description  # its foot is the ground


def test_what_wet_earth_pushes_is_told_of_a_drain() -> None:
    made = tower(2)
    kinds = MendOptions(kinds=("merge",))

    def told(water: str) -> str:
        earth = Earth.named(f"side=-x,weight=20kN/m3,k=2{water}").on(made)
        model = Model.of(made, load=LoadCase.gravity(made) + earth, friction=0.3)
        return " ".join(one.text for one in find_mends(model, options=kinds).sentences())

    assert "a drain was not tried: " in told(",water=2m")
    assert "drain" not in told("")


def test_a_pier_and_its_abutment_get_thicker_together_away_from_the_arch_that_pushes() -> None:
    """About the outer foot both weights, which grow as their arms do, balance the push."""
    parts = (
        box((4.0, 1.0, 0.2), (-3.0, 0.0, -0.2), "base"), box((0.6, 1.0, 2.0), name="pier"),
        box((0.5, 1.0, 0.4), (0.1, 0.0, 2.0), "abutment"),
        box((0.3, 1.0, 0.4), (0.6, 0.0, 2.0), "arch"),
    )  # fmt: skip
    assembly = Assembly(parts).with_fixed([0, 3])
    push = LoadCase.point_load(assembly, "abutment", (-6e3, 0.0, 0.0), (0.6, 0.5, 2.2))
    model = Model.of(assembly, friction=2.0, load=LoadCase.gravity(assembly) + push)
    (both,) = find_mends(model, options=MendOptions(kinds=("thicker",))).mends
    weight = assembly.mass[1:3] * 9.81
    share = np.sqrt(6e3 * 2.2 / (weight @ [0.3, 0.35])) - 1.0
    assert share <= both.change.value < share + 0.02
    told = both.change.description
    assert told.startswith("'pier' and 'abutment' thicker by 16 %, the thinnest from 500 mm")
    assert ", on one free face, along x; free mass" in told  # none overhangs another


def test_a_pier_gets_thicker_with_its_foot_and_not_with_the_course_below() -> None:
    """It tips away from a stub that leaves it one free face; the stone of the course has none."""
    ditch = [(-0.5, -1.2), (1.1, -1.2), (1.1, -0.5), (0.8, -0.5), (0.8, -1.0), (-0.2, -1.0),
             (-0.2, -0.5), (-0.5, -0.5)]  # fmt: skip
    parts = (
        prism(ditch, (0.0, 1.0), "ditch"),
        box((0.2, 1.0, 0.4), (0.3, 0.0, 0.0), "stub"),
        box((1.0, 1.0, 0.5), (-0.2, 0.0, -1.0), "stone"),
        box((1.0, 1.0, 0.5), (-0.2, 0.0, -0.5), "foot"), box((0.3, 1.0, 2.0), name="pier"),
        box((0.6, 1.0, 0.3), (-0.15, 0.0, 2.0), "cap"),
    )  # fmt: skip
    assembly = Assembly(parts).with_fixed([0, 1])
    tilted = LoadCase.tilt(assembly, (0.0, -1.0, 0.0), 8.0)
    model = Model.of(assembly, friction=0.3, load=tilted)
    options = MendOptions(kinds=("thicker",), margin=DesignMargin(robust=False))
    found = find_mends(model, options=options)
    told = [one.change.description.partition(" thicker")[0] for one in found.mends]
    assert told == ["'pier'", "'pier' and 'foot'", "'pier' and 'cap'"]
    assert "stone" not in " ".join(found.failures())


def test_a_pier_gets_thicker_alone_and_a_cap_that_is_kept_does_not() -> None:
    """A pier and its cap tip about its foot: half its width is less than their height leans."""
    parts = (
        box((0.5, 0.8, 0.2), (-0.1, 0.0, -0.2), "base"), box((0.3, 0.8, 2.0), name="pier"),
        box((0.6, 0.8, 0.3), (-0.15, 0.0, 2.0), "cap"),
    )  # fmt: skip
    assembly = Assembly(parts).with_fixed([0])
    model = Model.of(assembly, friction=0.7, load=LoadCase.tilt(assembly, (0.0, 1.0, 0.0), 8.0))
    kinds = MendOptions(kinds=("thicker",), keep=("cap",))
    (kept,) = find_mends(model, options=kinds).mends
    both = find_mends(model, options=replace(kinds, keep=())).mends
    assert kept.change.description.startswith("'pier' thicker by ")
    told = [one.change.description.partition(" thicker")[0] for one in both]
    assert told == ["'pier'", "'pier' and 'cap'"]
    assert kept.change.value == both[0].change.value
    assert not any("overhang" in one.change.description for one in both)  # the base is wider


def test_thicker_blocks_do_not_stand_on_a_ledge_that_they_make() -> None:
    """A block on a tilted pier; 9 % thicker it would lie on the buttress beside, with 14 mm."""
    parts = (
        box((0.3, 0.8, 1.0), name="pier"), box((0.5, 0.8, 1.0), (0.3, 0.0, 0.0), "buttress"),
        box((0.3, 0.8, 1.0), (0.0, 0.0, 1.0), "top"),
    )  # fmt: skip
    assembly = Assembly(parts).with_fixed([0, 1])
    model = Model.of(assembly, friction=0.7, load=LoadCase.tilt(assembly, (0.0, 1.0, 0.0), 18.0))
    options = MendOptions(kinds=("thicker",), keep=("buttress",))
    assert find_mends(model, options=options).mends == ()


def test_a_block_that_gets_thicker_upwards_overhangs_nothing() -> None:
    """A block with a wing beside its pier, lifted at the end of the wing."""
    section = [(0.0, 1.0), (0.8, 1.0), (0.8, 1.3), (2.0, 1.3), (2.0, 1.5), (0.0, 1.5)]
    pier, wing = box((0.8, 1.0, 1.0), name="pier"), prism(section, (0.0, 1.0), "wing")
    assembly = Assembly((pier, wing)).with_fixed([0])
    own = LoadCase.gravity(assembly)
    lifted = -0.5 * own.wrench[1, :3]
    load = own + LoadCase.point_load(assembly, "wing", lifted, (2.0, 0.5, 1.5))
    model = Model.of(assembly, friction=0.7, load=load)
    (found,) = find_mends(model, options=MendOptions(kinds=("thicker",))).mends
    assert ", along z; free mass" in found.change.description


def test_what_a_structure_stands_without_is_no_part_of_a_margin_that_is_told() -> None:
    """A pier stands to 5.7 degrees; a prop or rougher joints are no help below that."""
    courses = [box((0.3, 0.8, 1.0), (0.0, 0.0, z), f"course-{z}") for z in range(-1, 3)]
    model = Model.of(Assembly(tuple(courses)).with_fixed([0]), friction=0.7)
    options = MendOptions(margin=DesignMargin(tilt=45.0), kinds=("slide",))
    assert not any(one.less for _, one in find_mends(model, options=options).tried)


def test_two_arches_under_a_beam_get_a_tie_each() -> None:
    """Neither stands with a tie in the other one."""
    blocks, fixed = [], []
    for name, y in (("a", 0.0), ("b", 1.5)):
        one = arch(thickness_ratio=0.09, voussoirs=9).transformed(
            np.eye(3), np.array([0.0, y, 0.0])
        )
        blocks += [block.renamed(f"{block.name}-{name}") for block in one.blocks]
        fixed += one.fixed.tolist()
    top = blocks[5].bounds[1, 2]
    beam = box((0.1, 1.8, 0.1), (-0.05, 0.0, top), "beam")
    model = Model.of(Assembly((*blocks, beam), [*fixed, False]), friction=0.7)
    (only,) = find_mends(model, options=MendOptions(kinds=("tie",))).mends
    assert (
        "2 ties that pull 147 N between the middles of 'voussoir-01-a'" in only.change.description
    )
    assert "147 N between the middles of 'voussoir-01-b'" in only.change.description
    assert only.change.added == 2


def test_thicknesses_that_were_tried_are_told() -> None:
    """However thick, a plate whose middle lies beyond its edge tips."""
    base, out = box((1.0, 1.0, 1.0), name="base"), box((1.0, 1.0, 0.2), (0.7, 0.0, 1.0), "out")
    model = Model.of(Assembly((base, out)).with_fixed([0]), friction=0.6)
    found = find_mends(model, options=MendOptions(kinds=("thicker",)))
    ((_, tried),) = found.tried
    assert tried.what.startswith("10, 30 and 100 % more thickness of 'out', along x; ")


def test_blocks_to_keep_are_not_changed() -> None:
    base, out = box((1.0, 1.0, 1.0), name="base"), box((1.0, 1.0, 0.2), (0.7, 0.0, 1.0), "out")
    kinds = ("let-in", "glue", "thicker", "friction", "merge", "turn", "slide")
    for keep in ("out", "lowest, [o]*"):  # read as supports are
        options = MendOptions(kinds=kinds, keep=(keep,))
        found = find_mends(Assembly((base, out)).with_fixed([0]), friction=0.6, options=options)
        assert found.mends == ()
        assert {one.kind for _, one in found.tried} == {*kinds}
        assert all("may not be changed" in one.what for _, one in found.tried)
        (note,) = [one.text for one in found.sentences() if "kept" in one.text]
        assert "'out' kept: " in note
        assert "tried without" not in note


def test_wrong_options_are_refused_in_words() -> None:
    with pytest.raises(InputError, match="no kind of mend 'magic'"):
        MendOptions(kinds=("magic",))
    with pytest.raises(InputError, match=r"'glue,tie'; give several each on its own"):
        MendOptions(kinds=("glue,tie",))
    with pytest.raises(InputError, match="no kind of mend is allowed"):
        MendOptions(kinds=())
    with pytest.raises(InputError, match=r"friction is 1\.5; give a number above zero, up to 1"):
        DesignMargin(friction=1.5)
    with pytest.raises(InputError, match="no block is called 'nobody'"):
        find_mends(tower(2), options=MendOptions(keep=("nobody",)))


@pytest.fixture
def overhang(tmp_path: Path) -> str:
    base, out = box((1.0, 1.0, 1.0), name="base"), box((1.0, 1.0, 0.2), (0.7, 0.0, 1.0), "out")
    path = tmp_path / "overhang.json"
    drystone.write(Model.of(Assembly((base, out)).with_fixed([0]), friction=0.6), path)
    return str(path)


def test_the_command_writes_a_model_that_stands_and_a_page_with_what_it_was(
    overhang: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, page = tmp_path / "stands.json", tmp_path / "after.html"
    arguments = ["--auto", "--kind", "merge", "--out", str(out), "--html", str(page)]
    assert main(["mend", overhang, *arguments]) == 0
    assert "STABLE" in capsys.readouterr().out
    assert drystone.check(out).stable
    assert "edges before" in page.read_text(encoding="utf-8")


def test_the_command_lists_mends_and_makes_the_one_that_is_chosen(
    overhang: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["--kind", "prop", "--kind", "glue", "--margin", "friction=0.9x", "--json"]
    folder = tmp_path / "pages"
    assert main(["mend", overhang, *arguments, "--pages", str(folder)]) == 1
    told = json.loads(capsys.readouterr().out)
    assert [one["kind"] for one in told["mends"]] == ["prop", "glue"]
    assert not any("no margin was asked for" in one for one in told["notes"])
    pages = sorted(folder.iterdir())
    assert [page.name for page in pages] == ["mend-01.html", "mend-02.html"]
    assert "a prop of" in pages[0].read_text(encoding="utf-8")
    out = tmp_path / "propped.json"
    assert main(["mend", overhang, *arguments, "--apply", "1", "--out", str(out)]) == 0
    assert json.loads(capsys.readouterr().out)["verdict"] == "stable"
    assert drystone.check(out).stable
    assert main(["mend", overhang, *arguments[:2], "--apply", "1"]) == 0
    assert capsys.readouterr().out.startswith("STABLE, changed")
    assert main(["mend", overhang, "--kind", "prop", "--json"]) == 1
    assert "no margin was asked for: --margin" in json.loads(capsys.readouterr().out)["notes"][-1]


def test_a_file_that_no_mend_has_changed_is_not_written(
    overhang: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "falls.json"
    assert main(["mend", overhang, "--auto", "--kind", "friction", "--out", str(out)]) == 1
    told = " ".join(capsys.readouterr().out.split())
    assert "UNSTABLE" in told
    assert "it still falls: out" in told
    assert "is not written: no mend was made" in told
    assert not out.exists()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--auto", "--diagnose"], "ask for different things"),
        (["--auto", "--pages", "folder"], "is for the list of mends"),
        (["--out", "x.json"], "no mend is made"),
        (["--margin", "tilt=steep"], "has no number"),
        (["--margin", "load=0.5"], "give 1 or more"),
        (["--margin", "wind=3"], "is no margin"),
        (["--margin", "load=1.1", "--margin", "load=1.2"], "given twice"),
        (["--kind", "prop", "--apply", "7"], "there is no mend 7"),
        (["--kind", "tie", "--kind", "support", "--apply", "1"], "no mend 1: tie, support failed"),
        (["--apply", "0"], "--apply: is 0; give 1 or more"),
        (["--pages", f"{__file__}/pages"], "is no folder; name another folder"),
    ],
)
def test_the_command_refuses_what_contradicts_itself(
    overhang: str, arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["mend", overhang, *arguments]) == 2
    assert said in capsys.readouterr().err


def test_why_there_is_nothing_to_mend_is_said_once() -> None:
    model = Model.of(tower(2))
    undecided = replace(check(model), verdict=Verdict.UNDECIDED)
    said = [one.text for one in find_mends(model, result=undecided).sentences()]
    assert sum("no block needs help" in one for one in said) == 1


def corbel(count: int = 5, out: float = 0.13) -> Model:
    """Stones on a bed, each further towards +x than the one below it."""
    bed = box((1.2, 0.4, 0.2), (0.0, 0.0, -0.2), "bed")
    stones = [
        box((0.5, 0.4, 0.2), (0.35 + out * k, 0.0, 0.2 * k), f"stone-{k}") for k in range(count)
    ]
    return Model.of(Assembly((bed, *stones)).with_fixed([0]), friction=0.7)


def test_words_of_a_mend_tell_the_way_where_gravity_is_not_along_z() -> None:
    """What was level is along z then."""
    turned = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    assembly = corbel().assembly.transformed(turned)
    load = LoadCase.gravity(assembly, direction=(-1.0, 0.0, 0.0))
    model = Model.of(assembly, friction=0.7).with_load(load)
    (drawn,) = find_mends(model, options=MendOptions(kinds=("slide",))).mends
    assert "drawn back towards +z, to overhang " in drawn.change.description


def test_a_corbel_is_propped_from_below_or_each_of_its_stones_overhangs_less() -> None:
    found = find_mends(corbel(), options=MendOptions(kinds=("prop", "slide")))
    prop, drawn = (one.change for one in found.mends)
    assert "N (up) under 'stone-3' at" in prop.description  # below 4 a head without friction slips
    (region,) = found.diagnosis.regions
    (held,) = region.needs.props.props
    assert held.force[2] == pytest.approx(held.size, rel=1e-9)
    assert "drawn back towards -x, to overhang " in drawn.description
    built = drystone.plan(found.mends[0].model)
    needs = "1 permanent prop, which must be there before 'stone-3'"
    assert built.title == f"Can be assembled with {needs}"
    assert [one.text for one in built.sentences()].count(needs) == 1
    for stage in built.layers().stages:
        (post,) = (one for one in stage.layers if one.key == "posts")
        foot = float((post.position + np.asarray(post.vector))[0, 2])
        assert foot == pytest.approx(float(corbel().assembly.bounds[:, 0, 2].min()))
    share = drawn.value
    # stones 1 to 4 tip about the edge of stone 0 if the mean of their overhangs is above 0.25
    stands, falls = corbel(out=0.1), corbel(out=0.1001)
    assert (check(stands).stable, check(falls).falls) == (True, True)
    assert 0.13 * (1.0 - share) == pytest.approx(0.1, abs=0.13 * 0.011)
    mended = found.mends[1].model.assembly.centroid[1:, 0]
    assert np.diff(mended) == pytest.approx(0.13 * (1.0 - share))


def test_treads_that_tip_off_their_piers_are_propped_and_not_their_tails_pressed_down() -> None:
    blocks = []
    for k in range(3):
        at, rise = 0.3 * k, 0.3 + 0.18 * k
        blocks += [
            box((0.25, 0.3, rise), (0.0, at, 0.0), f"pier-{k}"),
            box((1.0, 0.3, 0.18), (0.0, at, rise), f"tread-{k}"),
            box((0.25, 0.3, 0.4), (0.0, at, rise + 0.18), f"tail-{k}"),
        ]
    model = Model.of(Assembly(tuple(blocks)).with_fixed([0, 3, 6]), friction=0.6)
    found = find_mends(model, options=MendOptions(kinds=("prop", "slide")))
    told = {one.change.kind: one.change.description for one in found.mends}
    assert told["prop"].startswith("3 props: each of 720 N (up), under 'tread-0' at")
    slid = next(one.change for one in found.mends if "slid by" in one.change.description)
    assert slid.description.endswith("towards -x on 'pier-0', 'pier-1' and 'pier-2'")


def test_a_vault_of_many_blocks_may_be_thicker_and_a_tie_says_how_long_it_is() -> None:
    vault = drystone.models.barrel_vault(thickness=0.09, courses=15, blocks=3, length=2.0)
    found = find_mends(vault, friction=0.6, options=MendOptions(kinds=("thicker", "tie")))
    tie, thicker = (one.change.description for one in found.mends)
    (row,) = found.mends[1].tables()[1]
    assert row["after"] == pytest.approx(1.52 * row["before"], rel=0.02)
    assert (
        "between the middles of 'c03-b01' and 'c11-b01', 2.96 m apart, 2.84 m of it in the open"
        in tie
    )
    grown = "half of it on each of two opposite free faces"
    assert f"thicker by 52 %, from 89.5 mm to 136 mm, {grown}" in thicker
    assert thicker.endswith("; free mass from 2.34 t to 3.55 t")


def test_what_stands_without_the_margin_is_not_headed_as_falling(tmp_path: Path) -> None:
    """The heading, the title and the page name the case of the margin in which it falls."""
    options = MendOptions(margin=DesignMargin(friction=0.3), kinds=("friction",))
    leaning = Model.of(tower(2), friction=0.6, load=LoadCase.tilt(tower(2), (1.0, 0.0, 0.0), 20.0))
    found = find_mends(leaning, options=options)
    said = [one.text for one in found.sentences()]
    assert said[0] == "STANDS; with 30 % of its friction it falls"
    assert "with 30 % of its friction: no contact forces can balance the loads" in said
    assert found.title.startswith("Stands; with 30 % of its friction, falls: block 'block-1'; ")
    headline = found.layers().stages[0].headline
    assert headline == "Stands; with 30 % of its friction, falls: block 'block-1'"
    assert found.code == 1
    bare = find_mends(leaning.with_friction(0.2), options=options)
    assert bare.sentences()[0].text == "UNSTABLE"
    kept = MendOptions(margin=DesignMargin(friction=0.3), kinds=("friction",), keep="*")
    made = mend(leaning, options=kept)
    assert made.sentences()[0].text == "STANDS, not at the margin"


def test_a_mend_names_each_block_once() -> None:
    found = find_mends(h_model(), friction=0.4, options=MendOptions(kinds=("let-in", "merge")))
    let_in, merged = (one.text for one in found.sentences()[1:3])
    assert "; like it is mend 2, elsewhere" in let_in
    assert let_in.startswith("mend 1: the joint of 'block' with 'left' let in by ")
    assert "is cut so deep, the other as much longer" in let_in
    assert (merged.count("'block'"), merged.count("'left'")) == (1, 1)
    made = mend(h_model(), friction=0.4, options=MendOptions(kinds=("let-in",)))
    told = [one.text for one in made.sentences()]
    assert sum("let in by" in text for text in told) == 1


def test_mends_that_cost_the_same_but_for_rounding_are_both_told_their_tilt_and_no_more() -> None:
    """A wedge in a trough, to be turned on either side: a list of mends tells no friction."""
    sides = [[(0.0, 0.0), (x, 0.0), (x, 1.0)] for x in (-0.63, 0.63)]
    sections = [*sides, [(0.0, 0.0), (0.63, 1.0), (-0.63, 1.0)]]
    trough = Assembly(tuple(prism(one, (0.0, 1.0), f"{i}") for i, one in enumerate(sections)))
    trough = trough.with_fixed([0, 1])
    load = LoadCase.tilt(trough, (1.0, 0.0, 0.0), 38.0)
    options = MendOptions(kinds=("turn",))
    one, two = find_mends(Model.of(trough, friction=0.37, load=load), options=options).mends
    assert one.change.cost != two.change.cost == pytest.approx(one.change.cost, rel=1e-12)
    assert one.price == two.price == "cost 5.88, margin: 16 degrees of tilt"
    assert one.result.friction_margin is None
    assert with_margins(one.result).friction_margin == pytest.approx(0.82, abs=0.01)


@dataclass(frozen=True)
class Counted(DesignMargin):
    """Keeps what each model that was tried came to, and whether it began near a rest state."""

    tried: ClassVar[list[bool]] = []
    near: ClassVar[list[bool]] = []

    def stands(self, model: Model, **how: Any) -> bool:
        self.near.append(bool(how["near"]))
        self.tried.append(super().stands(model, **how))
        return self.tried[-1]

    def holds(self, model: Model, *stop: Any, **how: Any) -> Result:
        self.near.append(bool(how.get("near")))
        return super().holds(model, *stop, **how)


def test_what_falls_by_a_mechanism_that_no_friction_stops_is_not_tried() -> None:
    wide = wall(8, 6)
    falls = Model.of(wide, friction=0.6, load=LoadCase.tilt(wide, (1.0, 0.0, 0.0), 25.0))
    Counted.tried.clear()
    found = find_mends(falls, options=MendOptions(Counted(), kinds=("friction", "glue")))
    assert [one.what for _, one in found.tried] == [
        "it falls up to a coefficient of 4 in all its joints"
    ]
    assert [one.change.kind for one in found.mends] == ["glue"]
    assert Counted.tried
    assert all(Counted.tried)


def test_a_prop_of_a_large_region_is_tried_and_checked_where_it_was_found_to_rest() -> None:
    """Beside a block that stands."""
    vault = barrel_vault(courses=15, blocks=3, length=2.0)
    base, block = (
        box((0.5, 0.5, 0.2), (9.0, 0.0, 0.0), "base"),
        box((0.5, 0.5, 0.2), (9.0, 0.0, 0.2)),
    )
    whole = Assembly((*vault.blocks, base, block))
    whole = whole.with_fixed([*np.flatnonzero(vault.fixed).tolist(), "base"])
    falls = Model.of(whole, friction=0.6, load=LoadCase.tilt(whole, (0.0, 1.0, 0.0), 21.0))
    Counted.near.clear()
    found = find_mends(falls, options=MendOptions(Counted(), kinds=("prop",)))
    assert [one.change.kind for one in found.mends] == ["prop"]
    assert Counted.near == [False, True, True]


def test_a_mended_model_is_told_with_the_file_that_it_was_made_of(tmp_path: Path) -> None:
    path = tmp_path / "h.json"
    drystone.write(Model.of(h_model(), friction=0.4), path)
    made = mend(path, options=MendOptions(kinds=("wedge",)))
    assert made.stands
    assert made.asked.file == str(path)
    assert "h.json" in made.layers().facts["File"]


def test_of_many_props_the_largest_are_told_and_each_one_pushes() -> None:
    blocks = [box((0.25, 0.3, 0.3), (0.0, 0.4 * k, 0.0), f"pier-{k}") for k in range(6)]
    long = [1.0 + 0.05 * k for k in range(6)]
    blocks += [box((x, 0.3, 0.18), (0.0, 0.4 * k, 0.3), f"tread-{k}") for k, x in enumerate(long)]
    beam = box((0.1, 2.3, 0.02), (0.6, 0.0, 0.48), "beam")  # one region
    model = Model.of(Assembly((*blocks, beam)).with_fixed(list(range(6))), friction=0.6)
    (found,) = find_mends(model, options=MendOptions(kinds=("prop",))).mends
    assert found.change.description.startswith(f"{found.change.added} props: ")
    told = (
        f", and {found.change.added - 3} with less; a post that does not give bears at most 1.18 kN"
    )
    assert found.change.description.endswith(told)
    forces = [row["force"] for row in found.result.reactions() if "prop" in row["support"]]
    assert len(forces) == found.change.added
    assert min(np.linalg.norm(one) for one in forces) > 0.0


def test_a_margin_of_loads_multiplies_the_pressure_that_is_drawn_with_them() -> None:
    blocks = tower(2)
    wind = LoadCase.surface_load(blocks, 1, (2000.0, 0.0, 0.0), facing=(-1, 0, 0))
    model = Model.of(blocks, friction=0.6, load=LoadCase.gravity(blocks) + wind)
    (case,) = DesignMargin(load=1.5).cases(model)
    drawn, given = case.load.surface, model.load.surface
    assert drawn is not None
    assert given is not None
    np.testing.assert_allclose(drawn.traction, 1.5 * given.traction)
    np.testing.assert_allclose(case.load.wrench[1, [0, 2]], [3000.0, -23544.0])


def test_two_parts_that_fall_are_listed_apart_and_one_mend_of_each_makes_it_stand() -> None:
    blocks = [
        box(size, (5.0 * k + at, 0.0, z), f"{name}-{k}")
        for k in range(2)
        for size, at, z, name in (
            ((1.0, 1.0, 1.0), 0.0, 0.0, "base"),
            ((1.0, 1.0, 0.2), 0.7, 1.0, "out"),
        )
    ]
    model = Model.of(Assembly(tuple(blocks)).with_fixed([0, 2]), friction=0.6)
    found = find_mends(model, options=MendOptions(kinds=("glue",)))
    said = [one.text for one in found.sentences()]
    assert said[1].endswith("--auto or --apply 1,2 makes the cheapest of each")
    assert said[2] == "for 'out-0':"
    assert said[3].startswith("mend 1: glue between")
    assert said[4] == "for 'out-1', alike: mend 2, as mend 1"
    assert found.failures()[0].startswith("mend 2: glue between")
    one = found.mends[0]
    assert (one.stands, one.held) == (False, ("out-1",))
    assert one.sentences()[-1].text == "still falls, held in this trial only: out-1"
    for stage in (one.layers().stages[0], found.layers().stages[1]):
        assert stage.role is Role.UNSURE
        assert "till fall" in stage.headline
        assert "out-1" in stage.headline
        assert (stage.state == State.FALLING).any()
    assert found.together([2, 1]).stands
    alone = found.together([1])
    assert (alone.stands, alone.message) == (False, "it still falls: out-1")
    with pytest.raises(InputError, match=r"mends 1 and 1 are both of out-0"):
        found.together([1, 1])


def test_mends_that_are_made_stand_only_at_the_margin_of_the_search(fallen: Mends) -> None:
    made = fallen.together([3], options=MendOptions(margin=DesignMargin(tilt=2.0)))
    assert (made.stands, made.message[:20]) == (False, "tilted by 2 degrees ")
    assert made.message.endswith(", it still falls: block-10")


def test_a_board_on_two_loose_cleats_is_held_by_the_joints_of_both() -> None:
    """Nothing presses on the cleats: one of them let in leaves the other one to slide."""
    blocks = []
    for name, x, inner in (("left", 0.0, 0.1), ("right", 1.1, 1.0)):
        blocks.append(box((0.1, 0.3, 1.2), (x, 0.0, 0.0), f"upright-{name}"))
        blocks.append(box((0.1, 0.3, 0.1), (inner, 0.0, 0.3), f"cleat-{name}"))
    blocks.append(box((0.9, 0.3, 0.05), (0.15, 0.0, 0.4), "board"))
    model = Model.of(Assembly(tuple(blocks)).with_fixed([0, 2]), friction=0.5)
    found = find_mends(model, options=MendOptions(kinds=("let-in", "tie"), keep=("board",)))
    let_in, dowels = sorted((one.change for one in found.mends), key=lambda one: one.kind)
    both = "the joint of 'cleat-left' with 'upright-left' and the joint of 'cleat-right' with"
    assert let_in.description.startswith(f"{both} 'upright-right', each let in by 10 mm")
    assert dowels.description.startswith("2 dowels that pull ")
    assert dowels.description.endswith("apart through their joint")
    assert (let_in.joints, dowels.joints, dowels.cost) == (2, 2, 6.0)
    assert sum("with 'board' kept" in one.skipped for _, one in found.tried) == 2  # one a joint


def test_what_spreads_is_held_by_a_pair_of_shores_alike_on_both_sides() -> None:
    """No one prop holds the four stones of a thin arch."""
    (both,) = find_mends(arch(0.06, 4), friction=0.7, options=MendOptions(kinds=("prop",))).mends
    left, right = both.result.resultants.force[-2:]
    np.testing.assert_allclose(left, right * (-1.0, 1.0, 1.0), atol=0.01 * np.linalg.norm(left))
    assert left[0] > abs(left[2])
    against = re.findall(r"against '([^']*)'", both.change.description)
    assert against == ["voussoir-00", "voussoir-03"]
