"""An earthquake shakes blocks, fill and masses in kg, in every command; forces where it is told."""

import json
from dataclasses import replace
from html import unescape
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import drystone
from drystone import Assembly, LoadCase, Model, check, limit_load, limit_tilt
from drystone.io.opening import as_model
from drystone.loads import Fill
from drystone.loads.applied import Shaken, common_acceleration, with_shaken_weights
from drystone.models import box, segmental_bridge, tower
from drystone.report import write_report
from drystone.seismic import local_mechanism
from drystone.settlement import push
from drystone.studies import combinations

G, UNIT = 9.81, 2400.0 * 9.81
FILL = "cover=2m,weight=20kN/m3"
BLOCKS, FILLED, MASS = 3.0 * UNIT, 40e3, 3000.0 * G
"""Weights [N] of a pier 1 m by 1 m by 3 m, of fill 2 m deep on it, and of a mass."""
TOP = "pier:3000kg@0.5,0.5,3.0"


@pytest.fixture(scope="module")
def pier() -> Assembly:
    """It overturns about an edge at x = 1 m."""
    base = box((20.0, 20.0, 1.0), (-10.0, -10.0, -1.0), "base")
    return Assembly((base, box((1.0, 1.0, 3.0), name="pier"))).with_fixed(["base"])


def overturns(*weights: tuple[float, float]) -> float:
    """The share of g: weights [N] at heights [m] whose middle is 0.5 m behind the edge."""
    return 0.5 * sum(w for w, _ in weights) / sum(w * h for w, h in weights)


def told_of(assembly: Assembly, load: LoadCase) -> str:
    shaken = Shaken.of(assembly, load)
    return "" if shaken is None else shaken.words


CASES: dict[str, tuple[Any, float]] = {
    "fill": (f"fill:{FILL}", overturns((BLOCKS, 1.5), (FILLED, 4.0))),
    "a mass": (TOP, overturns((BLOCKS, 1.5), (MASS, 3.0))),
    "both": ([f"fill:{FILL}", TOP], overturns((BLOCKS, 1.5), (FILLED, 4.0), (MASS, 3.0))),
}


@pytest.mark.parametrize("name", CASES)
def test_masses_are_shaken_at_their_places_by_every_command(pier: Assembly, name: str) -> None:
    load, alpha = CASES[name]
    model = Model.of(pier, friction=0.9)
    for share, stands in ((0.999, True), (1.001, False)):
        asked = check(model, load=load, seismic=share * alpha)
        assert asked.stable is stands
        assert asked.falls is not stands
    found = limit_load(model, "seismic:1,0", load=load)
    assert found.best.value == pytest.approx(alpha, rel=1e-3)
    assert found.quantity.remark == told_of(pier, found.model.load)
    of_masses = limit_load(model, (G, 0.0, 0.0), load=load)
    assert of_masses.best.value == pytest.approx(alpha, rel=1e-3)
    turned = limit_tilt(model, "y", load=load)
    assert turned.best.value == pytest.approx(np.degrees(np.arctan(alpha)), abs=0.03)
    for part in ("", "pier"):
        mechanism = local_mechanism(model, part=part, load=load)
        assert mechanism.oscillator.multiplier == pytest.approx(alpha, rel=1e-3)
        assert mechanism.oscillator.weight == pytest.approx(
            BLOCKS + (FILLED if "fill" in str(load) else 0.0) + (MASS if TOP in load else 0.0)
        )
    assert push(model, LoadCase.seismic(pier, 1.0), load=load).peak == (
        pytest.approx(alpha, rel=2e-3)
    )
    assert push(model, load=load).peak == pytest.approx(alpha, rel=2e-3)


