"""Face contacts: which are found, where, and how large."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import Voronoi
from shapely.geometry import Polygon

from drystone import Assembly, Block, Contacts, InputError, find_contacts
from drystone.detection import DetectionOptions, Reason
from drystone.geometry.frames import area_vectors, rotation_about
from drystone.models import (
    box,
    concave,
    cube_curve,
    curve_three_blocks,
    prism,
    random_pack,
    tower,
    wall,
    welded,
)

SLAB = box((4.0, 4.0, 0.5), (-2.0, -2.0, -0.5), "slab")


def assert_well_formed(contacts: Contacts) -> None:
    """Simple polygons, counter-clockwise about n, true corners, in the plane, with their area."""
    frame = contacts.frame
    np.testing.assert_allclose(
        frame @ frame.transpose(0, 2, 1), np.tile(np.eye(3), (len(frame), 1, 1)), atol=1e-12
    )
    assert (np.linalg.det(frame) > 0.0).all()
    for i in range(contacts.count):
        local = (contacts.polygon(i) - contacts.polygon(i)[0]) @ frame[i].T
        size = np.abs(local).max()
        assert np.abs(local[:, 0]).max() <= 1e-9 * size
        if len(local) < 3:
            assert contacts.area[i] == 0.0
            continue
        shape = Polygon(local[:, 1:])
        assert shape.is_valid
        assert shape.exterior.is_ccw
        assert shape.area == pytest.approx(contacts.area[i], rel=1e-9)
        edge = np.roll(local, -1, axis=0) - local
        turn = np.cross(edge, np.roll(edge, -1, axis=0))[:, 0]
        assert (np.linalg.norm(edge, axis=1) > 1e-9 * size).all()
        assert (np.abs(turn) > 1e-12 * size**2).all()


def ring(name: str, height: float) -> Block:
    """A square ring on z = 0, 3 m outside, 1 m inside: its top and bottom have a hole."""
    cells = [(x, y) for x in range(3) for y in range(3) if (x, y) != (1, 1)]
    loops = []
    for x, y in cells:
        for z in (0.0, height):
            loops.append([(x, y, z), (x + 1, y, z), (x + 1, y + 1, z), (x, y + 1, z)])
        for dx, dy in ((-1, 0), (1, 0), (0, -1), (0, 1)):
            if (x + dx, y + dy) not in cells:
                cx, cy = x + 0.5 + 0.5 * dx, y + 0.5 + 0.5 * dy
                a = (cx - 0.5 * abs(dy), cy - 0.5 * abs(dx))
                b = (cx + 0.5 * abs(dy), cy + 0.5 * abs(dx))
                loops.append([(*a, 0.0), (*b, 0.0), (*b, height), (*a, height)])
    return welded([np.array(loop, dtype=float) for loop in loops], name)


def test_cubes_of_a_tower_share_whole_faces() -> None:
    contacts = find_contacts(tower(3), friction=0.4).contacts
    assert_well_formed(contacts)
    assert contacts.block_a.tolist() == [0, 1]
    assert contacts.block_b.tolist() == [1, 2]
    np.testing.assert_allclose(contacts.area, 1.0)
    np.testing.assert_allclose(contacts.frame[:, 0], [[0, 0, 1], [0, 0, 1]])
    np.testing.assert_allclose(contacts.friction, 0.4)


def test_normals_point_from_the_lower_to_the_higher_position() -> None:
    above = find_contacts(Assembly(tower(2).blocks[::-1])).contacts
    np.testing.assert_allclose(above.frame[0, 0], [0, 0, -1])
    assert_well_formed(above)


def test_partial_overlap_is_the_shared_rectangle() -> None:
    moved = box((1.0, 1.0, 1.0), (1.7, 1.5, 0.0), "cube")
    contacts = find_contacts(Assembly((SLAB, moved))).contacts
    assert contacts.area == pytest.approx([0.3 * 0.5])
    np.testing.assert_allclose(contacts.point.min(axis=0), [1.7, 1.5, 0.0], atol=1e-12)
    np.testing.assert_allclose(contacts.point.max(axis=0), [2.0, 2.0, 0.0], atol=1e-12)


@pytest.mark.parametrize(("courses", "length"), [(4, 5), (13, 31)])
def test_toothed_wall_has_the_joints_of_its_formula(courses: int, length: int) -> None:
    expected = courses * (length - 1) + (courses - 1) * (2 * length - 1)
    for assembly in (
        wall(courses, length, bond="toothed"),
        wall(courses, length, bond="toothed").transformed(
            rotation_about([1.0, 2.0, 3.0], 37.0), (1e4, -2e4, 5e3)
        ),
        wall(courses, length, bond="toothed").transformed(1e-3 * np.eye(3)),
    ):
        contacts = find_contacts(assembly).contacts
        assert contacts.count == expected
        assert (np.diff(contacts.start) == 4).all()


def test_benchmark_walls_have_their_published_numbers_of_joints() -> None:
    sizes = {(13, 31): (403, 1_122), (28, 71): (1_988, 5_767), (63, 159): (10_017, 29_608)}
    for (courses, length), (blocks, joints) in sizes.items():
        assert courses * length == blocks
        assert courses * (length - 1) + (courses - 1) * (2 * length - 1) == joints
    assert find_contacts(wall(28, 71, bond="toothed")).contacts.count == 5_767


def test_long_block_on_eighty_small_ones_touches_each() -> None:
    small = [box((0.1, 0.2, 0.1), (0.1 * i, 0.0, 0.0), f"small-{i}") for i in range(80)]
    long = box((8.0, 0.2, 0.3), (0.0, 0.0, 0.1), "long")
    contacts = find_contacts(Assembly((*small, long))).contacts
    assert int((contacts.block_b == 80).sum()) == 80
    assert contacts.count == 80 + 79


def test_blocks_ten_thousand_times_smaller_are_found() -> None:
    edge = 4e-4
    crumbs = [box((edge, edge, edge), (3 * edge * i, 0.0, 0.0), f"crumb-{i}") for i in range(5)]
    report = find_contacts(Assembly((SLAB, *crumbs))).report
    assert report.interfaces.area == pytest.approx([edge**2] * 5)
    assert report.isolated == ()


def test_concave_blocks_have_seven_joints() -> None:
    for length in ("short", "long"):
        model = concave(length)  # type: ignore[arg-type]
        contacts = find_contacts(model).contacts
        assert_well_formed(contacts)
        expected = [0.06, 0.09, 0.09, 0.1, 0.12, 0.12, 0.18]
        np.testing.assert_allclose(np.sort(contacts.area), expected, atol=1e-6)


def test_curved_models_have_their_published_areas() -> None:
    for model, area in ((cube_curve(), 0.4708), (curve_three_blocks(), 2.460)):
        contacts = find_contacts(model).contacts
        assert_well_formed(contacts)
        assert contacts.area.sum() == pytest.approx(area, abs=6e-5)


def test_strips_in_one_plane_are_one_interface() -> None:
    """The two middle strips of an S-curve: in one joint of curve-3-blocks, four of cube-curve."""
    assert find_contacts(curve_three_blocks(20)).contacts.count == 2 * 20 - 1
    assert find_contacts(cube_curve(strips=18)).contacts.count == 4 * 18 - 4


def test_overlap_with_a_hole_becomes_pieces_without_one() -> None:
    contacts = find_contacts(
        Assembly((SLAB, ring("ring", 1.0).transformed(translation=(-1.5, -1.5, 0.0))))
    ).contacts
    assert_well_formed(contacts)
    assert contacts.count == 2
    assert contacts.area.sum() == pytest.approx(8.0)


def test_ring_on_a_ring_is_found_with_its_hole() -> None:
    upper = ring("upper", 1.0).transformed(translation=(0.0, 0.0, 1.0))
    contacts = find_contacts(Assembly((ring("lower", 1.0), upper))).contacts
    assert_well_formed(contacts)
    assert contacts.area.sum() == pytest.approx(8.0)


def lying(section: list[tuple[float, float]], name: str) -> Block:
    """A plate 1 m thick on z = 0 whose plan is ``section``."""
    plate = prism(section, (0.0, 1.0), name)
    return plate.transformed(rotation_about([1.0, 0.0, 0.0], 90.0))


def test_one_pair_of_faces_can_touch_in_two_places() -> None:
    fork = lying(
        [(-1.5, 0), (1.5, 0), (1.5, 2), (0.5, 2), (0.5, 1), (-0.5, 1), (-0.5, 2), (-1.5, 2)], "fork"
    )
    bar = box((3.0, 0.5, 1.0), (-1.5, -1.9, 1.0), "bar")
    contacts = find_contacts(Assembly((fork, bar))).contacts
    assert contacts.area == pytest.approx([0.5, 0.5])
    assert_well_formed(contacts)


def test_concave_face_clips_as_it_is() -> None:
    notched = lying([(-1, -1), (1, -1), (1, 1), (0, 0), (-1, 1)], "notched")
    contacts = find_contacts(Assembly((SLAB, notched))).contacts
    assert contacts.count == 1
    assert contacts.corner_count == 5
    assert contacts.area[0] == pytest.approx(3.0)
    assert_well_formed(contacts)


def test_triangulated_blocks_have_the_joints_of_their_polygons() -> None:
    model = wall(4, 4)
    cut = []
    for block in model.blocks:
        triangles = [t for f in block.faces for t in ((f[0], f[1], f[2]), (f[0], f[2], f[3]))]
        cut.append(Block(block.vertices, tuple(triangles), block.name))
    whole, pieces = find_contacts(model).contacts, find_contacts(Assembly(tuple(cut))).contacts
    assert pieces.count == whole.count
    np.testing.assert_allclose(pieces.area, whole.area)
    assert (np.diff(pieces.start) == 4).all()


def test_random_pack_agrees_with_intervals() -> None:
    pack = random_pack(120, seed=3)
    contacts = find_contacts(pack).contacts
    found = {
        (a, b): area
        for a, b, area in zip(
            contacts.block_a.tolist(), contacts.block_b.tolist(), contacts.area, strict=True
        )
    }
    low, high = pack.bounds[:, 0], pack.bounds[:, 1]
    expected = {}
    for a in range(len(pack)):
        for b in range(a + 1, len(pack)):
            shared = np.minimum(high[a], high[b]) - np.maximum(low[a], low[b])
            flat = np.abs(shared) < 1e-12
            if flat.sum() == 1 and (shared[~flat] > 0.0).all():
                expected[a, b] = float(shared[~flat].prod())
    assert found.keys() == expected.keys()
    for pair, area in expected.items():
        assert found[pair] == pytest.approx(area, rel=1e-9)


def test_cells_of_a_voronoi_diagram_share_their_ridges() -> None:
    points = np.random.default_rng(3).random((40, 3))
    mirrored = [points]
    for axis in range(3):
        for side in (0.0, 2.0):
            image = points.copy()
            image[:, axis] = side - image[:, axis]
            mirrored.append(image)
    cells = Voronoi(np.concatenate(mirrored))  # those of the first points fill the unit cube
    loops: list[list[np.ndarray]] = [[] for _ in points]
    expected: dict[tuple[int, int], float] = {}
    for pair, ridge in zip(cells.ridge_points.tolist(), cells.ridge_vertices, strict=True):
        corners = cells.vertices[ridge]
        for cell in pair:
            if cell < len(points):
                loops[cell].append(corners)
        if max(pair) < len(points):
            area = area_vectors(corners, np.array([0, len(corners)]))[0]
            expected[min(pair), max(pair)] = float(np.linalg.norm(area))
    model = Assembly(tuple(welded(faces, f"cell-{i}") for i, faces in enumerate(loops)))
    contacts = find_contacts(model).contacts
    found = dict(
        zip(
            zip(contacts.block_a.tolist(), contacts.block_b.tolist(), strict=True),
            contacts.area.tolist(),
            strict=True,
        )
    )
    assert_well_formed(contacts)
    large = {pair: area for pair, area in expected.items() if area > 1e-6}
    assert {pair: found[pair] for pair in large} == pytest.approx(large, rel=1e-6)
    assert sum(found.values()) == pytest.approx(sum(expected.values()), abs=1e-6)


def test_gap_is_relative_to_the_smaller_block() -> None:
    for scale in (1e-3, 1.0, 1e3):
        for gap, joined in ((0.004, True), (0.006, False), (-0.004, True), (-0.006, False)):
            cube = box((1.0, 1.0, 1.0), (0.0, 0.0, gap), "cube")
            model = Assembly((SLAB, cube)).transformed(scale * np.eye(3))
            found = find_contacts(model, options=DetectionOptions(inexact=False))
            assert (found.contacts.count == 1) is joined


def test_interface_lies_halfway_across_the_gap() -> None:
    contacts = find_contacts(Assembly((SLAB, box((1.0, 1.0, 1.0), (0.0, 0.0, 0.004))))).contacts
    np.testing.assert_allclose(contacts.point[:, 2], 0.002, atol=1e-12)


def test_faces_within_tolerance_on_a_part_touch_there_only() -> None:
    leaning = box((1.0, 1.0, 1.0)).transformed(rotation_about([0.0, 1.0, 0.0], -1.0))
    report = find_contacts(Assembly((SLAB, leaning))).report
    assert report.interfaces.area == pytest.approx([0.005 / np.tan(np.deg2rad(1.0))], rel=1e-3)
    assert report.interfaces.clipped.tolist() == [True]


def test_angle_beyond_tolerance_is_no_face_contact() -> None:
    leaning = box((1.0, 1.0, 1.0), name="leaning").transformed(
        rotation_about([0.0, 1.0, 0.0], -3.0)
    )
    options = DetectionOptions(edges="never")  # type: ignore[arg-type]
    report = find_contacts(Assembly((SLAB, leaning)), options=options).report
    assert len(report.interfaces.area) == 0
    assert [miss.reason for miss in report.missed] == [Reason.ANGLE]
    assert report.missed[0].needed == pytest.approx(3.0)
    raised = DetectionOptions(angle=3.1)
    assert len(find_contacts(Assembly((SLAB, leaning)), options=raised).report.interfaces.area) == 1


def test_warped_faces_are_granted_their_warp() -> None:
    lower, upper = tower(2).blocks
    vertices = {b.name: np.array(b.vertices) for b in (lower, upper)}
    vertices[lower.name][[4, 6], 2] -= 0.03
    vertices[lower.name][[5, 7], 2] += 0.03
    bent = Assembly((Block(vertices[lower.name], lower.faces, "lower"), upper))
    report = find_contacts(bent).report
    assert report.interfaces.area == pytest.approx([1.0], rel=1e-3)
    assert report.interfaces.warp == pytest.approx([0.03], rel=0.01)
    flat = DetectionOptions(warp=0.01)
    refused = find_contacts(bent, options=flat).report
    assert [miss.reason for miss in refused.missed] == [Reason.WARP]


def test_thin_block_hides_what_is_behind_it() -> None:
    thin = box((1.0, 1.0, 1e-3), name="thin")
    wide = box((2.0, 1.0, 1.0), (0.0, 0.0, 1e-3), "wide")
    detection = find_contacts(Assembly((SLAB, thin, wide)))
    pairs = list(
        zip(detection.contacts.block_a.tolist(), detection.contacts.block_b.tolist(), strict=True)
    )
    assert pairs == [(0, 1), (0, 2), (1, 2)]
    np.testing.assert_allclose(detection.contacts.area, 1.0)
    assert Reason.HIDDEN in {miss.reason for miss in detection.report.missed}


def test_slivers_are_dropped_with_a_reason() -> None:
    beside = box((1.0, 1.0, 1.0), (2.0 - 5e-5, 0.0, 0.0), "beside")
    report = find_contacts(Assembly((SLAB, beside))).report
    assert Reason.SLIVER in {miss.reason for miss in report.missed}
    assert report.interfaces.area.sum() == 0.0


def test_blocks_that_meet_along_an_edge_share_no_area() -> None:
    report = find_contacts(
        Assembly((box((1, 1, 1), name="a"), box((1, 1, 1), (1, 0, 1), "b")))
    ).report
    assert len(report.interfaces.area) == 0
    assert report.isolated == (0, 1)
    assert report.undirected == ((0, 1),)


def test_single_block_has_no_contacts() -> None:
    detection = find_contacts(Assembly((SLAB,)))
    assert detection.contacts.count == 0
    assert detection.report.isolated == (0,)


def test_order_and_frames_are_repeatable() -> None:
    one, two = (find_contacts(random_pack(40, seed=5)).contacts for _ in range(2))
    for name in ("block_a", "block_b", "frame", "point", "interface", "area"):
        assert np.array_equal(getattr(one, name), getattr(two, name))
    key = one.block_a * 40 + one.block_b
    assert (np.diff(key) >= 0).all()


@pytest.mark.parametrize("friction", [-0.1, float("nan")])
def test_impossible_friction_is_refused(friction: float) -> None:
    with pytest.raises(InputError, match="friction"):
        find_contacts(tower(2), friction=friction)


@pytest.mark.parametrize(
    "wrong", [{"gap": -1.0}, {"gap": float("nan")}, {"angle": 90.0}, {"edges": "some"}]
)
def test_impossible_tolerances_are_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(InputError):
        DetectionOptions(**wrong)  # type: ignore[arg-type]


@pytest.mark.parametrize(("scale", "shift"), [(1e30, 0.0), (1.0, 1e14)])
def test_blocks_without_digits_are_refused(scale: float, shift: float) -> None:
    ground = box((scale, scale, scale), (shift, 0.0, -scale), name="ground")
    small = box((1.0, 1.0, 1.0), (shift, 0.0, 0.0), name="small")
    with pytest.raises(InputError, match=r"rounding changes its shape.*units") as caught:
        find_contacts(Assembly((ground, small), np.array([True, False])))
    assert caught.value.where in ("block 'small'", "block 'ground'")


def test_blocks_of_very_different_sizes_touch() -> None:
    ground = box((1e8, 1e8, 1.0), (-5e7, -5e7, -1.0), name="ground")
    small = box((1.0, 1.0, 1.0), name="small")
    found = find_contacts(Assembly((ground, small), np.array([True, False])))
    assert found.contacts.area == pytest.approx([1.0])


def test_tolerance_that_is_no_number_is_named() -> None:
    with pytest.raises(InputError, match="gap is 'a'; give a number"):
        DetectionOptions(gap="a")  # type: ignore[arg-type]
