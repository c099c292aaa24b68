"""Shapes with a formula have defaults that a first look can be taken at."""

import numpy as np
import pytest

from drystone import InputError, Model, Verdict, check, find_contacts
from drystone.reproduce.assembly_cases import tri_dome as tri_dome_of_blocks
from drystone.sequence import StagedModel
from drystone.sequence.rules import courses
from drystone.shells import Layout, ShellBody, barrel_vault, build_shell, tri_dome


@pytest.mark.parametrize(("span", "rise"), [(3.0, None), (6.0, None), (6.0, 2.0), (6.0, 0.4)])
def test_a_barrel_stands_by_itself_with_its_default_thickness(span, rise):
    shell = build_shell(
        barrel_vault(span, span / 3.0, rise), Layout(courses=12, width=span / 8.0), ShellBody()
    )
    assert shell.shape.default_thickness == 0.075 * span
    contacts = find_contacts(shell.assembly, friction=0.6).contacts
    assert check(Model(shell.assembly, contacts)).verdict is Verdict.STABLE


def test_a_tri_dome_stands_on_three_feet_and_its_parts_are_alike():
    shell = tri_dome_of_blocks()
    assert len(shell.voussoirs) == 43
    result = check(shell.model(friction=0.66))
    assert result.verdict is Verdict.STABLE
    turn = 2.0 * np.pi / 3.0
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    at = dict(zip(shell.assembly.names, shell.assembly.centroid, strict=True))
    mass = dict(zip(shell.assembly.names, shell.assembly.mass, strict=True))
    for name in [one for one in at if one.startswith("p0-")]:
        other = name.replace("p0-", "p1-")
        assert at[other][:2] == pytest.approx(rotation @ at[name][:2], abs=1e-6)
        assert at[other][2] == pytest.approx(at[name][2], abs=1e-6)
        assert mass[other] == pytest.approx(mass[name], rel=1e-6)
    feet = shell.assembly.centroid[shell.assembly.fixed]
    assert len(feet) == 6
    assert np.ptp(feet[:, 2]) == pytest.approx(0.0, abs=1e-4)


def test_an_eye_that_cuts_the_openings_of_a_tri_dome_is_refused():
    with pytest.raises(InputError, match="too wide"):
        tri_dome(10.0, eye=7.0)


def test_courses_of_a_shell_of_several_patches_go_round_all_of_them():
    shell = build_shell(tri_dome(keystone=False), Layout(courses=4, blocks=2))
    of = dict(zip(shell.assembly.names, courses(StagedModel(shell.model())), strict=True))
    assert {of[f"p{patch}-c03-b00"] for patch in range(3)} == {3.0}
    assert of["p2-c00-b00"] < of["p0-c01-b00"]
