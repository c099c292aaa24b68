import pickle
from collections import Counter
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from drystone import InputError, check, find_contacts
from drystone.shells import (
    Edge,
    Ground,
    Intrados,
    JointForm,
    Layout,
    Seam,
    Shape,
    ShellBody,
    Side,
    barrel_vault,
    build_shell,
    cross_vault,
    dome,
    find_form,
    patch_from_function,
    patch_from_grid,
    pavilion_vault,
    rectangular_plan,
    shape_volume,
    shell_by_name,
    three_legged_plan,
)
from drystone.shells.materialise import cell_faces
from tests.oracle import largest_warp

LAYOUT = Layout(courses=9, blocks=4, wedge=0.2)
VAULT = build_shell(barrel_vault(6.0, 6.0, 1.732), LAYOUT, ShellBody(thickness=0.3))


def joints(shell):
    return [
        face
        for cell, ground in zip(shell.mesh.cells, shell.ground, strict=True)
        if not ground
        for face in cell_faces(shell.mesh, shell.pins, cell)[2]
    ]


def matched(shell):
    """Every side face is had by one block or, turned round, by two."""
    return {len(users) for users in shell.beside.values()} <= {1, 2}


FORM = find_form(rectangular_plan(6.0, 5.0), height=1.8)


def fan():
    """A low vault, 3 m wide at one end and 7 m at the other."""

    def point(u, v):
        return np.stack([(3.0 + 4.0 * v) * (u - 0.5), 6.0 * v, 4.8 * u * (1.0 - u)], axis=-1)

    return patch_from_function(point, name="fan")


SHELLS = {
    "cross vault": lambda: build_shell(cross_vault(), Layout(courses=11, width=0.8, wedge=0.1)),
    "pavilion vault": lambda: build_shell(pavilion_vault(), Layout(courses=5, width=1.0)),
    "joggle": lambda: build_shell(
        dome(), Layout(courses=6, blocks=12), ShellBody(thickness=0.4, joggle_deg=15.0)
    ),
    "straight intrados": lambda: build_shell(
        dome(), Layout(courses=6, blocks=12, wedge=0.2), ShellBody(intrados=Intrados.STRAIGHT)
    ),
    "by course": lambda: build_shell(
        barrel_vault(), LAYOUT, ShellBody(thickness=np.linspace(0.5, 0.3, 9).tolist())
    ),
    "half supported": lambda: build_shell(
        barrel_vault().supported_on(Edge(0, Side.BOTTOM, 0.0, 0.45), Edge(0, Side.TOP)), LAYOUT
    ),
}

SHELLS = {name: cache(build) for name, build in SHELLS.items()}


@pytest.mark.parametrize("kind", SHELLS)
def test_joints_are_planar_and_shared(kind):
    shell = SHELLS[kind]()
    assert shell.planar.reached
    assert largest_warp(shell.pins.point, joints(shell)) < 1e-8
    assert matched(shell)
    assert not any(block.repairs for block in shell.assembly.blocks)


def free_faces_volume(blocks):
    """[m3] enclosed by the faces that no other block has, as fans about their middles."""
    faces = [block.vertices[list(face)] for block in blocks for face in block.faces]
    keys = [frozenset(map(tuple, corner.tolist())) for corner in faces]
    total = 0.0
    for corner, key in zip(faces, keys, strict=True):
        if keys.count(key) == 1:
            after = np.roll(corner, -1, axis=0)
            total += float((np.cross(corner, after) @ corner.mean(axis=0)).sum()) / 6.0
    return total


def test_faceted_joints_join_the_same_blocks_as_plane_ones():
    """Two triangles each, the same ones in both blocks, with nothing between them."""
    layout = Layout(courses=5, width=1.4, wedge=0.2)
    plane, faceted = (
        build_shell(FORM.shape, layout, ShellBody(thickness=0.3, joints=form)) for form in JointForm
    )
    blocks = faceted.assembly.blocks
    assert not any(block.repairs for block in blocks)
    assert matched(faceted)
    assert sum(block.volume for block in blocks) == pytest.approx(free_faces_volume(blocks))
    assert faceted.planar.drift < 1e-12 < 1e-3 < faceted.planar.warp_after
    assert check(plane.model()).stable
    assert check(faceted.model()).stable
    found = find_contacts(faceted.assembly).contacts
    for contacts in (faceted.contacts, found):
        joints = Counter(joint.blocks for joint in contacts)
        assert joints.keys() == {joint.blocks for joint in plane.contacts}
        warped = [
            pair
            for pair, number in Counter(joint.blocks for joint in plane.contacts).items()
            if joints[pair] == 2 * number
        ]
        assert len(warped) > 0.8 * len(joints)


