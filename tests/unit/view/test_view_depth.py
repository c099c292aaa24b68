"""The order of drawing, held against ray casting at many points of the paper."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
import shapely

from drystone.assembly import Assembly, Block
from drystone.contacts import Contacts
from drystone.geometry.frames import frames_from_normals, rotation_about, unit
from drystone.models import box
from drystone.view.ink import ordered_patches, topological
from tests.unit.view.pictures import notched

VIEWS = [
    unit(np.array(v, dtype=float))
    for v in [(1, -2, 0.8), (-1, -2, 0.8), (1, 2, 3), (-3, 1, -0.7), (0.1, -1, 0.02), (1, 1, 1)]
]


def paper_of(toward: np.ndarray) -> np.ndarray:
    right = np.cross([0.0, 0.0, 1.0], toward)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(toward, right)])


def wrong_points(assembly: Assembly, contacts: Contacts, toward: np.ndarray, seed: int = 0) -> int:
    """Number of points of the paper where something other than the nearest face is drawn last."""
    paper = paper_of(toward)
    patches = ordered_patches(assembly, toward, paper)
    corners = assembly.faces.point[assembly.faces.loop]
    flat, depth = corners @ paper.T, corners @ toward
    loops = np.split(patches.corner, patches.start[1:-1])
    shapes = np.array([shapely.Polygon(flat[loop]) for loop in loops])
    low, high = flat.min(axis=0), flat.max(axis=0)
    points = np.random.default_rng(seed).uniform(low, high, (400, 2))
    wrong = 0
    for point in points:
        covering = np.flatnonzero(shapely.contains_xy(shapes, *point))
        if len(covering) == 0:
            continue
        reach = [plane_depth(flat[loops[i]], depth[loops[i]], point) for i in covering]
        wrong += reach[-1] < max(reach) - 1e-9 * np.ptp(depth)
    return wrong


def plane_depth(flat: np.ndarray, depth: np.ndarray, point: np.ndarray) -> float:
    matrix = np.column_stack([flat, np.ones(len(flat))])
    return float(np.append(point, 1.0) @ np.linalg.lstsq(matrix, depth, rcond=None)[0])


def guillotine(count: int, seed: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """A box cut again and again: boxes (low, high) that touch and fill it."""
    rng = np.random.default_rng(seed)
    boxes = [(np.zeros(3), np.array([4.0, 2.0, 3.0]))]
    while len(boxes) < count:
        low, high = boxes.pop(rng.integers(len(boxes)))
        axis = rng.integers(3)
        cut = low[axis] + (high[axis] - low[axis]) * rng.uniform(0.3, 0.7)
        middle_high, middle_low = high.copy(), low.copy()
        middle_high[axis] = middle_low[axis] = cut
        boxes += [(low, middle_high), (middle_low, high)]
    return boxes


def box_assembly(boxes: list[tuple[np.ndarray, np.ndarray]]) -> tuple[Assembly, Contacts]:
    """Boxes and their contacts, found by comparing all pairs."""
    assembly = Assembly(tuple(box(h - lo, lo, f"b{i}") for i, (lo, h) in enumerate(boxes)))
    pairs, normals, points, areas = [], [], [], []
    for (i, (low_i, high_i)), (j, (low_j, high_j)) in itertools.permutations(enumerate(boxes), 2):
        for axis in range(3):
            u, v = (axis + 1) % 3, (axis + 2) % 3
            low, high = np.maximum(low_i, low_j), np.minimum(high_i, high_j)
            if high_i[axis] == low_j[axis] and (high - low)[[u, v]].min() > 0.0:
                pairs.append((i, j))
                normals.append(np.eye(3)[axis])
                areas.append((high - low)[u] * (high - low)[v])
                for one, two in ((low, low), (high, low), (high, high), (low, high)):
                    corner = np.empty(3)
                    corner[[axis, u, v]] = high_i[axis], one[u], two[v]
                    points.append(corner)
    m = len(pairs)
    a, b = np.array(pairs).T
    frame = frames_from_normals(np.array(normals))
    friction, interface = np.full(m, 0.6), np.repeat(np.arange(m), 4)
    point, area = np.array(points), np.array(areas)
    return assembly, Contacts(a, b, frame, area, friction, point, interface)


def turned(assembly: Assembly, contacts: Contacts, shift: float) -> tuple[Assembly, Contacts]:
    rotation = rotation_about(np.array([1.0, 0.4, -0.3]), 33.0)
    offset = np.full(3, shift)
    moved = Contacts(
        contacts.block_a, contacts.block_b, contacts.frame @ rotation.T, contacts.area,
        contacts.friction, contacts.point @ rotation.T + offset, contacts.interface,
    )  # fmt: skip
    return assembly.transformed(rotation, offset), moved


@pytest.mark.parametrize("seed", range(3))
def test_touching_boxes_hide_each_other_as_rays_say(seed: int) -> None:
    assembly, contacts = box_assembly(guillotine(30, seed))
    for toward in VIEWS:
        assert wrong_points(assembly, contacts, toward) == 0


def test_turned_and_distant_boxes_too() -> None:
    assembly, contacts = turned(*box_assembly(guillotine(25, 7)), 1e4)
    for toward in VIEWS:
        assert wrong_points(assembly, contacts, toward) == 0


def test_boxes_apart_are_ordered_without_contacts() -> None:
    rng = np.random.default_rng(3)
    boxes = [
        (low, low + rng.uniform(0.3, 0.95, 3))
        for low in (np.array(c, dtype=float) for c in itertools.product(range(3), repeat=3))
    ]
    assembly = Assembly(tuple(box(h - lo, lo, f"b{i}") for i, (lo, h) in enumerate(boxes)))
    for toward in VIEWS:
        assert wrong_points(assembly, Contacts.empty(), toward) == 0


def test_centroids_alone_would_be_wrong() -> None:
    # The centroid of the long slab is nearer to the eye than that of the cube standing on its end.
    assembly, contacts = box_assembly(
        [
            (np.array([0.0, -9.0, 0.0]), np.array([1.0, 1.0, 0.2])),
            (np.array([0.0, 0.0, 0.2]), np.array([1.0, 1.0, 1.2])),
        ]
    )
    toward = unit(np.array([0.3, -1.0, 0.3]))
    assert assembly.centroid[0] @ toward > assembly.centroid[1] @ toward
    assert wrong_points(assembly, contacts, toward) == 0


def test_three_sticks_in_a_ring_are_drawn_triangle_by_triangle() -> None:
    stick = box((4.0, 0.4, 0.2), (-0.6, -0.2, 0.0), "stick").transformed(
        rotation_about(np.array([0.0, 1.0, 0.0]), 6.0)
    )
    ring = Assembly(
        tuple(
            stick.transformed(
                rotation_about(np.array([0.0, 0.0, 1.0]), 120.0 * i),
                1.2 * np.array([np.cos(2.1 * i - 1.6), np.sin(2.1 * i - 1.6), 0.0]),
            ).renamed(f"stick-{i}")
            for i in range(3)
        )
    )
    toward = unit(np.array([0.02, -0.03, 1.0]))
    assert wrong_points(ring, Contacts.empty(), toward) == 0


@pytest.mark.parametrize("toward", [*VIEWS, *(unit(np.array([x, -1.0, 1.0])) for x in (-2, 2))])
def test_a_box_in_the_notch_of_a_concave_block_is_drawn_right(toward: np.ndarray) -> None:
    assembly = notched()
    bed = [(1, 0, 1), (2, 0, 1), (2, 1, 1), (1, 1, 1)]
    cheek = [(1, 0, 1), (1, 1, 1), (1, 1, 2), (1, 0, 2)]
    contacts = Contacts(
        np.array([0, 0]), np.array([1, 1]),
        frames_from_normals(np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])), np.ones(2), np.ones(2),
        np.array(bed + cheek, dtype=float), np.repeat([0, 1], 4),
    )  # fmt: skip
    assert wrong_points(assembly, contacts, toward) == 0
    assert wrong_points(assembly, Contacts.empty(), toward) == 0


def test_a_concave_block_hides_parts_of_itself() -> None:
    one = Assembly((notched().blocks[0],))
    for toward in VIEWS:
        assert wrong_points(one, Contacts.empty(), toward) == 0


def test_faces_seen_from_behind_are_left_out() -> None:
    one = Assembly((box((1, 1, 1)),))
    patches = ordered_patches(one, VIEWS[0], paper_of(VIEWS[0]))
    assert len(patches.face) == 3
    assert patches.outlined.all()


def test_cuts_inside_a_flat_face_are_no_edges() -> None:
    cube = box((1, 1, 1))
    triangles = [t for f in cube.faces for t in ((f[0], f[1], f[2]), (f[0], f[2], f[3]))]
    one = Assembly((Block(cube.vertices, tuple(triangles), "cut"),))
    patches = ordered_patches(one, VIEWS[0], paper_of(VIEWS[0]))
    assert len(patches.face) == 6
    assert patches.outlined.sum() == 12  # four sides of each of three squares


def test_topological_order_respects_pairs_and_prefers_far() -> None:
    depth = np.array([5.0, 4.0, 3.0, 2.0])
    order = topological(4, np.array([0, 1]), np.array([1, 2]), depth).tolist()
    assert order == [3, 0, 1, 2]


def test_a_ring_of_pairs_starts_with_the_farthest() -> None:
    order = topological(3, np.array([0, 1, 2]), np.array([1, 2, 0]), np.array([2.0, 1.0, 3.0]))
    assert order.tolist() == [1, 2, 0]
