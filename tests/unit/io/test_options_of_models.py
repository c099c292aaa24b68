"""The options of every model, as ``drystone.read`` and the analyses take them."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

import drystone
from drystone import InputError, LoadCase, Model, io
from drystone.assembly import Assembly
from drystone.io import Contents
from drystone.models import box, tower

TOWER = tower(3)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    io.write(TOWER, tmp_path / "tower.json")
    return tmp_path / "tower.json"


def apart(tmp_path: Path, distance: float, size: float = 1.0) -> Path:
    low = box((size, size, size), name="low")
    up = box((size, size, size), (0.0, 0.0, size + distance), name="up")
    io.write(Assembly((low, up)), tmp_path / "apart.obj")
    return tmp_path / "apart.obj"


@pytest.mark.parametrize(("gap", "joints"), [("11mm", 1), ("9mm", 0), ("1.1%", 1), (0.009, 0)])
def test_a_gap_is_a_length_or_a_share_of_the_block(
    tmp_path: Path, gap: float | str, joints: int
) -> None:
    assert drystone.read(apart(tmp_path, 0.01), gap=gap).contacts.count == joints


def test_a_gap_in_metres_is_the_same_for_large_blocks(tmp_path: Path) -> None:
    assert drystone.read(apart(tmp_path, 0.01, size=4.0), gap="9mm").contacts.count == 0
    assert drystone.read(apart(tmp_path, 0.01, size=4.0), gap="11mm").contacts.count == 1


def test_blocks_are_kept_and_left_out_by_names_and_patterns(path: Path) -> None:
    assert drystone.read(path, only="block-[01]").assembly.names == ("block-0", "block-1")
    model = drystone.read(path, without="block-2")
    assert model.assembly.names == ("block-0", "block-1")
    assert "1 block of 3 left out" in model.notes
    assert drystone.check(TOWER, without="block-2").model.assembly.names == model.assembly.names
    with pytest.raises(InputError, match="without: no block is called 'blok'"):
        drystone.read(path, without="blok")
    with pytest.raises(InputError, match="no block is left"):
        drystone.read(path, without="*")


def test_loads_in_words_and_as_in_json_are_added(path: Path) -> None:
    word = drystone.read(path, load="block-2:0,0,-500")
    part = {"kind": "point", "block": "block-2", "force": [0.0, 0.0, -500.0]}
    for same in (
        drystone.read(path, load=[part]),
        io.as_model(TOWER, load=["block-2:500N"]),
        io.as_model(Model.of(TOWER), load="block-2:500N"),
    ):
        assert np.allclose(same.load.wrench, word.load.wrench)
    weight = drystone.read(path).load.wrench
    assert np.allclose(word.load.wrench[2] - weight[2], [0.0, 0.0, -500.0, 0.0, 0.0, 0.0])


def test_gravity_leaves_out_no_other_load_of_the_file_unless_weight_alone_is_asked_for(
    tmp_path: Path,
) -> None:
    push = LoadCase.gravity(TOWER) + LoadCase.point_load(TOWER, 1, (1e3, 0.0, 0.0))
    cases = (dataclasses.replace(push, name="push"),)
    io.write(Contents(TOWER, None, cases), tmp_path / "pushed.json")
    with pytest.raises(InputError, match="'push' of the file is more than weight; leave out"):
        drystone.read(tmp_path / "pushed.json", gravity=1.62)
    model = drystone.read(tmp_path / "pushed.json", gravity=1.62, case="weight")
    assert np.allclose(model.load.wrench[1], [0.0, 0.0, -1.62 * TOWER.mass[1], 0.0, 0.0, 0.0])
    assert drystone.read(tmp_path / "pushed.json").load.name == "push"


def test_friction_is_a_coefficient_or_an_angle(path: Path) -> None:
    assert drystone.read(path, friction="45deg").contacts.friction == pytest.approx(1.0)
    with pytest.raises(InputError, match="friction: 'much' is not a number"):
        drystone.read(path, friction="much")


def test_an_argument_that_is_not_known_is_refused_with_the_nearest_name(path: Path) -> None:
    with pytest.raises(InputError, match="no argument 'frction'; did you mean friction"):
        drystone.check(path, frction=0.7)  # type: ignore[call-arg]


@pytest.mark.parametrize(
    ("density", "meant"),
    [(2.4, 2400), (2.4e-9, 2400), (24.0, 2446), (24e3, 2446), (120.0, 0), (2400.0, 0), (19.3e3, 0)],
)
def test_a_density_that_no_block_has_is_told_with_the_option(density: float, meant: float) -> None:
    """In t/m3, t/mm3, kN/m3 and N/m3; those of cork, stone and gold are not."""
    told = [one for one in io.as_model(TOWER, density=density).notes if "density" in one]
    assert [one.partition("unit right ")[2] for one in told] == (
        [f"(--density {meant})?"] if meant else []
    )
