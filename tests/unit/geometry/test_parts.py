import numpy as np
import pytest

from drystone import Block
from drystone.base.arrays import Floats
from drystone.geometry.polyhedron import Loop
from drystone.geometry.soup import separate_parts
from drystone.models import box


def shells(*cubes: tuple[float, float, bool]) -> tuple[Floats, list[Loop]]:
    """Cubes about the origin or beside it: edge, shift along x, whether turned inside out."""
    vertices, faces = [], []
    for i, (edge, shift, turned) in enumerate(cubes):
        block = box((edge, edge, edge), (shift - edge / 2, -edge / 2, -edge / 2))
        vertices.append(block.vertices)
        loops = [tuple(8 * i + corner for corner in face) for face in block.faces]
        faces += [loop[::-1] if turned else loop for loop in loops]
    return np.concatenate(vertices), faces


def volume(vertices: Floats, loops: list[Loop]) -> float:
    return float(Block(vertices, tuple(loops)).volume)


def test_a_body_in_one_piece_is_left_as_it_is() -> None:
    vertices, faces = shells((2.0, 0.0, False))
    assert separate_parts(vertices, faces) == ([faces], 0)


def test_separate_shells_are_parts() -> None:
    vertices, faces = shells((2.0, 0.0, False), (1.0, 5.0, False))
    parts, turned = separate_parts(vertices, faces)
    assert [volume(vertices, part) for part in parts] == pytest.approx([8.0, 1.0])
    assert turned == 0


@pytest.mark.parametrize("inverted", [True, False])
def test_a_shell_inside_another_is_a_cavity_whichever_way_it_is_turned(inverted: bool) -> None:
    vertices, faces = shells((1.0, 0.1, inverted), (2.0, 0.0, False))
    (part,), turned = separate_parts(vertices, faces)
    assert volume(vertices, part) == pytest.approx(7.0)
    assert turned == (0 if inverted else 1)


def test_a_part_that_is_inside_out_is_turned() -> None:
    vertices, faces = shells((2.0, 0.0, False), (1.0, 5.0, True))
    parts, turned = separate_parts(vertices, faces)
    assert [volume(vertices, part) for part in parts] == pytest.approx([8.0, 1.0])
    assert turned == 1
    assert parts[1] == [loop[::-1] for loop in faces[6:]]


def test_a_stone_in_a_cavity_is_a_part_of_its_own() -> None:
    vertices, faces = shells((3.0, 0.0, False), (2.0, 0.0, True), (1.0, 0.0, False))
    parts, turned = separate_parts(vertices, faces)
    assert [volume(vertices, part) for part in parts] == pytest.approx([19.0, 1.0])
    assert turned == 0


def test_shells_that_touch_are_not_inside_each_other() -> None:
    vertices, faces = shells((2.0, 0.0, False), (1.0, 1.5, False))
    parts, turned = separate_parts(vertices, faces)
    assert len(parts) == 2
    assert turned == 0
