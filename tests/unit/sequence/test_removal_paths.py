"""Finite paths out of a place: straight, turning, and none."""

import numpy as np
import pytest

from drystone import Assembly, InputError, Model, plan
from drystone.geometry.convex_pieces import convex_pieces, solid_of
from drystone.models import bayonet, box, burr, dovetail, hooked_bar, stool, tower
from drystone.sequence import NoPath, PathOptions, RemovalPath, find_path
from drystone.sequence.freedom import free_twists, twist_rows
from drystone.sequence.sweeps import moved_along

STRAIGHT = PathOptions(turning=False)


def meets(model: Model, path: RemovalPath) -> float:
    """Largest share of the block's volume that it has in common with what stands, in any pose."""
    assembly = model.assembly
    body = assembly.blocks[path.block]
    others = [b for i, b in enumerate(assembly.blocks) if i != path.block]
    shared = 0.0
    for first, second in zip(path.poses[:-1], path.poses[1:], strict=True):
        for share in np.linspace(0.0, 1.0, 6):
            turn = (1.0 - share) * first.turn + share * second.turn
            left, _, right = np.linalg.svd(turn)
            shift = (1.0 - share) * first.shift + share * second.shift
            moved = solid_of(body.vertices @ (left @ right).T + shift, body.faces)
            for other in others:
                common = moved ^ solid_of(other.vertices, other.faces)
                shared = max(shared, common.volume() / body.volume)
    return shared


def test_a_block_on_a_tower_is_lifted_straight_up():
    path = find_path(Model.of(tower(3)), "block-2")
    assert isinstance(path, RemovalPath)
    assert not path.turning
    np.testing.assert_allclose(path.poses[-1].shift[:2], 0.0, atol=1e-9)
    assert path.poses[-1].shift[2] > 1.0
    assert path.clearance[0] == 0.0
    assert path.clearance[-1] > 0.5


def test_a_block_inside_a_tower_slides_out_sideways():
    path = find_path(Model.of(tower(3)), "block-1")
    assert isinstance(path, RemovalPath)
    assert abs(path.poses[-1].shift[2]) < 1e-9


def test_what_is_not_placed_is_not_in_the_way():
    path = find_path(Model.of(tower(3)), "block-1", placed=[])
    assert isinstance(path, RemovalPath)
    assert path.poses[-1].shift[2] > 1.0


def test_a_dovetail_slides_along_its_groove():
    path = find_path(Model.of(dovetail()), "tenon")
    assert isinstance(path, RemovalPath)
    assert not path.turning
    np.testing.assert_allclose(path.poses[-1].shift[[0, 2]], 0.0, atol=1e-6)


def test_a_hooked_bar_is_locked_for_straight_ways_and_turned_out():
    model = Model.of(hooked_bar())
    straight = find_path(model, "bar", options=STRAIGHT)
    assert isinstance(straight, NoPath)
    assert {face.name for face in straight.faces} == {"bed", "near", "far"}
    path = find_path(model, "bar")
    assert isinstance(path, RemovalPath)
    assert path.turning
    assert meets(model, path) < 0.02


def test_a_hooked_bar_without_cheeks_slides_out_sideways():
    path = find_path(Model.of(hooked_bar(cheeks=False)), "bar")
    assert isinstance(path, RemovalPath)
    assert not path.turning


@pytest.mark.parametrize("locked", [45.0, 90.0])
def test_a_bayonet_is_turned_to_its_slot_and_lifted(locked):
    model = Model.of(bayonet(locked))
    assert isinstance(find_path(model, "peg", options=STRAIGHT), NoPath)
    path = find_path(model, "peg")
    assert isinstance(path, RemovalPath)
    assert path.turning
    assert meets(model, path) < 0.01
    out = path.poses[-1].of(model.assembly.blocks[3].centroid[None])[0]
    assert out[2] > 3.0


def test_a_bayonet_at_its_slot_is_lifted_straight():
    path = find_path(Model.of(bayonet(0.0)), "peg")
    assert isinstance(path, RemovalPath)
    assert not path.turning


