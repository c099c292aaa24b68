"""Bodies behind open surfaces."""

from __future__ import annotations

import numpy as np
import pytest

from drystone.assembly import Block
from drystone.base.errors import InputError
from drystone.models import box
from drystone.repair import backed

ROOM = box((2.0, 2.0, 1.0), (-1.0, -1.0, 0.0))
INSIDE, ABOVE, BESIDE = [[0.0, 0.0, 0.3]], [[0.0, 0.0, 1.5]], [[3.0, 0.0, 0.5]]


def faces_at(*heights: float) -> list[tuple[int, ...]]:
    """The faces of the room whose middle is at one of the heights."""
    middle = [ROOM.vertices[list(face)][:, 2].mean() for face in ROOM.faces]
    return [face for face, z in zip(ROOM.faces, middle, strict=True) if z in heights]


def made(faces: list[tuple[int, ...]], beside: list[list[float]]) -> tuple[Block, list[str]]:
    (vertices, loops), done = backed(ROOM.vertices, faces, np.array(beside), 0.25)
    return Block(vertices, tuple(loops)), done


@pytest.mark.parametrize("turned", [False, True])
def test_a_face_gets_a_body_on_the_side_without_blocks(turned: bool) -> None:
    top = [face[::-1] if turned else face for face in faces_at(1.0)]
    for beside, bottom in ((ABOVE, 0.75), (INSIDE, 1.0)):
        block, done = made(top, beside)
        assert block.volume == pytest.approx(1.0)
        assert block.bounds[0, 2] == pytest.approx(bottom)
        assert done == ["an open surface backed by 0.25 m"]


def test_a_box_without_a_lid_is_a_basin_around_what_is_in_it() -> None:
    block, done = made(faces_at(0.0, 0.5), INSIDE)
    assert block.bounds[1, 2] == 1.0
    assert block.bounds[0, 2] < 0.0
    assert block.volume < 4.0
    assert done == ["an open surface backed by 0.25 m"]


def test_a_box_without_a_bottom_is_closed_under_what_is_on_it() -> None:
    block, done = made(faces_at(1.0, 0.5), ABOVE)
    assert block.volume == pytest.approx(4.0)
    assert done == ["the holes of a surface closed"]


def test_a_frame_keeps_its_inside_for_blocks_that_are_in_it() -> None:
    block, _ = made(faces_at(0.5), INSIDE)
    assert block.bounds[0, 0] < -1.1
    closed, done = made(faces_at(0.5), BESIDE)
    assert closed.volume == pytest.approx(4.0)
    assert done == ["the holes of a surface closed"]


def test_parts_that_are_apart_get_a_body_each() -> None:
    block, done = made(faces_at(0.0, 1.0), ABOVE)
    assert len(block.faces) == 12
    assert done == ["an open surface backed by 0.25 m"]


def test_a_surface_without_an_area_or_with_three_faces_at_an_edge_is_refused() -> None:
    line = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]])
    with pytest.raises(InputError, match="has no area"):
        backed(line, [(0, 1, 2)], np.zeros((0, 3)), 0.1)
    wings = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, -1, 0]])
    with pytest.raises(InputError, match="more than two faces"):
        backed(wings, [(0, 1, 2), (0, 1, 3), (0, 1, 4)], np.zeros((0, 3)), 0.1)
