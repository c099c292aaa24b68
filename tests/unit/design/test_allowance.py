import numpy as np
import pytest

from drystone.assembly import Assembly, Block
from drystone.base.errors import InputError
from drystone.design import joint_allowance
from drystone.detection import find_contacts
from drystone.geometry.convex_pieces import solid_of
from drystone.geometry.selfcontact import self_contacts
from drystone.model import Model
from drystone.models import arch, bayonet, box, bridge, burr, cube_curve, hooked_bar, tower

SANDPAPER = 0.58e-3


def model(assembly: Assembly) -> Model:
    return Model.of(assembly, friction=0.6)


def test_the_blocks_of_a_tower_are_lower_by_half_the_allowance_per_joint() -> None:
    made = joint_allowance(model(tower(4)), SANDPAPER)
    height = np.diff(made.bounds[:, :, 2], axis=1).ravel()
    share = np.array([0.5, 1.0, 1.0, 0.5])
    np.testing.assert_allclose(height, 1.0 - share * SANDPAPER, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(made.bounds[:, :, :2], tower(4).bounds[:, :, :2])
    assert (made.names, made.fixed.tolist()) == (tower(4).names, tower(4).fixed.tolist())


@pytest.mark.parametrize("made", [arch, bridge, hooked_bar, bayonet])
def test_joints_are_open_by_the_allowance_along_their_normal(made: type) -> None:
    before = made()
    after = joint_allowance(model(before), SANDPAPER)
    found = find_contacts(after).report
    assert len(found.interfaces.gap) > 0
    np.testing.assert_allclose(found.interfaces.gap, SANDPAPER, rtol=0, atol=1e-9)
    assert found.overlaps == ()
    assert self_contacts([b.vertices for b in after], [b.faces for b in after]) == []
    assert (after.volume <= before.volume).all()


def test_notched_blocks_are_cut_back_behind_each_face_of_a_joint() -> None:
    """More than three faces meet at the corners of a notch, so a face cannot move alone."""
    before = model(burr())
    after = joint_allowance(before, SANDPAPER)
    found = find_contacts(after).report
    assert len(found.interfaces.gap) == before.contacts.count
    np.testing.assert_allclose(found.interfaces.gap, SANDPAPER, rtol=0, atol=1e-8)
    assert found.overlaps == ()


def test_curved_joints_are_open_too() -> None:
    made = joint_allowance(model(cube_curve(strips=5)), SANDPAPER)
    one, other = (solid_of(block.vertices, block.faces) for block in made)
    assert one.min_gap(other, 1.0) == pytest.approx(SANDPAPER, rel=1e-6)


def test_parts_of_a_face_move_together_though_a_joint_covers_one() -> None:
    x, y, z = (0.0, 1.0, 2.0), (0.0, 1.0), (0.0, 1.0)
    corner = [(a, b, c) for a in x for b in y for c in z]
    faces = (
        (1, 5, 7, 3), (5, 9, 11, 7),  # the top, in two parts
        (0, 2, 6, 10, 8, 4), (0, 4, 8, 9, 5, 1), (2, 3, 7, 11, 10, 6), (0, 1, 3, 2), (8, 10, 11, 9),
    )  # fmt: skip
    base = Block(np.array(corner), faces, "base")
    made = joint_allowance(model(Assembly((base, box((1.0, 1.0, 1.0), (0.0, 0.0, 1.0))))), 0.1)
    assert made.bounds[0, 1].tolist() == pytest.approx([2.0, 1.0, 0.95])
    assert made.volume.tolist() == pytest.approx([1.9, 0.95])


@pytest.mark.parametrize(
    ("blocks", "allowance", "words"),
    [
        (tower(3), -0.001, "allowance is -0.001; give a number above zero"),
        (tower(3), 0.0, "give a number above zero"),
        (tower(3), 1.5, "block 'block-1', face 2: would remove a whole face; move it less"),
        (hooked_bar(), 1.0, "would remove a whole face"),
        (burr(), 0.19, "block 'x-low': the joint allowance would leave 2 pieces of it"),
        (Assembly((box((1, 1, 1)), box((1, 1, 1), (0, 0, 3), "up"))), 0.001, "no faces touch"),
    ],
)
def test_what_cannot_be_made_smaller_is_refused(
    blocks: Assembly, allowance: float, words: str
) -> None:
    with pytest.raises(InputError, match=words):
        joint_allowance(model(blocks), allowance)
