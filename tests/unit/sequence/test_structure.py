"""Subsets of a structure: the verdict of a check of each, whatever is known of others."""

import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import drystone
from drystone import CheckOptions, InputError, Model, Structure, Verdict, check
from drystone.models import arch, bridge, corbelled_wall, dome, tower, wall
from drystone.sequence import Evaluator, Stage, StagedModel
from drystone.sequence.stages import ALIKE, StageCheck, mask_of
from drystone.stability.problem import Problem


def orders(model: Model, seed: int, count: int) -> np.ndarray:
    """Different subsets (s, n) of so many random orders of removal, which begin at the top."""
    draw = np.random.default_rng(seed)
    free = model.assembly.free
    height = model.assembly.centroid[free, 2]
    found: dict[bytes, np.ndarray] = {}
    for _ in range(count):
        mask = np.ones(len(model), dtype=bool)
        for block in free[np.argsort(-height - draw.normal(0.0, 0.3, len(free)))][:-1]:
            mask[block] = False
            found[mask.tobytes()] = mask.copy()
    return np.array(list(found.values()))


def checked(model: Model, mask: np.ndarray, held: tuple[int, ...] = ()) -> Verdict:
    fixed = np.flatnonzero(model.assembly.fixed).tolist()
    resting = model.with_supports([*fixed, *held])
    return check(resting.subset(np.flatnonzero(mask | model.assembly.fixed))).verdict


@pytest.mark.parametrize(
    ("model", "count"),
    [
        (Model.of(arch(0.3, 7), friction=0.7), 10),
        (Model.of(bridge(), friction=0.66), 6),
        (Model.of(wall(4, 3), friction=0.6), 8),
        (Model.of(tower(5), friction=0.6), 4),
    ],
)
def test_each_subset_has_the_verdict_of_a_check(model, count):
    masks = orders(model, 1, count)
    found = Structure(model).stands_many(masks)
    assert list(found.verdict) == [checked(model, mask) for mask in masks]
    assert {*found.verdict} >= {Verdict.STABLE}
    assert (np.isnan(found.friction_left) == (np.array(found.verdict) == Verdict.UNDECIDED)).all()
    assert not found.falling[found.stands].any()


def test_what_is_asked_before_changes_no_verdict():
    model = Model.of(arch(0.3, 7), friction=0.7)
    masks = orders(model, 2, 10)
    structure = Structure(model)
    one_by_one = [structure.stands(mask).verdict for mask in masks[::-1]]
    assert one_by_one[::-1] == list(Structure(model).stands_many(masks).verdict)
    assert one_by_one[::-1] == list(structure.stands_many(masks).verdict)


def test_a_fall_proves_smaller_subsets_to_fall_with_the_blocks_that_move():
    model = Model.of(arch(0.3, 7), friction=0.7)
    structure = Structure(model)
    half = structure.stands([1, 2, 3, 4])
    assert half.verdict is Verdict.UNSTABLE
    known = structure.stands([1, 2, 3, 4, 7])
    assert set(half.falling) == set(known.falling)


def test_held_blocks_count_as_fixed_and_tell_the_force_on_them():
    model = Model.of(arch(0.3, 7), friction=0.7)
    structure = Structure(model)
    assert structure.stands([1, 2, 3, 4]).verdict is Verdict.UNSTABLE
    held = structure.stands([1, 2, 3, 4], held=[4])
    assert held.verdict is checked(model, np.isin(np.arange(9), [1, 2, 3, 4]), (4,))
    assert held.stands
    assert held.reaction[4][2] > 0.0
    assert structure.stands([1, 2, 3, 4], held=["voussoir-03"]).stands
    many = structure.stands_many(np.isin(np.arange(9), [1, 2, 3, 4])[None], held=np.arange(9) == 4)
    assert many[0].stands


def test_a_stage_may_have_a_load_of_its_own():
    structure = Structure(tower(3), friction=0.6)
    assert structure.stands([1, 2]).stands
    assert structure.stands([1, 2], load=(7.0, 0.0, -9.81)).verdict is Verdict.UNSTABLE
    assert structure.stands([1, 2]).stands


def test_the_friction_left_is_what_the_most_used_joint_leaves():
    structure = Structure(tower(3), friction=0.6)
    assert structure.stands([1, 2]).friction_left == pytest.approx(1.0)
    pushed = structure.stands([1, 2], load=(0.3 * 9.81, 0.0, -9.81))
    assert pushed.friction_left == pytest.approx(0.5, abs=1e-6)
    assert structure.stands([1, 2], load=(7.0, 0.0, -9.81)).friction_left == 0.0


