"""Shapes with a formula have defaults that a first look can be taken at."""

import pytest

from drystone import Verdict, check, find_contacts
from drystone.model import Model
from drystone.shells import Layout, ShellBody, barrel_vault, build_shell


@pytest.mark.parametrize(("span", "rise"), [(3.0, None), (6.0, None), (6.0, 2.0), (6.0, 0.4)])
def test_a_barrel_stands_by_itself_with_its_default_thickness(span, rise):
    shell = build_shell(
        barrel_vault(span, span / 3.0, rise), Layout(courses=12, width=span / 8.0), ShellBody()
    )
    assert shell.shape.default_thickness == 0.075 * span
    contacts = find_contacts(shell.assembly, friction=0.6).contacts
    assert check(Model(shell.assembly, contacts)).verdict is Verdict.STABLE
