"""Local collapse mechanisms against hand calculations."""

import math
from pathlib import Path

import numpy as np
import pytest

import drystone
from drystone import Assembly, DrystoneError, InputError, JointCapacity, LoadCase, Model
from drystone.answer import Role
from drystone.cli import main
from drystone.geometry.frames import rotation_about
from drystone.models import arch, box
from drystone.report.sketches import answer_pictures
from drystone.seismic import LocalMechanism, SeismicDemand, Spectrum, local_mechanism

G = 9.81
BASE = box((20.0, 20.0, 1.0), (-10.0, -10.0, -1.0), "base")


def standing(*blocks: drystone.Block, friction: float = 0.8) -> Model:
    return Model.of(Assembly((BASE, *blocks)).with_fixed(["base"]), friction=friction)


def courses(count: int, thick: float = 0.5, high: float = 0.5) -> Model:
    """A wall of courses, 2 m long across x."""
    return standing(
        *(box((thick, 2.0, high), (0.0, 0.0, i * high), f"wall-{i}") for i in range(count))
    )


def loaded(model: Model, *loads: LoadCase) -> Model:
    return model.with_load(LoadCase.combine([(1.0, one) for one in (model.load, *loads)]))


def test_a_wall_of_courses_turns_about_its_edge_with_the_numbers_of_the_method() -> None:
    """alpha0 = b/h; one body, so that e* = 1 whatever its courses are."""
    found = local_mechanism(courses(6), part="wall-*")
    one, mass, share = found.oscillator, 6 * 0.5 * 2.0 * 0.5 * 2400.0, 1.0
    assert one.multiplier == pytest.approx(0.5 / 3.0)
    assert one.share == pytest.approx(share)
    assert one.mass == pytest.approx(share * mass)
    assert found.acceleration == pytest.approx(G * 0.5 / 3.0 / share)
    assert one.displacement == pytest.approx(0.25 / share)  # the centroid stands over the edge
    assert found.ultimate == pytest.approx(0.4 * 0.25 / share)
    period = 1.68 * math.pi * math.sqrt(found.ultimate / (found.acceleration * (1.0 - 0.4)))
    assert found.secant_period == pytest.approx(period)


@pytest.mark.parametrize("count", [1, 5])
def test_a_wall_is_the_same_oscillator_however_many_courses_it_has(count: int) -> None:
    model = courses(count, high=3.0 / count)
    for part in ("wall-*", ""):
        found = local_mechanism(model, part=part)
        assert found.oscillator.share == pytest.approx(1.0, abs=1e-3)
        assert found.acceleration == pytest.approx(G * 0.5 / 3.0, rel=2e-3)


@pytest.mark.parametrize("lean", [0.001, 4.0])
def test_a_tower_whose_bed_is_not_level_turns_about_the_edge_it_falls_over(lean: float) -> None:
    """tan(atan(b/h) - lean) towards the lean, + lean away from it, (b/h) cos(lean) across it."""
    turn = rotation_about((0.0, 1.0, 0.0), lean)
    base, tower = box((3.0, 3.0, 1.0), (-1.0, -1.0, -1.0), "base"), box((1.0, 1.0, 4.0), name="t")
    made = Assembly((base, tower), [True, False]).transformed(turn)
    model = Model.of(made, friction=0.9)
    slender, angle = math.atan(0.25), math.radians(lean)
    expected = {"x": math.tan(slender - angle), "-x": math.tan(slender + angle),
                "y": 0.25 * math.cos(angle)}  # fmt: skip
    for direction, alpha in expected.items():
        found = local_mechanism(model, part="t", direction=direction)
        assert found.oscillator.multiplier == pytest.approx(alpha, rel=1e-3)


@pytest.mark.parametrize(("bed", "wall"), [(0.6, 0.8), (0.9, 0.7)])
def test_a_wall_that_juts_out_turns_about_the_edge_on_which_it_lies(
    bed: float, wall: float
) -> None:
    """It juts out by 0.2 m: its centroid is wall/2 - 0.2 behind that edge, and 1.25 m above."""
    lower, upper = box((bed, 2.0, 1.0), name="a"), box((wall, 2.0, 2.5), (-0.2, 0.0, 1.0), "b")
    found = local_mechanism(standing(lower, upper), part="b", direction="-x")
    assert found.oscillator.multiplier == pytest.approx((wall / 2.0 - 0.2) / 1.25)


