import numpy as np
import pytest

from drystone import Assembly, Block
from drystone.geometry.halfedge import merge_coplanar
from drystone.geometry.polyhedron import Loop
from drystone.geometry.triangulate import triangulate
from drystone.models import arch, box, dome, tower, vault, wall


def triangles(block: Block) -> list[Loop]:
    corners = np.concatenate([block.vertices[list(face)] for face in block.faces])
    index = np.array([i for face in block.faces for i in face])
    start = np.concatenate([[0], np.cumsum([len(face) for face in block.faces])])
    return [tuple(t) for t in index[triangulate(corners, start)[0]].tolist()]


def as_cycle(loop: Loop) -> Loop:
    first = loop.index(min(loop))
    return loop[first:] + loop[:first]


@pytest.mark.parametrize("assembly", [tower(2), arch(), dome(), vault(), wall()])
def test_triangles_become_the_polygons_that_they_were_cut_from(assembly: Assembly) -> None:
    blocks = assembly.blocks
    merged = merge_coplanar([b.vertices for b in blocks], [triangles(b) for b in blocks], 1e-9)
    for block, loops in zip(blocks, merged, strict=True):
        assert {as_cycle(loop) for loop in loops} == {as_cycle(face) for face in block.faces}


def test_single_precision_is_no_obstacle() -> None:
    rng = np.random.default_rng(5)
    for block in arch().blocks:
        points = (block.vertices + rng.uniform(0.0, 3.0)).astype(np.float32).astype(np.float64)
        (loops,) = merge_coplanar([points], [triangles(block)], 1e-6)
        assert len(loops) == len(block.faces)


def test_faces_that_bend_are_left_alone() -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 400, endpoint=False)
    ring = np.stack([np.cos(angle), np.sin(angle), np.zeros(400)], axis=1)
    vertices = np.concatenate([ring, ring + np.array([0.0, 0.0, 1.0])])
    n = len(ring)
    sides = [(i, (i + 1) % n, (i + 1) % n + n, i + n) for i in range(n)]
    loops = [tuple(range(n))[::-1], tuple(range(n, 2 * n)), *sides]
    (merged,) = merge_coplanar([vertices], [loops], 1e-6)
    assert merged == loops


def test_a_face_with_a_hole_stays_in_pieces() -> None:
    """A block with a square hole through it: its top and bottom are rings."""
    outer, inner = box((3.0, 3.0, 1.0)).vertices, box((1.0, 1.0, 1.0), (1.0, 1.0, 0.0)).vertices
    vertices = np.concatenate([outer, inner])
    top = [(4 + i, 4 + (i + 1) % 4, 12 + (i + 1) % 4, 12 + i) for i in range(4)]
    bottom = [(i, 8 + i, 8 + (i + 1) % 4, (i + 1) % 4) for i in range(4)]
    sides = [(i, (i + 1) % 4, 4 + (i + 1) % 4, 4 + i) for i in range(4)]
    inside = [(8 + i, 12 + i, 12 + (i + 1) % 4, 8 + (i + 1) % 4) for i in range(4)]
    loops = [*top, *bottom, *sides, *inside]
    assert Block(vertices, tuple(loops)).volume == pytest.approx(8.0)
    assert merge_coplanar([vertices], [loops], 1e-9) == [loops]


def test_nothing_is_merged_into_nothing() -> None:
    assert merge_coplanar([], [], 1e-9) == []
