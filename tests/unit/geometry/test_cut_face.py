"""Sections of bodies by planes: their area, their outline and their holes."""

from __future__ import annotations

import numpy as np
import pytest

from drystone.geometry.frames import area_vectors
from drystone.geometry.polyhedron import stack_faces
from drystone.models import arch, box, shelf
from drystone.view.section import clip_loop, cut_faces

AXES = np.eye(3)


def section_areas(blocks, normal, offset):
    """Area of the section of each body along the normal."""
    faces = stack_faces([b.vertices for b in blocks], [b.faces for b in blocks])
    total = np.zeros(len(blocks))
    for body, ring in cut_faces(faces, normal, offset):
        total[body] += area_vectors(ring, np.array([0, len(ring)]))[0] @ normal
    return total


@pytest.mark.parametrize("build", [lambda: arch(0.2, 6), shelf])
@pytest.mark.parametrize("normal", [*AXES, -AXES[0], np.array([0.6, 0.0, 0.8])])
def test_sections_add_up_to_the_volume(build, normal):
    """The area is a quadratic function between the heights of vertices: two places are exact."""
    blocks = build().blocks
    ends = np.unique(np.concatenate([b.vertices @ normal for b in blocks]).round(12))
    half, middle = 0.5 * np.diff(ends), 0.5 * (ends[1:] + ends[:-1])
    volume = sum(
        half @ [section_areas(blocks, normal, float(at)).sum() for at in middle + s * half]
        for s in (-np.sqrt(1.0 / 3.0), np.sqrt(1.0 / 3.0))
    )
    assert volume == pytest.approx(sum(b.volume for b in blocks), rel=1e-9)


def test_a_plane_through_vertices_gives_closed_rings():
    cube = box((1.0, 1.0, 1.0))
    diagonal = np.array([1.0, 1.0, 0.0]) / np.sqrt(2.0)
    assert section_areas([cube], diagonal, float(np.sqrt(0.5))) == pytest.approx(np.sqrt(2.0))
    assert section_areas([cube], AXES[2], 1.0) == 0.0


def test_a_concave_body_has_two_rings():
    frame = np.array([(0, 0), (3, 0), (3, 2), (2, 2), (2, 1), (1, 1), (1, 2), (0, 2)], dtype=float)
    n = len(frame)
    vertices = np.vstack([np.c_[frame, np.zeros(n)], np.c_[frame, np.ones(n)]])
    sides = [(i, (i + 1) % n, n + (i + 1) % n, n + i) for i in range(n)]
    loops = [tuple(range(n))[::-1], tuple(range(n, 2 * n)), *sides]
    rings = cut_faces(stack_faces([vertices], [loops]), AXES[1], 1.5)
    areas = [area_vectors(ring, np.array([0, len(ring)]))[0] @ AXES[1] for _, ring in rings]
    assert areas == pytest.approx([1.0, 1.0])


def test_a_polygon_is_clipped_with_its_values_and_its_marked_sides():
    told = np.array([[0.0, 0.0, 1.0], [4.0, 0.0, 5.0], [4.0, 1.0, 5.0], [0.0, 1.0, 1.0]])
    marked = np.array([True, False, True, False])
    part, sides = clip_loop(told, told[:, 0] - 1.0, marked)
    np.testing.assert_allclose(part, [[0, 0, 1], [1, 0, 2], [1, 1, 2], [0, 1, 1]])
    assert sides.tolist() == [True, False, True, False]
    assert len(clip_loop(told, np.ones(4), marked)[0]) == 0
    assert clip_loop(told, np.zeros(4), marked)[0] is told
