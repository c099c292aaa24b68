"""Fill on bridges and earth behind walls: sums, levels, hidden faces, and what is refused."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from drystone import Assembly, Block, InputError, Model, check
from drystone.answer.drawing import load_layers
from drystone.geometry.frames import rotation_about
from drystone.limits import LimitOptions, limit_load, limit_train
from drystone.loads import Earth, Fill, LoadCase
from drystone.loads.fill import Tops
from drystone.loads.seen_strips import SeenStrips
from drystone.models import barrel_vault, buttressed_arch, dome, segmental_bridge, tower
from drystone.models.simple import box, prism, welded
from drystone.report.sketches import dimensions_picture
from drystone.view import scene_of

PLACE = np.array([3.0])


def base_moment(assembly: Assembly, load: LoadCase) -> np.ndarray:
    """Force and moment about the origin of all loads."""
    force, moment = load.wrench[:, :3], load.wrench[:, 3:]
    turned = moment + np.cross(assembly.centroid, force)
    return np.concatenate([force.sum(axis=0), turned.sum(axis=0)])


def test_fill_weighs_what_lies_between_the_road_and_the_ring() -> None:
    bridge = segmental_bridge(6.0, 1.5, 0.45, 30)
    fill = Fill.named("cover=0.3m,weight=20kN/m3")
    force = fill.on(bridge).wrench[~bridge.fixed, :3].sum(axis=0)
    radius, centre, road = 3.75 + 0.45, 1.5 - 3.75, 1.5 + 0.45 + 0.3
    half = radius * 0.8  # sine of the angle of the feet
    each = 2.0 * np.arcsin(half / radius) / 30
    under = half * np.sqrt(radius**2 - half**2) + 15.0 * radius**2 * np.sin(each)
    area = 2.0 * half * (road - centre) - under
    assert force == pytest.approx([0.0, 0.0, -2e4 * area], rel=1e-6, abs=1e-6)
    assert not fill.on(bridge).each  # it does not press: no rows of rounding


def test_fill_presses_both_haunches_inwards_and_its_sum_is_that_of_the_vertical_plane() -> None:
    bridge = segmental_bridge(voussoirs=10)
    load = Fill(cover=0.0, weight=2e4, k=0.5).on(bridge)
    push = load.wrench[1:-1, 0]
    assert (push[:5] > 0.0).all()
    assert push[:5] == pytest.approx(-push[:4:-1])
    high = 1.5 + 0.45 - (1.5 + 0.45 - 4.2 + 4.2 * 0.6)  # of the extrados above its feet
    assert push[:5].sum() == pytest.approx(0.5 * 2e4 * 0.5 * high**2, rel=1e-9)


@pytest.mark.parametrize("angle", [0.0, 30.0, 90.0, 215.0])
def test_fill_presses_at_the_third_of_a_slope_that_faces_any_way(angle: float) -> None:
    """A slope of 2 m height on 1 m: pressure grows with depth from zero, about the centroid."""
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    block = prism([(0.0, 0.0), (3.0, 0.0), (2.0, 2.0), (0.0, 2.0)], (0.0, 1.0), "block")
    behind = box((1.0, 1.0, 2.0), (-1.0, 0.0, 0.0), "behind")
    turned = Assembly([block, behind], [False, True]).transformed(turn)
    wrench = Fill(cover=0.0, weight=18e3, k=0.5, between=(-9.0, 9.0)).on(turned).wrench[0]
    force = np.array([-18e3, 0.0, -18e3])
    place = np.array([3.0 - 1.0 / 3.0, 0.5, 2.0 / 3.0]) - block.centroid
    assert wrench[:3] == pytest.approx(turn @ force, abs=1e-6)
    assert wrench[3:] == pytest.approx(turn @ np.cross(place, force), abs=1e-6)


def test_fill_presses_the_backs_of_abutments_as_rankine_says() -> None:
    """``K w (H^2 - h^2) / 2`` of each half, from the road to the fixed course, however it steps."""
    bridge = segmental_bridge(8.0, 2.0, 0.5, 24, width=2.0, height=4.0)
    load = Fill(cover=0.4, weight=2e4, k=0.3).on(bridge)
    deep = 2.0 + 0.5 + 0.4 - bridge.bounds[0, 1, 2]
    left = ~bridge.fixed & (bridge.centroid[:, 0] < 4.0)
    thrust = 2.0 * 0.3 * 2e4 * (deep**2 - 0.4**2) / 2.0
    assert load.wrench[left, 0].sum() == pytest.approx(thrust, rel=1e-9)
    assert load.wrench[:, 0].sum() == pytest.approx(0.0, abs=1e-6)
    low = bridge.indices(["springer-left-1"])[0]
    mean = 0.3 * 2e4 * 2.0 * (deep - 0.5)  # of a course of 1 m
    assert load.wrench[low, 0] == pytest.approx(mean)
    assert load.wrench[low, 4] == pytest.approx(-0.3 * 2e4 * 2.0 / 12.0)  # its middle is deeper
    assert load.notes == (
        "fill acts on upright faces of springer-left-1, springer-left-2 and 6 more, also at the "
        "ends, as if the road went on",
    )
    field = load.surface
    assert field is not None
    assert np.abs(field.traction[field.block == low, :, 0]).max() == pytest.approx(6e3 * deep)


@pytest.mark.parametrize("degrees", [17.0, 30.0, 45.0, 90.0])
def test_fill_and_what_a_bridge_carries_turn_with_it(degrees: float) -> None:
    """Forces, moments, notes and a limit of two spans on piers, between backs."""
    bridge = segmental_bridge(5.0, 1.2, 0.4, 5, width=1.5, height=2.0, spans=2)
    fill, turn = Fill(0.4, 2e4, k=0.3), rotation_about(np.array([0.0, 0.0, 1.0]), degrees)
    first, turned = fill.on(bridge), fill.on(bridge.transformed(turn))
    back = np.concatenate([turned.wrench[:, :3] @ turn, turned.wrench[:, 3:] @ turn], axis=1)
    np.testing.assert_allclose(back, first.wrench, atol=1e-8 * np.abs(first.wrench).max())
    assert turned.notes == first.notes
    quick = LimitOptions(equilibrium_only=True)
    limits = []
    for one, load in ((bridge, first), (bridge.transformed(turn), turned)):
        model = Model.of(one, friction=0.6)
        live = LoadCase.point_load(one, one.names[13], (0.0, 0.0, -1e3))
        found = limit_load(model.with_load(model.load + load), live, options=quick)
        limits.append(found.equilibrium.stands)
    assert limits[1] == pytest.approx(limits[0], rel=1e-5)


def test_fill_presses_steps_and_walls_beside_it_but_not_what_is_covered_or_outside() -> None:
    """A step, a face in a hollow that is shut, and two spandrel walls of 2 m with fill between."""
    sizes = (4.0, 3.0, 2.0, 3.0)
    steps = [box((x, 1.0, 1.0), (0.0, 0.0, i), f"{i}") for i, x in enumerate(sizes)]
    steps.append(box((0.5, 1.0, 1.0), (2.5, 0.0, 2.0), "door"))
    push = Fill(cover=0.5, weight=2e4, k=0.5).on(Assembly(steps).with_fixed(["0", "door"]))
    assert push.wrench[:, 0] == pytest.approx([0.0, 0.0, 0.5 * 2e4 * 2.0, 0.0, 0.0], abs=1e-6)
    walls = [box((4.0, 0.5, 2.0), (0.0, y, 1.0), f"y={y}") for y in (0.0, 2.5)]
    low = box((4.0, 3.0, 1.0), name="low")
    outwards = 0.5 * 2e4 * 2.0**2 / 2.0 * 4.0
    for degrees in (0.0, 50.0, 90.0):  # nothing but what holds fill tells where the road runs
        turn = rotation_about(np.array([0.0, 0.0, 1.0]), degrees)
        slab = Assembly([low, *walls], [True, False, False]).transformed(turn)
        wrench = Fill(cover=0.0, weight=2e4, k=0.5).on(slab).wrench
        assert wrench[1:, :3] @ turn[:, 1] == pytest.approx([-outwards, outwards])
        assert wrench[1:, 3:] @ turn[:, 0] == pytest.approx([-outwards / 3.0, outwards / 3.0])
    resisting = Tops.of(Assembly(steps), Fill(0.5, 2e4, passive=3.0)).resisting
    assert np.flatnonzero(resisting.any(axis=1)).tolist() == [2, 4]


@pytest.mark.parametrize(("wide", "jut"), [(3.0, 0.15), (1.2, 0.5)])
def test_fill_presses_walls_below_copings_that_jut_over_it_and_tells_what_it_leaves(
    wide: float, jut: float
) -> None:
    """Walls of 2 m below copings of 0.3 m, from as far below the tops of these as they jut out.

    The second is open by 0.2 m between the copings.
    """
    blocks = [box((6.0, wide + 1.0, 0.5), (0.0, 0.0, -0.5), "deck")]
    for z, high, across in ((0.0, 2.0, 0.5), (2.0, 0.3, 0.5 + jut)):
        places = (0.0, wide + 1.0 - across)
        blocks += [box((6.0, across, high), (0.0, y, z), f"{z:g} at {y:g}") for y in places]
    load = Fill(cover=0.2, weight=2e4, k=0.4).on(Assembly(blocks).with_fixed(["deck"]))
    deep = (2.5, max(0.5, 0.2 + jut)), (0.5, 0.2)
    push, top = (0.4 * 2e4 * 6.0 / 2.0 * (a**2 - b**2) for a, b in deep)
    assert load.wrench[1:, 1] == pytest.approx([-push, push, -top, top])
    (told,) = load.notes[1:]
    assert told.startswith("fill below what juts out presses 0 at 0, 0 at ")


def test_one_free_wall_beside_fixed_masonry_holds_fill_or_is_told_to_hold_none() -> None:
    """K w (H^2 - h^2) / 2 of 4 m; zero where fixed blocks stand on both sides, or on none."""
    deck, south = box((4.0, 4.0, 0.5), (0.0, 0.0, -0.5), "deck"), box((4.0, 0.5, 2.0), name="south")
    north = box((4.0, 0.5, 2.0), (0.0, 3.5, 0.0), "north")
    ground = [
        box((4.0, 2.0, 0.5), (0.0, -2.0, -0.5), "g"),
        box((4.0, 1.0, 3.0), (0.0, -3.0, -0.5), "q"),
    ]
    fill = Fill(cover=0.1, weight=2e4, k=0.4)
    push = 0.4 * 2e4 * 4.0 * (2.1**2 - 0.1**2) / 2.0
    for others, held in (([deck, north], -push), ([deck, north, *ground], 0.0), ([deck], 0.0)):
        bridge = Assembly([south, *others], [False, *(True for _ in others)])
        load = fill.on(bridge)
        assert load.wrench[0, 1] == pytest.approx(held)
        assert any("no fill is seen before" in one for one in load.notes) == (held == 0.0)


def test_a_wing_is_pressed_from_behind_as_an_end_or_told_not_to_be() -> None:
    """K w (H^2 - h^2) / 2 by its true length where it is splayed by less than 45 degrees."""
    bridge = segmental_bridge(6.0, 1.5, 0.45, 4, width=4.0, height=3.0)
    wing, corner = (
        box((3.0, 0.5, 3.0), (0.0, 0.0, -3.0), "wing"),
        (bridge.bounds[..., 0].max(), 4.0, 0),
    )
    push = 0.3 * 2e4 * 3.0 * (5.25**2 - 2.25**2) / 2.0
    for splay, size, word in (
        (60.0, push, "oblique faces of wing"),
        (20.0, 0.0, "no fill is seen"),
    ):
        turn = rotation_about(np.array([0.0, 0.0, 1.0]), splay)
        blocks = [*bridge.blocks, wing.transformed(turn, corner)]
        load = Fill(0.3, 2e4, k=0.3).on(Assembly(blocks, [*bridge.fixed.tolist(), False]))
        assert load.wrench[-1, :3] @ turn[:, 1] == pytest.approx(size, abs=1e-6)
        assert any(word in one and "wing" in one for one in load.notes)


@pytest.mark.parametrize("batter", [0.0, 1e-8, 1e-6, 0.05, 0.3])
def test_fill_does_not_lie_outside_a_battered_wall(batter: float) -> None:
    """Two spandrel walls 2 m high: from outside it pressed them as much as from within."""
    low = box((4.0, 3.0, 1.0), name="low")
    across = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    section = np.array([(0.0, 1.0), (0.5, 1.0), (0.5, 3.0), (batter, 3.0)])
    one = prism(section, (-4.0, 0.0), "south").transformed(across)
    two = prism((3.0, 0.0) + section * (-1.0, 1.0), (-4.0, 0.0), "north").transformed(across)
    walls, words = Assembly([low, one, two], [True, False, False]), "cover=0m,weight=20kN/m3,k=0.5"
    if batter > 2.0 / 20.0:  # not plumb
        with pytest.raises(InputError, match=r"from outside, .* between=0.3m:2.7m") as told:
            Fill.named(words).on(walls)
        words += "," + str(told.value).partition("lies, ")[2].partition(" or")[0]
    push = Fill.named(words).on(walls).wrench
    outwards = 0.5 * 2e4 * 2.0**2 / 2.0 * 4.0
    assert push[1:, 1] == pytest.approx([-outwards, outwards], rel=1e-5)


@pytest.mark.parametrize("lean", [-0.02, -1e-5, 0.0, 1e-5, 0.02])
def test_walls_that_lean_a_little_are_pressed_and_turn_no_road(lean: float) -> None:
    """Spandrel walls 2 m above a slab, with copings that jut out on both sides."""
    low = box((4.0, 3.0, 1.0), name="low")
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    section = np.array([(0.0, 1.0), (0.5, 1.0), (0.5 - 2.0 * lean, 3.0), (-2.0 * lean, 3.0)])
    one = prism(section, (-4.0, 0.0), "south").transformed(turn)
    two = prism((3.0, 0.0) + section * (-1.0, 1.0), (-4.0, 0.0), "north").transformed(turn)
    tops = [
        box((4.0, 0.6, 0.2), (0.0, y, 3.0), f"{y}") for y in (-0.1 - 2.0 * lean, 2.5 + 2.0 * lean)
    ]
    walls = Assembly([low, one, two, *tops], [True, False, False, False, False])
    load = Fill(cover=0.2, weight=2e4, k=0.5)
    push = load.on(walls).wrench
    outwards = 0.5 * 2e4 * 4.0 * (2.4**2 - 0.4**2) / 2.0
    assert push[1:3, 1] == pytest.approx([-outwards, outwards])
    above = max(lean, 0.0) * 4.0 * (2.4**2 - 0.4**2) / 2.0  # [m3], on its inner face
    assert push[1:3, 2] == pytest.approx(-2e4 * above, abs=1e-6)
    np.testing.assert_array_equal(Tops.of(walls, load).road.strips.axes, np.eye(3))


def test_outer_slopes_of_gables_are_not_pressed_and_oblique_ends_are_named() -> None:
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    gable = prism([(0.0, 1.0), (0.6, 1.0), (0.3, 1.2)], (-4.0, 0.0), "gable").transformed(turn)
    blocks = [box((4.0, 3.0, 1.0), name="slab"), gable]
    blocks.append(gable.transformed(np.eye(3), (0.0, 2.4, 0.0)).renamed("other"))
    load = Fill(cover=0.1, weight=2e4, k=0.5).on(Assembly(blocks))
    push = 0.5 * 2e4 * 4.0 * (0.3**2 - 0.1**2) / 2.0
    assert load.wrench[:, 1] == pytest.approx([0.0, -push, push])
    assert load.wrench[1:, 2] == pytest.approx([-2e4 * 4.0 * 0.6 * 0.2] * 2)
    assert "oblique" not in " ".join(load.notes)
    wing = prism([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)], (0.0, 2.0), "wing")
    blocks.append(wing.transformed(rotation_about((0, 0, 1), 30.0), (6.0, 1.0, 0.0)))
    notes = " ".join(Fill(cover=0.1, weight=2e4, k=0.5).on(Assembly(blocks)).notes)
    assert "oblique faces of wing are pressed as ends" in notes


def test_chamfers_below_copings_turn_no_road() -> None:
    """Spandrel walls 2 m above a slab along x, their copings jut out above slopes of 45 degrees."""
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    top = np.array([(-0.3, 3.3), (0.0, 3.0), (0.5, 3.0), (0.5, 3.5), (-0.3, 3.5)])
    south, north = (
        prism(one, (-4.0, 0.0), f"top {one[0, 0]:g}").transformed(turn)
        for one in (top, (3.0, 0.0) + top[::-1] * (-1.0, 1.0))
    )
    walls = [box((4.0, 0.5, 2.0), (0.0, y, 1.0), f"wall {y}") for y in (0.0, 2.5)]
    bridge = Assembly([box((4.0, 3.0, 1.0), name="slab"), *walls, south, north])
    axes = Tops.of(bridge, Fill(cover=0.2, weight=2e4)).road.strips.axes
    np.testing.assert_array_equal(axes, np.eye(3))


@pytest.mark.parametrize("voussoirs", [5, 12])
@pytest.mark.parametrize(("degrees", "digits"), [(0.0, 15), (17.0, 15), (17.0, 6), (57.0, 4)])
def test_a_spandrel_wall_is_pressed_above_the_arch_and_below_the_road(
    voussoirs: int, degrees: float, digits: int
) -> None:
    """K w (road - z)^2 / 2 along the extrados; half of it to twice as much was found once."""
    ring = segmental_bridge(10.0, 2.0, 0.5, voussoirs, width=4.0)
    corners = np.concatenate([b.vertices for b in ring.blocks[1:-1]])[:, [0, 2]]
    centre, outer = (2.0**2 - 5.0**2) / 4.0, 5.0**2 / 4.0 + 1.0 + 0.5
    far = np.hypot(corners[:, 0] - 5.0, corners[:, 1] - centre) > outer - 1e-6
    line = np.unique(corners[far].round(9), axis=0)
    section = [*line.tolist(), [line[-1, 0], 4.0], [line[0, 0], 4.0]]
    walls = [prism(section, at, f"wall {at}") for at in ((0.0, 0.5), (3.5, 4.0))]
    turn = rotation_about(np.array([0.0, 0.0, 1.0]), degrees)
    blocks = [
        welded([(b.vertices @ turn.T).round(digits)[list(face)] for face in b.faces], b.name)
        for b in (*ring.blocks, *walls)
    ]
    bridge = Assembly(blocks, [*ring.fixed.tolist(), False, False])
    fill = Fill(cover=0.0, weight=2e4, k=0.4, between=(0.4999, 3.5001))
    deep = 4.0 - line[:, 1]
    each = np.diff(line[:, 0]) * (deep[1:] ** 2 + deep[1:] * deep[:-1] + deep[:-1] ** 2) / 6.0
    push = Tops.of(bridge, fill).pressed(1.0, 0.4)[-2:, :3] @ turn
    assert push[:, 1] == pytest.approx(0.4 * 2e4 * each.sum() * np.array([-1.0, 1.0]), rel=1e-3)


@pytest.mark.parametrize(("batter", "cover"), [(0.0, 0.1), (0.02, 0.1), (0.045, 0.1), (0.045, 2.0)])
def test_a_battered_wall_over_an_extrados_that_slopes_is_pressed_up_to_the_road(
    batter: float, cover: float
) -> None:
    """K w h^2 / 2 of 1 m of slope 0.5, to the road or to the top; its foot is farther away."""

    def moved(made: Block, top: float, face: float) -> Block:
        x, y, z = made.vertices.T
        z = np.where(z > z.min(), top, 0.5 * x) if top else np.where(z > z.min(), 0.5 * x, z)
        y = np.where(y == face, face + np.sign(2.0 - face) * batter * (1.9 - z), y)
        return Block(np.column_stack([x, y, z]), made.faces, made.name)

    deck = moved(box((1.0, 4.0, 1.0), (0.0, 0.0, -1.0), "deck"), 0.0, 9.0)
    south = moved(box((1.0, 0.4, 1.0), (0.0, 0.0, 0.0), "south"), 1.9, 0.4)
    north = moved(box((1.0, 0.4, 1.0), (0.0, 3.6, 0.0), "north"), 1.9, 3.6)
    fill = Fill(cover, weight=2e4, k=0.3, between=(0.4, 3.6))
    push = fill.on(Assembly([deck, south, north])).wrench[1:, 1]
    above = max(cover + 0.5 - 1.9, 0.0)
    outwards = 0.3 * 2e4 * (((cover + 0.5) ** 3 - cover**3) / 1.5 - above**2) / 2.0
    assert push == pytest.approx([-outwards, outwards])


def test_a_face_that_goes_on_above_the_road_is_pressed_below_it_only() -> None:
    low = box((6.0, 4.0, 0.5), name="low")
    walls = [box((6.0, 0.5, 2.0), (0.0, y, 0.5), f"y={y}") for y in (0.0, 3.5)]
    both = Assembly([low, *walls], [False, False, False])
    wrench = Fill(0.3, 2e4, k=0.4, between=(0.5, 3.5)).on(both).wrench[1:]
    outwards = 0.4 * 2e4 * 0.3**2 / 2.0 * 6.0
    assert wrench[:, 1] == pytest.approx([-outwards, outwards])
    arm = 1.5 - 0.5 - 0.1  # [m], below the middle of the wall
    assert wrench[:, 3] == pytest.approx([-outwards * arm, outwards * arm])


def test_walls_that_turn_in_plan_or_end_askew_are_pressed_by_their_true_length() -> None:
    """5 m, and 4 m splayed by 20 degrees with its end; no fill stands on the ground beside them."""
    deck = box((12.0, 10.0, 0.5), (-1.0, -3.0, -0.5), "deck")
    straight, turn = (
        box((5.0, 0.5, 2.0), name="s"),
        rotation_about(np.array([0.0, 0.0, 1.0]), -20.0),
    )
    south = [
        straight,
        box((4.0, 0.5, 2.0), (0.0, -0.5, 0.0), "s2").transformed(turn, (5.0, 0.5, 0.0)),
    ]
    north = [
        welded(
            [(b.vertices * [1, -1, 1] + [0, 4, 0])[list(f)][::-1] for f in b.faces], b.name + "n"
        )
        for b in south
    ]
    both = Assembly([deck, *south, *north]).with_fixed(["deck"])
    one = Assembly([box((5.0, 2.0, 0.5), (0.0, 0.0, -0.5), "deck"), straight])
    fill, push = Fill(cover=0.1, weight=2e4, k=0.4), 0.4 * 2e4 * (2.1**2 - 0.1**2) / 2.0
    splayed = push * (4.0 * np.cos(np.radians(20.0)) - 0.5 * np.sin(np.radians(20.0)))
    want = np.array([-5.0 * push, -splayed, 5.0 * push, splayed])
    assert fill.on(both).wrench[1:, 1] == pytest.approx(want)
    assert fill.on(one).wrench[1, 1] == pytest.approx(-5.0 * push)


@pytest.mark.parametrize("skew", [0.2, 0.6, 1.0])
def test_fill_between_two_places_of_a_skew_bridge_is_that_of_a_narrower_one(skew: float) -> None:
    shear = np.array([[1.0, skew, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    turn = rotation_about(np.array([0.0, 0.0, 1.0]), 12.0)

    def bridge(low: float, high: float) -> Assembly:
        right = segmental_bridge(6.0, 1.5, 0.45, 8, width=high - low, height=2.0)
        corners = ((b.vertices + np.array([0.0, low, 0.0])) @ shear.T for b in right.blocks)
        blocks = [
            welded([corner[list(face)] for face in b.faces], b.name)
            for b, corner in zip(right.blocks, corners, strict=True)
        ]
        return Assembly(blocks, right.fixed).transformed(turn)

    fill, part = Fill(0.3, 2e4, k=0.3), Fill(0.3, 2e4, k=0.3, between=(0.5, 2.5))
    wide, narrow = Tops.of(bridge(0.0, 3.0), part), Tops.of(bridge(0.5, 2.5), fill)
    np.testing.assert_allclose(wide.road.strips.axes[:2, :2], turn[:2, :2].T, atol=1e-9)
    force = narrow.pressed(1.0, 0.3)[:, :3]
    np.testing.assert_allclose(
        wide.pressed(1.0, 0.3)[:, :3], force, atol=1e-6 * np.abs(force).max()
    )
    assert wide.bridge.road.breadth == pytest.approx(narrow.road.breadth + 1.0)


def test_fill_between_two_places_is_that_of_a_narrower_bridge() -> None:
    wide, narrow = (segmental_bridge(voussoirs=8, width=w) for w in (2.0, 0.8))
    within = Fill(0.3, 2e4, k=0.3, between=(0.0, 0.8)).on(wide).wrench
    assert within[:, :3] == pytest.approx(Fill(0.3, 2e4, k=0.3).on(narrow).wrench[:, :3])
    asked = Fill(0.3, 2e4, between=(0.0, 0.8))
    assert "between 0 and 0.8 m across" in asked.words
    assert Tops.of(wide, asked).borne(PLACE, 0.3, 2.4) == [1.0]  # all of it, on the ring of 2 m


def test_what_juts_out_at_a_pier_takes_nothing_of_an_axle_elsewhere() -> None:
    """Cutwaters 0.8 m long on a free pier: they took 35 % of what acts at the crown."""
    bridge = segmental_bridge(6.0, 1.5, 0.45, 12, width=3.0, spans=2, pier=1.2, height=3.0)
    waters = [box((1.2, 0.8, 1.5), (6.0, y, -3.0), f"y={y}") for y in (-0.8, 3.0)]
    assembly = Assembly((*bridge.blocks, *waters), [*bridge.fixed.tolist(), False, False])
    fill = Fill(0.3, 2e4)
    alone, beside = (Tops.of(one, fill) for one in (bridge, assembly))
    assert beside.road.breadth == pytest.approx(4.6)
    assert beside.whole
    assert not alone.whole
    places, borne = np.array([1.0, 3.0]), np.array([1.0, 3.0 / 2.7])
    share = (borne / alone.borne(places, 0.4, 2.4))[:, None, None]
    down = beside.spread(1e3, places, 0.4, 2.4)[:, : len(bridge)]
    assert down == pytest.approx(share * alone.spread(1e3, places, 0.4, 2.4))
    assert down[:, :, 2].sum(axis=1) == pytest.approx(-1e3 * borne)


def test_an_axle_between_walls_that_reach_the_road_spreads_by_the_mean_depth() -> None:
    low = box((6.0, 3.0, 1.0), name="low")
    walls = [box((6.0, 0.5, 1.0), (0.0, y, 1.0), f"y={y}") for y in (0.0, 2.5)]
    road = Tops.of(Assembly([low, *walls]), Fill(0.0, 2e4)).road
    assert road.depth(PLACE) == pytest.approx(2.0 / 3.0)


COUNTERFORTS: dict[str, list[tuple[float, float, float]]] = {
    "none": [],
    "one": [(2.5, 1.0, 3.0)],
    "two": [(1.0, 1.0, 3.0), (4.0, 1.0, 3.0)],
    "wide": [(1.0, 4.0, 3.0)],
    "low": [(2.0, 2.0, 1.0)],
}
"""Of a wall 6 m long: place along it, width and height [m]."""


@pytest.mark.parametrize("some", COUNTERFORTS.values(), ids=COUNTERFORTS)
def test_what_stands_before_a_wall_takes_the_earth_of_what_it_covers(
    some: list[tuple[float, float, float]],
) -> None:
    before = [box((w, 1.0, h), (x, -1.0, 0.0), f"c{x}") for x, w, h in some]
    blocks = (box((6.0, 0.5, 3.0), name="wall"), *before)
    push = Earth(side="-y", weight=20e3, k=0.5).on(Assembly(blocks)).wrench[:, 1]
    covered = [w * 5e3 * (9.0 - (3.0 - h) ** 2) for _, w, h in some]  # K gamma / 2 = 5 kN/m3
    np.testing.assert_allclose(push, [270e3 - sum(covered), *covered])


def test_walls_beside_fill_have_no_fill_below_them_and_are_pressed_where_it_lies() -> None:
    long, length = 6.0, 2.2
    ground = box((long, 5.0, 0.5), (0.0, -1.0, -0.5), "ground")
    ring = box((length, 3.0, 0.5), name="ring")
    rest = box((long - length, 0.3, 0.5), (length, 0.0, 0.0), "rest")
    walls = [box((long, 0.3, 1.5), (0.0, y, 0.5), name) for y, name in ((0.0, "a"), (2.7, "b"))]
    other = box((long - length, 0.3, 0.5), (length, 2.7, 0.0), "other")
    assembly = Assembly((ground, ring, rest, other, *walls)).with_fixed(["ground"])
    wrench = Fill(cover=0.0, weight=20e3, k=0.5).on(assembly).wrench
    assert wrench[1, 2] == pytest.approx(-20e3 * 1.5 * length * 2.4)
    low = 5e3 * (2.0**2 - 1.5**2) * (long - length)  # on what is below the walls, beside the ring
    push = 5e3 * 1.5**2 * long
    np.testing.assert_allclose(wrench[2:, 1], [-low, low, -push, push])


TURNED: dict[str, Callable[[], Assembly]] = {
    "barrel vault": barrel_vault,
    "buttressed arch": buttressed_arch,
    "dome": dome,
    "two rings": lambda: segmental_bridge(rings=2, width=2.0),
    "random boxes": lambda: scattered(15),
}


def scattered(count: int) -> Assembly:
    """Boxes of random sizes over one another, turned in plan."""
    random, blocks = np.random.default_rng(5), []
    for i in range(count):
        size, shift = random.uniform(0.2, 1.5, 3), np.append(random.uniform(0.0, 3.0, 2), 2.0 * i)
        turn = rotation_about(np.array([0.0, 0.0, 1.0]), random.uniform(0.0, 90.0))
        blocks.append(box(size, name=f"b{i}").transformed(turn, shift))
    return Assembly(tuple(blocks), np.zeros(count, dtype=bool))


@pytest.mark.parametrize("name", TURNED)
def test_what_lies_on_each_block_is_the_same_about_any_way_it_is_turned_in_plan(name: str) -> None:
    model = TURNED[name]()
    level = model.bounds[..., 2].max() + 0.3

    def pressed(turn: np.ndarray, shift: tuple[float, float, float]) -> np.ndarray:
        turned = model.transformed(turn, shift)
        seen = SeenStrips.of(turned, np.eye(3))
        down = np.array([0.0, 0.0, -2e4])
        wrench = seen.wrenches(turned, lambda at: (level - at.point[:, 2:]) * down)
        return np.concatenate([wrench[:, :3] @ turn, wrench[:, 3:] @ turn], axis=1)

    straight = pressed(np.eye(3), (0.0, 0.0, 0.0))
    for degrees in (0.5, 2.0, 3.0, 8.0, 45.0, 90.0, 215.0):
        turn = rotation_about(np.array([0.0, 0.0, 1.0]), degrees)
        found = pressed(turn, (0.7, -30.0, 0.0))
        np.testing.assert_allclose(found, straight, 0.0, 1e-9 * np.abs(straight).max())


@pytest.mark.parametrize("degrees", [0.0, 20.0, 40.0, 45.0])
def test_a_bar_across_another_one_takes_the_fill_above_where_they_cross(degrees: float) -> None:
    lower = box((6.0, 1.0, 1.0), (-3.0, -0.5, 0.0), "lower")
    turn = rotation_about(np.array([0.0, 0.0, 1.0]), degrees + 90.0)
    upper = box((6.0, 1.0, 1.0), (-3.0, -0.5, 0.0), "upper").transformed(turn, (0.0, 0.0, 1.0))
    assembly = Assembly((lower, upper))
    push = Fill(cover=0.4, weight=20e3, k=0.0).on(assembly).wrench[:, 2]
    shared = 1.0 / np.cos(np.deg2rad(degrees))  # [m2], a rhombus 1 m high
    np.testing.assert_allclose(push, [-28e3 * (6.0 - shared), -8e3 * 6.0])


def test_joints_along_meridians_of_a_dome_are_not_below_fill() -> None:
    tops = Tops.of(dome(), Fill(0.4, 2e4, k=0.5, between=(-9.0, 9.0)))
    assert not any(len(one.block) for one in tops.road.beside)
    assert not tops.notes


def test_a_road_that_rises_adds_fill_at_one_end_and_takes_it_at_the_other() -> None:
    bridge = segmental_bridge(voussoirs=10)
    level, rising = (Fill(0.5, 2e4, grade=rise).on(bridge).wrench[1:-1, 2] for rise in (0.0, 0.02))
    assert rising.sum() == pytest.approx(level.sum())
    more = level - rising
    assert more == pytest.approx(-more[::-1])
    width = (6.0 + 2.0 * 0.45 * 0.8) / 2.0
    assert more[5:].sum() == pytest.approx(0.02 * 2e4 * width**2 / 2.0)


def test_fill_lies_on_the_outer_ring_only() -> None:
    bridge = segmental_bridge(voussoirs=6, rings=2, ring=0.3)
    loaded = np.flatnonzero(Fill(0.2, 2e4).on(bridge).wrench[:, 2])
    assert {bridge.names[i].partition("-v")[0] for i in loaded} == {"ring-2"}


@pytest.mark.parametrize("law", ["even", "boussinesq"])
def test_a_load_spreads_and_none_of_it_is_lost(law: str) -> None:
    bridge = segmental_bridge(voussoirs=20)
    top = Tops.of(bridge, Fill(1.0, 2e4, law=law))  # type: ignore[arg-type]
    total = base_moment(bridge, LoadCase(top.spread(1e3, PLACE, 0.3, 0.0)[0]))
    assert total[2] == pytest.approx(-1e3, rel=2e-2)
    assert total[4] == pytest.approx(3.0 * 1e3, rel=2e-2)


def test_a_narrow_bridge_bears_its_share_of_an_axle() -> None:
    bridge = segmental_bridge(voussoirs=20, width=1.0)
    top = Tops.of(bridge, Fill(0.3, 2e4))
    force = top.spread(1e3, PLACE, 0.3, 2.4)[0, :, 2].sum()
    assert force == pytest.approx(-1e3 / (2.4 + 0.3), rel=1e-9)


def test_ground_below_fixed_ends_keeps_fill_from_the_foot_of_a_pier() -> None:
    """A deck between two banks on a pier whose lower part stands in the open below them."""
    banks = [box((1.0, 1.0, 1.0), (x, 0.0, 0.0), f"bank{x}") for x in (-1.0, 3.0)]
    ground = box((2.0, 1.0, 0.5), (0.5, 0.0, -4.5), "ground")
    deck, pier = box((3.0, 1.0, 0.5), (0.0, 0.0, 0.5), "deck"), box((1, 1, 4.5), (1, 0, -4), "pier")
    bridge = Assembly([*banks, ground, deck, pier], [True, True, True, False, False])
    load = Fill(cover=0.5, weight=18e3, k=0.3).on(bridge)
    assert load.wrench[3:, :3] == pytest.approx(np.array([[0.0, 0.0, -27e3], [0.0, 0.0, 0.0]]))
    (note,) = load.notes
    assert note.startswith("the ground below fixed blocks keeps fill from upright faces of pier:")


def test_earth_presses_as_rankine_says_to_the_third_of_its_height() -> None:
    wall = tower(4)
    load = Earth.named("side=-x,weight=18kN/m3,k=active:30deg").on(wall)
    total = base_moment(wall, load)
    assert total[0] == pytest.approx(6e3 * 16.0 / 2.0)
    assert total[4] == pytest.approx(6e3 * 64.0 / 6.0)


@pytest.mark.parametrize(("state", "sense"), [("active", 1.0), ("passive", -1.0)])
def test_earth_in_an_earthquake_presses_as_the_worst_wedge_does(state: str, sense: float) -> None:
    """Mononobe and Okabe: at 0.2 g, the least favourable of the plane slips behind a wall of 4 m.

    A wedge above a slope s weighs 18 s 4^2 / 2 by width, and slides on its friction of 35 degrees.
    """
    slope = np.linspace(0.71, 6.0, 20_001)  # of a slip plane, across by up
    weight = 18e3 * slope * 4.0**2 / 2.0
    push = weight * (np.tan(np.arctan(1.0 / slope) - sense * np.radians(35.0)) + sense * 0.2)
    worst = push.max() if state == "active" else push.min()
    load = Earth.named(f"side=-x,weight=18kN/m3,k={state}:35deg:0.2").on(tower(4))
    assert load.wrench[:, 0].sum() == pytest.approx(worst, rel=1e-6)


def test_what_earth_presses_with_stands_in_the_name_of_a_load() -> None:
    earth = Earth.named("side=-x,weight=18kN/m3,k=active:30deg,wall_friction=20deg")
    told = "earth of 18 kN/m3 to 2 m on side -x with K 0.333"
    assert earth.on(tower(2)).name == f"{told} and wall friction 0.364, at most its own"
    wet = Earth.named("side=-x,weight=18kN/m3,k=active:30deg,surcharge=5kPa,water=0.5m")
    assert wet.on(tower(2)).name == f"{told} and surcharge 5 kPa and water to 0.5 m"
    notes = [replace(wet, water=one).on(tower(2)).notes[-1] for one in (1.5, 2.0 + 1e-15, 2.5)]
    above = "water, a level, stands 0.5 m above what it presses"
    assert [one == above for one in notes] == [False, False, True]
    assert Fill(0.0, 0.0, spread=0.0).words == "no fill: a load acts where it stands"
    fill = Fill.named("cover=0.3m,weight=20kN/m3,k=rest:30deg")
    told = "fill of 20 kN/m3 to 0.3 m above the crown with K 0.5, passive none"
    assert fill.on(tower(2)).name == f"{told} (a load spreads 0.5 by depth, evenly)"


def test_earth_presses_on_the_blocks_that_are_named_up_to_their_top() -> None:
    """Cubes of 1 m: on each of two 9 kN from the middle depth 0.5 m; below, 2.5 m and none."""
    words = "side=-x,weight=18kN/m3,k=1,blocks={}"
    some = Earth.named(words.format("block-2+block-1")).on(tower(4))
    assert some.name == "earth of 18 kN/m3 to 3 m on side -x with K 1 on block-2+block-1"
    assert some.wrench[:, 0] == pytest.approx([0.0, 27000.0, 9000.0, 0.0])
    every = Earth.named(words.format("block-*")).on(tower(4))
    assert every.wrench == pytest.approx(Earth("-x", 18e3, 1.0).on(tower(4)).wrench)


def test_water_and_a_surcharge_add_to_earth() -> None:
    wall = tower(3)
    load = Earth.named("side=y,weight=20kN/m3,k=0.5,water=1m,surcharge=10kPa").on(wall)
    thrust = 0.5 * (20e3 * 4.5 - 9810.0 * 0.5 + 10e3 * 3.0) + 9810.0 * 0.5
    assert load.wrench[:, 1].sum() == pytest.approx(-thrust)
    assert not load.notes  # its level is the foot of what is free: no uplift


def test_uplift_below_a_wall_is_told_ready_to_type() -> None:
    """1.5 m of water above the foot of the free blocks: 14.7 kPa at one edge, none at the other."""
    wall = tower(3)
    load = Earth.named("side=y,weight=20kN/m3,k=0.5,water=2.5m").on(wall)
    uplift, _, typed = load.notes[0].partition(" --load ")
    assert uplift == (
        "uplift below the wall is not counted: at 1 m, 14.7 kPa at the wet side, none at a "
        "drained one, 7.36 kPa on average, turning it as 9.81 kPa would: add a pressure to each "
        "block there, such as"
    )
    pushed = check(wall, friction=0.6, load=typed.strip("'")).model.load.wrench
    assert pushed[1, 2] == pytest.approx(7358.0 - 9.81 * wall.mass[1])


def test_earth_weighs_on_a_back_that_leans_and_not_on_what_stands_before_it() -> None:
    wide, high = box((2.0, 1.0, 1.0), name="foot"), box((1.0, 1.0, 1.0), (0.0, 0.0, 1.0), "stem")
    wall = Assembly((wide, high), np.zeros(2, dtype=bool))
    toe = Earth(side="-x", weight=2e4, k=0.3).on(wall)
    heel = Earth(side="x", weight=2e4, k=0.3).on(wall)
    assert toe.wrench[:, 0] == pytest.approx(-heel.wrench[:, 0])
    leaning = Assembly((prism([(0, 0), (2, 0), (1, 2), (0, 2)], (0, 1)),), np.array([False]))
    load = Earth(side="x", weight=2e4, k=0.3).on(leaning)
    assert load.wrench[0, :3] == pytest.approx([-0.3 * 4e4, 0.0, -2e4])  # half of 1 m by 2 m


@pytest.mark.parametrize("degrees", [30.0, 44.0, -60.0])
def test_earth_presses_square_to_a_wing_wall_that_is_splayed(degrees: float) -> None:
    """By its true length: K (w h^2 / 2 + q h) less uplift, and water; its friction down."""
    height, length, lean = 3.0, 5.0, 0.4
    profile = [(0.0, 0.0), (1.0 + lean, 0.0), (1.0, height), (0.0, height)]
    places = ((length * i, length * (i + 1.0)) for i in range(3))  # neighbours hide its ends
    turn = rotation_about(np.array([0.0, 0.0, 1.0]), degrees)
    each = tuple(prism(profile, at, f"wing-{at[0]:g}") for at in places)
    wings = Assembly(each, np.zeros(3, dtype=bool)).transformed(turn)
    words = "side=x,weight=18kN/m3,k=0.3,surcharge=5kPa,water=2m,wall_friction=0.2"
    force = Earth.named(words).on(wings).wrench[1, :3] @ turn
    earth = 0.3 * (18e3 * 4.5 + 5e3 * 3.0 - 9810.0 * 2.0) * length
    water = 9810.0 * 2.0 * length
    weighs = (18e3 * 4.5 + 5e3 * 3.0) * length * lean / height  # and the water in it
    np.testing.assert_allclose(force, [-earth - water, 0.0, -weighs - 0.2 * earth], atol=1e-8)


@pytest.mark.parametrize(("taper", "told"), [(0.0, False), (0.05, True), (0.3, False)])
def test_ends_of_a_wall_that_earth_presses_although_hardly_seen_are_named(
    taper: float, told: bool
) -> None:
    upright = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
    plan = [(0.0, 0.0), (1.0, taper), (1.0, 4.0 - taper), (0.0, 4.0)]
    wall = Assembly([prism(plan, (0.0, 2.0), "wall").transformed(upright.T)])
    notes = Earth.named("side=x,weight=18kN/m3,k=0.5").on(wall).notes
    assert [one[:36] for one in notes] == ["earth presses also faces of wall tha"] * told


def test_pressure_is_drawn_as_a_field_whose_size_is_that_of_the_formula() -> None:
    """K (w h + p) at both ends of each face; factors and a tilt go with it, forces stay arrows."""
    wall = tower(3)
    earth = Earth.named("side=-x,weight=18kN/m3,k=0.5,surcharge=10kPa").on(wall)
    field = earth.surface
    assert field is not None
    assert field.wrench[1:] == pytest.approx(earth.wrench[1:])  # the lowest block is fixed
    depth = wall.bounds[..., 2].max() - field.point[..., 2]
    assert field.traction[..., 0] == pytest.approx(0.5 * (18e3 * depth + 10e3), rel=1e-5)
    twice = (LoadCase.gravity(wall) + 2.0 * earth).turned(np.eye(3)[[1, 2, 0]]).surface
    assert twice is not None
    assert np.abs(twice.traction).max() == pytest.approx(2.0 * np.abs(field.traction).max())
    push = LoadCase.point_load(wall, 2, (0.0, 10.0, 0.0))
    for load, keys in ((earth, ["surface"]), (earth + push, ["loads", "surface"])):
        assert [one.key for one in load_layers(wall, load)] == keys


def test_a_wall_is_seen_from_its_end_with_an_arrow_at_each_end_of_a_face() -> None:
    blocks = [box((1.0, 0.5, 0.4), (0.0, 0.0, 0.4 * i), f"b{i}") for i in range(3)]
    wall = Assembly(tuple(blocks), (True, False, False))
    earth = Earth.named("side=-y,weight=18kN/m3,k=0.5,surcharge=5kPa").on(wall)
    model = Model.of(wall, load=LoadCase.gravity(wall) + earth)
    scene = scene_of(model)
    assert scene.toward.tolist() == [1.0, 0.0, 0.0]
    (drawn,) = (one for one in scene.stages[0].layers if one.key == "surface")
    assert drawn.vector is not None
    assert not drawn.vector[:, 0].any()  # a face of two triangles has one upright line
    assert drawn.count == 7 * len(model.assembly.free)
    assert dimensions_picture(model).caption.endswith(drawn.label)


def test_pressures_on_the_same_faces_are_added_in_their_picture() -> None:
    """Earth and 0.311 of it is 1.311 of it; a surcharge adds to it, also where water cuts faces."""
    wall = tower(3)
    dry, wet, load = (
        Earth.named(f"side=-x,k=0.5,{words}").on(wall)
        for words in ("weight=18kN/m3", "weight=18kN/m3,water=0.7m", "weight=0kN/m3,surcharge=8kPa")
    )
    for earth, factor, more in ((dry, 0.311, dry), (wet, 1.0, load), (load, 1.0, wet)):
        field = (earth + factor * more).surface
        assert field is not None
        alone = [one.by(by) for one, by in ((earth.surface, 1.0), (more.surface, factor)) if one]
        most = sum(float(np.abs(one.traction).max()) for one in alone)
        assert np.abs(field.traction).max() == pytest.approx(most)
        assert len(field.block) == max(len(one.block) for one in alone)
    none = Earth("-x", 0.0, 0.5).on(wall)
    press = LoadCase.surface_load(wall, 1, 100.0)
    field = (none + press + dry + press).surface
    assert field is not None
    assert np.isclose(field.traction, -200.0).any()  # of the face that is pressed twice


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("fill:cover=-0.1m,weight=20kN/m3", "cover is -0.1; give 0 or more"),
        ("fill:cover=0.1m,weight=20kN/m3,grade=90%", "m below the top of 'voussoir-"),
        ("fill:cover=0.1m,weight=20", "'20' has no unit"),
        ("fill:cover=0.1m,weight=20kN/m33", "'20kN/m33' has another unit; write 20kN/m3 or"),
        ("fill:cover=0.1m", "fill has no weight"),
        ("fill:cover=1e9m,weight=20kN/m3", "cover is 1e.09; give 0 or more, up to 100"),
        ("fill:cover=0.1m,weight=1e30kN/m3", "'1e30kN' is larger than anything .* to 1e.09kN"),
        ("fill:cover=0.1m,weight=1e4kN/m3", "weight is 1e.07; give 0 or more, up to 1e.06 .N/m3"),
        ("fill:cover=0.1m,weight=20kN/m3,k=1e9", "k is 1e.09; give 0 or more, up to 15"),
        ("fill:cover=0.1m,weight=20kN/m3,spread=1e9", "spread is 1e.09; .* up to 2"),
        (
            "fill:cover=0.1m,weight=20kN/m3,spread=45",
            "spread is 45; give 0 or more, up to 2; degrees are written spread=45deg",
        ),
        ("fill:cover=0.1m,weight=20kN/m3,passive=40", "15; degrees are .* passive=passive:40deg"),
        (
            "fill:cover=0.1m,weight=20kN/m3,passive=passive:70deg",
            "32.16.* give 0 or more, up to 15$",
        ),
        ("earth:side=-x,weight=18kN/m3,k=30", "k is 30; .* up to 15; .* k=active:30deg"),
        (
            "earth:side=-x,weight=18kN/m3,k=0.333,wall_friction=20",
            "wall_friction is 20; give 0 or more, up to 1.2; .* wall_friction=20deg",
        ),
        ("earth:side=-x,weight=18kN/m3,k=0.3,water=1e9", "water is 1e.09; give -100000 or more"),
        ("fill:cover=0.1m,weight=20kN/m3,k=-0.3", "load fill: k: is -0.3; give a coefficient"),
        ("fill:cover=0.1m,weight=20kN/m3,spread=-1", "load fill: spread: is -1"),
        ("fill:cover=0.1m,weight=20kN/m3,k=0.5,passive=0.3", "give more than k"),
        ("fill:cover=0.1m,weight=20kN/m3,law=odd", "law is 'odd'"),
        ("fill:cover=0.1m,height=2m", "fill has no 'height'; did you mean weight"),
        ("fill:cover=0.1m,cover=0.2m", "'cover' is given twice"),
        ("fill:cover=0.1m,weight=20kN/m3,between=1m:0m", "give the lesser place first"),
        ("fill:cover=0.1m,weight=20kN/m3,between=5m:6m", "no free block has a top there"),
        ("fill:cover=0.1m,weight=20kN/m3,between=5m", "'5m' is one place; write two"),
        ("earth:side=-x,weight=18kN/m3,k=0.3,delta=20deg", "no 'delta'; .* wall_friction"),
        ("earth:side=-x,weight=18kN/m3,k=-1", "load earth: k: is -1"),
        ("earth:side=z,weight=18kN/m3,k=0.3", "side is 'z'"),
        ("earth:side=-x,weight=18kN/m3,k=0.3,top=-1m", "is below the wall"),
        ("earth:side=-x,weight=18kN/m3,k=0.3,top=300", "its top, 300 m, .* as 300mm"),
        ("earth:side=-x,weight=18kN/m3,k=0.3,water=1500", "its water, 1500 m, .* as 1500mm"),
        ("earth:side=-x,weight=8kN/m3,k=0.3,water=1m", "less than the water in it"),
        (
            "earth:side=-x,weight=18kN/m3,k=0.3,water=-1m",
            "its water, -1 m, is below the wall; .* not a height",
        ),
        ("earth:side=x,weight=18kN/m3,k=0.3,blocks=springer-right", "springer-right, is fixed"),
        ("earth:side=-x,weight=18kN/m3,k=resting:30deg", "no state of earth"),
        ("earth:side=-x,weight=18kN/m3,k=0.3,blocks=wall-*", "load earth: .*'wall-\\*'"),
        ("earth:side=-x,weight=18kN/m3,k=0.3,blocks=voussoir-03", "it touches no face"),
        ("earth:side=-x,weight=18kN/m3,k=0.3,blocks=", "'blocks=' is not NAME=VALUE"),
        ("earth:side=-x,weight=18kN/m3,k=0.3,surcharge=10", "with a unit; write 10Pa, 10kPa"),
        ("earth:side=-x,weight=18kN/m3,k=active:30", "'30' is no angle; write active:30deg"),
        ("earth:side=-x,weight=18kN/m3,k=30deg", "'30deg' is an angle; write active:30deg"),
        ("earth:side=-x,weight=18kN/m3,k=active:30deg:0.6", "by itself at 0.6 g; .* most 0.577"),
        ("earth:side=-x,weight=18kN/m3,k=rest:30deg:0.1", "not rest; write active:30deg:0.1"),
        ("earth:side=-x,weight=18kN/m3,k=0.3,wall_friction=active:30deg", "is not a number"),
        ("earth:side=-x,weight=18kN/m3,k=0.3,surcharge=10kN/m20", "another unit; write 10kPa or"),
        ("earth:side=-x,weight=18kN/m3,k=0.3,surcharge=5psf", "use one of Pa, kPa, MPa, kN/m2"),
        (
            "earth:side=-x,weight=18kN/m3,wall_friction=50deg,k=active:30deg",
            "of 50 degrees is more than that of the earth, 30; give no more than 30deg",
        ),
        ("fill:cover=0.1m,weight=20kN/m3,passive=passive:30", "'30' is no angle"),
    ],
)
def test_ground_that_cannot_be_is_told_in_one_line(words: str, told: str) -> None:
    with pytest.raises(InputError, match=told):
        check(segmental_bridge(voussoirs=4), friction=0.6, load=words)


def test_fill_as_a_part_or_of_a_train_is_refused_where_gravity_is_turned() -> None:
    """As in words; an earthquake is not turned gravity."""
    bridge = segmental_bridge(voussoirs=8)
    part = {"kind": "fill", "words": "cover=0.3m,weight=20kN/m3"}
    with pytest.raises(InputError, match="fill weighs along -z"):
        check(bridge, load=[part], gravity=(1.0, 0.0, -9.7))
    with pytest.raises(InputError, match="fill weighs along -z"):
        limit_train(bridge, fill=Fill(0.3, 2e4), gravity=(1.0, 0.0, -9.7))
    assert check(bridge, load=[part], seismic=0.05).stable
