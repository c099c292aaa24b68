"""Loads become wrenches about centroids."""

import numpy as np
import pytest

from drystone import Assembly, InputError, LoadCase, Model, check
from drystone.loads import placing
from drystone.loads.applied import applied_loads
from drystone.models import prism, stool, tower

TOWER = tower(2)  # block-1 fills the unit square from z = 1 to 2
TOP = 1


def test_gravity_acts_along_any_direction_with_its_full_size() -> None:
    load = LoadCase.gravity(TOWER, 2.0, (3.0, 0.0, 4.0))
    np.testing.assert_allclose(load.wrench[TOP, :3], 2400.0 * 2.0 * np.array([0.6, 0.0, 0.8]))


def test_seismic_forces_are_shares_of_the_weight_without_the_weight() -> None:
    load = LoadCase.seismic(TOWER, 0.1, -0.2)
    np.testing.assert_allclose(load.wrench[TOP], 2400.0 * 9.81 * np.array([0.1, -0.2, 0, 0, 0, 0]))


def test_density_of_one_block_changes_its_weight_only() -> None:
    heavy = LoadCase.gravity(TOWER.with_density([2400.0, 4800.0]))
    assert heavy.wrench[1, 2] == pytest.approx(2.0 * heavy.wrench[0, 2])


def test_a_force_away_from_the_centroid_turns_the_block() -> None:
    load = LoadCase.point_load(TOWER, "block-1", (10.0, 0.0, 0.0), at=(0.5, 0.5, 2.0))
    np.testing.assert_allclose(load.wrench[TOP], [10.0, 0, 0, 0, 5.0, 0])
    assert load.notes == ()


def test_names_of_forces_have_no_powers_of_ten() -> None:
    names = [LoadCase.point_load(TOWER, TOP, (0.0, 0.0, -f)).name for f in (1234.0, 30e3, 1.5e6)]
    forces = ["0, 0, -1234 N", "0, 0, -30000 N", "0, 0, -1500000 N"]
    assert names == [f"{force} on 'block-1'" for force in forces]


def test_a_point_off_the_block_is_told_with_its_distance() -> None:
    load = LoadCase.point_load(TOWER, "block-1", (1.0, 0.0, 0.0), at=(0.5, 0.5, 2.25))
    assert load.notes == ("the point 0.5, 0.5, 2.25 is 0.25 m off block 'block-1'",)
    assert (LoadCase.gravity(TOWER) + 2.0 * load).notes == load.notes


def test_a_point_off_the_block_goes_through_sums_and_factors() -> None:
    load = LoadCase.point_load(TOWER, "block-1", (0.0, 0.0, -5.0), at=(-0.5, 0.5, 3.0))
    half = LoadCase.point_load(TOWER, "block-1", (0.0, 0.0, -5.0), at=(-0.5, 0.5, 4.0))
    model = Model.of(TOWER, load=LoadCase.gravity(TOWER) + 3.0 * load + half)
    assert applied_loads(TOWER, model.load).point.tolist() == [pytest.approx([-0.5, 0.5, 3.25])]
    each = check(model).loads()  # as they were asked for
    assert each["point"][:, 2].tolist() == [3.0, 4.0]
    assert each["force"][:, 2].tolist() == [-15.0, -5.0]


@pytest.mark.parametrize("make", [LoadCase.point_load, LoadCase.moment])
def test_a_load_on_a_fixed_or_unknown_block_is_refused(make) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(InputError, match="'block-0' is fixed"):
        make(TOWER, "block-0", (1.0, 0.0, 0.0))
    with pytest.raises(InputError, match="no block is called 'bloc-1'"):
        make(TOWER, "bloc-1", (1.0, 0.0, 0.0))


def test_a_line_load_acts_at_the_middle_of_its_line() -> None:
    load = LoadCase.line_load(TOWER, 1, (0.0, 0.0, -3.0), (0.0, 1.0, 2.0), (1.0, 1.0, 2.0))
    np.testing.assert_allclose(load.wrench[TOP], [0, 0, -3.0, -1.5, 0, 0])
    with pytest.raises(InputError, match="no length"):
        LoadCase.line_load(TOWER, 1, (0.0, 0.0, 1.0), (0.0, 0.0, 2.0), (0.0, 0.0, 2.0))


def test_traction_on_the_face_that_looks_up() -> None:
    load = LoadCase.surface_load(TOWER, 1, (2.0, 0.0, -5.0), facing=(0.0, 0.0, 1.0))
    np.testing.assert_allclose(load.wrench[TOP], [2.0, 0, -5.0, 0, 1.0, 0], atol=1e-12)


def test_pressure_all_around_balances_itself_on_any_block() -> None:
    assembly = stool()  # concave
    load = LoadCase.surface_load(assembly, "stool", 1e3)
    np.testing.assert_allclose(load.wrench[1], 0.0, atol=1e-10)