def test_a_facade_with_return_walls_turns_about_its_front_whatever_the_rounding_of_its_bed() -> (
    None
):
    """A hull of corners that differ by 1e-15 m had an edge across the wall: half of it."""
    parts = (
        ("front", 6.0, 0.6, 0.0, 0.0),
        ("left", 0.5, 1.5, 0.0, 0.6),
        ("right", 0.5, 1.5, 5.5, 0.6),
    )
    walls = [
        box((wide, deep, 1.0), (x, y, float(i)), f"{name}-{i}")
        for name, wide, deep, x, y in parts
        for i in range(5)
    ]
    ground = box((12.0, 12.0, 1.0), (-3.0, -3.0, -1.0), "ground")
    model = Model.of(Assembly((ground, *walls)).with_fixed(["ground"]), friction=0.6)
    found = local_mechanism(model, part="front-*,left-*,right-*", direction="-y")
    weight, arm = np.array([3.6, 0.75, 0.75]), np.array([0.3, 1.35, 1.35])
    assert found.oscillator.multiplier == pytest.approx(weight @ arm / weight.sum() / 2.5)


def test_stacks_side_by_side_overturn_as_far_as_one_of_them() -> None:
    one, other = (box((0.5, 1.0, 3.0), (0.0, y, 0.0), f"wall-{y}") for y in (0, 1))
    found = local_mechanism(standing(one, other))
    assert found.oscillator.displacement == pytest.approx(0.25, rel=0.02)


def test_the_mechanism_that_is_found_is_that_wall_and_is_followed_until_it_overturns() -> None:
    by_line, found = local_mechanism(courses(3), part="wall-*"), local_mechanism(courses(3))
    for name in ("multiplier", "share"):
        expected = getattr(by_line.oscillator, name)
        assert getattr(found.oscillator, name) == pytest.approx(expected, rel=1e-3)
    reach = by_line.oscillator.displacement
    assert found.oscillator.displacement == pytest.approx(reach, rel=0.02)
    assert "followed" in found.how
    assert found.table()["acceleration"].max() == pytest.approx(found.acceleration, rel=0.01)
    (shaken,) = (x for x in by_line.layers().stages[0].layers if x.key == "acceleration")
    blocks = by_line.model.assembly
    assert shaken.position == pytest.approx(blocks.centroid[blocks.free])  # on stone
    whole = by_line.oscillator.multiplier * by_line.oscillator.weight
    assert shaken.vector.sum(axis=0)[0] == pytest.approx(whole)


def test_what_slides_goes_as_far_as_what_pushes_it_and_is_not_lifted() -> None:
    """A wall turns and its top pushes a plate along a shelf: d = 1/2 and 1, friction or not."""
    shelf, wall = box((4, 2, 2.5), (2, 0, 0), "shelf"), box((0.5, 2, 3), (0, 0, 0), "wall")
    plate = box((3, 2, 0.5), (0.5, 0, 2.5), "plate", density=240.0)
    model = Model.of(
        Assembly((BASE, shelf, wall, plate)).with_fixed(["base", "shelf"]), friction=0.3
    )
    found = local_mechanism(model).oscillator
    weight = G * np.array([7200.0, 720.0])
    share = (weight @ [0.5, 1.0]) ** 2 / (weight.sum() * weight @ [0.25, 1.0])
    assert found.share == pytest.approx(share, rel=1e-3)
    crushes = JointCapacity.of_stress(model.contacts, compression=1e7)
    even = local_mechanism(model.with_capacity(crushes))
    assert even.oscillator.share == pytest.approx(1.0)
    assert "joints slide, and how" in even.remarks[-1]


def test_a_roof_holds_by_its_weight_pushes_by_its_thrust_and_shakes_if_asked() -> None:
    """W b/2 + N e = alpha (W h/2 [+ N h]) + H h, with the roof 0.1 m behind the outer edge."""
    model = courses(1, 0.4, 3.0)
    weight = 0.4 * 2.0 * 3.0 * 2400.0 * G
    roof, thrust = 20e3, 1e3
    at = (0.3, 1.0, 3.0)
    model = loaded(model, LoadCase.point_load(model.assembly, "wall-0", (thrust, 0.0, -roof), at))
    holds = weight * 0.2 + roof * 0.1 - thrust * 3.0
    for shaken, masses in ((False, weight * 1.5), (True, weight * 1.5 + roof * 3.0)):
        found = local_mechanism(model, part="wall-0", shaken=shaken)
        assert found.oscillator.multiplier == pytest.approx(holds / masses)
        assert found.moments is not None
        assert found.moments["holds"].sum() == pytest.approx(holds)
        assert found.moments["turns"].sum() == pytest.approx(masses)
    assert found.oscillator.masses["P"] == pytest.approx([weight, roof])
    assert found.oscillator.masses["d"] == pytest.approx([0.5, 1.0])
    every = {one.title: one for one in found.tables()}["weights that move"]
    assert every["P_d"][-1] == pytest.approx(weight / 2.0 + roof)
    assert next(answer_pictures(found)).caption == "Capacity curve"
    line, ends = [one for one in found.layers().stages[0].layers if one.group == "hinges"]
    assert line.position[0] == pytest.approx((0.4, 0.0, 0.0))
    assert ends.position == pytest.approx(np.array([(0.4, 0.0, 0.0), (0.4, 2.0, 0.0)]))
    moved = weight * 1.5 + roof * 3.0
    share = moved**2 / ((weight + roof) * (weight * 1.5**2 + roof * 3.0**2))
    assert found.oscillator.share == pytest.approx(share)


