"""What a block refuses to be."""

import numpy as np
import pytest

from drystone import Assembly, Block, Contacts, InputError, find_contacts
from drystone.detection import contacts_from_mesh
from drystone.models import box, tower
from drystone.repair import mended_block

CUBE = box((1.0, 1.0, 1.0))


@pytest.mark.parametrize("scale", [1e31, 1e75, 1e154, 1e307])
def test_coordinates_whose_products_overflow_are_refused(scale: float) -> None:
    far = "give metres, up to 1e\\+30"
    joint = scale * np.array([(0.0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)])
    with pytest.raises(InputError, match=far):
        Block(scale * CUBE.vertices, CUBE.faces)
    with pytest.raises(InputError, match=far):
        mended_block(scale * CUBE.vertices, CUBE.faces)
    with pytest.raises(InputError, match=far):
        CUBE.transformed(scale * np.eye(3))
    with pytest.raises(InputError, match=far):
        contacts_from_mesh(tower(2), 0, 1, joint, [(0, 1, 2), (2, 3, 0)])
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