def test_pressure_pushes_against_a_face_chosen_by_number() -> None:
    load = LoadCase.surface_load(TOWER, 1, 7.0, faces=[1])  # of a box, face 1 is its top
    np.testing.assert_allclose(load.wrench[TOP], [0, 0, -7.0, 0, 0, 0], atol=1e-12)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"faces": [6]}, "numbered 0 to 5"),
        ({"facing": (1.0, 1.0, 1.0)}, "no face has this direction"),
        ({"faces": [0], "facing": (0.0, 0.0, 1.0)}, "chosen twice"),
        ({"facing": (0.0, 0.0, 0.0)}, "facing is zero"),
    ],
)
def test_faces_that_cannot_be_chosen_are_refused(options, words) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(InputError, match=words):
        LoadCase.surface_load(TOWER, 1, 1.0, **options)


def test_extra_mass_is_a_weight_at_its_place() -> None:
    load = LoadCase.extra_mass(TOWER, 1, 100.0, at=(1.0, 0.5, 2.0))
    np.testing.assert_allclose(load.wrench[TOP], [0, 0, -981.0, 0, 490.5, 0], atol=1e-9)
    with pytest.raises(InputError, match="mass is -1"):
        LoadCase.extra_mass(TOWER, 1, -1.0)


def test_combinations_add_with_their_factors_and_leave_the_parts_alone() -> None:
    dead, live = LoadCase.gravity(TOWER), LoadCase.seismic(TOWER, 1.0)
    before = dead.wrench.copy()
    both = LoadCase.combine([(1.35, dead), (1.5, live)], "1.35 G + 1.5 E")
    np.testing.assert_allclose(both.wrench, 1.35 * dead.wrench + 1.5 * live.wrench)
    np.testing.assert_array_equal(dead.wrench, before)
    assert both.name == "1.35 G + 1.5 E"
    with pytest.raises(InputError, match="nothing to combine"):
        LoadCase.combine([])


def test_a_load_in_the_notch_of_a_face_is_off_the_block() -> None:
    """It lies in the plane of the face, and between corners of it; so does the centroid."""
    angle = prism([(3, 1), (1, 1), (1, 3), (0, 3), (0, 0), (3, 0)], (0.0, 1.0), name="L")
    assembly = Assembly((angle,), np.array([False]))
    load = LoadCase.point_load(assembly, "L", (0.0, 0.0, -1.0), (1.8, 1.0, 1.8))
    assert load.notes == ("the point 1.8, 1, 1.8 is 0.8 m off block 'L'",)
    assert LoadCase.extra_mass(assembly, "L", 2.0).notes == ()  # no point was given


def test_a_load_leaves_the_assembly_alone() -> None:
    assembly = Assembly(TOWER.blocks, TOWER.fixed)
    LoadCase.extra_mass(assembly, 1, 5.0)
    assert assembly.mass.tolist() == TOWER.mass.tolist()


def test_motions_of_supports_add_and_take_factors_like_forces() -> None:
    assembly = tower(2)
    down = LoadCase.settlement(assembly, 0, (0.0, 0.0, -1e-2))
    turn = LoadCase.settlement(assembly, "block-0", (0.0, 0.0, 0.0, 1e-3, 0.0, 0.0))
    both = LoadCase.combine([(1.0, LoadCase.gravity(assembly)), (2.0, down), (-1.0, turn)])
    assert both.motion is not None
    assert both.motion[0].tolist() == [0.0, 0.0, -2e-2, -1e-3, 0.0, 0.0]
    assert not both.motion[1].any()
    assert (down + (-1.0) * down).motion is None
    assert LoadCase.gravity(assembly).motion is None


def test_a_weight_beyond_the_largest_number_is_refused() -> None:
    heavy = TOWER.with_density([1e308, 2400.0])
    with pytest.raises(InputError, match=r"a mass of 1e\+308 kg: .* too large"):
        LoadCase.gravity(heavy)


def test_a_block_is_triangulated_once_for_all_its_loads(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[object] = []
    covers = placing.triangulate
    monkeypatch.setattr(placing, "triangulate", lambda *of: asked.append(of) or covers(*of))
    block, down = tower(2), (0.0, 0.0, -1.0)
    lines = [LoadCase.line_load(block, 1, down, (x, 0.5, 2.0), (x, 9.0, 2.0)) for x in (0, 1)]
    points = [LoadCase.point_load(block, 1, down, (0.2, 0.5, z)) for z in (1.5, 2.0)]
    pressed = LoadCase.surface_load(block, 1, 5.0, facing=(0, 0, 1))
    assert len(asked) == 1
    total = LoadCase.combine([(1.0, one) for one in (*lines, *points, pressed, pressed)])
    said = "the point {}, 9, 2 is 8 m off block 'block-1'"
    assert total.notes == (said.format(0), said.format(1))
    assert total.wrench[1, 2] == pytest.approx(-2 * 8.5 - 2 - 2 * 5.0)
    assert total.surface is not None
    assert total.surface.traction == pytest.approx(2.0 * pressed.surface.traction)  # type: ignore[union-attr]
