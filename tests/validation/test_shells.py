"""Four shells from a surface to a verdict: blocks that fit, joints that are found, what stands."""

from functools import cache

import numpy as np
import pytest

from benchmarks.sample_shells import SAMPLES, sample_shell
from drystone import CheckOptions, LoadCase, Model, Verdict, check, find_contacts
from drystone.detection import DetectionOptions
from drystone.geometry.solid import solid_angles
from drystone.geometry.surface import edge_defects
from drystone.geometry.triangulate import triangulate
from drystone.settlement import Carrier, SettlementOptions
from drystone.shells import (
    Edge,
    Ground,
    Layout,
    Shape,
    ShellBody,
    Side,
    build_shell,
    patch_from_function,
    rectangular_plan,
    shape_volume,
)
from drystone.shells.materialise import cell_faces
from tests.oracle import largest_warp

TIGHTEST = DetectionOptions(gap=1e-6)
QUICK = CheckOptions(samples=1)
ON_THE_BLOCK = CheckOptions(samples=1, settlement=SettlementOptions(carrier=Carrier.MOVING))
"""Flush ends of joints go with the block that leans: carried by its bed it falls before."""


@cache
def sampled(kind):
    return sample_shell(kind, 40)


@cache
def found_in(kind):
    return find_contacts(sampled(kind).assembly, options=TIGHTEST)


@pytest.fixture(params=SAMPLES)
def kind(request):
    return request.param


def shared_areas(shell):
    """Area of the faces that each pair of blocks shares, as they were made."""
    areas = {}
    for joint in shell.contacts:
        pair = frozenset(joint.blocks)
        areas[pair] = areas.get(pair, 0.0) + joint.area
    return areas


def test_every_block_is_closed_and_has_a_volume(kind):
    for block in sampled(kind).assembly.blocks:
        assert edge_defects(block.faces) == ([], [], True)
        assert block.volume > 0.0
        assert not block.repairs


def test_no_two_blocks_stand_in_each_other(kind):
    assert found_in(kind).report.overlaps == ()
    assert found_in(kind).report.isolated == ()


def test_every_joint_is_planar(kind):
    shell = sampled(kind)
    faces = [face for face, users in shell.beside.items() if len(users) == 2]
    assert len(faces) == len(shell.contacts)
    made = (cell_faces(shell.mesh, shell.pins, cell)[2] for cell in shell.mesh.cells)
    loops = {frozenset(face): face for sides in made for face in sides}
    worst = largest_warp(shell.pins.point, [loops[face] for face in faces])
    assert worst <= 1e-6 * shell.assembly.size.min()
    assert shell.planar.warp_after <= 1e-6


def test_every_joint_is_found_at_the_tightest_tolerance_with_its_area(kind):
    made = shared_areas(sampled(kind))
    contacts = found_in(kind).contacts
    found = {}
    pairs = zip(contacts.block_a.tolist(), contacts.block_b.tolist(), strict=True)
    for pair, area in zip(pairs, contacts.area.tolist(), strict=True):
        found[frozenset(pair)] = found.get(frozenset(pair), 0.0) + area
    assert set(found) == set(made)
    for pair, area in made.items():
        assert found[pair] == pytest.approx(area, rel=1e-6)


def test_the_blocks_have_the_volume_of_the_shell(kind):
    shell = sampled(kind)
    thickness = SAMPLES[kind][40][1]
    assert shell.volume == pytest.approx(shape_volume(shell.shape, thickness), rel=0.01)


def test_blocks_stay_near_the_surface(kind):
    assert sampled(kind).planar.drift < 0.15
    assert sampled(kind).fitted < 0.06


def test_the_shells_stand(kind):
    shell = sampled(kind)
    result = check(Model(shell.assembly, found_in(kind).contacts), options=QUICK)
    assert result.verdict is Verdict.STABLE
    assert result.residuals.largest <= 1e-8


