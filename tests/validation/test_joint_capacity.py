"""Joints that pull and cohere against closed forms: cantilever, incline, hanging block, dowel."""

from dataclasses import replace

import numpy as np
import pytest

import drystone
from drystone import Assembly, JointCapacity, LoadCase, Model, Verdict, check, solve_rbe
from drystone.checks import check_forces, mechanism_defects
from drystone.models import box as box_of_size


def box(low, high, name):
    """A box between two corners."""
    size = np.subtract(high, low)
    return box_of_size(size, low, name)


HEIGHT, WIDTH, LENGTH = 0.4, 0.3, 1.0


def cantilever(tension, cohesion=1e9, friction=0.6, brittle=False):
    """A block glued by its end face to the side of a fixed one."""
    wall = box((-1.0, 0.0, 0.0), (0.0, WIDTH, HEIGHT), "wall")
    arm = box((0.0, 0.0, 0.0), (LENGTH, WIDTH, HEIGHT), "arm")
    model = Model.of(Assembly((wall, arm), fixed=[True, False]), friction=friction)
    glue = JointCapacity.of_stress(
        model.contacts, tension=tension, cohesion=cohesion, brittle=brittle
    )
    return model.with_capacity(glue)


def weight(model):
    return -model.load.wrench[~model.assembly.fixed, 2].sum()


def critical_tension():
    """The moment W L / 2 is carried by the glue about the lower edge: t (b h) h / 2."""
    moment = weight(cantilever(1.0)) * LENGTH / 2.0
    return moment / (WIDTH * HEIGHT * HEIGHT / 2.0)


@pytest.mark.parametrize(("share", "verdict"), [(1.01, "stable"), (0.99, "unstable")])
def test_a_glued_cantilever_falls_at_tension_times_lever_arm(share, verdict):
    model = cantilever(share * critical_tension())
    result = check(model)
    assert result.verdict == verdict
    if result.stable:
        assert check_forces(model, result.force, result.displacement).largest <= 1e-8
    else:
        violation, power = mechanism_defects(model, result.mechanism)
        assert violation < 1e-5
        assert power > 0.0


def test_the_largest_load_of_a_glued_cantilever():
    model = cantilever(critical_tension())
    force = 100.0
    load = LoadCase.point_load(model.assembly, "arm", (0, 0, -force), (LENGTH, 0.15, 0.2))
    strong = cantilever(2.0 * critical_tension())
    expected = weight(model) * 0.5 / force  # W L / 2 more at the lever L
    limit = drystone.limit_load(strong, load, upper=3.0 * expected)
    for bracket in (limit.equilibrium, limit.rest):
        assert bracket.stands <= expected * (1 + 1e-6)
        assert bracket.falls >= expected * (1 - 1e-6)
        assert bracket.falls - bracket.stands < 0.05 * expected


@pytest.mark.parametrize(("share", "verdict"), [(1.01, "stable"), (0.99, "unstable")])
def test_a_brittle_cantilever_breaks_at_tension_times_section_modulus(share, verdict):
    """M = t b h2 / 6 of a plane section; the ductile one carries t b h2 / 2 about its edge."""
    model = cantilever(3.0 * share * critical_tension(), brittle=True)
    assert check(model).verdict == verdict


WALL, COURSES = (1.0, 0.3, 2.0), 4


def wall(tension, brittle=True, cohesion=1e6):
    """A wall 2 m high and 0.3 m thick, of 1,800 kg/m3: its foot is pressed with 35,316 Pa."""
    length, thick, height = WALL
    low = [-0.2, *(height * i / COURSES for i in range(COURSES))]
    high = [0.0, *low[2:], height]
    blocks = [
        box_of_size((length, thick, top - bottom), (0.0, 0.0, bottom), f"b{i}", density=1800.0)
        for i, (bottom, top) in enumerate(zip(low, high, strict=True))
    ]
    model = Model.of(Assembly(tuple(blocks), [True] + COURSES * [False]), friction=0.6)
    mortar = JointCapacity.of_stress(
        model.contacts, tension=tension, cohesion=cohesion, brittle=brittle
    )
    return model.with_capacity(mortar)


@pytest.mark.parametrize(
    ("tension", "brittle", "expected"),
    [
        (5e4, False, 0.15 * (1.0 + 5e4 / 35316.0)),  # (t / h) (1 + f A / W): 0.362
        (5e4, True, 0.15),  # it cracks at 0.121 already, and rocks as a dry one: t / h
        (2e5, True, 0.05 * (1.0 + 2e5 / 35316.0)),  # (t / 3 h) (1 + f A / W): 0.333, uncracked
    ],
)
def test_the_mortar_of_a_wall_in_an_earthquake(tension, brittle, expected):
    found = drystone.limit_load(wall(tension, brittle), (0.0, 9.81, 0.0), upper=2.0)
    assert found.rest.stands <= expected * (1.0 + 1e-5)
    assert found.rest.falls >= expected * (1.0 - 1e-5)
    assert found.rest.falls - found.rest.stands <= 2e-3 * expected


