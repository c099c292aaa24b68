"""An assembly as a container of blocks, and the ways to name some of them."""

import numpy as np
import pytest

from drystone import Assembly, InputError
from drystone.models import tower

TOWER = tower(4)


def test_it_holds_its_blocks_in_order() -> None:
    assert len(TOWER) == 4
    assert list(TOWER) == list(TOWER.blocks)
    assert list(reversed(TOWER)) == list(TOWER.blocks[::-1])


@pytest.mark.parametrize("key", ["block-3", 3, -1, np.int64(3)])
def test_a_block_is_found_by_name_and_by_position(key: str | int) -> None:
    assert TOWER[key] is TOWER.blocks[3]


def test_names_and_blocks_are_in_it_or_not() -> None:
    assert "block-1" in TOWER
    assert TOWER.blocks[1] in TOWER
    assert "base" not in TOWER
    assert tower(4).blocks[1] not in TOWER
    assert 1 not in TOWER


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("block-9", r"no block is called 'block-9'; did you mean"),
        ("pier", r"no block is called 'pier'; names are like block-0, block-1, block-2"),
        (4, "there is no block 4; 0 to 3 exist"),
        (-5, "there is no block -5"),
        (1.0, r"asked for by 1\.0; give its name or position"),
        (slice(0, 2), r"subset\(\.\.\.\) takes several"),
        (None, "asked for by None"),
    ],
)
def test_what_is_no_block_is_refused(key: object, words: str) -> None:
    with pytest.raises(InputError, match=words):
        TOWER[key]  # type: ignore[index]


@pytest.mark.parametrize(
    "some",
    [
        "block-2",
        2,
        ["block-2"],
        (2,),
        np.array([2]),
        np.arange(4) == 2,
        {"block-2"},
        [False, False, True, False],
    ],
)
def test_some_blocks_are_named_in_any_of_these_ways(some: object) -> None:
    assert TOWER.with_fixed(some).fixed.tolist() == [False, False, True, False]  # type: ignore[arg-type]
    assert TOWER.subset(some).names == ("block-2",)  # type: ignore[arg-type]
    assert TOWER.without(some).names == ("block-0", "block-1", "block-3")  # type: ignore[arg-type]
    assert TOWER.indices(some).tolist() == [2]  # type: ignore[arg-type]


def test_names_of_the_first_two_blocks_are_no_mask() -> None:
    assert TOWER.indices(["block-1", "block-0", "block-1", "block-1"]).tolist() == [1, 0, 1, 1]


@pytest.mark.parametrize(
    ("some", "words"),
    [
        ([2.5], r"a block is 2\.5; give a whole number"),
        ([True, False, False], r"a mask of blocks has shape \(3,\), not \(4,\)"),
        (np.array([1, 0, 1, 0]), "blocks are 0 and 1, one for each block; give a mask of bool"),
        (np.array([True, False]), r"a mask of blocks has shape \(2,\), not \(4,\)"),
        (None, "blocks are None; give names or positions"),
        (0.5, "blocks are 0.5"),
        ([-1], "there is no block -1"),
    ],
)
def test_what_names_no_blocks_is_refused(some: object, words: str) -> None:
    with pytest.raises(InputError, match=words):
        TOWER.indices(some)  # type: ignore[arg-type]


@pytest.mark.parametrize("blocks", [42, None, "tower", [1, 2], [*TOWER.blocks, "base"]])
def test_an_assembly_is_made_of_blocks(blocks: object) -> None:
    with pytest.raises(InputError, match=r"give a list of Block"):
        Assembly(blocks)  # type: ignore[arg-type]
