"""Neighbours across edges, turning angles, outlines of merged faces."""

from __future__ import annotations

import numpy as np
import pytest

from drystone.geometry.frames import area_vectors
from drystone.geometry.halfedge import half_edges, joined_faces, outlines, turn_angles
from drystone.geometry.polyhedron import Faces, stack_faces
from drystone.models import box, prism


def faces_of(block) -> tuple[Faces, np.ndarray]:
    faces = stack_faces([block.vertices], [block.faces])
    vectors = area_vectors(faces.point[faces.loop], faces.start)
    return faces, vectors / np.linalg.norm(vectors, axis=1)[:, None]


def test_twins_are_each_others_twin_and_run_backwards() -> None:
    faces, _ = faces_of(box((1, 1, 1)))
    edges = half_edges(faces)
    assert (edges.twin >= 0).all()
    assert np.array_equal(edges.twin[edges.twin], np.arange(24))
    assert np.array_equal(faces.loop[edges.twin], faces.loop[edges.after])


def test_surface_turns_outwards_at_convex_and_inwards_at_reentrant_edges() -> None:
    faces, normal = faces_of(box((1, 1, 1)))
    np.testing.assert_allclose(turn_angles(faces, half_edges(faces), normal), 0.5 * np.pi)
    notched = prism([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], (0.0, 1.0))
    faces, normal = faces_of(notched)
    turn = turn_angles(faces, half_edges(faces), normal)
    assert int((turn < 0.0).sum()) == 2
    assert turn.min() == pytest.approx(-0.5 * np.pi)


def test_outline_of_a_side_and_its_hole() -> None:
    faces, _ = faces_of(box((1, 1, 1)))
    edges = half_edges(faces)
    group = np.array([0, 1, 0, 0, 0, 0])
    loop, start, owner = outlines(faces, edges, group)
    assert sorted(owner.tolist()) == [0, 1]
    assert np.diff(start).tolist() == [4, 4]
    assert set(loop[:4].tolist()) == set(loop[4:].tolist())


def test_faces_joined_across_edges_share_a_group() -> None:
    faces, _ = faces_of(box((1, 1, 1)))
    edges = half_edges(faces)
    level = (edges.face < 2) & (edges.face[edges.twin] < 2)
    assert len(set(joined_faces(edges, level, 6).tolist())) == 6
    every = np.ones(24, dtype=bool)
    assert set(joined_faces(edges, every, 6).tolist()) == {0}
