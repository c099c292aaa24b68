import numpy as np
import pytest

from drystone.assembly import Assembly
from drystone.errors import InputError
from drystone.models import box, tower
from drystone.supports import select


def named(*names: str) -> Assembly:
    blocks = [box((1.0, 1.0, 1.0), (2.0 * i, 0.0, 0.0), name=n) for i, n in enumerate(names)]
    return Assembly(tuple(blocks))


def steps(*bottoms: float) -> Assembly:
    blocks = [box((1.0, 1.0, 1.0), (2.0 * i, 0.0, z), name=f"b{i}") for i, z in enumerate(bottoms)]
    return Assembly(tuple(blocks))


def test_lowest_are_those_within_a_tenth_of_the_median_height() -> None:
    assembly = steps(0.0, 0.099, 0.101, 1.0)
    assert select(assembly, "lowest").fixed.tolist() == [True, True, False, False]


def test_lowest_replaces_the_flags_of_the_file() -> None:
    assembly = Assembly(tower(3).blocks, np.array([False, False, True]))
    assert select(assembly, "lowest").fixed.tolist() == [True, False, False]


def test_selection_leaves_its_input_alone() -> None:
    assembly = tower(3)
    select(assembly, "block-2")
    assert assembly.fixed.tolist() == [True, False, False]


@pytest.mark.parametrize(
    ("spec", "expected"),
    [
        ("block-0,block-2", [True, False, True]),
        ("block-0, block-2", [True, False, True]),
        ("block-[12]", [False, True, True]),
        ("*", [True, True, True]),
        ("below:0.5", [True, False, False]),
        ("below:1", [True, True, False]),
        ("below:1000mm", [True, True, False]),
    ],
)
def test_blocks_are_chosen(spec: str, expected: list[bool]) -> None:
    assert select(tower(3), spec).fixed.tolist() == expected


def test_names_may_hold_spaces_commas_and_brackets() -> None:
    assembly = named("left, upper", "a[1]", "a1", "Mesh 0")
    assert select(assembly, "left, upper").fixed.tolist() == [True, False, False, False]
    assert select(assembly, "a[1],Mesh 0").fixed.tolist() == [False, True, False, True]


@pytest.mark.parametrize(
    ("spec", "words"),
    [
        ("blok-1", ["'blok-1'", "did you mean", "block-1"]),
        ("col*", ["'col*'", "names are like block-0"]),
        ("block-0,", ["empty name"]),
        ("", ["empty name"]),
        ("below:-1", ["no block reaches down to -1 m", "0 m"]),
        ("below:high", ["height 'high' is not a number with a unit", "0.15"]),
        ("below:1yd", ["unit 'yd'"]),
    ],
)
def test_what_fits_no_block_is_refused_with_advice(spec: str, words: list[str]) -> None:
    with pytest.raises(InputError) as caught:
        select(tower(3), spec)
    for word in words:
        assert word in str(caught.value)


def test_keywords_names_and_patterns_add_up():
    assembly = tower(4)
    assert select(assembly, "lowest, block-[3]").fixed.tolist() == [True, False, False, True]
    assert select(assembly, "below:1.5,block-3").fixed.tolist() == [True, True, False, True]