def test_faceted_joints_that_are_plane_stay_whole():
    shell = build_shell(dome(), Layout(courses=4, blocks=8), ShellBody(joints=JointForm.FACETED))
    pairs = [joint.blocks for joint in shell.contacts]
    assert len(pairs) == len(set(pairs))


@pytest.mark.parametrize("other", [{"joggle_deg": 15.0}, {"intrados": Intrados.STRAIGHT}])
def test_a_joggle_and_a_straight_intrados_need_plane_joints(other):
    with pytest.raises(InputError, match="needs plane joints"):
        ShellBody(joints=JointForm.FACETED, **other)


def test_a_straight_intrados_is_planar():
    shell = SHELLS["straight intrados"]()
    low = [
        cell_faces(shell.mesh, shell.pins, cell)[0]
        for cell, ground in zip(shell.mesh.cells, shell.ground, strict=True)
        if not ground
    ]
    assert largest_warp(shell.pins.point, low) < 1e-8


def test_a_joggle_makes_concave_blocks():
    shell = SHELLS["joggle"]()
    assert max(len(face) for block in shell.assembly.blocks for face in block.faces) == 10


def test_a_joggle_steps_the_bed_joint():
    shell = SHELLS["joggle"]()
    pins = shell.pins
    stepped = np.flatnonzero(np.diff(pins.start) == 4)
    first = pins.start[stepped]
    step = np.linalg.norm(pins.point[first + 2] - pins.point[first + 1], axis=1)
    assert np.allclose(step, 0.4 * np.tan(np.deg2rad(15.0)), rtol=0.05)


def test_volume_is_that_of_the_shell():
    assert VAULT.volume == pytest.approx(shape_volume(VAULT.shape, 0.3), rel=0.01)


def test_volume_of_a_smooth_dome():
    """Between two spheres, less the eye: a closed form by Cavalieri."""
    low, high = 5.0 - 0.2, 5.0 + 0.2
    sine = np.sqrt(1.0 - 0.2**2)  # of the latitude of the eye
    exact = 2.0 * np.pi / 3.0 * (high**3 - low**3) * sine
    assert shape_volume(dome(5.0, 1.0), 0.4) == pytest.approx(exact, rel=1e-4)


def test_blocks_are_as_thick_as_asked():
    shell = build_shell(
        barrel_vault(6.0, 6.0), Layout(courses=12, blocks=4), ShellBody(thickness=0.3)
    )
    pins = shell.pins
    for cell in np.array(shell.mesh.cells, dtype=object)[shell.voussoirs]:
        low = pins.point[pins.start[list(cell)]]
        high = pins.point[pins.start[np.array(cell) + 1] - 1]
        area = np.cross(low[2] - low[0], low[3] - low[1])
        across = (high - low) @ (area / np.linalg.norm(area))
        assert abs(across).mean() == pytest.approx(0.3, rel=1e-6)


def test_ground_blocks_stand_under_every_springer():
    roles = np.array([block.metadata["role"] for block in VAULT.assembly.blocks])
    springer = np.flatnonzero(roles == "springer")
    assert (VAULT.assembly.fixed == (roles == "ground")).all()
    pairs = [joint.blocks for joint in VAULT.contacts]
    under = {a for a, b in pairs if VAULT.ground[b] and not VAULT.ground[a]}
    assert under == set(springer.tolist())


def test_springers_may_be_fixed_instead():
    shell = build_shell(barrel_vault(), LAYOUT, ShellBody(ground=Ground.SPRINGERS))
    roles = np.array([block.metadata["role"] for block in shell.assembly.blocks])
    assert (shell.assembly.fixed == (roles == "springer")).all()
    assert shell.assembly.fixed.any()


