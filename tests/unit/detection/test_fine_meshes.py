"""Finely meshed blocks: the memory of the search grows with the number of faces, not its square."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable

import numpy as np
import pytest

from drystone.assembly import Assembly, Block
from drystone.detection import DetectionOptions, find_contacts
from drystone.models import box, curve_three_blocks

PLAY = 0.002
"""[m] between the peg and its sleeve."""
BATCH = 64 * 2**20
"""Bytes of the pairs that are compared at once."""


def ring(radius: float, height: float, count: int) -> np.ndarray:
    turn = 2.0 * np.pi * np.arange(count) / count
    flat = [radius * np.cos(turn), radius * np.sin(turn), np.full(count, height)]
    return np.stack(flat, axis=1)


def band(around: int, along: int, first: int = 0, *, inwards: bool = False) -> list[tuple]:
    """Triangles between rings of vertices, each ring above the one before."""
    faces = []
    for a in range(around * along):
        b = a - around + 1 if a % around == around - 1 else a + 1
        quad = [first + x for x in (a, b, b + around, a + around)]
        faces += [tuple(quad[:3]), (quad[0], *quad[2:])]
    return [face[::-1] for face in faces] if inwards else faces


def peg(around: int, along: int, radius: float = 0.02, bottom: float = 0.0) -> Block:
    heights = np.linspace(bottom, bottom + 0.1, along + 1)
    rings = [ring(radius, z, around) for z in heights]
    ends = [[0.0, 0.0, heights[0]], [0.0, 0.0, heights[-1]]]
    faces = band(around, along)
    low, top = around * (along + 1), around * along
    for i in range(around):
        j = (i + 1) % around
        faces += [(low, j, i), (low + 1, top + i, top + j)]
    return Block(np.concatenate([*rings, ends]), tuple(faces), "peg")


def sleeve(around: int, along: int, radius: float) -> Block:
    heights = np.linspace(0.0, 0.08, along + 1)
    rings = [ring(r, z, around) for r in (0.03, radius) for z in heights]
    inner, top = around * (along + 1), around * along
    faces = [*band(around, along), *band(around, along, inner, inwards=True)]
    for i in range(around):
        j = (i + 1) % around
        for a, b, c, d in ((i, j, inner + i, inner + j), (j, i, inner + j, inner + i)):
            low = a == i
            faces.append((a, c, b) if low else tuple(top + x for x in (a, c, b)))
            faces.append((b, c, d) if low else tuple(top + x for x in (b, c, d)))
    return Block(np.concatenate(rings), tuple(faces), "sleeve")


def peg_in_sleeve(grade: int, play: float = PLAY) -> Assembly:
    blocks = (sleeve(12 * grade, 4 * grade, 0.02 + play), peg(12 * grade, 8 * grade))
    return Assembly(blocks, np.array([True, False]))


def piled(grade: int) -> Assembly:
    """A peg 5 mm deep in another."""
    lower = peg(12 * grade, grade).transformed(translation=(0.0, 0.0, -0.095))
    blocks = (Block(lower.vertices, lower.faces, "lower"), peg(12 * grade, grade))
    return Assembly(blocks, np.array([True, False]))


def peak(work: Callable[[], object]) -> int:
    tracemalloc.start()
    work()
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return most


@pytest.mark.parametrize(
    ("edges", "play"),
    [
        ("isolated", PLAY),
        ("never", PLAY),
        ("always", 0.0),
        ("isolated", -0.0005),
    ],
)
def test_memory_of_a_peg_in_a_sleeve_grows_with_its_faces(edges: str, play: float) -> None:
    options = DetectionOptions(edges=edges)
    coarse, fine = (peg_in_sleeve(grade, play) for grade in (2, 4))
    find_contacts(coarse, options=options)  # imports
    few, many = (peak(lambda m=m: find_contacts(m, options=options)) for m in (coarse, fine))
    ratio = sum(len(b.faces) for b in fine.blocks) / sum(len(b.faces) for b in coarse.blocks)
    assert many < max(1.5 * ratio * few, BATCH)


def test_memory_of_deep_pegs_grows_with_their_faces() -> None:
    coarse, fine = piled(4), piled(8)
    find_contacts(coarse)
    few, many = (peak(lambda m=m: find_contacts(m)) for m in (coarse, fine))
    assert many < max(1.6 * 4.0 * few, BATCH)


def test_memory_of_strips_across_a_joint_grows_with_their_number() -> None:
    coarse, fine = curve_three_blocks(600), curve_three_blocks(1200)
    find_contacts(coarse)
    few, many = (peak(lambda m=m: find_contacts(m)) for m in (coarse, fine))
    assert many < max(1.5 * 2.0 * few, BATCH)


@pytest.mark.parametrize("grade", [1, 4])
def test_a_depth_does_not_depend_on_the_mesh(grade: int) -> None:
    (found,) = find_contacts(piled(3 * grade)).report.overlaps
    assert found.depth == pytest.approx(0.005, rel=1e-3)


def test_a_peg_that_is_drawn_into_its_sleeve_touches_all_round() -> None:
    model = peg_in_sleeve(5, -0.0005)
    found = find_contacts(model)
    assert found.contacts.area.sum() == pytest.approx(2.0 * np.pi * 0.0195 * 0.08, rel=0.01)
    assert [pair.off for pair in found.report.inexact] == pytest.approx([0.0005], rel=0.01)
    assert found.report.shortfalls == ()
    assert found.report.unjoined == ()


def test_a_peg_with_play_touches_nothing() -> None:
    found = find_contacts(peg_in_sleeve(3))
    assert found.contacts.count == 0
    assert found.report.missed == ()


def test_a_finely_meshed_peg_on_its_edge_touches_along_a_line() -> None:
    lying = peg(48, 24).transformed(np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]]))
    lying = lying.transformed(translation=(0.0, 0.0, -lying.bounds[0, 2]))
    floor = box((1.0, 1.0, 0.1), (-0.5, -0.5, -0.1), "floor")
    found = find_contacts(Assembly((floor, lying), np.array([True, False]))).contacts
    assert np.ptp(found.point[:, 0]) == pytest.approx(0.1, rel=1e-6)
    np.testing.assert_allclose(found.frame[:, 0], [[0.0, 0.0, 1.0]] * found.count, atol=1e-9)
