"""Joint tables and thrust lines from corner forces."""

from dataclasses import replace

import numpy as np
import pytest

from drystone import Assembly, Contacts, InputError, LoadCase, Model, Result, Verdict, solve_rbe
from drystone.design import Changed
from drystone.joints import chain, corner_pressure, force_network, hinged, worst_joints
from drystone.models import arch, tower, wall
from drystone.ties import tied
from drystone.view.palette import PRESETS, is_shown
from tests.oracle import touching_faces

TOWER = tower(2)
SQUARE = touching_faces(TOWER, 0.5)


def answer(force: np.ndarray, contacts: Contacts = SQUARE, assembly: Assembly = TOWER) -> Result:
    load = LoadCase.gravity(assembly)
    return Result("rbe", Verdict.EQUILIBRIUM_EXISTS, Model(assembly, contacts, load), force=force)


def pressing(at: tuple[float, float], total: float, slide: float = 0.0) -> Result:
    """Corner forces on the unit square with their resultant at a point (bilinear)."""
    x, y = SQUARE.point[:, 0], SQUARE.point[:, 1]
    share = np.where(x > 0.5, at[0], 1.0 - at[0]) * np.where(y > 0.5, at[1], 1.0 - at[1])
    return answer(np.stack([total * share, slide * share, 0.0 * share], axis=1))


def test_a_central_force_presses_evenly() -> None:
    table = pressing((0.5, 0.5), 10.0).joints()
    assert (table["block_a"][0], table["block_b"][0]) == ("block-0", "block-1")
    assert table["kern_ratio"][0] == table["edge_ratio"][0] == pytest.approx(0.0, abs=1e-12)
    assert (
        table["peak_pressure"][0] == pytest.approx(table["mean_pressure"][0]) == pytest.approx(10.0)
    )


def test_a_force_on_the_kern_doubles_the_pressure_on_one_side() -> None:
    table = pressing((0.5 + 1.0 / 6.0, 0.5), 10.0).joints()
    assert table["kern_ratio"][0] == pytest.approx(1.0)
    assert table["edge_ratio"][0] == pytest.approx(1.0 / 3.0)
    assert table["eccentricity"][0] == pytest.approx(1.0 / 6.0)
    assert table["peak_pressure"][0] == pytest.approx(20.0)


def test_a_force_outside_the_kern_presses_three_times_its_distance_to_the_edge() -> None:
    table = pressing((0.9, 0.5), 10.0).joints()
    assert table["kern_ratio"][0] > 1.0
    assert table["peak_pressure"][0] == pytest.approx(2.0 * 10.0 / 0.3, rel=1e-6)


def test_a_force_on_the_edge_has_no_finite_pressure() -> None:
    table = pressing((1.0, 0.5), 10.0).joints()
    assert table["edge_ratio"][0] == pytest.approx(1.0)
    assert table["peak_pressure"][0] == float("inf")


def test_friction_use_is_that_of_the_resultant() -> None:
    assert pressing((0.5, 0.5), 10.0, 4.0).joints()["friction_use"][0] == pytest.approx(0.8)


def test_an_unloaded_joint_uses_nothing() -> None:
    table = answer(np.zeros((4, 3))).joints()
    for name in ("friction_use", "kern_ratio", "edge_ratio", "mean_pressure", "peak_pressure"):
        assert table[name][0] == 0.0
    assert next(iter(table))["strength_use"] == 0.0


def test_the_forces_of_corners_add_up_to_those_of_joints() -> None:
    result = solve_rbe(Model.of(arch(0.3, 8), friction=0.7))
    table, joints = result.corners(), result.joints()
    world = sum(table[f"force_{axis}"][:, None] * table[axis] for axis in "nuv")
    for row, name in enumerate(("force_x", "force_y", "force_z")):
        total = np.bincount(table["joint"], world[:, row])
        np.testing.assert_allclose(total, joints[name], atol=1e-9 * joints["normal"].max())
    np.testing.assert_array_equal(table["point"], result.contacts.point)
    np.testing.assert_allclose(table["pressure"] * table["area"], table["force_n"])
    assert table["block_a"].tolist()[::4] == joints["block_a"].tolist()


def test_rows_are_plain_values_and_the_worst_come_first() -> None:
    assembly = wall(3, 2)
    contacts = touching_faces(assembly, 0.6)
    table = solve_rbe(Model(assembly, contacts)).joints()
    worst = worst_joints(table, 3)
    use = np.maximum(table["friction_use"], table["edge_ratio"])
    assert len(worst) == 3
    loaded = table["normal"] > 0.05 * table["normal"].max()
    assert use[worst[0]] == use[loaded].max()
    assert use[worst[0]] < use.max()  # of a head joint that carries hardly anything
    assert {type(value) for value in next(iter(table.take(worst))).values()} <= {
        int,
        float,
        str,
        bool,
    }