def test_a_keystone_closes_the_eye():
    shell = build_shell(dome(keystone=True), Layout(courses=6, blocks=12))
    stone = shell.assembly.index("keystone")
    beside = {joint.blocks[0] for joint in shell.contacts if joint.blocks[1] == stone}
    assert {shell.assembly.names[i][:3] for i in beside} == {"c05"}
    assert len(beside) == 12


def test_the_ring_around_an_eye_is_known():
    shell = build_shell(dome(), Layout(courses=6, blocks=12))
    ring = [b.name for b in shell.assembly.blocks if b.metadata["role"] == "ring"]
    assert ring == [f"c05-b{k:02d}" for k in range(12)]


def test_the_middle_course_of_a_vault_is_its_key():
    keys = [b.name for b in VAULT.assembly.blocks if b.metadata["role"] == "keystone"]
    assert keys == [f"c04-b{k:02d}" for k in range(4)]


def test_metadata_tells_course_and_place():
    block = VAULT.assembly.blocks[VAULT.assembly.index("c03-b02")]
    assert dict(block.metadata) == {"course": 3, "position": 2, "patch": 0, "role": "voussoir"}


def test_seams_have_no_corner_on_one_side_only():
    shell = SHELLS["cross vault"]()
    across = [
        (a, b)
        for a, b in (joint.blocks for joint in shell.contacts)
        if not (shell.ground[a] or shell.ground[b])
        and shell.mesh.of_patch[a] != shell.mesh.of_patch[b]
    ]
    assert len(across) >= 4 * 5
    alone = [face for face, users in shell.beside.items() if len(users) == 1]
    supported = {frozenset(e) for e in shell.mesh.supported}
    assert alone
    assert not supported & set(alone)


def test_continuous_courses_across_a_seam_meet():
    half = barrel_vault(6.0, 3.0).patches[0]
    moved = type(half)(lambda u, v: half.function(u, v) + np.array([0.0, 3.0, 0.0]), name="second")
    shape = Shape(
        (half, moved),
        (Seam(Edge(0, Side.RIGHT), Edge(1, Side.LEFT)),),
        tuple(Edge(k, side) for k in (0, 1) for side in (Side.BOTTOM, Side.TOP)),
    )
    layouts = (Layout(courses=9, blocks=2), Layout(courses=6, blocks=2))
    shell = build_shell(shape, layouts, ShellBody(thickness=0.3))
    assert shell.planar.reached
    assert matched(shell)
    assert shell.volume == pytest.approx(shape_volume(shape, 0.3), rel=0.01)


def test_sides_that_are_apart_are_no_seam():
    with pytest.raises(InputError, match="sides of a seam are 6 m apart"):
        Shape(barrel_vault().patches * 2, (Seam(Edge(0, Side.LEFT), Edge(1, Side.RIGHT)),))


def test_a_shell_without_a_support_is_refused():
    with pytest.raises(InputError, match="shape 'barrel vault': the shell has no support"):
        build_shell(barrel_vault().supported_on(), LAYOUT)


def test_a_thickness_above_the_radius_is_refused():
    with pytest.raises(InputError, match=r"thickness 1.2 m is larger than the radius .* 1 m"):
        build_shell(barrel_vault(2.0, 2.0), LAYOUT, ShellBody(thickness=1.2))


@pytest.mark.parametrize(
    ("thickness", "message"),
    [
        (0.0, "the thickness is 0.0"),
        (-0.1, "the thickness is -0.1"),
        (float("nan"), "the thickness is nan"),
        ([0.2, 0.3], "2 thicknesses for 9 courses"),
        (lambda points: points, "thickness has shape"),
    ],
)
def test_an_impossible_thickness_is_refused(thickness, message):
    with pytest.raises(InputError, match=message):
        build_shell(barrel_vault(), LAYOUT, ShellBody(thickness=thickness))


