"""Mending on request, and what is said about it."""

from __future__ import annotations

import numpy as np
import pytest

from drystone import Assembly, Block, InputError, find_contacts
from drystone.models import box, tower
from drystone.repair import mended_block, mended_blocks, split_components

CUBE = box((1.0, 1.0, 1.0), name="cube")


def together(*blocks: Block, inside_out: tuple[int, ...] = ()) -> Block:
    """One block from the surfaces of several."""
    vertices, faces = [], []
    for i, block in enumerate(blocks):
        offset = sum(len(v) for v in vertices)
        step = -1 if i in inside_out else 1
        faces += [tuple(k + offset for k in face)[::step] for face in block.faces]
        vertices.append(block.vertices)
    return Block(np.concatenate(vertices), tuple(faces), "pair")


def test_parts_become_blocks_with_their_support_and_density() -> None:
    pair = together(CUBE, box((1.0, 1.0, 1.0), (0.0, 0.0, 1.0)))
    heavy = Block(pair.vertices, pair.faces, "pair", 3000.0, {"layer": "A"})
    split = split_components(
        Assembly((heavy, box((1, 1, 1), (0, 0, 2), "top")), np.array([True, False]))
    )
    assert split.names == ("pair-0", "pair-1", "top")
    assert split.fixed.tolist() == [True, True, False]
    assert [block.density for block in split.blocks[:2]] == [3000.0, 3000.0]
    assert split.blocks[1].metadata == {"layer": "A"}
    assert split.blocks[1].repairs == ("part 2 of 2 of 'pair'",)
    assert split.volume == pytest.approx([1.0, 1.0, 1.0])
    assert find_contacts(split).contacts.count == 2


@pytest.mark.parametrize(
    "faces", [[], [(0, 1, 2)], [(0, 1, 2), (2, 1, 0)], [(0, 1, 2), (0, 1, 2), (0, 2, 1)]]
)
def test_a_mesh_of_which_no_face_is_left_is_refused(faces: list[tuple[int, ...]]) -> None:
    flat = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    for vertices in (flat, flat * [1.0, 0.0, 0.0]):
        with pytest.raises(InputError):
            mended_blocks(vertices, faces)
    with pytest.raises(InputError):
        mended_blocks(np.empty((0, 3)), [])


def test_cavity_stays_in_its_block() -> None:
    hollow = together(CUBE, box((0.2, 0.2, 0.2), (0.4, 0.4, 0.4)), inside_out=(1,))
    assert hollow.volume == pytest.approx(1.0 - 0.008)
    assert split_components(Assembly((hollow,))).blocks == (hollow,)


def test_cavity_goes_with_the_part_around_it() -> None:
    far = box((1.0, 1.0, 1.0), (5.0, 0.0, 0.0))
    cavity = box((0.2, 0.2, 0.2), (5.4, 0.4, 0.4))
    parts = split_components(Assembly((together(CUBE, far, cavity, inside_out=(2,)),)))
    assert parts.volume == pytest.approx([1.0, 0.992])


def test_whole_blocks_stay_as_they_are() -> None:
    model = tower(3)
    assert split_components(model).blocks == model.blocks


def test_report_names_blocks_of_several_parts() -> None:
    pair = together(CUBE, box((1.0, 1.0, 1.0), (0.0, 0.0, 1.5)))
    report = find_contacts(Assembly((pair,))).report
    assert report.parts == ((0, 2),)
    assert any("2 separate parts" in line for line in report.summary())


def test_loose_faces_are_joined_and_said_so() -> None:
    loose = CUBE.vertices[[i for face in CUBE.faces for i in face]]
    noise = 1e-8 * np.random.default_rng(0).standard_normal(loose.shape)
    mended = mended_block(loose + noise, [range(4 * i, 4 * i + 4) for i in range(6)], "loose")
    assert len(mended.vertices) == 8
    assert "16 coincident vertices merged" in mended.repairs


def test_collapsed_faces_are_dropped_and_said_so() -> None:
    vertices = np.concatenate([CUBE.vertices, CUBE.vertices[:1]])
    mended = mended_block(vertices, [*CUBE.faces, (0, 8, 1)])
    assert "1 face without area dropped" in mended.repairs
    assert mended.volume == pytest.approx(1.0)


def test_turned_faces_are_turned_back_and_said_so() -> None:
    mended = mended_block(CUBE.vertices, [CUBE.faces[0][::-1], *CUBE.faces[1:]])
    assert mended.volume == pytest.approx(1.0)
    assert any("turned" in note for note in mended.repairs)


def test_holes_are_not_filled() -> None:
    with pytest.raises(InputError, match="open mesh"):
        mended_block(CUBE.vertices, CUBE.faces[1:])


@pytest.mark.parametrize("merge", [-1.0, 0.5])
def test_merging_across_a_block_is_refused(merge: float) -> None:
    with pytest.raises(InputError, match="merge"):
        mended_block(CUBE.vertices, CUBE.faces, merge=merge)


def test_face_of_no_vertex_is_refused() -> None:
    with pytest.raises(InputError, match="names no vertex"):
        mended_block(CUBE.vertices, [(0, 1, 99)])


@pytest.mark.parametrize("turned", [1, -1])
def test_a_block_whose_faces_all_occur_twice_is_the_block(turned: int) -> None:
    faces = [*CUBE.faces, *(face[1:][::turned] + face[:1] for face in CUBE.faces)]
    block = mended_block(CUBE.vertices, faces)
    assert block.volume == pytest.approx(CUBE.volume)
    assert len(block.faces) == 6
    assert "6 faces that occurred twice dropped" in block.repairs
