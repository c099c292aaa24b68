import numpy as np
import pytest

from drystone import Assembly, InputError, Model
from drystone.models import arch, box, dome, tower, vault
from drystone.supports import advice, select


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
        ("lowset", ["did you mean lowest?"]),
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


def uneven(rise: float = 0.4) -> Assembly:
    """A beam between two posts, the right one of which stands ``rise`` higher."""
    left = box((0.5, 1.0, 2.0), (0.0, 0.0, 0.0), "left")
    right = box((0.5, 1.0, 2.0 - rise), (3.5, 0.0, rise), "right")
    return Assembly((left, right, box((4.0, 1.0, 0.5), (0.0, 0.0, 2.0), "beam")))


def test_lowest_fixes_a_foot_on_another_level_and_says_so() -> None:
    model = Model.of(uneven(), supports="lowest")
    assert model.assembly.fixed.tolist() == [True, True, False]
    assert model.notes == (
        "'lowest' also fixes 1 block (right), up to 0.4 m above the others: nothing else is below",
        "2 of 3 blocks are fixed by 'lowest'",
    )
    assert Model.of(uneven(0.0), supports="lowest").notes == (model.notes[1],)


def test_what_hangs_without_being_a_foot_is_named_and_left_free() -> None:
    hanging = box((0.5, 1.0, 0.5), (1.5, 0.0, 1.5), "hanging")
    model = Model.of(Assembly((*uneven(0.0).blocks, hanging)), supports="lowest")
    assert model.assembly.fixed.tolist() == [True, True, False, False]
    assert any("nothing is below 1 block (hanging)" in note for note in model.notes)


def test_the_supports_of_the_families_are_their_lowest_blocks() -> None:
    for assembly in (arch(), vault(), dome()):
        found = Model.of(assembly, supports="lowest").assembly.fixed
        assert np.array_equal(found, assembly.fixed)


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_heights_are_along_the_axis_against_gravity(axis: int, sense: float) -> None:
    """The posts are fixed however the model and its gravity are turned together."""
    rotation = np.roll(np.eye(3), axis + 1, axis=0) * sense
    gravity = rotation @ [1.0, 0.0, -9.81]
    turned = uneven().transformed(rotation)
    for spec in ("lowest", "below:0.5"):
        model = Model.of(turned, supports=spec, load=gravity)
        assert model.assembly.fixed.tolist() == [True, True, False]


def test_advice_counts_what_would_be_fixed() -> None:
    told = advice(tower(5))
    assert told == (
        "'lowest' would fix 1 block (block-0); 'below:0.5' 1 block; 'ground' lays a plane below;"
        " or give names"
    )