def test_a_roof_moves_with_the_top_of_the_wall_that_is_followed() -> None:
    """W (b/2 cos - h/2 sin) + N (e cos - h sin) = 0 at the angle to which it stands."""
    model = courses(1, 0.4, 3.0)
    weight, roof = 0.4 * 2.0 * 3.0 * 2400.0 * G, 20e3
    load = LoadCase.point_load(model.assembly, "wall-0", (0.0, 0.0, -roof), (0.3, 1.0, 3.0))
    found = local_mechanism(loaded(model, load)).oscillator
    angle = math.atan((weight * 0.2 + roof * 0.1) / (weight * 1.5 + roof * 3.0))
    away = 0.2 - 0.2 * math.cos(angle) + 1.5 * math.sin(angle)
    assert found.displacement == pytest.approx(away, rel=0.012)


def test_a_roof_off_its_wall_acts_at_the_height_that_was_given() -> None:
    """W (b/2 cos - h/2 sin) + N (e cos - h sin) = 0; no line through N meets the wall."""
    model = courses(1, 0.4, 3.0)
    weight, roof = 0.4 * 2.0 * 3.0 * 2400.0 * G, 20e3
    load = LoadCase.point_load(model.assembly, "wall-0", (0.0, 0.0, -roof), (-0.1, 1.0, 3.0))
    found = local_mechanism(loaded(model, load), part="wall-0").oscillator
    angle = math.atan((weight * 0.2 + roof * 0.5) / (weight * 1.5 + roof * 3.0))
    away = 0.2 - 0.2 * math.cos(angle) + 1.5 * math.sin(angle)
    assert found.displacement == pytest.approx(away, rel=1e-6)


def test_a_roof_on_a_wall_and_a_load_off_it_are_followed_together() -> None:
    """One took the place of the other's arms, which then stayed as they were."""
    model = courses(1, 0.4, 3.0)
    weight, roof, off = 0.4 * 2.0 * 3.0 * 2400.0 * G, 20e3, 30e3
    load = LoadCase.point_load(model.assembly, "wall-0", (0.0, 0.0, -roof), (0.3, 1.0, 3.0))
    load += LoadCase.point_load(model.assembly, "wall-0", (0.0, 0.0, -off), (-0.1, 1.0, 3.0))
    found = local_mechanism(loaded(model, load)).oscillator
    holds = weight * 0.2 + roof * 0.1 + off * 0.5
    angle = math.atan(holds / (weight * 1.5 + (roof + off) * 3.0))
    away = 0.2 - 0.2 * math.cos(angle) + 1.5 * math.sin(angle)
    assert found.displacement == pytest.approx(away, rel=0.012)


def test_a_tie_holds_with_its_strength() -> None:
    """W b/2 + T z = alpha W h/2."""
    weight = 0.4 * 2.0 * 3.0 * 2400.0 * G
    model = courses(1, 0.4, 3.0)
    tie = "wall-0@0,1,2.8:base@-3,1,2.8:15kN"
    found = local_mechanism(model, part="wall-0", tie=tie)
    expected = (weight * 0.2 + 15e3 * 2.8) / (weight * 1.5)
    either = local_mechanism(model, part="wall-0", tie="base@-3,1,2.8:wall-0@0,1,2.8:15kN")
    assert either.oscillator.multiplier == pytest.approx(expected)
    assert found.oscillator.multiplier == pytest.approx(expected)
    layers = found.layers().stages[0].layers
    drawn = {one.key: one.vector for one in layers}
    assert "loads" not in drawn  # the tie is no load: it is drawn from the base to the wall
    assert drawn["tie-forces"][0, 0] > 0.0 == pytest.approx(drawn["tie-forces"][0, 1:])
    assert "tie, yields at 15 kN" in [one.label for one in layers]
    asked = found.asked.facts()
    assert (asked["Load"], asked["Ties"]) == ("gravity", "wall-0:base 15 kN")
    assert drawn["acceleration"][0].tolist() == pytest.approx([expected * weight, 0.0, 0.0])


