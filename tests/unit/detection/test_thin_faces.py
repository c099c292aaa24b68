"""Faces without an area: refused when folded, harmless when thin."""

import numpy as np
import pytest

from drystone import Assembly, Block, InputError, find_contacts
from drystone.models import box, prism


def pair(upper):
    return Assembly((box((1, 1, 1), name="lower"), upper), np.array([True, False]))


def test_a_face_folded_onto_itself_is_named():
    straight = box((1, 1, 1), (0, 0, 1), name="twisted")
    points = straight.vertices.copy()
    points[4:] = points[[6, 7, 4, 5]]
    with pytest.raises(InputError, match=r"block 'twisted': face \d is folded onto itself"):
        find_contacts(pair(Block(points, straight.faces, "twisted")))


def test_a_triangle_without_width_changes_nothing():
    plain = box((1, 1, 1), (0, 0, 1), name="upper")
    points = np.vstack([plain.vertices, [[0.5, 0.0, 2.0]]])
    faces = [f for f in plain.faces if f != (0, 1, 5, 4)]
    thin = Block(points, (*faces, (0, 1, 5, 8, 4), (5, 4, 8)[::-1]), "upper")
    expected = find_contacts(pair(plain)).contacts
    found = find_contacts(pair(thin)).contacts
    assert found.count == expected.count == 1
    assert found.area == pytest.approx(expected.area)


def test_a_large_smooth_surface_with_an_edge_without_length_gives_no_warning():
    turn = np.linspace(0.0, 2.0 * np.pi, 20, endpoint=False)
    drum = prism(1e3 * np.stack([np.cos(turn), np.sin(turn)], axis=1), (0.0, 100.0))
    points = drum.vertices.copy()
    points[20] = points[0]
    found = find_contacts(Assembly((Block(points, drum.faces),)))
    assert found.contacts.count == 0