def test_a_joggle_too_deep_for_a_course_names_the_block():
    with pytest.raises(InputError, match=r"block 'c\d\d-b00': has a face that crosses itself"):
        build_shell(
            barrel_vault(), Layout(courses=30, blocks=8), ShellBody(thickness=1.2, joggle_deg=25.0)
        )


@pytest.mark.parametrize("joggle", [25.1, -45.0, 9.0, float("nan")])
def test_a_joggle_out_of_range_is_refused(joggle):
    with pytest.raises(InputError, match=f"the joggle is {joggle} degrees; give 10 to 25"):
        ShellBody(joggle_deg=joggle)


def bent(courses):
    """A strip whose section is a curve in a plane, along y over 2 m."""

    def build(section, span=(0.0, 2.0 * np.pi)):
        def point(u, v):
            x, z = section(span[0] + (span[1] - span[0]) * u)
            return np.stack([x, 2.0 * v, z], axis=-1)

        shape = Shape((patch_from_function(point, name="strip"),), (), (Edge(0, Side.BOTTOM),))
        return build_shell(shape, Layout(courses=courses, blocks=3), ShellBody(thickness=0.1))

    return build


def test_a_surface_that_crosses_itself_is_refused():
    """The section is an eight on its side; it crosses itself in the middle."""
    with pytest.raises(
        InputError,
        match=r"blocks 'c\d+-b\d+' and 'c\d+-b\d+': overlap, .* and \d+ more pairs; "
        "the surface must not cross itself",
    ):
        bent(40)(lambda t: (4.0 * np.sin(t), 2.0 * np.sin(2.0 * t)), (0.3, 2.0 * np.pi + 0.1))


def test_warped_outer_faces_of_neighbours_do_not_overlap():
    """Three corners of them are almost in one line; triangles of these alone cross the joints."""
    shell = shell_by_name("free-edge", courses=5, blocks=5)
    assert find_contacts(shell.assembly).report.overlaps == ()


@pytest.mark.parametrize("gap", [0.08, 0.12])
def test_a_surface_may_come_as_near_to_itself_as_it_is_thick(gap):
    """A spiral of a turn and a half, 0.1 m thick, its turns apart by the gap [m]."""

    def spiral(t):
        radius = 2.0 + gap * t / (2.0 * np.pi)
        return radius * np.cos(t), radius * np.sin(t)

    if gap < 0.1:
        with pytest.raises(InputError, match="nor come closer to itself than the shell is thick"):
            bent(60)(spiral, (0.0, 3.0 * np.pi))
    else:
        shell = bent(60)(spiral, (0.0, 3.0 * np.pi))
        assert find_contacts(shell.assembly).report.overlaps == ()


def test_a_patch_may_not_cross_another():
    arch = barrel_vault(6.0, 2.0).patches[0]
    other = patch_from_function(
        lambda u, v: arch.point(u, v)[:, [1, 0, 2]] + [-1.0, 1.0, 0.3], name="across"
    )
    shape = Shape((arch, other), (), tuple(Edge(k, Side.BOTTOM) for k in (0, 1)))
    with pytest.raises(InputError, match=r"blocks 'p0-c.*' and 'p1-c.*': overlap"):
        build_shell(shape, Layout(courses=9, blocks=3), ShellBody(thickness=0.2))


@pytest.mark.parametrize(
    ("shape", "layout"),
    [
        (dome(3.0, 0.5), Layout(courses=12, width=0.75, wedge=None)),
        (FORM.shape, Layout(courses=12, width=0.75, wedge=None)),
    ],
    ids=["dome", "form-found"],
)
def test_inner_faces_are_planar_with_the_wedge_of_the_curvatures(shape, layout):
    """Without a wedge three corners of a face lie on one line: a bent ring has no such faces."""
    body = ShellBody(thickness=0.2, intrados=Intrados.STRAIGHT)
    shell = build_shell(shape, layout, body)
    inner = [cell_faces(shell.mesh, shell.pins, shell.mesh.cells[i])[0] for i in shell.voussoirs]
    assert largest_warp(shell.pins.point, inner) < 1e-8
    with pytest.raises(InputError, match=r"wedge=None.*no wider than twice their height"):
        build_shell(shape, replace(layout, wedge=0.0), body)