def test_without_forces_there_is_no_table_and_no_line() -> None:
    empty = Result("rbe", Verdict.UNSTABLE, Model(TOWER, SQUARE, LoadCase.gravity(TOWER)))
    with pytest.raises(InputError, match="no forces"):
        empty.joints()
    with pytest.raises(InputError, match="no forces"):
        empty.corners()
    with pytest.raises(InputError, match="no forces"):
        empty.thrust_line()


def test_the_thrust_line_of_an_arch_runs_from_foot_to_foot_within_the_joints() -> None:
    assembly = arch(0.2, 11)
    result = solve_rbe(Model(assembly, touching_faces(assembly, 0.7)))
    line = result.thrust_line()
    names = [assembly.names[i] for i in line.blocks]
    assert {names[0], names[-1]} == {"springer-left", "springer-right"}
    radius = np.linalg.norm(line.point[:, [0, 2]], axis=1)
    assert (radius > 0.9 * np.cos(np.pi / 22) - 1e-9).all()
    assert (radius < 1.1 + 1e-9).all()
    # the force changes from joint to joint by the weight between them, and only by that
    change = np.diff(line.force, axis=0)
    inner = list(line.blocks[1:-1])
    np.testing.assert_allclose(change, result.load.wrench[inner, :3], atol=1e-3)


def test_a_row_given_backwards_gives_the_opposite_forces() -> None:
    assembly = arch(0.2, 5)
    result = solve_rbe(Model(assembly, touching_faces(assembly, 0.7)))
    forth = result.thrust_line(["voussoir-01", "voussoir-02", "voussoir-03"])
    back = result.thrust_line(["voussoir-03", "voussoir-02", "voussoir-01"])
    np.testing.assert_allclose(forth.point, back.point[::-1])
    np.testing.assert_allclose(forth.force, -back.force[::-1])
    with pytest.raises(InputError, match="do not touch"):
        result.thrust_line(["voussoir-01", "voussoir-03"])


def test_a_wall_is_no_chain() -> None:
    assembly = wall(3, 2)
    with pytest.raises(InputError, match="not one row"):
        chain(assembly, touching_faces(assembly, 0.6))


def test_the_force_network_of_an_arch_is_its_thrust_line() -> None:
    voussoirs = arch(0.3, 7)
    result = solve_rbe(Model(voussoirs, touching_faces(voussoirs, 0.7)))
    line = result.thrust_line()
    made = force_network(result.assembly, result.contacts, result.resultants)
    free = ~result.assembly.fixed
    assert len(made.force) == 2 * free.sum()  # two lines in each voussoir, none in the supports
    for start, end in zip(made.start, made.end, strict=True):
        a, b = line.point[:-1], line.point[1:]
        along = b - a
        share = np.clip(((end - a) * along).sum(axis=1) / (along**2).sum(axis=1), 0.0, 1.0)
        assert np.linalg.norm(a + share[:, None] * along - end, axis=1).min() < 1e-9
        assert np.linalg.norm(line.point - start, axis=1).min() < 1e-9


def test_a_tie_is_a_line_of_its_own_and_no_part_of_the_force_network() -> None:
    before = Model(arch(0.3, 7), touching_faces(arch(0.3, 7), 0.7))
    model = tied(before, 3, 5)
    result = solve_rbe(model)
    tie = len(model.contacts.area) - 1
    result = replace(result, force=np.where(model.contacts.interface[:, None] == tie,
                     [500.0, 0.0, 0.0], result.force))  # fmt: skip
    made = force_network(result.assembly, result.contacts, result.resultants)
    assert tie not in made.interface
    (drawn,) = (one for one in result.layers().stages[0].layers if one.key == "tie-forces")
    np.testing.assert_allclose(drawn.position + drawn.vector, model.assembly.centroid[[3]])
    assert drawn.label == "a tie, which pulls 2 kN"
    assert all(is_shown(drawn, name) for name in PRESETS)  # without it the arch may not stand
    (mended,) = Changed.by_hand(before, result).layers().stages
    assert [one.label for one in mended.layers if "tie" in one.label] == [drawn.label]


def test_a_force_on_the_rim_is_a_hinge_and_one_inside_is_none() -> None:
    contacts = touching_faces(tower(2), 0.7)
    on_rim, inside = np.zeros((4, 3)), np.zeros((4, 3))
    edge = np.flatnonzero(contacts.point[:, 0] == contacts.point[:, 0].max())
    on_rim[edge, 0] = 100.0
    inside[:, 0] = 100.0
    for force, expected in ((on_rim, True), (inside, False)):
        result = Result("rbe", Verdict.STABLE, Model(tower(2), contacts), force=force)
        assert hinged(contacts, result.resultants).tolist() == [expected]
    np.testing.assert_allclose(corner_pressure(contacts, inside), 400.0)
