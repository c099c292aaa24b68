"""What a block refuses to be."""

import numpy as np
import pytest

from drystone import Assembly, Block, Contacts, InputError, Model, check, find_contacts
from drystone.models import box, tower
from drystone.poses import find_poses
from drystone.repair import mended_block

CUBE = box((1.0, 1.0, 1.0))


@pytest.mark.parametrize("scale", [1e31, 1e75, 1e154, 1e307])
def test_coordinates_whose_products_overflow_are_refused(scale: float) -> None:
    far = "give metres, up to 1e\\+30"
    with pytest.raises(InputError, match=far):
        Block(scale * CUBE.vertices, CUBE.faces)
    with pytest.raises(InputError, match=far):
        mended_block(scale * CUBE.vertices, CUBE.faces)
    with pytest.raises(InputError, match=far):
        CUBE.transformed(scale * np.eye(3))
    found = find_contacts(tower(2)).contacts
    parts = ("block_a", "block_b", "frame", "area", "friction", "interface")
    kept = {part: getattr(found, part) for part in parts}
    with pytest.raises(InputError, match=far):
        Contacts(**kept, point=scale * found.point)


@pytest.mark.parametrize("scale", [1e-31, 1e-100, 1e-320])
def test_blocks_whose_volume_underflows_are_refused(scale: float) -> None:
    with pytest.raises(InputError, match="m across; give metres"):
        Block(scale * CUBE.vertices, CUBE.faces)


@pytest.mark.parametrize("scale", [1e-29, 1e-9, 1e9, 1e29])
def test_between_them_the_size_does_not_matter(scale: float) -> None:
    blocks = [Block(scale * b.vertices, b.faces, b.name) for b in tower(3).blocks]
    found = find_contacts(Assembly(tuple(blocks), tower(3).fixed)).contacts
    np.testing.assert_allclose(found.area, [scale**2] * 2, rtol=1e-12)


def tongue(*, checked: bool = True) -> Block:
    """A tongue whose concave caps are fans that leave them: its volume is right all the same."""
    outline = [(-0.4, 0.0), (-0.4, -0.5), (0.4, -0.5), (0.4, 0.0), (0.5, 0.3), (-0.5, 0.3)]
    vertices = np.array([(x, y, z) for y in (-0.5, 0.5) for x, z in outline])
    caps = [(0, i, i + 1) for i in range(1, 5)] + [(11, i + 1, i) for i in range(9, 5, -1)]
    sides = [(i, i + 6, (i + 1) % 6 + 6, (i + 1) % 6) for i in range(6)]
    return Block(vertices, (*caps, *sides), name="tongue", checked=checked)


def test_a_block_made_in_python_is_refused_where_it_crosses_itself_as_one_from_a_file() -> None:
    with pytest.raises(InputError, match="block 'tongue': its surface"):
        check(Assembly((tongue(),)).with_fixed([0]))
    with pytest.raises(InputError, match="its surface"):
        check(Assembly((tongue().renamed("other").transformed(),)).with_fixed([0]))
    with pytest.raises(InputError, match="its surface"):
        check(Model(Assembly((tongue(),)).with_fixed([0]), Contacts.empty()))
    with pytest.raises(InputError, match="its surface"):
        find_poses(tongue())


def test_a_shell_that_is_inside_out_is_refused_and_a_cavity_is_not() -> None:
    """Files turn such shells and say so."""
    outer, inner = box((1.0, 1.0, 1.0), name="hollow"), box((0.5, 0.5, 0.5), (0.25, 0.25, 0.25))
    corners = np.concatenate([outer.vertices, inner.vertices])
    for turn, volume in ((1, 1.125), (-1, 0.875)):
        more = [[8 + i for i in loop[::turn]] for loop in inner.faces]
        hollow = Block(corners, (*outer.faces, *more), "hollow")
        assert hollow.volume == pytest.approx(volume)
        below = box((3.0, 3.0, 1.0), (-1.0, -1.0, -1.0), name="below")
        blocks = Assembly((below, hollow)).with_fixed([0])
        if turn < 0:
            assert check(blocks).stable
        else:
            for _ in range(2):  # and again
                with pytest.raises(InputError, match="'hollow': a shell of it is inside out"):
                    check(blocks)


def test_a_block_that_is_told_to_be_unchecked_is_taken_as_it_is() -> None:
    taken = tongue(checked=False).renamed("taken").transformed(translation=(1.0, 0.0, 0.0))
    assert not taken.checked
    assert check(Assembly((taken,)).with_fixed([0])).stable