def test_planar_cells_of_a_sphere_have_a_wedge_by_width_and_height():
    """w^2 / (8 h^2) of planes that touch a sphere: with it hardly a corner has to move."""
    layout = Layout(courses=12, blocks=30, wedge=None)
    shell = build_shell(dome(), layout, ShellBody(thickness=0.2, intrados=Intrados.STRAIGHT))
    assert shell.planar.drift < 0.02


@pytest.mark.parametrize("shape", [cross_vault(), pavilion_vault()], ids=lambda shape: shape.name)
def test_courses_that_end_at_seams_take_no_joggle(shape):
    with pytest.raises(InputError, match=r"takes no joggle: its courses end at seams"):
        build_shell(shape, Layout(courses=11, width=0.8), ShellBody(thickness=0.2, joggle_deg=10.0))


def test_a_joggle_that_does_not_fit_is_to_be_left_out():
    form = find_form(three_legged_plan(), height=2.5)
    with pytest.raises(InputError, match="leave the joggle out"):
        build_shell(
            form.shape, Layout(courses=5, width=1.3), ShellBody(thickness=0.2, joggle_deg=10.0)
        )


@pytest.mark.parametrize("side", [Side.LEFT, Side.RIGHT])
def test_a_closed_patch_has_no_left_and_right(side):
    with pytest.raises(InputError, match=f"a closed patch has no side '{side.value}'"):
        dome().supported_on(Edge(0, side))
    with pytest.raises(InputError, match=f"a closed patch has no side '{side.value}'"):
        Shape(dome().patches * 2, seams=(Seam(Edge(0, side), Edge(1, side)),))


def test_a_patch_may_not_be_there_twice():
    shape = Shape(barrel_vault().patches * 2, (), (Edge(0, Side.BOTTOM), Edge(1, Side.BOTTOM)))
    with pytest.raises(InputError, match=r"blocks 'p0-c.*' and 'p1-c.*': overlap"):
        build_shell(shape, Layout(courses=6, blocks=3))


def test_ground_blocks_may_not_stand_in_each_other():
    """Under an upright wall and one that leans away from it."""
    walls = [
        patch_from_function(
            lambda u, v, foot=foot, lean=lean: np.stack([foot + lean * u, 2.0 * v, u], axis=-1),
            name=f"wall at {foot}",
        )
        for foot, lean in ((0.0, 0.0), (0.3, 1.0))
    ]
    shape = Shape(tuple(walls), (), (Edge(0, Side.BOTTOM), Edge(1, Side.BOTTOM)))
    layout = Layout(courses=3, blocks=3)
    with pytest.raises(InputError, match=r"'ground-p0.*' and 'ground-p1.*give a smaller ground"):
        build_shell(shape, layout, ShellBody(thickness=0.1, ground_depth=0.5))
    assert build_shell(shape, layout, ShellBody(thickness=0.1, ground_depth=0.1)).ground.sum() == 6


def test_a_large_drift_is_noted_with_its_block():
    """At a corner whose both sides stand on the ground the surface twists."""
    shell = build_shell(FORM.shape, Layout(courses=16, width=0.3, wedge=0.2))
    assert shell.planar.drift > 0.25
    assert shell.off_surface < shell.planar.drift
    assert len(shell.notes) == 1
    assert "the surface twists at block 'c00-b" in shell.notes[0]
    assert f"{shell.planar.drift:.2f} of a block's width" in shell.notes[0]
    assert VAULT.notes == ()


def test_layouts_must_be_one_per_patch():
    with pytest.raises(InputError, match="2 layouts for 4 patches"):
        build_shell(cross_vault(), (LAYOUT, LAYOUT))