def test_how_far_a_tie_is_drawn_out_at_the_ultimate_displacement_is_told() -> None:
    """Mean and tie move by b - b cos(t) + z sin(t), with b = 0.2 and 0.4 m, z = 1.5 and 2.8 m."""
    ties = [f"wall-0@0,1,{z}:base@-3,1,{z}:15kN" for z in (1.0, 2.8)]
    found = local_mechanism(courses(1, 0.4, 3.0), part="wall-0", tie=ties)
    turned = np.linspace(0.0, 0.5, 10001)
    mean, tie = (b - b * np.cos(turned) + z * np.sin(turned) for b, z in ((0.2, 1.5), (0.4, 2.8)))
    far = np.interp(found.ultimate, mean, tie)
    (said,) = [one for one in found.sentences() if "drawn out" in one.text]
    assert said.role is Role.REMARK
    assert f"at du* the tie wall-0 is drawn out by {far:.2g} m" in said.text
    bare = local_mechanism(courses(1, 0.4, 3.0), part="wall-0")
    assert not any("drawn out" in one.text for one in bare.sentences())


@pytest.mark.parametrize("shape", ["L", "T"])
def test_a_facade_that_takes_a_return_wall_along_turns_later(shape: str) -> None:
    """Moments about the outer edge of the facade, 0.4 m thick; the return is 1.2 m long."""
    along = 0.0 if shape == "L" else 1.8
    facade = box((0.4, 4.0, 3.0), (0.0, 0.0, 0.0), "facade")
    side = box((1.2, 0.4, 3.0), (-1.2, along, 0.0), "side")
    found = local_mechanism(standing(facade, side), part="facade,side")
    one, other = 0.4 * 4.0, 1.2 * 0.4
    expected = (one * 0.2 + other * (0.4 + 0.6)) / ((one + other) * 1.5)
    assert found.oscillator.multiplier == pytest.approx(expected)
    assert found.oscillator.share == pytest.approx(1.0)


def test_a_corner_turns_about_a_line_across_the_diagonal() -> None:
    """A square pier of 1 m and 4 m about its corner: half the diagonal by half the height."""
    pier = standing(box((1.0, 1.0, 4.0), (0.0, 0.0, 0.0), "pier"))
    by_default = local_mechanism(pier, part="pier", direction=(1.0, 1.0, 0.0))
    by_hand = local_mechanism(
        pier, part="pier", direction=(1.0, 1.0, 0.0), line=(0.0, 2.0, 0.0, 2.0, 0.0, 0.0)
    )
    for found in (by_default, by_hand):
        assert found.oscillator.multiplier == pytest.approx(math.sqrt(0.5) / 2.0)


@pytest.mark.parametrize("aside", [0.1, -1.0])
def test_a_long_wall_that_is_pushed_aside_turns_about_its_long_edge(aside: float) -> None:
    """b/h by the cosine between the direction and the normal of the edge."""
    wall = standing(box((6.0, 0.6, 5.0), (0.0, 0.0, 0.0), "wall"))
    found = local_mechanism(wall, part="wall", direction=(aside, 1.0, 0.0))
    cosine = 1.0 / math.hypot(aside, 1.0)
    assert found.oscillator.multiplier == pytest.approx(0.6 / 5.0 / cosine)
    assert found.oscillator.displacement == pytest.approx(0.3 * cosine)
    (told,) = found.remarks
    assert told == "the part turns about the edge of its foot from 6, 0.6, 0 to 0, 0.6, 0"


def test_what_turns_sooner_within_a_part_is_told() -> None:
    """A parapet at 0.2 / 2; both at (24 0.3 + 8 0.1) / (24 1 + 8 3). A tie without end holds it."""
    parapet = box((0.2, 2, 2), (0.4, 0, 2), "parapet")
    model = standing(box((0.6, 2, 2), (0, 0, 0), "wall"), parapet)
    found = local_mechanism(model, part="wall,parapet")
    assert found.oscillator.multiplier == pytest.approx(1.0 / 6.0)
    assert found.remarks == ("what is above 2 m turns sooner, at 0.1 g: parapet",)
    tied = local_mechanism(model, part="wall,parapet", tie="wall@0.1,1,1:parapet@0.5,1,3")
    assert not tied.remarks
    assert not local_mechanism(arch(0.2, 9), part="voussoir-*").remarks  # its joints are no beds