def test_a_wall_says_what_its_mortar_does():
    model = wall(5e4)
    for factor, words in (
        (0.1, "every joint of mortar cracked"),
        (0.2, "its mortar cracks in 2 joints, and what is left falls"),
    ):
        shaken = model.with_load(model.load + factor * LoadCase.seismic(model.assembly, 0.0, 1.0))
        found = check(shaken)
        assert words in found.message
        assert found.asked.mortar == "brittle"
        assert "(brittle)" in found.asked.facts()["Joint capacity"]


def incline(angle_deg, cohesion, friction=0.5):
    """A flat block on a plane; gravity leans."""
    base = box((-2.0, -2.0, -0.2), (2.0, 2.0, 0.0), "base")
    block = box((-0.5, -0.4, 0.0), (0.5, 0.4, 0.05), "block")
    assembly = Assembly((base, block), fixed=[True, False])
    load = LoadCase.tilt(assembly, (0.0, 1.0, 0.0), angle_deg)
    model = Model.of(assembly, friction=friction, load=load)
    return model.with_capacity(JointCapacity.of_stress(model.contacts, cohesion=cohesion))


@pytest.mark.parametrize("friction", [0.0, 0.5])
@pytest.mark.parametrize("angle", [20.0, 35.0])
def test_a_cohesive_block_slides_at_friction_and_cohesion_by_pressure(angle, friction):
    """tan(angle) = mu + c A / (W cos(angle))"""
    dry = incline(angle, 0.0)
    load = np.linalg.norm(dry.load.wrench[1, :3])
    tangent, cosine = np.tan(np.deg2rad(angle)), np.cos(np.deg2rad(angle))
    critical = (tangent - friction) * load * cosine / 0.8
    if critical <= 0.0:
        assert check(incline(angle, 0.0, friction)).stable
        return
    assert check(incline(angle, 1.01 * critical, friction)).stable
    falls = check(incline(angle, 0.99 * critical, friction))
    assert falls.verdict is Verdict.UNSTABLE
    assert solve_rbe(incline(angle, 0.99 * critical, friction)).verdict is Verdict.UNSTABLE
    assert (
        solve_rbe(incline(angle, 1.01 * critical, friction)).verdict is Verdict.EQUILIBRIUM_EXISTS
    )


def hanging(tension):
    """A block below a fixed one."""
    top = box((0.0, 0.0, 1.0), (1.0, 1.0, 2.0), "top")
    block = box((0.0, 0.0, 0.0), (1.0, 1.0, 1.0), "block")
    model = Model.of(Assembly((top, block), fixed=[True, False]), friction=0.6)
    return model.with_capacity(JointCapacity.of(model.contacts, tension=tension))


def test_a_hanging_block_falls_when_its_weight_exceeds_the_tension():
    load = weight(hanging(0.0))
    held = check(hanging(1.001 * load))
    assert held.stable
    assert held.resultants.normal == pytest.approx([-load], rel=1e-6)
    assert check(hanging(0.999 * load)).verdict is Verdict.UNSTABLE
    assert check(hanging(0.0)).verdict is Verdict.UNSTABLE


def test_a_limit_of_shear_holds_whatever_the_pressure():
    """A block pressed on a table is pushed sideways: it slides at s although mu n is larger."""
    base = box((-2.0, -2.0, -0.2), (2.0, 2.0, 0.0), "base")
    block = box((-0.5, -0.5, 0.0), (0.5, 0.5, 0.05), "block")
    assembly = Assembly((base, block), fixed=[True, False])
    own = LoadCase.gravity(assembly)
    for push, verdict in ((99.0, "stable"), (101.0, "unstable")):
        load = own + LoadCase.point_load(assembly, "block", (push, 0.0, 0.0), (0.0, 0.0, 0.0))
        model = Model.of(assembly, friction=0.6, load=load)
        capacity = JointCapacity.of(model.contacts, shear=100.0)
        assert check(model).stable  # friction alone would hold it
        result = check(model.with_capacity(capacity))
        assert result.verdict == verdict
        if not result.stable:
            violation, power = mechanism_defects(model.with_capacity(capacity), result.mechanism)
            assert violation < 1e-5
            assert power > 0.0


