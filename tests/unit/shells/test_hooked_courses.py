"""Blocks with a joggle hook over the course below: they are not lifted but turned out."""

import numpy as np
import pytest

from drystone import check, write
from drystone.sequence import NoPath, RemovalPath, find_path
from drystone.shells import Layout, ShellBody, barrel_vault, build_shell, dome

LAYOUT = Layout(courses=6, blocks=3)


def half_built(joggle_deg, top=2):
    """The lower courses of one side of a barrel vault."""
    shell = build_shell(barrel_vault(), LAYOUT, ShellBody(joggle_deg=joggle_deg))
    model = shell.model(friction=0.6)
    courses = [f"c{course:02d}-" for course in range(top + 1)]
    kept = [n for n in model.assembly.names if n.startswith(("ground-c00", *courses))]
    return model.subset(kept)


def free_translation(model, block):
    """Least opening of the joints of a block, over directions on a fine sphere: the largest."""
    i = model.assembly.index(block)
    contacts = model.contacts
    sign = np.where(contacts.block_b == i, 1.0, np.where(contacts.block_a == i, -1.0, 0.0))
    normal = (sign[:, None] * contacts.frame[:, 0])[sign != 0.0]
    z = np.linspace(-1.0, 1.0, 181)
    turn = np.arange(360) * np.pi / 180.0
    flat = np.sqrt(1.0 - z**2)
    sphere = np.stack(
        [np.outer(flat, np.cos(turn)), np.outer(flat, np.sin(turn)), np.outer(z, np.ones(360))], -1
    )
    return (sphere.reshape(-1, 3) @ normal.T).min(axis=1).max()


@pytest.mark.parametrize("joggle_deg", [10.0, 20.0, 25.0, -10.0])
def test_a_hooked_block_has_no_straight_way_out_and_is_turned_out(joggle_deg):
    model = half_built(joggle_deg)
    assert free_translation(model, "c02-b01") < -1e-3
    path = find_path(model, "c02-b01")
    assert isinstance(path, RemovalPath)
    assert path.turning
    assert path.clearance[-1] > 0.1


def test_without_a_joggle_it_is_lifted():
    path = find_path(half_built(0.0), "c02-b01")
    assert isinstance(path, RemovalPath)
    assert not path.turning


def test_a_hooked_block_at_an_open_end_slides_out_along_its_course():
    path = find_path(half_built(20.0), "c02-b00")
    assert not path.turning
    assert np.abs(path.poses[-1].shift @ [1.0, 0.0, 1.0]) < 1e-6


def test_a_block_on_hooks_that_meet_at_an_angle_is_locked_and_the_shell_says_so():
    """In a ring of eight the beds below a block meet at 22.5 degrees."""
    shell = build_shell(
        dome(), Layout(courses=4, blocks=8), ShellBody(thickness=0.4, joggle_deg=10.0)
    )
    model = shell.model(friction=0.6)
    below = [n for n in model.assembly.names if n.startswith(("ground", "c00"))]
    path = find_path(model.subset([*below, "c01-b00"]), "c01-b00")
    assert isinstance(path, NoPath)
    assert path.proved
    assert any("hooks over beds that meet at 2" in note for note in shell.notes)
    straight = build_shell(barrel_vault(), LAYOUT, ShellBody(joggle_deg=10.0))
    assert not any("hooks over" in note for note in straight.notes)


def test_a_hooked_vault_stands_and_is_written(tmp_path):
    shell = build_shell(barrel_vault(), LAYOUT, ShellBody(joggle_deg=10.0))
    assert check(shell.model(friction=0.6)).stable
    write(shell.assembly, tmp_path / "hooked.obj")