@pytest.mark.parametrize(
    ("side", "direction", "told"),
    [
        ((0.5, 2.5, 5.0), (-1, -1, 0), ["what upright joints part turns sooner, at 0.1414 g: x"]),
        ((3.0, 0.5, 1.0), (0, 1, 0), []),  # x alone at 0.1 g would enter y
        ((3.0, 0.5, 5.0), (0, -1, 0), ["what upright joints part turns sooner, at 0.1 g: x"]),
    ],
)
def test_a_leg_of_a_part_without_bond_that_turns_sooner_is_told(
    side: tuple[float, float, float], direction: tuple[int, int, int], told: list[str]
) -> None:
    """By hand (0.5 / 5) sqrt(2) about the long edge, and 0.5 / 5."""
    wall = box((3.0, 0.5, 5.0), (0.0, 0.0, 0.0), "x"), box(side, (0.0, 0.5, 0.0), "y")
    found = local_mechanism(standing(*wall), part="x,y", direction=direction)
    assert list(found.remarks[:1]) == told
    assert ["leave out --part" in one for one in found.remarks[1:]] == [True] * len(told)


def test_what_is_behind_an_oblique_line_is_so_along_the_earthquake() -> None:
    """The line x = 0.4 + (y - 1)/2 about a wall whose middle is at x = 0.2, y = 1."""
    line = (-0.1, 0.0, 0.0, 0.9, 2.0, 0.0)
    found = local_mechanism(courses(1, 0.4, 3.0), part="wall-0", line=line)
    assert found.moments is not None
    assert found.moments["behind"] == pytest.approx(0.2)
    assert found.oscillator.multiplier == pytest.approx(0.2 / 1.5)


def test_a_line_within_the_bed_turns_a_part_sooner_and_is_told() -> None:
    """The wall of 0.5 x 3 m about a line 0.1 m behind its edge: 0.15 / 1.5."""
    found = local_mechanism(courses(6), part="wall-*", line=(0.4, 0, 0, 0.4, 1, 0))
    assert found.oscillator.multiplier == pytest.approx(0.1)
    assert "the line lies 0.1 m behind the part's edge" in found.remarks


def test_a_line_above_the_foot_of_a_part_names_the_blocks_that_are_above_it() -> None:
    with pytest.raises(InputError, match=r"above it alone: wall-4, wall-5 \(--part\)"):
        local_mechanism(courses(6), part="wall-*", line=(0.5, 0, 2, 0.5, 1, 2))