def test_a_straight_way_that_something_stands_in_is_not_taken():
    # the joints of the lower block leave it free to rise, the roof above does not
    floor = box((4.0, 4.0, 0.2), (-1.5, -1.5, -0.2), "floor")
    walls = [box((0.2, 1.0, 1.0), (x, 0.0, 0.0), f"wall-{x:g}") for x in (-0.2, 1.0)]
    ends = [box((1.4, 0.2, 1.0), (-0.2, y, 0.0), f"end-{y:g}") for y in (-0.2, 1.0)]
    roof = box((4.0, 4.0, 0.2), (-1.5, -1.5, 1.5), "roof")
    block = box((1.0, 1.0, 1.0), name="block")
    blocks = (floor, *walls, *ends, roof, block)
    model = Model.of(Assembly(blocks, np.arange(len(blocks)) < len(blocks) - 1))
    found = find_path(model, "block")
    assert isinstance(found, NoPath)
    assert not found.proved
    assert "'roof'" in found.reason
    open_above = find_path(model.without(["roof"]), "block")
    assert isinstance(open_above, RemovalPath)


def test_what_locks_a_piece_of_the_burr_is_named_by_faces_that_look_at_it():
    model = Model.of(burr())
    found = find_path(model, "z-low")
    assert isinstance(found, NoPath)
    assert found.proved
    assert {face.name for face in found.faces} <= set(model.assembly.names) - {"z-low"}
    for face in found.faces:
        body = model.assembly.blocks[face.block]
        loop = body.vertices[list(body.faces[face.face])]
        normal = np.cross(loop[1] - loop[0], loop[2] - loop[1])
        np.testing.assert_allclose(normal / np.linalg.norm(normal), face.towards, atol=1e-6)


def test_the_burr_comes_apart_in_the_order_in_which_its_pieces_are_free():
    model = Model.of(burr())
    left, order = list(model.assembly.names), []
    while len(left) > 1:
        paths = {n: find_path(model, n, placed=[m for m in left if m != n]) for n in left}
        free = [n for n in left if isinstance(paths[n], RemovalPath)]
        assert free, f"nothing can be taken out of {left}"
        order.append(free[0])
        left.remove(free[0])
    assert order[0] == "key"


def test_a_plan_takes_out_what_must_be_turned_and_says_why_it_cannot_where_it_cannot():
    found = plan(Model.of(bayonet()))
    assert found.counts["free"] == 1
    assert found.counts["impossible"] == 0
    closed = [
        box((1.0, 1.0, 1.0), np.array(axis) * side, f"{name}{side:+d}")
        for name, axis in zip("xyz", np.eye(3).tolist(), strict=True)
        for side in (-1, 1)
    ]
    blocks = (*closed, box((1.0, 1.0, 1.0), name="inside"))
    model = Model.of(Assembly(blocks, np.arange(7) < 6))
    assert plan(model).counts["impossible"] == 1
    assert "face" in plan(model).impossible[6]


def test_a_twist_is_free_where_no_corner_closes():
    rng = np.random.default_rng(1)
    for _ in range(20):
        corner, normal = rng.normal(size=(6, 3)), rng.normal(size=(6, 3))
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        rows = twist_rows(corner, normal, np.zeros(3), 1.0)
        found = free_twists(rows)
        assert not found.blocked  # six rows cannot lock six freedoms
        for twist in found.twist:
            moved = moved_along(1e-6 * twist, np.zeros(3), 1.0).of(corner) - corner
            assert ((moved * normal).sum(axis=1) > -2e-9).all()


def test_what_blocks_every_twist_blocks_by_itself():
    corners = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    rows = np.concatenate(
        [
            twist_rows(corners, np.tile(n, (8, 1)), np.full(3, 0.5), 1.0)
            for n in (*np.eye(3), *-np.eye(3))
        ]
    )
    found = free_twists(rows)
    assert found.blocked
    assert free_twists(rows[found.blocking]).blocked


def test_convex_pieces_fill_a_concave_block_without_overlap():
    block = stool().blocks[1]
    pieces = convex_pieces(block.vertices, block.faces)
    solids = [solid_of(p.point, _hull_faces(p.point)) for p in pieces]
    assert sum(s.volume() for s in solids) == pytest.approx(block.volume, rel=1e-5)
    shared = sum((a ^ b).volume() for i, a in enumerate(solids) for b in solids[:i])
    assert shared < 1e-9


def _hull_faces(point):
    from scipy.spatial import ConvexHull

    hull = ConvexHull(point)
    faces = []
    for simplex, plane in zip(hull.simplices, hull.equations, strict=True):
        a, b, c = point[simplex]
        outward = np.cross(b - a, c - a) @ plane[:3] > 0.0
        faces.append(tuple(simplex.tolist()) if outward else tuple(simplex[::-1].tolist()))
    return faces


def test_senseless_options_are_refused():
    with pytest.raises(InputError):
        PathOptions(play=0.0)
    with pytest.raises(InputError):
        PathOptions(effort=0)
    with pytest.raises(InputError):
        PathOptions(up=(0.0, 0.0, 0.0))
