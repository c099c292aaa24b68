"""The source's own structures, against what it says of them.

Source: Kao 2023, doctoral dissertation, ETH Zurich; Kao et al. 2022, Computer-Aided Design 146.
"""

import math
from pathlib import Path

import numpy as np
import pytest

from drystone import (
    InputError,
    LoadCase,
    Model,
    Verdict,
    check,
    limit_tilt,
    plan,
    solve_cra,
    solve_rbe,
)
from drystone.models import arch, bridge, dome, overhang, shelf, snake
from drystone.programs import CRAOptions, FrictionCone, Objective, RBEOptions
from drystone.reproduce import SECTIONS, reproduce, save_case
from drystone.sequence import PlanOptions
from drystone.virtual import shrink

THOROUGH = PlanOptions(patience=math.inf)


def test_the_bridge_is_symmetric_and_its_blocks_touch_without_overlap():
    model = Model.of(bridge())
    assembly = model.assembly
    assert len(assembly) == 11
    assert model.contacts.count == 32  # 33 published: an odd number on a symmetric bridge
    assert model.report.overlaps == ()
    mirrored = assembly.centroid * (-1.0, 1.0, 1.0)
    for right, left in ((0, 1), (2, 3), (4, 5), (6, 7), (9, 10)):
        np.testing.assert_allclose(mirrored[right], assembly.centroid[left], atol=1e-12)
        assert assembly.blocks[right].volume == pytest.approx(assembly.blocks[left].volume)


def test_the_bridge_is_built_freely_from_friction_035_and_not_at_034():
    model = Model.of(bridge())
    free = plan(model.with_friction(0.35), options=THOROUGH)
    assert free.counts["free"] == 9
    helped = plan(model.with_friction(0.34), options=THOROUGH)
    assert helped.counts["free"] < 9


def test_the_loaded_bridge_stands_its_keystone_pressed_at_its_upper_faces():
    model = Model.of(bridge(load=True), friction=0.9)
    result = check(model)
    assert result.verdict is Verdict.STABLE
    found = result.resultants
    contacts, names = model.contacts, model.assembly.names
    pressing = {
        names[b]: found.normal[i]
        for i, (a, b) in enumerate(zip(contacts.block_a, contacts.block_b, strict=True))
        if names[a] == "block-8" and contacts.centroid[i, 2] > 1.5
    }
    assert set(pressing) == {"block-9", "block-10", "load-13"}
    assert min(pressing.values()) > 0.0


def test_the_loaded_bridge_meets_eq_56():
    found = solve_cra(Model.of(bridge(load=True), friction=0.9), options=CRAOptions(tolerance=2e-6))
    assert found.method == "cra"
    assert found.verdict is Verdict.STABLE


def test_the_bridge_alone_meets_eq_56_down_to_its_least_friction():
    for friction in (0.35, 0.66):
        assert solve_cra(Model.of(bridge(), friction=friction)).method == "cra"


@pytest.mark.parametrize("fix", [1, 2, 3])
def test_each_fix_of_the_shelf_holds_block_9_and_leaves_block_10(fix):
    assert check(shelf(fix), friction=0.9).falling_names == ("block-10",)


def test_the_shelf_without_a_fix_loses_both():
    assert check(shelf(), friction=0.9).falling_names == ("block-9", "block-10")


def test_there_is_no_fourth_fix():
    with pytest.raises(InputError):
        shelf(4)


def test_the_snake_stands_at_its_friction_and_not_at_half_of_it():
    model = Model.of(snake(), friction=0.7)
    assert len(model.assembly) == 4
    assert model.report.overlaps == ()
    assert check(model).verdict is Verdict.STABLE
    assert check(model.with_friction(0.35)).verdict is Verdict.UNSTABLE


def test_the_tilt_of_the_experiment_is_that_of_an_arch_with_joints_13_percent_thinner():
    model = Model.of(arch(0.15, 36), friction=math.tan(math.radians(43.0)))
    worn = limit_tilt(model.with_contacts(shrink(model.contacts, 0.87)), "y").rest
    assert worn.stands == pytest.approx(4.7, abs=0.2)
    thin = Model.of(arch(0.87 * 0.15, 36), friction=math.tan(math.radians(43.0)))
    assert limit_tilt(thin, "y").rest.stands == pytest.approx(4.7, abs=0.2)


SLOW = ("6.1.3", "6.2.3", "6.2.4", "6.2.5", "6.3.3", "6.4.2", "7.2.4", "7.5.1", "7.5.2", "7.5.3")
"""Sections that take more than a second: ``benchmarks.thesis`` computes them."""
DIFFERS = {"7.2.3": ["order, friction 0.66"]}
"""What disagrees with the source, and is told on docs/trust/source-studies.md."""


@pytest.mark.parametrize("section", [one for one in SECTIONS if one not in SLOW])
def test_what_disagrees_with_what_is_published_is_known(section):
    case = reproduce(section)
    assert case.section == section
    assert case.lines
    wrong = [line.what for line in case.lines if line.agrees is False]
    assert wrong == DIFFERS.get(section, [])
    assert all("(check)" in line.found for line in case.lines if "(3DEC)" in line.published)


@pytest.mark.parametrize("cone", [FrictionCone.exact(), FrictionCone.octagon()])
@pytest.mark.parametrize("objective", [Objective.QUADRATIC, Objective.LINEAR])
def test_the_penalty_form_has_forces_wherever_a_block_overhangs(cone, objective):
    """Figure 6.2, and beyond: the tension is what the moment about the edge needs."""
    options = RBEOptions(cone=cone, objective=objective)
    for share in np.linspace(0.05, 0.95, 11):
        result = solve_rbe(overhang([float(share)]), friction=0.8, options=options)
        assert result.force is not None, share
        assert (result.tension is not None) == (share > 0.5)
        # the lower brick presses under its edge and pulls at the other end of the joint
        weight, width = 0.125 * 2400.0 * 9.81, 1.0 - share
        pull = max(0.0, (share - 0.5) * weight / width)
        found = 0.0 if result.tension is None else result.tension.sum()
        assert found == pytest.approx(pull, rel=1e-3, abs=1e-3)


@pytest.mark.parametrize(
    ("tilt", "objective"), [(32.5, Objective.QUADRATIC), (40.0, Objective.LINEAR)]
)
def test_the_penalty_form_has_forces_for_the_dome_beyond_its_limit(tilt, objective):
    blocks = dome()
    model = Model.of(blocks, friction=0.6, load=LoadCase.tilt(blocks, (0.0, 1.0, 0.0), tilt))
    result = solve_rbe(model, options=RBEOptions(objective=objective))
    assert result.verdict is Verdict.UNSTABLE
    assert result.tension is not None
    assert result.residuals.equilibrium < 1e-6


def test_pages_go_into_the_folder_that_is_named_and_nowhere_else(tmp_path):
    written = save_case(reproduce("5.1.1"), tmp_path)
    assert sorted(written) == sorted(str(path) for path in tmp_path.iterdir())
    with pytest.raises(InputError, match="cannot be written"):
        save_case(reproduce("5.1.1"), Path(written[0]) / "missing")