def test_masses_weigh_and_are_shaken_by_the_gravity_that_is_given(pier: Assembly) -> None:
    """Blocks, fill and a mass of so many kg weigh by 1.62 m/s2; a roof of 8 kN weighs 8 kN."""
    moon, fill, roof = 1.62, 2000.0, "pier:8kN@0.5,0.5,3"
    words = [f"fill:cover=2m,weight={fill:g}kg/m3", TOP, roof]
    blocks, filled, mass = BLOCKS * moon / G, 2.0 * fill * moon, 3000.0 * moon
    model = Model.of(pier, friction=0.9)
    found = check(model, load=words, gravity=moon)
    assert found.reactions()["force"][0, 2] == pytest.approx(blocks + filled + mass + 8e3)
    share = overturns((blocks, 1.5), (filled, 4.0), (mass, 3.0), (8e3, 3.0)) * moon / G
    for factor, stands in ((0.999, True), (1.001, False)):
        asked = check(model, load=words, gravity=moon, seismic=factor * share, shaken=True)
        assert asked.stable is stands
    for ground in (f"fill:{FILL}", "earth:side=-x,weight=18kN/m3,k=0.3"):
        with pytest.raises(drystone.DrystoneError, match="gravity is turned"):
            check(model, load=ground, gravity="0,0,9.81")


def test_the_sum_of_cases_shakes_the_masses_of_all_of_them_in_any_order(pier: Assembly) -> None:
    dead, quake = LoadCase.gravity(pier), LoadCase.seismic(pier, 0.1, 0.05)
    fill, mass = Fill.named(FILL).on(pier), LoadCase.extra_mass(pier, "pier", 100.0, (0.5, 0.5, 3))
    force = LoadCase.point_load(pier, "pier", (0.0, 0.0, -5e3))
    total = dead + fill + mass + quake + force
    at_once = LoadCase.combine([(1.0, one) for one in (force, quake, fill, mass, dead)])
    for one in (quake + mass + dead + fill + force, dead + (mass + quake) + force + fill, at_once):
        assert one.wrench == pytest.approx(total.wrench)
    expected = 0.1 * (BLOCKS + FILLED + 100.0 * G)
    assert total.wrench[1, 0] == pytest.approx(expected)
    assert total.wrench[1, 4] == pytest.approx(0.1 * (FILLED * 2.5 + 100.0 * G * 1.5))
    assert (1.5 * total).wrench == pytest.approx(1.5 * total.wrench)
    back = total.turned(np.eye(3))
    assert back.wrench == pytest.approx(total.wrench)
    half = dead + 0.5 * mass + 2.0 * quake
    assert half.wrench[1, 0] == pytest.approx(0.2 * (BLOCKS + 50.0 * G))


@pytest.mark.parametrize("share", [0.5, 0.85, 1.0, 1.15, 2.0])
def test_a_roof_that_weighs_as_its_block_is_shaken_too(share: float) -> None:
    """From 0.8 to 1.2 it was taken for the weight of the block, and only this was shaken."""
    wall = Assembly([box((4.0, 0.5, 1.0), (0.0, 0.0, i), f"w{i}") for i in range(3)])
    wall = wall.with_fixed(["w0"])
    roof = share * 9.81 * float(wall.mass[2])
    found = check(wall, load=f"w2:{roof:.6f}N@2,0.25,3", seismic=(0.0, 0.01), shaken=True)
    assert [float(one.mass.sum()) for one in found.load.masses] == pytest.approx([roof / 9.81])


def test_reactions_are_those_of_all_masses_and_the_answer_says_what_is_not_shaken(
    pier: Assembly,
) -> None:
    model = Model.of(pier, friction=0.9)
    words = [f"fill:{FILL}", TOP, "pier:8kN@0.5,0.5,3"]
    still = "the earthquake shakes 140 kN: 70.6 kN of blocks, 40 kN of fill and 29.4 kN of masses "
    still += "in kg; 8 kN of forces are not (--shaken)"
    found = check(model, load=words, seismic=(0.05, 0.02))
    shaken = BLOCKS + FILLED + MASS
    assert found.reactions()["force"][0, :2] == pytest.approx([-0.05 * shaken, -0.02 * shaken])
    assert found.model.notes[-1] == still
    assert found.asked.facts()["Earthquake"] == still
    table = found.loads()
    told = [
        "earthquake",
        "0, 0, -8000 N on 'pier' at 0.5, 0.5, 3 m",
        "fill of 4.08 t",
        "mass of 3 t",
    ]
    assert table["load"].tolist() == told
    assert table["force"][0] == pytest.approx([0.05 * shaken, 0.02 * shaken, 0.0])
    assert table["point"][0] == pytest.approx(
        [0.5, 0.5, (1.5 * BLOCKS + 4.0 * FILLED + 3.0 * MASS) / shaken]
    )
    assert table["moment"][0] == pytest.approx([0.0, 0.0, 0.0])
    assert table["force"][1:, 2] == pytest.approx([-8e3, -FILLED, -MASS])
    (drawn,) = [x for x in found.layers().stages[0].layers if x.key == "acceleration"]
    assert drawn.vector == pytest.approx(table["force"][:1])
    assert drawn.position == pytest.approx(table["point"][:1])
    told = found.to_dict()["asked"]["earthquake"]
    assert told["weights"]["fill"] == pytest.approx(FILLED)
    assert told["force"] == pytest.approx(table["force"][0])
    every = check(model, load=words, seismic=(0.05, 0.02), shaken=True)
    assert every.reactions()["force"][0, 0] == pytest.approx(-0.05 * (shaken + 8e3))
    assert every.model.notes[-1].endswith("29.4 kN of masses in kg and 8 kN of loads")


