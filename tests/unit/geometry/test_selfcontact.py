import numpy as np
import pytest

from drystone import Assembly, Block, InputError, Model
from drystone.base.arrays import Floats
from drystone.geometry.polyhedron import Loop
from drystone.geometry.selfcontact import convex_bodies, self_contacts
from drystone.models import arch, box, concave, cube_curve, dome, vault

Body = tuple[Floats, list[Loop]]

C_SHAPE = [(0, 0), (4, 0), (4, 1), (1, 1), (1, 2), (4, 2), (4, 3), (0, 3)]
C_CAPS = [(0, 1, 2, 3), (0, 3, 4, 7), (4, 5, 6, 7)]


def c_shape(moved: dict[int, tuple[float, float]]) -> Body:
    """A C with some corners of its outline moved; its caps are made of convex pieces."""
    outline = [moved.get(i, corner) for i, corner in enumerate(C_SHAPE)]
    vertices = np.array([[x, y, z] for z in (0.0, 1.0) for x, y in outline], dtype=np.float64)
    n = len(outline)
    faces: list[Loop] = [cap[::-1] for cap in C_CAPS]
    faces += [tuple(i + n for i in cap) for cap in C_CAPS]
    faces += [(i, (i + 1) % n, (i + 1) % n + n, i + n) for i in range(n)]
    return vertices, faces


def together(*bodies: Body) -> Body:
    """Several shells as one body."""
    vertices, faces, offset = [], [], 0
    for points, loops in bodies:
        vertices.append(points)
        faces += [tuple(i + offset for i in loop) for loop in loops]
        offset += len(points)
    return np.concatenate(vertices), faces


def cube(x: float, y: float, z: float, edge: float = 1.0) -> Body:
    block = box((edge, edge, edge), (x, y, z))
    return block.vertices, list(block.faces)


def wedge_on_edge(up: bool) -> Body:
    """A tetrahedron with an edge through (0, 0, 1), along x from below or along y from above."""
    points = np.array([[-1.0, 0, 1], [1, 0, 1], [0, 1, 0], [0, -1, 0]])
    if up:
        points = np.array([[0, -1.0, 1], [0, 1, 1], [-1, 0, 2], [1, 0, 2]])
    return points, [(0, 1, 2), (1, 0, 3), (0, 2, 3), (2, 1, 3)]


@pytest.mark.parametrize(
    ("body", "what"),
    [
        (c_shape({5: (4, 1)}), "touches itself: vertex"),  # the arms meet at their tips
        (c_shape({5: (2, 1), 4: (1, 1.5)}), "touches itself: vertex 5 lies on face"),
        (c_shape({5: (2, 0.5), 4: (1, 1.5)}), "touches itself: vertex 5 lies on face 0"),
        (c_shape({5: (4, 0.9)}), "touches itself: vertex 2"),
        (together(cube(0, 0, 0), cube(0.5, 0.5, 0.5)), "goes through face"),
        (together(cube(0, 0, 0), cube(0.25, 0.25, 1.0, 0.5)), "vertex 8 lies on face"),
        (together(cube(0, 0, 0), cube(1, 1, 1)), "touches itself: vertex"),
        (together(wedge_on_edge(False), wedge_on_edge(True)), "edges 0-1 and 4-5 cross"),
    ],
)
def test_surfaces_that_meet_themselves_are_found(body: Body, what: str) -> None:
    for scale, shift in ((1.0, 0.0), (1e-3, 0.0), (1e3, 1e4)):
        ((at_fault, found),) = self_contacts([body[0] * scale + shift * 0.125], [body[1]])
        assert at_fault == 0
        assert what in found


@pytest.mark.parametrize(
    "body",
    [
        c_shape({}),
        c_shape({5: (4, 1 + 1e-6), 4: (1, 1 + 1e-6)}),
        together(cube(0, 0, 0), cube(1.0 + 1e-6, 0, 0)),
        together(cube(0, 0, 0), cube(0.25, 0.25, 0.25, 0.5)),
    ],
)
def test_surfaces_that_only_come_near_themselves_are_not(body: Body) -> None:
    assert self_contacts([body[0]], [body[1]]) == []


def test_the_body_that_is_at_fault_is_named() -> None:
    bodies = [cube(0, 0, 0), c_shape({}), c_shape({5: (4, 0.9)}), c_shape({})]
    found = self_contacts([points for points, _ in bodies], [loops for _, loops in bodies])
    assert [body for body, _ in found] == [2]


@pytest.mark.parametrize(
    "assembly", [arch(), concave("short"), concave("long"), cube_curve("tall"), dome(), vault()]
)
def test_model_families_do_not_touch_themselves(assembly) -> None:  # type: ignore[no-untyped-def]
    blocks = assembly.blocks
    assert self_contacts([b.vertices for b in blocks], [b.faces for b in blocks]) == []


def test_warped_faces_are_no_fault() -> None:
    rng = np.random.default_rng(0)
    points, loops = c_shape({})
    bent = [points + rng.uniform(-0.02, 0.02, points.shape) for _ in range(50)]
    assert self_contacts(bent, [loops] * 50) == []


def test_convex_and_concave_are_told_apart() -> None:
    bodies = [cube(0, 0, 0), c_shape({}), cube(1e4, 0, 0), c_shape({5: (4, 0.9)})]
    convex = convex_bodies([points for points, _ in bodies], [loops for _, loops in bodies])
    assert convex.tolist() == [True, False, True, False]
    assert convex_bodies([], []).tolist() == []


def test_a_tall_finely_meshed_body_is_searched_to_its_end() -> None:
    """Its faces lie above each other: in plan view all of them overlap."""
    along = 1500
    outline = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
    heights = np.repeat(np.linspace(0.0, 9.0, along + 1), 4)
    points = np.column_stack([np.tile(outline, (along + 1, 1)), heights])
    quads = [
        (4 * k + i, 4 * k + (i + 1) % 4, 4 * k + (i + 1) % 4 + 4, 4 * k + i + 4)
        for k in range(along)
        for i in range(4)
    ]
    faces: list[Loop] = [(3, 2, 1, 0), *quads, tuple(range(4 * along, 4 * along + 4))]
    points[4 * (along - 1), 0] = -1.5  # through the wall on the other side
    (found,) = self_contacts([points], [faces])
    assert "itself" in found[1]


def test_the_same_cube_twice_in_one_block_touches_itself() -> None:
    one = box((1.0, 1.0, 1.0))
    faces = [*one.faces, *(tuple(i + 8 for i in loop) for loop in one.faces)]
    above = one.vertices + np.array([0.0, 0.0, 1.0])
    twice = Block(np.concatenate([above, above]), faces, name="twice")
    with pytest.raises(InputError, match=r"block 'twice'.*touches itself"):
        Model.of(Assembly([one, twice], np.array([True, False])))
