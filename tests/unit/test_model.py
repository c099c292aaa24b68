"""The model: checked once, and made of whatever a caller has."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import drystone
from drystone import Assembly, InputError, LoadCase, Model, Verdict
from drystone.models import arch, box, prism, tower


def test_contacts_and_self_weight_are_found_when_they_are_left_out() -> None:
    model = Model.of(tower(3), friction=0.4)
    assert model.contacts.friction.tolist() == [0.4, 0.4]
    assert np.array_equal(model.load.wrench, LoadCase.gravity(tower(3)).wrench)
    assert model.report is not None


@pytest.mark.parametrize(
    ("load", "force"),
    [
        (None, (0.0, 0.0, -9.81)),
        (2, (0.0, 0.0, -19.62)),
        (0.5, (0.0, 0.0, -4.905)),
        ((1.0, 0.0, -9.81), (1.0, 0.0, -9.81)),
        (np.zeros(3), (0.0, 0.0, 0.0)),
    ],
)
def test_a_load_is_a_case_a_multiple_of_gravity_or_an_acceleration(load, force):  # type: ignore[no-untyped-def]
    model = Model.of(tower(2), load=load)
    np.testing.assert_allclose(model.load.wrench[1, :3] / 2400.0, force, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Model(tower(2), Model.of(tower(3)).contacts), "does not have"),
        (lambda: Model(tower(2), drystone.find_contacts(tower(2))), r"give the \.contacts"),
        (lambda: Model.of(tower(2), load=LoadCase.gravity(tower(3))), "3 wrenches"),
        (lambda: Model.of(tower(2), load="heavy"), "multiple of gravity"),
        (lambda: Model.of(tower(2), load=(0.0, 1.0)), "vector in m/s2"),
        (lambda: Model.of(tower(2), load=float("nan")), "load"),
        (lambda: drystone.check(42), "a path or a list"),
        (lambda: drystone.check(tower(2), units="mm"), "takes no 'units'"),
        (lambda: drystone.check(Model.of(tower(2)), density=1.0), "takes no 'density'"),
    ],
)
def test_what_does_not_fit_is_refused_with_a_remedy(make, words):  # type: ignore[no-untyped-def]
    with pytest.raises(InputError, match=words):
        make()


def test_a_file_an_assembly_and_a_model_give_the_same_answer(tmp_path: Path) -> None:
    path = tmp_path / "arch.obj"
    drystone.write(arch(), path)
    how = {"supports": "springer-*", "friction": 0.9}
    found = [
        drystone.check(path, **how),
        drystone.check(str(path), **how),
        drystone.check(arch(), friction=0.9),
        drystone.check(drystone.read(path, **how)),
        drystone.check(Model.of(arch()), friction=0.9),
    ]
    assert {result.verdict for result in found} == {Verdict.STABLE}
    for result in found[1:]:
        np.testing.assert_allclose(result.resultants.normal, found[0].resultants.normal, rtol=1e-6)


def test_another_load_friction_or_support_is_another_model() -> None:
    model = Model.of(tower(3))
    tilted = model.with_load(LoadCase.tilt(model.assembly, (0.0, 1.0, 0.0), 5.0))
    assert tilted.contacts is model.contacts
    assert tilted.load is not model.load
    assert model.with_friction(0.1).contacts.friction.tolist() == [0.1, 0.1]
    assert model.contacts.friction.tolist() == [0.6, 0.6]
    assert model.with_supports("block-2").assembly.fixed.tolist() == [False, False, True]
    assert model.with_supports([0, "block-1"]).assembly.fixed.tolist() == [True, True, False]


def test_a_part_of_a_model_keeps_its_contacts_and_loads() -> None:
    model = Model.of(tower(4), load=(1.0, 0.0, -9.81))
    part = model.without(["block-3"])
    assert part.assembly.names == ("block-0", "block-1", "block-2")
    assert part.contacts.count == 2
    assert np.array_equal(part.load.wrench, model.load.wrench[:3])


def test_a_file_whose_y_axis_points_up_is_turned(tmp_path: Path) -> None:
    upright = tower(3)
    lying = upright.transformed([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
    drystone.write(lying, tmp_path / "tower.obj")
    model = drystone.read(tmp_path / "tower.obj", up="y", supports="lowest")
    np.testing.assert_allclose(model.assembly.bounds, upright.bounds, atol=1e-12)
    assert model.assembly.fixed.tolist() == [True, False, False]
    with pytest.raises(InputError, match="up is 'x'; give one of 'z', 'y'"):
        drystone.read(tmp_path / "tower.obj", up="x")


def ells() -> Assembly:
    """Two blocks of three cubes, in one plane, that have a cube in common."""
    one = prism([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], (0.0, 1.0), "one")
    other = one.transformed(np.diag([-1.0, 1.0, -1.0]), (1.0, 0.0, 1.0)).renamed("other")
    return Assembly((one, other), np.array([True, False]))


def sunk_lintel() -> Assembly:
    """A lintel whose ends fill the tops of both legs of a U, flush with its outside."""
    outline = [(0, 0), (4, 0), (4, 3), (3, 3), (3, 1), (1, 1), (1, 3), (0, 3)]
    u = prism(outline, (0.0, 1.0), "U")
    return Assembly((u, box((4.0, 1.0, 1.0), (0.0, 0.0, 2.0), "lintel")), np.array([True, False]))


@pytest.mark.parametrize(
    ("assembly", "said"),
    [
        (ells(), r"'one' and 'other': overlap: they share 1 m3 \(33 % of the smaller one\)"),
        (sunk_lintel(), r"'U' and 'lintel': overlap: they share 2 m3 \(50 % of the smaller one\)"),
    ],
)
def test_blocks_that_share_much_are_refused_unless_they_are_accepted(
    assembly: Assembly, said: str
) -> None:
    with pytest.raises(InputError, match=said):
        Model.of(assembly)
    with pytest.raises(InputError, match=said):
        drystone.check(assembly)
    accepted = Model.of(assembly, anyway=True)
    assert "m3" in accepted.notes[0]
    assert accepted.report is not None
    (overlap,) = accepted.report.overlaps
    assert overlap.share == pytest.approx(overlap.volume / min(assembly.volume))


def test_a_block_inside_another_is_told_without_a_power_of_ten() -> None:
    nested = Assembly((box((3, 3, 3), name="out"), box((1, 1, 1), (1, 1, 1), "in")))
    with pytest.raises(InputError, match=r"they share 1 m3 \(100 % of the smaller one\)"):
        Model.of(nested)


def test_blocks_that_share_little_are_a_note() -> None:
    low = tower(2).blocks[1].transformed(translation=(0.0, 0.0, -0.09))
    model = Model.of(Assembly((tower(2).blocks[0], low), np.array([True, False])))
    assert model.notes == (
        "blocks 'block-0' and 'block-1' overlap: they share 0.09 m3 (9 % of the smaller one),"
        " 90 mm deep",
    )


def test_overlaps_are_told_where_the_file_brings_its_contacts(tmp_path: Path) -> None:
    drystone.write(Model.of(ells(), anyway=True), tmp_path / "ells.json")
    with pytest.raises(InputError, match="they share 1 m3"):
        drystone.read(tmp_path / "ells.json")
    notes = drystone.read(tmp_path / "ells.json", anyway=True).notes
    assert sum("they share 1 m3" in note for note in notes) == 1


@pytest.mark.parametrize("size", [5e-170, 1e-130, 1e-200])
def test_a_load_whose_square_does_not_fit_a_float_is_not_taken_for_none(size: float) -> None:
    with pytest.raises(InputError, match="cannot be calculated with"):
        Model.of(tower(3), load=(size, 0.0, -1.8 * size))


@pytest.mark.parametrize("size", [1e160, 1e308])
def test_a_load_too_large_for_a_float_is_refused_by_the_name_of_a_block(size: float) -> None:
    with pytest.raises(InputError, match="block-"):
        Model.of(tower(3), load=(size, 0.0, -size))


def test_a_load_far_from_the_mass_of_its_block_is_refused() -> None:
    # the acceleration of such a block decided, and its square is no float
    light = replace(tower(3).blocks[1], density=1e-155)
    blocks = (tower(3).blocks[0], light, tower(3).blocks[2])
    wrench = np.zeros((3, 6))
    wrench[1:, 2] = -100.0
    fixed = np.array([True, False, False])
    with pytest.raises(InputError, match=r"block-1.*its mass 1e-155 kg"):
        Model.of(Assembly(blocks, fixed), load=LoadCase(wrench))
    lighter = Assembly((blocks[0], replace(light, density=1e-60), blocks[2]), fixed)
    assert drystone.check(Model.of(lighter, load=LoadCase(wrench))).stable