def test_forces_are_shaken_where_it_is_told_once_and_masses_once_only(pier: Assembly) -> None:
    roof = LoadCase.point_load(pier, "pier", (2e3, 0.0, -981.0), (0.5, 0.5, 3.0))
    quake = LoadCase.seismic(pier, 0.1)
    total = LoadCase.gravity(pier) + roof + quake
    once = with_shaken_weights(pier, total)
    assert once.wrench[1, 0] == pytest.approx(total.wrench[1, 0] + 98.1)
    assert with_shaken_weights(pier, once).wrench == pytest.approx(once.wrench)
    before = with_shaken_weights(pier, roof) + LoadCase.gravity(pier) + quake
    assert before.wrench == pytest.approx(once.wrench)
    assert with_shaken_weights(pier, quake) is quake


def test_push_of_a_model_tells_what_is_shaken(pier: Assembly) -> None:
    found = push(pier, LoadCase.seismic(pier, 1.0), friction=0.9, load=TOP)
    assert found.asked.notes[-1].startswith("the earthquake shakes 100 kN: 70.6 kN of blocks and")


def test_a_file_keeps_masses_and_subsets_have_theirs(tmp_path: Path) -> None:
    assembly = tower(3)
    load = LoadCase.gravity(assembly) + LoadCase.extra_mass(assembly, 2, 50.0, (0.2, 0.0, 3.0))
    load = load + LoadCase.surface_load(assembly, 1, 100.0) + LoadCase.seismic(assembly, 0.01)
    model = replace(Model.of(assembly, load=load), cases=(load,))
    drystone.write(check(model), tmp_path / "tower.json")
    read = drystone.read(tmp_path / "tower.json")
    assert read.load.wrench.tobytes() == load.wrench.tobytes()
    assert read.load.shake == pytest.approx(load.shake)
    assert vars(read.load.masses[0]).keys() == vars(load.masses[0]).keys()
    assert read.load.masses[0].moment == pytest.approx(load.masses[0].moment)
    more = read.load + LoadCase.seismic(assembly, 0.01)
    assert more.wrench[2, 0] == pytest.approx(2.0 * load.wrench[2, 0])
    part = model.subset([0, 2]).load
    assert part.masses[0].mass.tolist() == [0.0, 50.0]
    assert part.surface is not None
    assert not len(part.surface.block)
    with pytest.raises(drystone.DrystoneError, match="different assemblies"):
        replace(load, wrench=load.wrench[:2], surface=None)
    content = json.loads((tmp_path / "tower.json").read_text())
    content["loads"][0]["masses"][0]["mass"] = [1.0]
    (tmp_path / "odd.json").write_text(json.dumps(content))
    with pytest.raises(drystone.DrystoneError, match="mass"):
        drystone.read(tmp_path / "odd.json")


def test_combinations_shake_permanent_masses_and_the_share_of_variable_ones(
    pier: Assembly, tmp_path: Path
) -> None:
    path = tmp_path / "cases.toml"
    path.write_text(
        f'situations = ["seismic"]\n[case.dead]\nkind = "permanent"\n'
        f'load = ["gravity", "fill:{FILL}"]\n'
        '[case.cart]\nkind = "variable"\npsi = [0.7, 0.5, 0.3]\nload = "pier:1000kg"\n'
        '[case.roof]\nkind = "permanent"\nload = "pier:10kN@0.5,0.5,3"\nshaken = true\n'
        '[case.quake]\nkind = "seismic"\nload = "seismic:0.1,0"\n'
    )
    found = combinations(Model.of(pier, friction=0.9), path, needed_of="none")
    pushed = {one.words: one.load.wrench[1, 0] for one in found.each}
    dead = 0.1 * (BLOCKS + FILLED + 10e3)
    assert pushed["1 dead + 1 roof + 1 quake"] == pytest.approx(dead)
    cart = next(force for words, force in pushed.items() if "0.3 cart" in words)
    assert cart == pytest.approx(dead + 0.1 * 0.3 * 1000.0 * G)
    told = [one.text for one in found.sentences() if "earthquake" in one.text]
    assert any("40 kN of fill and 10 kN of loads" in one for one in told)
    assert [one.partition(" (in ")[2][:-1] in pushed for one in told] == [True, True]