def test_the_plan_of_the_form_found_shell_does_not_stand_flat():
    layout = SAMPLES["form-found"][40][0]
    flat = build_shell(rectangular_plan(6.0, 5.0), layout, ShellBody(thickness=0.2))
    contacts = find_contacts(flat.assembly, options=TIGHTEST).contacts
    assert check(Model(flat.assembly, contacts), options=QUICK).verdict is Verdict.UNSTABLE


def test_a_hooked_dome_is_concave_and_stands():
    shell = build_shell(
        sampled("dome").shape,
        Layout(courses=5, blocks=8),
        ShellBody(thickness=0.4, joggle_deg=12.0),
    )
    found = find_contacts(shell.assembly, options=TIGHTEST)
    assert found.report.overlaps == ()
    pairs = [frozenset(p) for p in zip(found.contacts.block_a, found.contacts.block_b, strict=True)]
    assert max(pairs.count(pair) for pair in pairs) == 4  # the four faces of the hook
    made = sum(shared_areas(shell).values())
    assert float(found.contacts.area.sum()) == pytest.approx(made, rel=1e-6)
    assert check(Model(shell.assembly, found.contacts), options=QUICK).verdict is Verdict.STABLE


def single_block(wedge):
    """One block of a straight wall on the course below: assembly and contacts."""

    def wall(u, v):
        return np.stack([3.0 * v, 0.0 * u, 0.8 * u], axis=-1)

    shape = Shape((patch_from_function(wall, name="wall"),), supports=(Edge(0, Side.BOTTOM),))
    layout = Layout(courses=2, blocks=5, wedge=wedge)
    shell = build_shell(shape, layout, ShellBody(thickness=0.2, ground=Ground.SPRINGERS))
    below = [name for name in shell.assembly.names if name.startswith("c00")]
    assembly = shell.assembly.subset([*below, "c01-b02"])
    return assembly, find_contacts(assembly, friction=0.84, options=TIGHTEST).contacts


def leans(wedge, angle):
    assembly, contacts = single_block(wedge)
    tilt = LoadCase.tilt(assembly, (1.0, 0.0, 0.0), angle)
    return check(Model(assembly, contacts, tilt), options=ON_THE_BLOCK).verdict is Verdict.STABLE


def test_a_plain_block_leans_until_its_weight_leaves_the_bed():
    """Thickness 0.2 m by height 0.4 m: atan(1/2) = 26.565 degrees."""
    assert leans(0.0, 26.5)
    assert not leans(0.0, 26.65)


@pytest.mark.parametrize(("wedge", "angle"), [(0.1, 28.5), (0.2, 37.5), (0.3, 44.5)])
def test_the_larger_the_wedge_the_farther_a_block_leans(wedge, angle):
    assert leans(wedge, angle)
    assert not leans(wedge - 0.1, angle)


def test_no_point_lies_in_two_blocks(kind):
    """Points drawn in every block and just inside its corners, tested by their solid angles.

    Independent of how the depth of one block in another is found.
    """
    blocks = sampled(kind).assembly.blocks
    random = np.random.default_rng(7)
    for name in set(sampled(kind).contacts.block_a.tolist()):
        one = blocks[name]
        triangles = _triangles(one)
        low, high = one.vertices.min(axis=0), one.vertices.max(axis=0)
        points = random.uniform(low, high, (60, 3))
        corners = one.vertices[random.integers(0, len(one.vertices), 20)]
        points = np.concatenate([points, corners + 0.02 * (one.centroid - corners)])
        points = points[_inside(points, triangles)]
        for other in range(len(blocks)):
            near = (blocks[other].vertices.min(axis=0) < high).all()
            if other != name and near and (blocks[other].vertices.max(axis=0) > low).all():
                shared = points[_inside(points, _triangles(blocks[other]))]
                assert len(shared) == 0, (one.name, blocks[other].name)


def _triangles(block):
    corner = block.vertices[[i for face in block.faces for i in face]]
    start = np.concatenate([[0], np.cumsum([len(face) for face in block.faces])])
    return corner[triangulate(corner, start)[0]]


def _inside(points, triangles):
    return solid_angles(points[:, None], triangles).sum(axis=1) > 2.0 * np.pi