def test_without_any_capacity_nothing_changes():
    dry = cantilever(0.0, 0.0)
    assert check(dry).verdict is Verdict.UNSTABLE
    model = Model.of(drystone.models.arch(0.15), friction=0.9)
    none = JointCapacity.of(model.contacts)
    assert check(model.with_capacity(none)).message == check(model).message


def test_a_pull_ends_where_the_joint_slides_open():
    """Mohr and Coulomb: with friction 0.5 and a cohesion of 100 N no pull exceeds 200 N."""
    model = hanging(1e6)
    load = weight(model)
    for cohesion, verdict in ((0.61 * load, "stable"), (0.59 * load, "unstable")):
        capacity = JointCapacity.of(model.contacts, tension=1e9, cohesion=cohesion)
        assert check(model.with_capacity(capacity)).verdict == verdict


def test_an_arch_of_blocks_glued_without_limit_stands_like_one_block():
    """Half an arch leans out and falls dry; glued to its support it is a cantilever."""
    from drystone.joint_capacity import NO_LIMIT

    whole = Model.of(drystone.models.arch(0.15, 7), friction=0.6)
    names = whole.assembly.names
    half = whole.subset(names[: len(names) // 2 + 1])
    assert half.assembly.fixed.any()
    assert check(half).verdict is Verdict.UNSTABLE
    glue = JointCapacity.of(half.contacts, tension=NO_LIMIT, cohesion=NO_LIMIT)
    assert check(half.with_capacity(glue)).stable
    assert solve_rbe(half.with_capacity(glue)).verdict is Verdict.EQUILIBRIUM_EXISTS


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_the_verdict_does_not_depend_on_units(scale):
    for share, verdict in ((1.01, "stable"), (0.99, "unstable")):
        model = cantilever(share * critical_tension())
        assembly = model.assembly.transformed(scale * np.eye(3))
        scaled = Model.of(assembly, friction=0.6)
        forces = model.contacts.capacity
        cube = scale**3
        capacity = JointCapacity(forces.tension * cube, forces.cohesion * cube, brittle=False)
        assert check(scaled.with_capacity(capacity)).verdict == verdict


def crushing(model, strength, factor):
    """The model with joints of a strength, in an earthquake."""
    capacity = model.contacts.capacity
    both = replace(capacity, compression=strength * model.contacts.area)
    quake = LoadCase.seismic(model.assembly, 0.0, factor)
    return model.with_capacity(both).with_load(model.load + quake)


@pytest.mark.parametrize(("share", "verdict"), [(0.99, "stable"), (1.01, "undecided")])
def test_mortar_that_holds_is_pressed_linearly_up_to_the_strength(share, verdict):
    """At the foot W/A (1 + 3 k h/t) = f. Beyond it nobody knows how the rest is shared out."""
    factor = share * (2e5 / 35316.0 - 1.0) / 20.0
    found = check(crushing(wall(2e5), 2e5, factor))
    assert found.verdict == verdict
    if found.stable:
        assert found.message == "stands on its mortar, uncracked"
        assert found.joints()["strength_use"].max() == pytest.approx(
            (1.0 + 20.0 * factor) * 35316.0 / 2e5
        )
    else:
        assert "ductile mortar tells a bound from above" in found.message


@pytest.mark.parametrize(("share", "stands"), [(1.01, True), (0.99, False)])
def test_a_pier_crushes_below_an_arm_that_mortar_holds(share, stands):
    """The arm, 15 % of the pier, has moved the force by 46 mm: f = N / (b - 2 e)."""
    ground = box((-2.0, -2.0, -0.2), (2.0, 2.0, 0.0), "ground")
    pier = box((-0.2, -0.5, 0.0), (0.2, 0.5, 1.0), "pier")
    arm = box((0.2, -0.5, 0.8), (0.5, 0.5, 1.0), "arm")
    model = Model.of(Assembly((ground, pier, arm), [True, False, False]), friction=0.6)
    glued = model.contacts.block_b == 2
    weight = 9.81 * model.assembly.mass
    off = 0.35 * weight[2] / (weight[1] + weight[2])
    strength = share * (weight[1] + weight[2]) / (0.4 - 2.0 * off)
    mortar = JointCapacity.of_stress(
        model.contacts, tension=1e6 * glued, cohesion=1e6 * glued, compression=strength
    )
    found = check(model.with_capacity(mortar))
    assert (found.stable, found.falls) == (stands, not stands)
    if stands:
        assert found.strength_use.max() == pytest.approx(1.0 / share)
    else:
        assert "the joint of 'ground' and 'pier' crushes most" in found.message