PRESSED = (
    "level pressure (earth, fill, water) does not grow with it: "
    "k=active:30deg:0.1 is Mononobe-Okabe's at 0.1 g"
)
STATIC = "passive pressure is the one given (passive=passive:30deg:0.1 is less)"


@pytest.mark.usefixtures("unpainted")
def test_every_answer_says_that_pressure_in_an_earthquake_is_the_one_given(
    tmp_path: Path,
) -> None:
    path, out = tmp_path / "cases.toml", tmp_path / "sheet.html"
    path.write_text(
        'situations = ["seismic"]\n[case.dead]\nkind = "permanent"\nload = "model"\n'
        '[case.quake]\nkind = "seismic"\nload = "seismic:0.1,0"\n'
    )
    bridge, fill = segmental_bridge(voussoirs=6), "fill:cover=0.4m,weight=19kN/m3,k=0.3"
    model = as_model(bridge, load=f"{fill},passive=1.5", tie="fill")
    asked = [
        check(model, seismic=0.1),
        limit_load(model, "seismic:1,0"),
        push(model, LoadCase.seismic(bridge, 1.0)),
        combinations(model, path, needed_of="none"),
    ]
    for one in asked:
        said = [*(x.text for x in one.sentences()), *one.asked.notes]
        assert any(x.endswith(f"; {PRESSED}; {STATIC}") for x in said)
    write_report(asked[:1], out)
    assert f"{PRESSED}; {STATIC}" in unescape(out.read_text(encoding="utf-8"))
    active = check(bridge, load=fill, seismic=0.1)
    assert active.asked.notes[-1].endswith(PRESSED)
    drystone.write(active, tmp_path / "pressed.json")
    assert check(tmp_path / "pressed.json").asked.notes[-1].endswith(PRESSED)
    assert not any("Mononobe" in x or STATIC in x for x in check(model).asked.notes)


def test_the_pressure_of_earth_is_told_not_to_grow_where_all_else_that_presses_down_is_shaken() -> (
    None
):
    wall, words = tower(3), "earth:side=-x,weight=18kN/m3,k=0.3,wall_friction=0.3"
    found = check(wall, load=words, seismic=(0.01, 0.0), shaken=True)
    assert found.asked.notes[-1].endswith(f"of loads; {PRESSED}")
    snow = LoadCase.gravity(wall) + LoadCase.surface_load(wall, 2, 100.0, facing=(0.0, 0.0, 1.0))
    assert told_of(wall, snow + LoadCase.seismic(wall, 0.01)).endswith("(--shaken)")


def test_fill_is_no_weight_of_blocks_where_it_is_as_heavy_as_some(
    pier: Assembly, tmp_path: Path
) -> None:
    """Fill of 3 m on a pier of 3 m of nearly the same weight by volume."""
    path = tmp_path / "cases.toml"
    words = "fill:cover=3m,weight=23kN/m3"
    path.write_text(f'[case.dead]\nkind = "permanent"\nload = ["gravity", "{words}"]\n')
    found = combinations(Model.of(pier, friction=0.9), path, needed_of="none")
    assert found.governing.stable
    assert common_acceleration(pier, Fill.named(words.removeprefix("fill:")).on(pier)).tolist() == (
        [0.0, 0.0, 0.0]
    )


def test_the_report_says_what_is_shaken(pier: Assembly, tmp_path: Path) -> None:
    out = tmp_path / "sheet.html"
    write_report([check(pier, friction=0.9, load=TOP, seismic=0.05)], out)
    assert "The earthquake shakes 100 kN: 70.6 kN of blocks" in out.read_text(encoding="utf-8")
