"""Every family: closed blocks, no interpenetration, exact joints, volumes in closed form."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from drystone import Assembly, Block, InputError, find_contacts, models
from drystone.geometry import polyhedron
from drystone.models.domes import resampled
from drystone.models.simple import sections
from tests.oracle import touching_faces

FAMILIES: dict[str, Assembly] = {
    "tower": models.tower(4),
    "square hollow tower": models.tower(4, 3.0, course=0.5, thickness=0.6, stones=2),
    "leaning tower": models.tower(4, 3.0, course=0.5, thickness=0.6, lean=5.0),
    "incline": models.incline(25.0),
    "two blocks": models.two_blocks_on_incline(),
    "overhang": models.overhang(models.harmonic_offsets(4)),
    "stool": models.stool(),
    "arch": models.arch(),
    "segmental bridge": models.segmental_bridge(voussoirs=8),
    "pointed bridge": models.segmental_bridge(rise=4.0, voussoirs=8, profile="pointed"),
    "elliptic bridge": models.segmental_bridge(voussoirs=8, profile="elliptic"),
    "three-centred bridge": models.segmental_bridge(voussoirs=8, profile="three-centred"),
    "viaduct": models.segmental_bridge(voussoirs=6, rings=2, spans=2, pier=1.5, height=2.0),
    "buttressed arch": models.buttressed_arch(),
    "dome": models.dome(slices=6, rings=4),
    "bonded dome": models.dome(slices=6, rings=4, bonded=True),
    "closed dome": models.dome(oculus=0.0, slices=5, rings=3, bonded=True),
    "barrel vault": models.barrel_vault(courses=7, blocks=3),
    "straight barrel vault": models.barrel_vault(courses=7, blocks=3, staggered=False),
    "vault": models.vault(),
    "wall": models.wall(),
    "toothed wall": models.wall(5, 4, bond="toothed"),
    "stacked wall": models.wall(3, 4, bond="stack", ground=True),
    "ferris": models.ferris_wall(1),
    "buttressed wall": models.buttressed_wall(courses=4),
    "pier": models.buttressed_wall(0, courses=4),
    "corbelled wall": models.corbelled_wall(),
    **{f"wedge {kind}": models.wedge(kind) for kind in ("a", "b", "c", "d")},
    "H": models.h_model(),
    "A": models.a_model(),
    "shelf": models.shelf(),
    "concave short": models.concave(),
    "concave long": models.concave("long"),
    "curve": models.curve_three_blocks(),
    "coarse curve": models.curve_three_blocks(7),
    "cube curve short": models.cube_curve(),
    "cube curve tall": models.cube_curve("tall", 30),
}


def inside(block: Block, points: np.ndarray) -> np.ndarray:
    """Winding number of the block's surface about each point, rounded: 1 inside, 0 outside.

    Source: van Oosterom and Strackee 1983.
    """
    triangles, _ = polyhedron.fan_triangles(polyhedron.stack_faces([block.vertices], [block.faces]))
    a, b, c = (triangles[None, :, i] - points[:, None] for i in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=2) for v in (a, b, c))
    triple = (a * np.cross(b, c)).sum(axis=2)
    scale = la * lb * lc + (a * b).sum(2) * lc + (b * c).sum(2) * la + (c * a).sum(2) * lb
    return np.rint(np.arctan2(triple, scale).sum(axis=1) / (2.0 * np.pi)).astype(int)


@pytest.mark.parametrize("name", FAMILIES)
def test_blocks_are_clean_and_faces_planar(name: str) -> None:
    for block in FAMILIES[name].blocks:
        assert block.repairs == ()
        for loop in block.faces:
            corners = block.vertices[list(loop)]
            spread = np.linalg.svd(corners - corners.mean(axis=0), compute_uv=False)
            assert spread[2] < 1e-12 * block.size


@pytest.mark.parametrize("name", FAMILIES)
def test_blocks_do_not_interpenetrate(name: str) -> None:
    assembly = FAMILIES[name]
    random = np.random.default_rng(7)
    for a, b in combinations(range(len(assembly)), 2):
        low = np.maximum(assembly.bounds[a, 0], assembly.bounds[b, 0])
        high = np.minimum(assembly.bounds[a, 1], assembly.bounds[b, 1])
        if (high - low > 1e-9).all():
            points = random.uniform(low, high, (60, 3))
            both = inside(assembly.blocks[a], points) + inside(assembly.blocks[b], points)
            assert both.max() < 2, (assembly.names[a], assembly.names[b])


@pytest.mark.parametrize("name", FAMILIES)
def test_every_free_block_touches_another(name: str) -> None:
    assembly = FAMILIES[name]
    contacts = touching_faces(assembly, 0.6)
    touched = np.zeros(len(assembly), dtype=bool)
    touched[contacts.block_a] = True
    touched[contacts.block_b] = True
    assert assembly.fixed.any()
    assert touched[assembly.free].all()


IN_ONE_PLANE = {"curve": 1, "cube curve short": 4, "cube curve tall": 4}
"""Pairs of neighbouring strips at the inflections of the published curves, joined to one joint."""


@pytest.mark.parametrize("name", FAMILIES)
def test_detection_finds_the_joints_of_the_family(name: str) -> None:
    assembly = FAMILIES[name]
    contacts = find_contacts(assembly, friction=0.6).contacts
    brute = touching_faces(assembly, 0.6)
    assert contacts.count == brute.count - IN_ONE_PLANE.get(name, 0)
    for block in range(len(assembly)):
        area = [
            c.area[(c.block_a == block) | (c.block_b == block)].sum() for c in (contacts, brute)
        ]
        assert area[0] == pytest.approx(area[1], rel=1e-6)


def test_arch_has_the_volume_of_its_chords() -> None:
    assembly = models.arch(0.15, 36, radius=2.0, depth=0.5)
    inner, outer = 1.85, 2.15
    section = 0.5 * (outer**2 - inner**2) * np.sin(np.pi / 36)
    assert assembly.volume[~assembly.fixed] == pytest.approx(section * 0.5)
    assert assembly.names[:2] == ("springer-left", "voussoir-00")
    assert assembly.names[-1] == "springer-right"


def test_dome_approaches_the_volume_between_its_spheres_at_second_order() -> None:
    exact = 2.0 / 3.0 * np.pi * (2.1**3 - 1.9**3)
    missing = [
        exact - models.dome(2.0, 0.2, oculus=0.0, slices=n, rings=n).volume.sum() for n in (8, 16)
    ]
    assert np.log2(missing[0] / missing[1]) == pytest.approx(2.0, abs=0.05)


def test_dome_of_the_literature_has_140_blocks_of_ten_kinds() -> None:
    assembly = models.dome()
    assert (len(assembly), int(assembly.fixed.sum())) == (140, 14)
    by_ring = assembly.volume.reshape(10, 14)
    assert np.ptp(by_ring, axis=1).max() < 1e-12
    top = assembly.bounds[-1, 1, 2]
    assert top == pytest.approx(5.125 * np.sin(np.arccos(0.2)))


def test_bonded_dome_is_the_finer_dome_with_its_blocks_joined_in_pairs() -> None:
    fine = models.dome(slices=12, rings=4)
    bonded = models.dome(slices=6, rings=4, bonded=True)
    assert bonded.volume.sum() == pytest.approx(fine.volume.sum())


def test_barrel_vault_is_a_long_arch() -> None:
    flat = models.barrel_vault(2.0, 0.3, 4.0, courses=15, blocks=6)
    section = 0.5 * (2.15**2 - 1.85**2) * np.sin(np.pi / 15) * 15
    assert flat.volume.sum() == pytest.approx(section * 4.0)
    assert len(flat) == 8 * 6 + 7 * 7


def test_vault_is_as_high_and_wide_as_asked_and_symmetric() -> None:
    assembly = models.vault(span=6.0, rise=2.0, thickness=0.2, courses=11)
    middle = 0.5 * (assembly.bounds[..., 2].max() + 1.9)
    assert middle == pytest.approx(2.0, abs=0.02)  # the crown course is flat
    assert (assembly.mass @ assembly.centroid[:, :2]).tolist() == pytest.approx(
        [0.0, 0.0], abs=1e-8
    )
    assert {assembly.names[i].split("-")[0] for i in np.flatnonzero(assembly.fixed)} == {
        "c00",
        "c10",
    }


@pytest.mark.parametrize(
    ("courses", "length", "blocks", "joints"),
    [(13, 31, 403, 1122), (28, 71, 1988, 5767), (63, 159, 10017, 29608)],
)
def test_toothed_wall_has_the_stated_number_of_joints(
    courses: int, length: int, blocks: int, joints: int
) -> None:
    assert courses * length == blocks
    assert courses * (length - 1) + (courses - 1) * (2 * length - 1) == joints


def test_walls_have_the_joints_of_their_bond() -> None:
    toothed = models.wall(4, 5, bond="toothed")
    assert (len(toothed), touching_faces(toothed, 0.6).count) == (20, 4 * 4 + 3 * 9)
    running = models.wall(4, 5)
    assert (len(running), touching_faces(running, 0.6).count) == (22, 2 * 4 + 2 * 5 + 3 * 10)
    stacked = models.wall(4, 5, bond="stack")
    assert (len(stacked), touching_faces(stacked, 0.6).count) == (20, 4 * 4 + 3 * 5)
    assert running.volume.sum() == pytest.approx(4 * 5 * 0.4 * 0.2 * 0.2)


def test_ferris_walls_have_33_and_55_blocks_on_the_ground() -> None:
    assert [len(models.ferris_wall(n)) - 1 for n in (1, 2)] == [33, 55]


def test_published_models_have_their_joints_and_areas() -> None:
    names = (
        "concave short",
        "concave long",
        "cube curve short",
        "curve",
        "arch",
        "shelf",
        "H",
        "A",
    )
    found = {name: touching_faces(FAMILIES[name], 0.84) for name in names}
    assert found["concave short"].count == found["concave long"].count == 7
    areas = [0.12, 0.12, 0.06, 0.09, 0.09, 0.18, 0.10]
    assert sorted(found["concave short"].area) == pytest.approx(sorted(areas))
    assert found["cube curve short"].count == 72
    assert found["cube curve short"].area.sum() == pytest.approx(0.4708, abs=5e-5)
    assert found["curve"].count == 40
    assert found["curve"].area.sum() == pytest.approx(2.460, abs=5e-4)
    assert found["arch"].count == 37
    assert found["shelf"].count == 19
    assert found["H"].area == pytest.approx([0.8, 0.8])
    assert found["A"].area == pytest.approx(np.hypot(0.8, 1.154701 - 0.69282))


@pytest.mark.parametrize(
    ("kind", "side"), [("a", (0.6, 1.5392304845413263)), ("d", (1.0, 1.0773502691896257))]
)
def test_wedges_rest_on_two_joints_from_the_tip_to_each_shoulder(
    kind: str, side: tuple[float, float]
) -> None:
    contacts = touching_faces(models.wedge(kind), 0.84)
    joints = contacts.select(contacts.block_b == 2)
    assert joints.area == pytest.approx([np.hypot(side[0], side[1] - 0.5)] * 2)


def test_cube_curve_has_the_published_volumes() -> None:
    assert models.cube_curve("short").volume == pytest.approx([0.262032, 0.262032], rel=2e-4)
    assert models.cube_curve("tall").volume == pytest.approx([0.550002, 0.514002], rel=1e-5)


def test_concave_blocks_fill_their_box_together() -> None:
    assembly = models.concave("short")
    cantilever = 0.9 * 0.6 * 0.1
    assert assembly.volume.sum() == pytest.approx(1.6 * 1.0 * 0.2 + cantilever)


def test_stool_is_a_seat_and_four_legs() -> None:
    seat = models.stool(side=0.4, leg=0.08, seat=0.06, height=0.45).blocks[1]
    assert seat.volume == pytest.approx(0.4**2 * 0.06 + 4 * 0.08**2 * 0.39)
    assert seat.centroid[:2] == pytest.approx([0.2, 0.2])


def test_harmonic_overhang_reaches_half_the_harmonic_number() -> None:
    reach = [sum(models.harmonic_offsets(n)) for n in (1, 2, 3, 4)]
    assert reach == pytest.approx([0.5, 0.75, 0.9167, 1.0417], abs=5e-5)


def test_incline_slopes_by_its_angle() -> None:
    contacts = touching_faces(models.incline(31.0), 0.6)
    assert contacts.frame[0, 0] @ [0.0, 0.0, 1.0] == pytest.approx(np.cos(np.deg2rad(31.0)))
    assert contacts.frame[0, 0, 0] > 0.0


def test_buttressed_arch_has_the_published_layout() -> None:
    assembly = models.buttressed_arch()
    assert assembly.fixed.sum() == 2
    assert {block.density for block in assembly.blocks} == {1800.0}
    assert touching_faces(assembly, 0.6).count == 14 + 2 + 10
    assert assembly.bounds[:, 1, 2].max() == pytest.approx(2.5 + 1.3 * np.cos(0.0), abs=0.01)


@pytest.mark.parametrize(
    "curve",
    [sections("curve-three-blocks")[name] for name in ("bed", "hollow")]
    + [sections("cube-curve")["rim"]],
)
def test_resampling_keeps_points_ends_and_shape(curve: list[tuple[float, float]]) -> None:
    count = len(curve) - 1
    assert resampled(curve, count).tolist() == np.array(curve).tolist()
    doubled = resampled(curve, 2 * count)
    assert doubled[::2] == pytest.approx(np.array(curve), abs=1e-12)
    length = [np.linalg.norm(np.diff(c, axis=0), axis=1).sum() for c in (curve, doubled)]
    assert 1.0 <= length[1] / length[0] < 1.003


@pytest.mark.parametrize(
    ("make", "word"),
    [
        (lambda: models.arch(2.5), "thickness_ratio is 2.5; give a number above zero, below 2"),
        (lambda: models.arch(voussoirs=1), "voussoirs"),
        (lambda: models.buttressed_arch(depth=2.0), "wider"),
        (lambda: models.dome(slices=2), "slices"),
        (lambda: models.dome(oculus=6.0), "oculus"),
        (lambda: models.dome(thickness=-0.1), "thickness"),
        (lambda: models.barrel_vault(courses=2), "courses"),
        (lambda: models.barrel_vault(thickness=5.0), "thickness"),
        (lambda: models.vault(flare=2.0), "ends meet"),
        (lambda: models.vault(span=0.0), "span"),
        (lambda: models.wall(0, 3), "courses is 0; give 1 or more"),
        (lambda: models.wall(bond="flemish"), "flemish"),
        (lambda: models.ferris_wall(3), "number is 3"),
        (lambda: models.corbelled_wall(corbel=0.4), "rest on the one below"),
        (lambda: models.wedge("e"), "'e'"),
        (lambda: models.concave("medium"), "medium"),
        (lambda: models.cube_curve("wide"), "wide"),
        (lambda: models.cube_curve(strips=3), "strips"),
        (lambda: models.curve_three_blocks(1), "strips"),
        (lambda: models.stool(leg=0.3), "legs"),
        (lambda: models.overhang([1.5]), "rest on the one below"),
        (lambda: models.harmonic_offsets(0), "bricks"),
        (lambda: models.two_blocks_on_incline(80.0), "80"),
        (lambda: models.prism([(0, 0), (1, 0), (0, 1)], (1.0, 1.0)), "depth"),
    ],
)
def test_impossible_parameters_are_refused_in_one_line(make: object, word: str) -> None:
    with pytest.raises(InputError, match=word) as caught:
        make()
    assert "\n" not in str(caught.value)
