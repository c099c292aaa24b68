"""The joints that a shell knows are those that the contact search finds on its blocks."""

import numpy as np
import pytest

from benchmarks.sample_shells import sample_shell
from drystone import Contacts, find_contacts
from drystone.shells import (
    Ground,
    JointForm,
    Layout,
    Shell,
    ShellBody,
    barrel_vault,
    build_shell,
    dome,
    find_form,
    rectangular_plan,
)

SHELLS = {
    "barrel": lambda: sample_shell("barrel", 40),
    "dome": lambda: sample_shell("dome", 40),
    "freeform": lambda: sample_shell("freeform", 40),
    "form-found": lambda: sample_shell("form-found", 40),
    "keyed bed joints": lambda: build_shell(
        barrel_vault(), Layout(courses=10, blocks=4), ShellBody(joggle_deg=20.0)
    ),
    "keystone": lambda: build_shell(dome(keystone=True), Layout(courses=6, blocks=12)),
    "faceted joints": lambda: build_shell(
        find_form(rectangular_plan(6.0, 5.0), height=1.8).shape,
        Layout(courses=6, width=1.2, wedge=0.2),
        ShellBody(thickness=0.3, joints=JointForm.FACETED),
    ),
    "fixed springers": lambda: build_shell(
        dome(), Layout(courses=6, blocks=12, wedge=0.2), ShellBody(ground=Ground.SPRINGERS)
    ),
}


def sorted_joints(contacts: Contacts) -> list[tuple[tuple[int, int], np.ndarray, int]]:
    """Blocks, mean of the corners and position of every interface, in one order."""
    rows = [(joint.blocks, joint.corners.mean(axis=0), i) for i, joint in enumerate(contacts)]
    return sorted(rows, key=lambda row: (row[0], *np.round(row[1], 6).tolist()))


@pytest.mark.parametrize("name", SHELLS)
def test_a_shell_hands_over_the_joints_that_the_search_finds(name: str) -> None:
    shell: Shell = SHELLS[name]()
    made, found = shell.contacts, find_contacts(shell.assembly).contacts
    assert len(made) == len(found) > 30
    size = float(np.cbrt(shell.assembly.volume.mean()))
    for one, other in zip(sorted_joints(made), sorted_joints(found), strict=True):
        a, b = made[one[2]], found[other[2]]
        assert a.blocks == b.blocks
        assert a.area == pytest.approx(b.area, rel=1e-9)
        np.testing.assert_allclose(a.frame[0], b.frame[0], atol=1e-9)
        assert len(a.corners) == len(b.corners)
        away = np.linalg.norm(a.corners[:, None] - b.corners[None], axis=2).min(axis=1)
        assert away.max() < 1e-6 * size


def test_the_model_of_a_shell_has_its_joints_its_notes_and_the_friction_asked_for() -> None:
    shell = sample_shell("dome", 40)
    model = shell.model(friction=0.7, load=2.0)
    assert set(model.contacts.friction.tolist()) == {0.7}
    assert model.notes == shell.notes
    assert model.contacts.count == len(shell.contacts)
    assert model.load.wrench[5, 2] == pytest.approx(-2.0 * 9.81 * shell.assembly.mass[5])
