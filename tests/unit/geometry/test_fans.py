"""Warped faces become the fan that volumes follow, and nothing else changes."""

import numpy as np
import pytest

from drystone import Assembly, Block
from drystone.geometry.polyhedron import mass_properties
from drystone.geometry.triangulate import fan_warped, point_owners, triangulate, warp_and_view
from drystone.models import box


def cushion(height: float, offset: float = 0.0) -> Block:
    """A cube whose upper face is a saddle, ``height`` above and below its middle."""
    cube = box((1.0, 1.0, 1.0), (offset, 0.0, 0.0), name=f"b{offset}")
    raised = cube.vertices.copy()
    top = raised[:, 2] > raised[:, 2].mean()
    corner = raised[:, 0] - offset > 0.0
    diagonal = corner == (raised[:, 1] > 0.0)
    raised[top, 2] += np.where(diagonal, height, -height)[top]
    return Block(raised, cube.faces, cube.name)


def volumes(faces):
    """By the triangles themselves."""
    triangle, polygon = triangulate(faces.point[faces.loop], faces.start)
    a, b, c = (faces.point[faces.loop[triangle[:, i]]] for i in range(3))
    six = np.einsum("ti,ti->t", a, np.cross(b, c))
    return np.bincount(faces.owner[polygon], six) / 6.0


def test_triangles_enclose_the_volume_of_the_block():
    assembly = Assembly(
        (cushion(0.2), box((1.0, 1.0, 1.0), (5.0, 0, 0), name="plain"), cushion(-0.1, 9.0))
    )
    fanned = fan_warped(assembly.faces, 1e-9)
    assert volumes(fanned) == pytest.approx(assembly.volume, rel=1e-14)
    assert volumes(assembly.faces) != pytest.approx(assembly.volume, rel=1e-3)
    assert mass_properties(fanned, 3)[1] == pytest.approx(assembly.centroid, abs=1e-14)


def test_only_warped_faces_get_a_middle_and_bodies_stay_together():
    assembly = Assembly(
        (cushion(0.2), box((1.0, 1.0, 1.0), (5.0, 0, 0), name="plain"), cushion(-0.1, 9.0))
    )
    fanned = fan_warped(assembly.faces, 1e-9)
    assert np.bincount(fanned.owner).tolist() == [9, 6, 9]
    assert np.bincount(point_owners(fanned)).tolist() == [9, 8, 9]
    assert (np.diff(point_owners(fanned)) >= 0).all()


def test_planar_bodies_are_left_as_they_are():
    faces = Assembly((box((1.0, 2.0, 3.0)),)).faces
    assert fan_warped(faces, 1e-9) is faces


def test_a_face_is_warped_from_the_tolerance_on():
    faces = Assembly((cushion(1e-7),)).faces
    assert fan_warped(faces, 1e-6) is faces
    assert fan_warped(faces, 1e-8).count == 9


def test_the_mean_of_a_dart_does_not_see_its_edges():
    dart = np.array([[2.0, 0, 0], [0.2, 0.2, 0.1], [0, 2, 0], [0, 0, 0]])
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    height, seen = warp_and_view(np.concatenate([dart, square]), np.array([0, 4, 8]))
    assert seen.tolist() == [False, True]
    assert height[0] > 0.01
    assert height[1] == 0.0