def test_nothing_in_place_stands_and_what_touches_nothing_falls():
    structure = Structure(tower(4), friction=0.6)
    assert structure.stands([]).stands
    found = structure.stands([1, 3])
    assert (found.verdict, found.falling) == (Verdict.UNSTABLE, (3,))


def test_robust_answers_tell_whether_other_stiffnesses_hold_it_too():
    model = Model.of(arch(0.11, 11), friction=0.9)
    robust, plain = Structure(model, robust=True), Structure(model)
    everything = np.ones((1, len(model)), dtype=bool)
    assert robust.stands_many(everything).verdict == plain.stands_many(everything).verdict
    tall = Structure(tower(3), friction=0.6, robust=True)
    assert not tall.stands([1, 2]).sensitive


def test_a_check_that_takes_too_long_is_undecided():
    structure = Structure(arch(0.3, 7), friction=0.7, each_s=0.0)
    found = structure.stands([1, 2, 3, 4, 5, 6, 7])
    assert found.verdict is Verdict.UNDECIDED
    assert "time" in found.message


def test_a_search_that_is_stopped_leaves_the_rest_undecided():
    model = Model.of(tower(4), friction=0.6)
    found = Structure(model).stands_many(orders(model, 0, 3), stop=lambda: True)
    assert {*found.verdict} == {Verdict.UNDECIDED}
    assert found[0].message == "it was interrupted"


def test_workers_give_the_same_verdicts():
    model = Model.of(arch(0.3, 7), friction=0.7)
    masks = orders(model, 3, 5)
    alone = Structure(model).stands_many(masks).verdict
    with ThreadPoolExecutor(2) as threads:
        assert Structure(model).stands_many(masks, executor=threads).verdict == alone


def test_a_structure_travels_to_other_processes():
    structure = Structure(tower(3), friction=0.6, robust=True, each_s=5.0)
    there = pickle.loads(pickle.dumps(structure))
    assert (there.robust, there.each_s, there.kept) == (True, 5.0, structure.kept)
    assert there.stands([1, 2]).stands


def test_few_answers_are_kept_where_few_may_be():
    model = Model.of(wall(3, 2), friction=0.6)
    masks = orders(model, 1, 5)
    few = Structure(model, kept=2).stands_many(masks)
    assert few.verdict == Structure(model).stands_many(masks).verdict


def test_what_cannot_be_asked_is_refused():
    structure = Structure(tower(3), friction=0.6)
    for wrong in (np.ones((2, 4), dtype=bool), np.ones(3, dtype=bool), np.ones((2, 3))):
        with pytest.raises(InputError, match="masks"):
            structure.stands_many(wrong)
    with pytest.raises(InputError, match="'block-2' is held and not in place"):
        structure.stands([1], held=[2])
    with pytest.raises(InputError, match="no block is fixed"):
        Structure(Model.of(tower(3).with_fixed([])))
    with pytest.raises(InputError, match="kept"):
        Structure(tower(3), kept=0)


def test_no_proof_of_a_fall_rests_on_blocks_that_are_near_and_were_not_joined():
    stack = tower(3)
    up = (0.0, 0.0, 0.02)
    apart = (*stack.blocks[:2], stack.blocks[2].transformed(translation=up))
    model = Model.of(drystone.Assembly(apart, stack.fixed), friction=0.6)
    assert model.unjoined
    masks = np.array([[True, True, False], [True, True, True]])
    found = Structure(model).stands_many(masks)
    assert list(found.verdict) == [checked(model, mask) for mask in masks]


def test_what_cannot_be_asked_of_many_subsets_is_refused_in_words() -> None:
    structure = Structure(tower(3), friction=0.6)
    masks = np.ones((3, 3), dtype=bool)
    with pytest.raises(InputError, match="held has 2 rows and masks 3"):
        structure.stands_many(masks, held=np.zeros((2, 3), dtype=bool))
    with pytest.raises(InputError, match=r"masks is .*; give numbers"):
        structure.stands_many([[True], [True, False]])  # type: ignore[arg-type]
    with pytest.raises(InputError, match="each_s is -1"):
        Structure(tower(3), each_s=-1.0)
    sinking = drystone.LoadCase.settlement(tower(3), 0, (0.0, 0.0, -0.01, 0.0, 0.0, 0.0))
    with pytest.raises(InputError, match="moves supports"):
        structure.stands([1, 2], load=sinking)


