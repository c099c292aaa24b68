"""One model, several analyses: they must not contradict each other."""

import numpy as np
import pytest

from drystone import (
    CheckOptions,
    LoadCase,
    Model,
    Verdict,
    check,
    find_contacts,
    solve_cra,
    solve_cra_penalty,
    solve_rbe,
)
from drystone.checks import check_forces, mechanism_defects
from drystone.models import a_model, arch, concave, cube_curve, h_model, shelf, stool, vault, wedge

STANDING = {
    "arch": (arch(0.15), 0.9, None),
    "arch of little friction": (arch(0.15), 0.4, None),
    "cube-curve": (cube_curve("short"), 0.84, None),
    "concave": (concave("short"), 0.84, None),
    "stool": (stool(), 0.6, None),
    "shelf without two": (shelf().without([9, 10]), 0.9, None),
    "wedge d tilted about xy 48": (wedge("d"), 0.84, ((3**0.5, 1, 0), 48.0)),
}
FALLING = {
    "H": (h_model(), 0.6, None),
    "A": (a_model(), 0.6, None),
    "shelf": (shelf(), 0.9, None),
    "arch tilted": (arch(0.15), 0.9, ((0, 1, 0), 8.5)),
    "arch of less friction": (arch(0.15), 0.3, None),
    "wedge b tilted 59.5": (wedge("b"), 0.84, ((1, 0, 0), 59.5)),
    "wedge c tilted 44.6": (wedge("c"), 0.84, ((1, 0, 0), 44.6)),
    "wedge d tilted about y 70.5": (wedge("d"), 0.84, ((0, 1, 0), 70.5)),
    "wedge a tilted about x 60": (wedge("a"), 0.84, ((1, 0, 0), 60.0)),
}


def build(case):
    model, friction, tilt = case
    load = LoadCase.tilt(model, *tilt) if tilt else LoadCase.gravity(model)
    return model, find_contacts(model, friction=friction).contacts, load


@pytest.mark.parametrize("name", STANDING)
def test_what_stands_stands_for_every_analysis(name):
    model, contacts, load = build(STANDING[name])
    result = check(Model(model, contacts, load))
    assert result.verdict is Verdict.STABLE
    again = check_forces(Model(model, contacts, load), result.force, result.displacement)
    assert again.largest <= 1e-8
    assert solve_rbe(Model(model, contacts, load)).verdict is Verdict.EQUILIBRIUM_EXISTS
    helped = solve_cra_penalty(Model(model, contacts, load))
    assert helped.verdict is Verdict.STABLE
    assert not helped.tension.any()


@pytest.mark.parametrize("name", FALLING)
def test_what_falls_falls_with_a_proof(name):
    model, contacts, load = build(FALLING[name])
    result = check(Model(model, contacts, load))
    assert result.verdict is Verdict.UNSTABLE
    assert result.falling
    closing = contacts.with_friction(0.0)
    violation, power = mechanism_defects(Model(model, closing, load), result.mechanism)
    assert violation <= 1e-5
    assert power > 0.0
    assert solve_cra(Model(model, contacts, load)).verdict is Verdict.UNSTABLE


@pytest.mark.parametrize("name", STANDING)
def test_coupled_analysis_has_equal_overlaps_wherever_force_passes(name):
    model, contacts, load = build(STANDING[name])
    result = solve_cra(Model(model, contacts, load))
    assert result.method == "cra"
    assert result.residuals.largest <= 1e-6
    assert result.eta < 1000.0


def test_a_failed_equilibrium_means_unstable_and_its_mechanism_is_one():
    model, contacts, load = build(FALLING["arch tilted"])
    balance = solve_rbe(Model(model, contacts, load))
    assert balance.verdict is Verdict.UNSTABLE
    violation, power = mechanism_defects(Model(model, contacts, load), balance.mechanism)
    assert violation <= 1e-6
    assert power > 0.0


def test_the_penalty_form_names_the_two_pieces_of_the_shelf():
    model, contacts, load = build(FALLING["shelf"])
    result = solve_cra_penalty(Model(model, contacts, load))
    assert set(result.falling) == {9, 10}
    assert result.tension.max() > 0.0


@pytest.mark.parametrize("name", ["H", "A"])
def test_the_prop_of_a_block_between_walls_carries_its_weight(name):
    model, contacts, load = build(FALLING[name])
    result = solve_cra_penalty(Model(model, contacts, load))
    (block,) = result.falling
    assert result.prop[block] == pytest.approx(-load.wrench[block], rel=1e-6, abs=1e-3)


def test_a_block_between_vertical_walls_cannot_be_glued_in_place_by_pressure():
    model, contacts, load = build(FALLING["H"])
    assert "glue cannot hold" in solve_cra_penalty(Model(model, contacts, load)).message


def test_uniform_stiffness_alone_gives_the_same_verdict_on_the_vault():
    model = vault()
    contacts = find_contacts(model, friction=0.6).contacts
    quick = check(Model(model, contacts), options=CheckOptions(samples=0))
    full = check(Model(model, contacts))
    assert quick.verdict is full.verdict is Verdict.STABLE
    assert np.allclose(quick.force, full.force)
