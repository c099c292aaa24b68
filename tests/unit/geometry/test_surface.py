import numpy as np
import pytest

from drystone import Block, InputError
from drystone.geometry.polyhedron import (
    BOX,
    Fan,
    body_mass_properties,
    mass_properties,
    stack_faces,
)
from drystone.geometry.surface import SHARED_FACES, closed_surface
from drystone.models import box, concave, cube_curve, prism

CUBE = box((1.0, 1.0, 1.0)).vertices
RING = [(np.cos(a), np.sin(a)) for a in np.linspace(0.0, 2.0 * np.pi, 200, endpoint=False)]


def test_blocks_of_one_kind_share_their_faces():
    one, other = box((1.0, 2.0, 3.0)), box((2.0, 2.0, 2.0), (5.0, 0.0, 0.0))
    assert one.faces is other.faces


def test_long_face_lists_are_not_kept():
    drum = prism(RING, (0.0, 1.0))
    assert len(drum.faces) > SHARED_FACES
    assert closed_surface(drum.faces, 400) is not closed_surface(drum.faces, 400)
    assert closed_surface(BOX, 8) is closed_surface(BOX, 8)


def test_faces_of_arrays_lists_and_tuples_are_one():
    assert closed_surface(np.array(BOX), 8) is closed_surface(BOX, 8)
    assert closed_surface([list(f) for f in BOX], 8) is closed_surface(BOX, 8)


@pytest.mark.parametrize("extra", [0, 2])
def test_the_same_faces_are_checked_with_their_own_vertices(extra):
    vertices = np.concatenate([CUBE, np.full((extra, 3), 9.0)])
    assert Block(vertices, BOX).repairs == ((f"{extra} unused vertices dropped",) * (extra > 0))
    with pytest.raises(InputError, match="uses vertex 7"):
        Block(CUBE[:7], BOX)


def test_a_bad_face_list_is_refused_every_time_under_the_name_of_its_block():
    for name in ("first", "second"):
        with pytest.raises(InputError, match=f"block '{name}'.*4 edges have one face only"):
            Block(CUBE, BOX[:-1], name)


@pytest.mark.parametrize(
    ("faces", "words"),
    [
        ((*BOX, (0, 1, 2)), "non-manifold: more than two faces meet at edges"),
        (BOX[:3], "has 3 faces"),
        ((*BOX[:-1], (3, 0, 4)), "open mesh"),
        ((*BOX[:-1], (3, 0, 0, 7)), "none twice"),
        ((*BOX[:-1], (3, 0, -4, 7)), "uses vertex -4"),
        ((*BOX[:-1], ("a", "b", "c")), "face 5 is not a list of integers"),
        ((*BOX[:-1], 5), "face 5 is not a list of integers"),
    ],
)
def test_face_lists_that_bound_nothing_are_refused(faces, words):
    with pytest.raises(InputError, match=words):
        Block(CUBE, faces)


def test_edges_are_named_as_the_caller_numbers_them():
    apart = np.concatenate([np.full((3, 3), 9.0), CUBE])
    faces = [[i + 3 for i in face] for face in BOX[:-1]]
    with pytest.raises(InputError, match="3-7"):
        Block(apart, faces)


def test_bodies_that_touch_in_a_vertex_are_refused():
    other = CUBE + 1.0
    faces = list(BOX) + [[i + 8 if i else 6 for i in face] for face in BOX]
    with pytest.raises(InputError, match="touches itself at vertex 6"):
        Block(np.concatenate([CUBE, other]), faces)


def test_an_inside_out_body_is_turned_and_says_so():
    inside_out = [face[::-1] for face in BOX]
    for _ in range(2):
        block = Block(CUBE, inside_out)
        assert block.volume == pytest.approx(1.0)
        assert block.repairs == ("all faces pointed inwards, and are turned",)
        assert block.faces == BOX
    assert box((1.0, 1.0, 1.0)).repairs == ()


def test_a_mirror_image_keeps_its_faces_outwards():
    mirrored = box((1.0, 2.0, 3.0)).transformed(np.diag([-1.0, 1.0, 1.0]))
    assert mirrored.volume == pytest.approx(6.0)
    assert mirrored.repairs == ()


def test_one_body_weighs_what_it_weighs_among_others():
    blocks = [*concave("long").blocks, *cube_curve("tall").blocks, prism(RING, (0.0, 2.0))]
    stacked = stack_faces([b.vertices for b in blocks], [b.faces for b in blocks])
    volumes, centroids = mass_properties(stacked, len(blocks))
    for block, volume, centroid in zip(blocks, volumes, centroids, strict=True):
        alone, middle = body_mass_properties(block.vertices, Fan.of(block.faces))
        assert alone == pytest.approx(volume, rel=1e-13)
        np.testing.assert_allclose(middle, centroid, rtol=0.0, atol=1e-13 * block.size)


def test_far_from_the_origin_no_digit_is_lost():
    near = prism([(0, 0), (2, 0), (0, 1)], (0.0, 0.5))
    far = near.transformed(translation=(2.0**20, -(2.0**20), 2.0**20))
    assert far.volume == near.volume