def test_joints_that_carry_hardly_anything_leave_the_friction_left_alone():
    wall = Structure(corbelled_wall(), friction=0.6)
    lowest = [name for name in wall.model.assembly.names if name < "c03-b01"]
    found = wall.stands(lowest)  # head joints with a thousandth of the largest force slide
    assert found.stands
    assert found.friction_left > 0.9
    assert wall.stands(["c01-b00"]).friction_left == 1.0  # and no rounding


def test_the_image_of_a_mechanism_is_one():
    """An arch is its own image: its halves fall inwards alike, and one of them is calculated."""
    model = Model.of(arch(0.25, 10), friction=0.6)
    along = model.assembly.centroid[:, 0]
    halves = [~model.assembly.fixed & (side * along > 1e-6) for side in (-1.0, 1.0)]
    evaluator = Evaluator(StagedModel(model), learns=True)
    left, right = (evaluator.answer(Stage(mask_of(np.flatnonzero(half)))) for half in halves)
    assert left.verdict is right.verdict is checked(model, halves[1]) is Verdict.UNSTABLE
    assert evaluator.solved == 1
    assert right.falling
    assert halves[1][list(right.falling)].all()


def test_what_falls_when_it_is_followed_does_so_in_an_image_of_the_structure():
    """Two blocks beside one that is held, at either end of a bridge."""
    structure = Structure(bridge(), friction=0.66)
    found = structure.stands([3, 7, 8], held=[8])
    image = structure.stands([2, 6, 8], held=[8])
    assert found.falling == (3, 7)
    assert image.falling == (2, 6)
    assert image.verdict is Verdict.UNSTABLE
    assert image.message == f"its image falls: {found.message}"


def test_what_was_followed_falls_between_the_same_blocks_whatever_stands_elsewhere():
    model = Model.of(wall(4, 3), friction=0.6)
    structure = Structure(model)
    assert structure.stands([3, 4, 5, 7, 8, 9]).stands
    followed = structure.stands([4, 5, 6, 7, 8, 9, 10, 12, 13])
    fewer = structure.stands([4, 5, 7, 8, 9, 10])
    mirrored = structure.stands([3, 4, 5, 7, 8, 9, 10, 13])
    assert "it falls" in followed.message
    assert fewer.message == mirrored.message == ALIKE
    assert (followed.falling, fewer.falling, mirrored.falling) == ((7, 10), (7, 10), (9, 13))
    assert checked(model, np.isin(np.arange(14), [4, 5, 7, 8, 9, 10])) is Verdict.UNSTABLE


def test_the_image_of_what_stands_has_the_image_of_its_forces():
    """The left part of an arch, its last stone held, and the right one."""
    model = Model.of(arch(0.3, 7), friction=0.7)
    left, right = (
        Stage(mask_of([1, 2, 3, 4]), mask_of([4])),
        Stage(mask_of([4, 5, 6, 7]), mask_of([4])),
    )
    evaluator = Evaluator(StagedModel(model), learns=True)
    evaluator.answer(left)
    image, itself = evaluator.answer(right), Evaluator(StagedModel(model)).answer(right)
    assert evaluator.solved == 1
    assert image.stands
    assert image.used == pytest.approx(itself.used, rel=1e-4)
    weight = abs(itself.reaction[4]).max()
    assert image.reaction[4] == pytest.approx(itself.reaction[4], abs=1e-5 * weight)
    order = np.argsort(image.corner)
    assert np.array_equal(image.corner[order], itself.corner)
    assert image.force[order] == pytest.approx(itself.force, abs=1e-5 * weight)


def test_edges_that_meet_where_a_block_is_gone_may_hold_a_subset():
    """In the whole dome blocks between them press with their faces, and they do not count."""
    model = Model.of(dome(slices=6, rings=3), friction=0.8)
    blocks = [6, 8, 9, 10, 12, 13, 17]
    found = Structure(model).stands(blocks)
    assert found.verdict is checked(model, np.isin(np.arange(len(model)), blocks))
    assert found.verdict is Verdict.UNDECIDED
    assert "direction in which edges press" in found.message


def test_what_does_not_rest_near_a_similar_part_begins_with_forces_that_balance_its_loads():
    model = Model.of(bridge(), friction=0.66)
    near = check(model).displacement
    part = model.with_supports([0, 1, 9]).subset([0, 1, 2, *range(4, 11)])
    brief = StageCheck(CheckOptions(), brief=True)
    found = brief.begun_at(Problem.build(part), np.delete(near, 3, axis=0))
    assert found.stable
    assert found.iterations < 60  # 118 by the path from nothing