def test_impossible_families_are_refused():
    with pytest.raises(InputError, match="more than half the span"):
        barrel_vault(2.0, 2.0, 3.0)
    with pytest.raises(InputError, match=r"eye of 3\.0 m radius is not above"):
        dome(2.0, 3.0)
    with pytest.raises(InputError, match="as wide as the span"):
        pavilion_vault(2.0, 2.0)
    with pytest.raises(InputError, match="span is nan"):
        cross_vault(float("nan"))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Layout(courses="9", blocks=4), "courses is '9'; give a whole number"),
        (lambda: Layout(courses=9.5, blocks=4), "courses is 9.5; give a whole number"),
        (lambda: Layout(courses=9, blocks=4.5), "blocks is 4.5; give a whole number"),
        (lambda: Layout(courses=2, blocks=[4, 4.5]), r"blocks is \[4, 4.5\]; give a whole number"),
        (lambda: ShellBody(joggle_deg="x"), "joggle_deg is 'x'; give a number"),
        (
            lambda: ShellBody(intrados="bent"),
            "intrados is 'bent'; give one of 'offset', 'straight'",
        ),
        (lambda: barrel_vault().supported_on("left"), "a border stretch is 'left'"),
        (lambda: patch_from_grid([[[0, 0, 0], [1, 0, 0]], [[0, 1, 0]]]), "control grid.*numbers"),
        (lambda: build_shell(barrel_vault(), [None]), r"layout is \[None\]; give Layout"),
        (lambda: built(wedge="a"), "wedge is 'a'; give a number"),
        (lambda: built(wedge=lambda u, v: "a"), "wedges must be numbers, got 'a'"),
        (lambda: built(thickness="x"), "thickness is 'x'; give a number"),
        (lambda: built(thickness=[0.3, "x"]), "thickness is .*; give a number"),
        (lambda: built(blocks=None, width="x"), "width is 'x'; give a number"),
    ],
)
def test_a_value_of_another_type_is_named(make, words):
    with pytest.raises(InputError, match=words) as caught:
        make()
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("keystone", [True, False])
def test_the_blocks_around_the_eye_of_a_pavilion_are_its_ring(keystone):
    shell = build_shell(pavilion_vault(keystone=keystone), Layout(courses=5, width=1.0))
    role = [block.metadata["role"] for block in shell.assembly.blocks]
    top = [i for i in shell.voussoirs if shell.mesh.course[i] == 4]
    assert [role[i] for i in top] == ["ring"] * len(top)
    assert role.count("ring") == len(top)
    assert role.count("keystone") == keystone


def built(thickness=0.4, **layout):
    return build_shell(
        barrel_vault(),
        Layout(**{"courses": 9, "blocks": 4} | layout),
        ShellBody(thickness=thickness),
    )


def test_numbers_of_numpy_are_numbers():
    shell = built(np.float32(0.4), courses=np.int64(9), blocks=np.int32(4))
    assert len(shell.voussoirs) == len(built().voussoirs)


@pytest.mark.parametrize("name", ["barrel", "pavilion", "dome", "free-edge", "tri-dome"])
def test_a_shell_travels_to_another_process(name: str):
    shell = shell_by_name(name, courses=5, width=1.6, thickness=0.3)
    again = pickle.loads(pickle.dumps(shell))
    assert np.array_equal(again.assembly.centroid, shell.assembly.centroid)
    point = [one.shape.patches[0].point(0.3, 0.7) for one in (again, shell)]
    assert np.array_equal(*point)


def test_a_named_shell_takes_what_the_command_takes():
    """Its springers are fixed, as those of the source's vault are; its faces as they are asked."""
    size = {"courses": 4, "blocks": 6, "thickness": 0.5}
    found = {
        "as it is": shell_by_name("dome", **size),
        "straight": shell_by_name("dome", **size, straight=True),
        "faceted": shell_by_name("dome", **size, joints="faceted", wedge=0.2),
        "blocks": shell_by_name("dome", **size, ground="blocks"),
    }
    fixed = {told: int(shell.assembly.fixed.sum()) for told, shell in found.items()}
    assert fixed == dict.fromkeys(found, 6)
    assert {told: int(shell.ground.sum()) for told, shell in found.items()} == {
        "as it is": 0, "straight": 0, "faceted": 0, "blocks": 6,
    }  # fmt: skip
    assert found["faceted"].pins.faceted
    assert found["straight"].contacts.area.sum() != found["as it is"].contacts.area.sum()
    with pytest.raises(InputError, match="ground is 'sand'"):
        shell_by_name("dome", **size, ground="sand")
