"""Contacts and parts of them."""

from dataclasses import replace

import numpy as np
import pytest

from drystone import Contacts, InputError, find_contacts
from drystone.models import tower
from tests.oracle import touching_faces

STACK = find_contacts(tower(5)).contacts.with_friction([0.3, 0.4, 0.5, 0.6])


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


def test_an_interface_is_taken_out_by_its_position() -> None:
    contacts = touching_faces(tower(4), 0.7)
    assert len(contacts) == 3
    assert [one.blocks for one in contacts] == [(0, 1), (1, 2), (2, 3)]
    last = contacts[-1]
    assert (last.blocks, last.area, last.friction) == ((2, 3), 1.0, 0.7)
    assert np.array_equal(last.corners, contacts.polygon(2))
    assert np.array_equal(last.frame, contacts.frame[2])
    assert len(Contacts.empty()) == 0


@pytest.mark.parametrize(
    ("position", "words"),
    [
        (3, "there is no interface 3; there are 3"),
        (-4, "there is no interface -4"),
        (1.0, r"position of an interface is 1\.0"),
        ("block-1", "position of an interface is 'block-1'"),
        (slice(2), "give a whole number"),
    ],
)
def test_what_is_no_interface_is_refused(position: object, words: str) -> None:
    with pytest.raises(InputError, match=words):
        touching_faces(tower(4), 0.7)[position]  # type: ignore[index]


def test_friction_beyond_what_can_be_calculated_with_is_refused() -> None:
    with pytest.raises(InputError, match=r"friction is 1e\+308.*1e\+50 at most"):
        find_contacts(tower(2), friction=1e308)


@pytest.mark.parametrize("wrong", [1e308, 1.01, -1.0])
def test_a_frame_that_is_not_made_of_unit_vectors_is_refused(wrong: float) -> None:
    found = find_contacts(tower(2)).contacts
    frame = np.array(found.frame)
    frame[0, 0] += (wrong, 0.0, 0.0)
    with pytest.raises(InputError, match="frame of interface 0 are not unit vectors"):
        replace(found, frame=frame)