@pytest.mark.parametrize(
    ("part", "message"),
    [
        ("wall-0,wall-1", "leaves out what stands on it alone: wall-2, wall-3; name it too"),
        ("wall-0,wall-2,wall-3", "is 2 pieces that do not touch: of wall-0, wall-2; name what is"),
    ],
)
def test_a_part_is_one_piece_with_all_that_stands_on_it(part: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        local_mechanism(courses(4), part=part)


def test_a_beam_that_rests_on_the_part_and_beside_it_is_told() -> None:
    walls = (box((0.5, 2.0, 3.0), (x, 0.0, 0.0), f"wall-{x}") for x in (0, 3))
    both = standing(*walls, box((3.5, 0.5, 0.2), (0.0, 0.5, 3.0), "beam"))
    found = local_mechanism(both, part="wall-3")
    assert found.oscillator.multiplier == pytest.approx(0.5 / 3.0)
    (told,) = found.remarks
    assert told.startswith("what beam lays on the part is not counted")


def test_spectra_are_those_of_the_codes() -> None:
    ec8 = Spectrum.ec8(0.25 * G, "C")
    assert ec8.acceleration(0.0) == pytest.approx(0.25 * G * 1.15)
    assert ec8.acceleration(0.4) == pytest.approx(0.25 * G * 1.15 * 2.5)
    assert ec8.acceleration(1.2) == pytest.approx(0.25 * G * 1.15 * 2.5 * 0.5)
    assert ec8.acceleration(4.0) == pytest.approx(0.25 * G * 1.15 * 2.5 * 0.6 * 2.0 / 16.0)
    ntc = Spectrum.ntc(0.2 * G, 2.4, 0.3, "C", 1.2)
    assert ntc.soil == pytest.approx((1.7 - 0.6 * 2.4 * 0.2) * 1.2)
    corner = 1.05 * 0.3**-0.33 * 0.3
    periods = (ntc.corner_b, ntc.corner_c, ntc.corner_d)
    assert periods == pytest.approx((corner / 3.0, corner, 2.4))
    assert Spectrum.ntc(0.5 * G, 2.5, 0.3, "C").soil == 1.0  # the least


def site(folder: Path, *lines: str) -> Path:
    path = folder / "site.toml"
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def verified(folder: Path, ag: float, *more: str) -> LocalMechanism:
    path = site(folder, 'code = "ec8"', f'ag = "{ag}g"', 'soil = "A"', *more)
    return local_mechanism(courses(1, 0.5, 3.0), part="wall-0", site=SeismicDemand.named(path))


OLD = 'edition = "2009"'


def test_the_site_is_told_as_its_file_says_it(tmp_path: Path) -> None:
    lines = ('code = "ntc"', 'ag = "0.2g"', 'soil = "B"', "F0 = 2.4", "TC_star = 0.33")
    demand = SeismicDemand.named(site(tmp_path, *lines))
    told = demand.table()
    said = dict(zip(told["of"], told["value"], strict=True))
    assert (said["code"], said["soil"], said["TC_star"]) == ("ntc", "B", "0.33")
    assert (said["site file"], len(said["SHA-256 begins"])) == ("site.toml", 32)
    assert said["limit state"] == "SLV, Circolare of 2019, as no edition is given"


@pytest.mark.parametrize(
    ("part", "lines", "said"),
    [
        ("wall-2", (), True),
        ("wall-*", (), False),
        ("wall-2", ("T1 = 0.4", "psi = 0.6", "gamma = 1.2"), False),
    ],
)
def test_a_part_above_the_ground_asks_for_the_demand_of_its_storey(tmp_path, part, lines, said):
    path = site(tmp_path, 'code = "ec8"', 'ag = "0.1g"', 'soil = "A"', *lines)
    found = local_mechanism(courses(3), part=part, site=SeismicDemand.named(path))
    told = " ".join(one.text for one in found.sentences())
    assert ("turns 1 m above the ground" in told) == said


def test_the_linear_verification_compares_a0_with_ag_s_by_q(tmp_path: Path) -> None:
    """Alpha0 g = g/6 against ag/2: the threshold is ag = g/3, and g/3/1.35 with a factor FC."""
    for more, limit in (((), 1.0 / 3.0), (("confidence = 1.35",), 1.0 / 3.0 / 1.35)):
        assert verified(tmp_path, 0.999 * limit, OLD, *more).fulfils("linear")
        assert not verified(tmp_path, 1.001 * limit, OLD, *more).fulfils("linear")


def test_the_nonlinear_verification_compares_displacements(tmp_path: Path) -> None:
    """D0* = 0.25 m: du* = 0.1 m, ds* = 0.04 m, as* = 0.84 g/6; Ts = 1.07 s is between TC and TD."""
    found = verified(tmp_path, 0.3, OLD)
    level = 0.84 * G / 6.0
    period = 2.0 * math.pi * math.sqrt(0.04 / level)
    asked = 0.3 * G * 2.5 * 0.4 / period * (period / 2.0 / math.pi) ** 2
    (row,) = [one for one in found.verifications if one[0] == "non-linear"]
    assert row[2:4] == pytest.approx((asked, 0.1))
    limit = 0.3 * 0.1 / asked
    assert verified(tmp_path, 0.999 * limit, OLD).fulfils("non-linear")
    assert not verified(tmp_path, 1.001 * limit, OLD).fulfils("non-linear")
    above = verified(tmp_path, 0.3, OLD, "T1 = 0.3", "psi = 0.8", "gamma = 1.2")
    asked = [one[2] for one in above.verifications]
    assert asked[1] == pytest.approx(0.3 * G * 2.5 * 0.8 * 1.2 / 2.0)
    ratio = period / 0.3
    grown = ratio**2 / math.sqrt((1.0 - ratio) ** 2 + 0.02 * ratio)
    ground = 0.3 * G * 2.5 * (0.3 / 2.0 / math.pi) ** 2
    assert asked[3] == pytest.approx(ground * 0.8 * 1.2 * grown)


def test_the_edition_of_2019_takes_the_displacement_at_the_ultimate_state(tmp_path: Path) -> None:
    """D0* = 0.25 m, a0* = g/6/FC: T = 1.68 pi (0.1/0.6 a0)^0.5 with 8 %; SLC 0.15 m with 10 %."""
    rows = (("SLV", 0.4, 1.68, 8.0), ("SLC", 0.6, 1.56, 10.0))
    for state, share, factor, damping in rows:
        asked = 'edition = "2019"', f'state = "{state}"', 'confidence = "LC2"'
        found = verified(tmp_path, 0.3, *asked)
        reached = 0.25 * share
        period = factor * math.pi * math.sqrt(reached / ((1.0 - share) * G / 6.0 / 1.2))
        assert (found.ultimate, found.secant_period) == pytest.approx((reached, period))
        eta = math.sqrt(10.0 / (5.0 + damping))
        (row,) = [one for one in found.verifications if one[0] == "non-linear"]
        level = 0.3 * G * eta * 2.5 * 0.4 / period * min(2.0 / period, 1.0)
        asked_for = level * (period / 2.0 / math.pi) ** 2
        assert row[2] == pytest.approx(asked_for)
        drawn = found.chart().marks[-1]
        assert drawn.label == f"elastic spectrum, {damping:g} %"
        assert max(drawn.y) == pytest.approx(0.3 * G * eta * 2.5)
    assert {one[0] for one in found.verifications} == {"non-linear"}  # SLC has no q
    new = verified(tmp_path, 0.1)  # the edition in force is that where none is given
    assert (new.confidence, new.state.edition) == (1.35, "2019")
    damage = verified(tmp_path, 0.1, 'edition = "2019"', 'state = "SLD"')
    assert [one[0] for one in damage.verifications] == ["linear"]
    assert math.isnan(damage.ultimate)
    assert not any("0 d0*" in text for text in damage.tables()[0]["from"])


def test_a_storey_amplifies_by_the_edition_of_2019(tmp_path: Path) -> None:
    """Se(T1) psi gamma (1 + 0.0004 25)^0.5; at T1 it grows by 1.1 0.05^-0.5 eta."""
    found = verified(
        tmp_path, 0.1, 'edition = "2019"', "T1 = 0.3", "psi = 0.8", "gamma = 1.2"
    )  # fmt: skip
    site = found.site
    assert site is not None
    storey = 0.1 * G * 2.5 * 0.96 * math.sqrt(1.01)
    assert site.accelerations()["aZ(z) / q"] == pytest.approx(storey / 2.0)
    most = 1.1 / math.sqrt(0.05) * math.sqrt(10.0 / 13.0)
    name = "SeZ(Ts) (Ts / 2 pi)^2"
    for period, less in ((0.12, 0.5**1.6), (0.3, 0.0)):
        level = most * storey / (1.0 + (most - 1.0) * less)
        asked = level * (period / 2.0 / math.pi) ** 2
        assert site.displacements(period)[name] == pytest.approx(asked)
    least = most * storey * (0.33 / 2.0 / math.pi) ** 2
    assert site.displacements(0.4)[name] == pytest.approx(least)
    far = site.displacements(1.5)
    assert far[name] >= far["SDe(Ts)"]


@pytest.mark.parametrize("pull", [3e3, 15e3])
def test_ties_hold_the_mechanism_that_is_found_too(pull: float) -> None:
    """W b/2 + T z = alpha W h/2; followed, it falls where the weight holds as much less."""
    weight = 0.4 * 2.0 * 3.0 * 2400.0 * G
    tie = f"wall-0@0,1,2.8:base@-3,1,2.8:{pull}N"
    found = local_mechanism(courses(1, 0.4, 3.0), tie=tie)
    expected = (weight * 0.2 + pull * 2.8) / (weight * 1.5)
    assert found.oscillator.multiplier == pytest.approx(expected, rel=1e-3)
    by_hand = local_mechanism(courses(1, 0.4, 3.0), part="wall-0", tie=tie).oscillator
    assert found.oscillator.displacement == pytest.approx(by_hand.displacement, rel=0.02)


def test_a_tie_that_goes_slack_and_one_within_the_part_hold_nothing() -> None:
    for tie in ("wall-0@0.4,1,2.8:base@3,1,2.8:15kN", "wall-0@0,1,0.1:wall-1@0,1,2.9:15kN"):
        found = local_mechanism(courses(2, 0.4, 1.5), part="wall-*", tie=tie)
        assert found.oscillator.multiplier == pytest.approx(0.4 / 3.0)


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"direction": "z"}, "is not level"),
        ({"direction": (-1.0, -1.0, 1.0)}, "direction: is not level; give x, y or X,Y,0"),
        ({"part": "base"}, "has no free block"),
        ({"part": "walls"}, "part"),
        ({"part": "wall-0", "line": (0, 0, 0, 1, 0, 0)}, "nothing overturns"),
        ({"part": "wall-0", "line": (0, 0, 0)}, "has 3 numbers"),
        ({"part": "wall-0", "line": (0, 0, 0, 0, 1, 0.5)}, "is not level"),
        ({"part": "wall-0", "line": (0.5, 0, 0.2, 0.5, 1, 0.2)}, "0.2 m above .*; give z = 0$"),
        ({"part": "wall-0", "line": (0.5, 0, 0.5, 0.5, 1, 0.5)}, "0.5 m above"),
        ({"part": "wall-0", "line": (0.5, 0, -0.1, 0.5, 1, -0.1)}, "0.1 m below"),
        ({"part": "wall-0", "line": (0.6, 0, 0, 0.6, 1, 0)}, "beside .*; give one through 0.5, "),
        ({"part": "wall-0", "line": (-0.1, 0, 0, -0.1, 1, 0)}, "0.1 m beside"),
        ({"part": "wall-0", "tie": "wall-0:base@-3,0,1:15"}, "not a number with a unit"),
        ({"part": "wall-0", "tie": "wall-0:base@-3,0,1"}, "the tie of 'wall-0' has no strength"),
        ({"line": (0, 0, 0, 0, 1, 0)}, "is for a part"),
    ],
)
def test_what_cannot_turn_is_refused(asked: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        local_mechanism(courses(1), **asked)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('code = "ec8"\nag = 0.15\nsoil = "A"', "ag: has no unit"),
        ('code = "ec8"\nag = "0.15m"\nsoil = "A"', "unit 'm' is not known"),
        ('code = "ec8"\nag = "0.15g"\nsoil = "F"', "soil is 'F'"),
        ('code = "ec8"\nag = "0.15g"\nsoil = "A"\ntype = 3', "type is '3'"),
        ('code = "uni"', "code: is 'uni'"),
        ('code = "ntc"\nag = "0.15g"\nsoil = "A"', "'F0' is missing"),
        ('code = "ec8"\nag = "0.15g"\nsoil = "A"\nq = 0.5', "q: is 0.5"),
        ('code = "ec8"\nag = "0.15g"\nsoil = "A"\nconfidence = 1e308', "confidence: is 1e"),
        (
            'code = "ec8"\nag = "0.15g"\nsoil = "A"\nT1 = 1e-300\npsi = 1\ngamma = 1',
            "T1: is 1e-300",
        ),
        ('code = "ec8"\nag = "0.15g"\nsoil = "A"\nT1 = 0.5', "has T1, not all"),
        ('code = "ec8"\nag = "0.15g"\nsoil = "A"\nedition = "2014"', "edition is '2014'"),
        (
            'code = "ec8"\nag = "0.15g"\nsoil = "A"\nedition = "2009"\nstate = "SLC"',
            "state is 'SLC'",
        ),
        ('code = "ec8"\nag = "0.15g"\nsoil = "A"\nconfidence = "LC4"', "level is 'LC4'"),
        ('code = "ec8"\nag = "0.15g"\nsoil = "A"\nstate = "SLD"\nq = 2', "SLD counts no q"),
    ],
)
def test_a_site_that_is_not_known_is_refused_in_one_line(
    text: str, message: str, tmp_path: Path
) -> None:
    with pytest.raises(DrystoneError, match=message):
        SeismicDemand.named(site(tmp_path, text))


