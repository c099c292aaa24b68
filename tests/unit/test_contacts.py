"""Contacts and parts of them."""

from dataclasses import replace

import numpy as np

from drystone import find_contacts, models

STACK = find_contacts(models.tower(5)).contacts.with_friction([0.3, 0.4, 0.5, 0.6])


def test_a_part_is_what_its_arrays_make_and_read_only() -> None:
    new = np.array([-1, 0, 1, 2, -1])
    part = STACK.select(np.array([False, True, True, False]), new)
    assert part.block_a.tolist() == [0, 1]
    assert part.block_b.tolist() == [1, 2]
    assert part.friction.tolist() == [0.4, 0.5]
    made = replace(part)
    for name in ("block_a", "block_b", "frame", "area", "friction", "point", "interface"):
        assert np.array_equal(getattr(part, name), getattr(made, name))
        assert not getattr(part, name).flags.writeable
    assert np.array_equal(part.tributary, made.tributary)


def test_contacts_of_some_blocks_are_numbered_as_these() -> None:
    part = STACK.of_blocks([1, 2, 3], 5)
    assert part.block_a.tolist() == [0, 1]
    assert part.block_b.tolist() == [1, 2]
    assert part.friction.tolist() == [0.4, 0.5]
    assert part.interface.tolist() == [0] * 4 + [1] * 4


def test_no_interface_makes_a_part_as_well() -> None:
    assert STACK.select(np.zeros(4, dtype=bool)).count == 0
