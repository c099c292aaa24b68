"""Faces as patches: merging, warp, curvature, convexity."""

from __future__ import annotations

import numpy as np
import pytest

from drystone import Assembly, Block, InputError
from drystone.base.arrays import Floats
from drystone.detection.patches import patches_of
from drystone.models import box, concave, curve_three_blocks, dome, prism, tower, welded


def gridded(count: int, rise: Floats | None = None) -> Block:
    """A unit cube whose top is cut into squares, lifted by ``rise`` at their corners."""
    place = np.linspace(0.0, 1.0, count + 1)
    height = np.ones((count + 1, count + 1)) if rise is None else 1.0 + rise
    top = [
        np.array(
            [
                (place[a], place[b], height[a, b])
                for a, b in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))
            ]
        )
        for i in range(count)
        for j in range(count)
    ]
    rim = [[(t, 0.0) for t in place], [(1.0, t) for t in place]]
    rim += [[(t, 1.0) for t in place[::-1]], [(0.0, t) for t in place[::-1]]]
    at = {(x, y): height[i, j] for i, x in enumerate(place) for j, y in enumerate(place)}
    sides = [
        [(*p, 0.0) for p in side[:: len(side) - 1]] + [(*p, at[p]) for p in side[::-1]]
        for side in rim
    ]
    return welded([*top, *sides, [(0, 0, 0), (0, 1, 0), (1, 1, 0), (1, 0, 0)]], "gridded")


def test_size_of_a_cube_is_its_edge() -> None:
    assert patches_of(tower(2, edge=0.3)).size == pytest.approx([0.3, 0.3])


def test_coplanar_faces_are_one_patch() -> None:
    patches = patches_of(Assembly((gridded(5),)))
    assert patches.count == 6
    assert np.diff(patches.ring_start[patches.first_ring]).tolist() == [4] * 6
    assert patches.area == pytest.approx([1.0] * 6)
    assert patches.convex.all()


def test_finely_meshed_curve_is_not_flattened() -> None:
    count = 2_000
    angle = np.linspace(0.0, np.pi, count + 1)
    arc = prism(np.stack([np.cos(angle), np.sin(angle)], axis=1), (0.0, 1.0))
    assert patches_of(Assembly((arc,))).count == count + 3


def test_planar_faces_have_no_warp_and_warped_ones_theirs() -> None:
    assert patches_of(concave()).warp.max() < 1e-15
    cube = box((1.0, 1.0, 1.0))
    vertices = np.array(cube.vertices)
    vertices[[4, 6], 2] += 0.02
    vertices[[5, 7], 2] -= 0.02
    assert patches_of(Assembly((Block(vertices, cube.faces),))).warp.max() == pytest.approx(
        0.02, rel=0.01
    )


def test_strips_of_a_curve_know_their_sag() -> None:
    strips = 20
    angle = np.linspace(0.0, np.pi, strips + 1)
    arc = prism(np.stack([np.cos(angle), np.sin(angle)], axis=1), (0.0, 1.0))
    patches = patches_of(Assembly((arc,)))
    sag = 1.0 - np.cos(0.5 * np.pi / strips)
    assert patches.sag.max() == pytest.approx(sag, rel=0.01)
    assert patches.bend.max() == pytest.approx(0.5 * np.pi / strips, rel=0.01)


def test_chamfer_does_not_make_its_neighbour_curved() -> None:
    c = 0.02
    chamfered = prism([(0, 0), (1, 0), (1, 1 - 0.5 * c), (1 - c, 1), (0, 1)], (0.0, 1.0))
    patches = patches_of(Assembly((chamfered,)))
    large = patches.area > 0.9
    assert patches.sag[large].max() < 2e-3
    assert np.rad2deg(patches.bend[large].max()) < 0.5


def test_convex_and_concave_blocks_are_told_apart() -> None:
    model = Assembly((*concave().blocks, box((1, 1, 1), name="c")))
    assert patches_of(model).block_convex.tolist() == [False, False, True]
    assert patches_of(dome()).block_convex.all()
    assert patches_of(curve_three_blocks()).block_convex.tolist() == [False, False, True]


def test_two_shells_in_one_block_are_not_convex() -> None:
    one, two = box((1, 1, 1)), box((1, 1, 1), (3, 0, 0))
    faces = (*one.faces, *(tuple(i + 8 for i in face) for face in two.faces))
    both = Block(np.concatenate([one.vertices, two.vertices]), faces)
    assert patches_of(Assembly((both,))).block_convex.tolist() == [False]


def test_face_numbers_are_those_of_the_block() -> None:
    patches = patches_of(tower(2))
    assert patches.face.tolist() == [*range(6), *range(6)]
    assert patches.owner.tolist() == [0] * 6 + [1] * 6


def test_a_block_that_rounding_has_flattened_is_refused() -> None:
    low = [(0, 0, 0), (0, 0, 0), (1, 0, 0), (1, 0, 0), (0, 1, 0), (0, 1, 0), (1, 1, 0)]
    vertices = np.array([*low, (1, 1, 1e-7)], dtype=float)
    thin = Block(vertices, box((1.0, 1.0, 1.0)).faces, name="plate")
    with pytest.raises(InputError, match="block 'plate': its faces lie in one plane"):
        patches_of(Assembly((thin,)))