def test_the_command_compares_a_wall_with_a_spectrum(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    drystone.write(courses(2).assembly, tmp_path / "wall.json")
    path = site(tmp_path, 'code = "ec8"', 'ag = "0.2g"', 'soil = "A"')
    told = ["kinematic", str(tmp_path / "wall.json"), "--part", "wall-*", "--site", str(path)]
    assert main(told) == 0
    assert "verification linear fulfilled, non-linear fulfilled" in capsys.readouterr().out


def test_a_mechanism_begins_no_later_than_the_stone_allows() -> None:
    """A block b wide, h high: M = N b/2 (1 - N / (f b)) crushes its foot, M = alpha N h/2."""
    blocks = (box((4, 4, 1), (-2, -2, -1), "base"), box((0.5, 1.0, 3.0), (0, 0, 0), "wall"))
    dry = drystone.Model.of(drystone.Assembly(blocks).with_fixed(["base"]), friction=0.9)
    weight = 9.81 * dry.assembly.mass[1]
    strong = JointCapacity.of_stress(dry.contacts, compression=2.0 * weight / 0.5)
    wall = dry.with_capacity(strong)
    found = local_mechanism(wall, direction="x")
    assert found.oscillator.multiplier == pytest.approx(0.5 / 3.0 * 0.5, rel=5e-3)
    assert not len(found.displacement)
    with pytest.raises(InputError, match="do not crush"):
        local_mechanism(wall, direction="x", part="wall")
