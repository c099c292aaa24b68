"""Walls, earth and combinations against hand calculations: the rows of ``assessment.csv``."""

import csv
import math
from collections.abc import Callable
from pathlib import Path

import pytest

from drystone import Assembly, Block, LoadCase, Model, check
from drystone.models import box, tower
from drystone.seismic import SeismicDemand, local_mechanism
from drystone.studies import combinations

G, UNIT = 9.81, 2400.0 * 9.81
TABLE = Path(__file__).parents[2] / "docs" / "trust" / "tables" / "assessment.csv"
Stands = Callable[[float, Path], bool]
"""Whether something stands at a value; a folder for its files."""


def standing(*blocks: Block, friction: float = 0.8) -> Model:
    base = box((20.0, 20.0, 1.0), (-10.0, -10.0, -1.0), "base")
    return Model.of(Assembly((base, *blocks)).with_fixed(["base"]), friction=friction)


def pushed(model: Model, kx: float, ky: float, *more: LoadCase) -> bool:
    """Under its weight, an earthquake of shares of g, and more."""
    assembly = model.assembly
    parts = (LoadCase.gravity(assembly), LoadCase.seismic(assembly, kx, ky), *more)
    return check(model.with_load(LoadCase.combine([(1.0, one) for one in parts]))).stable


def courses(alpha: float, _: Path) -> bool:
    rows = (box((0.5, 2.0, 1.0), (0.0, 0.0, float(i)), f"wall-{i}") for i in range(3))
    return pushed(standing(*rows), alpha, 0.0)


THICK = standing(box((0.4, 2.0, 3.0), (0.0, 0.0, 0.0), "wall"))
WEIGHT = 0.4 * 2.0 * 3.0 * UNIT


def at(force: tuple[float, float, float], x: float, z: float) -> LoadCase:
    return LoadCase.point_load(THICK.assembly, "wall", force, (x, 1.0, z))


def roofed(alpha: float, _: Path) -> bool:
    return pushed(THICK, alpha, 0.0, at((1e3, 0.0, -20e3), 0.3, 3.0))


def shaken(alpha: float, _: Path) -> bool:
    return pushed(THICK, alpha, 0.0, at((1e3 + alpha * 20e3, 0.0, -20e3), 0.3, 3.0))


def carrying(words: str) -> Stands:
    """A pier 1 m thick and 3 m high with something on it."""

    def stands(alpha: float, _: Path) -> bool:
        pier = standing(box((1.0, 1.0, 3.0), name="pier"), friction=0.9)
        return check(pier, load=words, seismic=alpha).stable

    return stands


def tied(alpha: float, _: Path) -> bool:
    return pushed(THICK, alpha, 0.0, at((-15e3, 0.0, 0.0), 0.0, 2.8))


def corner(alpha: float, _: Path) -> bool:
    pier = standing(box((1.0, 1.0, 4.0), (0.0, 0.0, 0.0), "pier"))
    return pushed(pier, alpha * math.sqrt(0.5), alpha * math.sqrt(0.5))


OLD = 'edition = "2009"'


def returned(along: float) -> Stands:
    """A facade with a return wall, 1.2 m long, on ground A with q = 2."""

    def fulfilled(ground: float, folder: Path) -> bool:
        facade = box((0.4, 4.0, 3.0), (0.0, 0.0, 0.0), "facade")
        model = standing(facade, box((1.2, 0.4, 3.0), (-1.2, along, 0.0), "side"))
        site = SeismicDemand.named(_site(folder, ground))
        return local_mechanism(model, part="facade,side", site=site).fulfils("linear")

    return fulfilled


def _site(folder: Path, ground: float, more: str = OLD) -> Path:
    path = folder / "site.toml"
    path.write_text(f'code = "ec8"\nag = "{ground!r}g"\nsoil = "A"\n{more}', encoding="utf-8")
    return path


def displaced(more: str) -> Stands:
    def fulfilled(ground: float, folder: Path) -> bool:
        wall = standing(box((0.5, 2.0, 3.0), (0.0, 0.0, 0.0), "wall"))
        site = SeismicDemand.named(_site(folder, ground, more))
        return local_mechanism(wall, part="wall", site=site).fulfils("non-linear")

    return fulfilled


def behind(words: str) -> Stands:
    """A wall 1 m thick and 3 m high of 2000 kg/m3, with ground behind it by words and a value."""

    def stands(value: float, _: Path) -> bool:
        wall = standing(box((1.0, 1.0, 3.0), name="wall"), friction=1.5).assembly
        return check(wall.with_density(2000.0), friction=1.5, load=words.format(value)).stable

    return stands


def combined(friction: float) -> Stands:
    """A cube of 1 m on a cube, pushed by a variable action [N]."""

    def stands(force: float, folder: Path) -> bool:
        path = folder / "cases.toml"
        path.write_text(
            'situations = ["EQU"]\n[material]\nfriction = 1.25\n'
            '[case.weight]\nkind = "permanent"\nload = "gravity"\n'
            '[case.push]\nkind = "variable"\npsi = [0.7, 0.5, 0.3]\n'
            f'load = "block-1:{force!r},0,0N"\n',
            encoding="utf-8",
        )
        model = Model.of(tower(2), friction=friction)
        return combinations(model, path, needed_of="none").governing.stable

    return stands


def displacement_capacity(secant: float, factor: float, confidence: float, eta: float) -> float:
    """The ground [g] at which SDe(Ts) is du* = 0.4 b/2, of a wall 0.5 m by 3 m: TC < Ts < TD."""
    reached = secant * 0.1
    level = (1.0 - reached / 0.25) * G / 6.0 / confidence
    period = factor * math.pi * math.sqrt(reached / level)
    return 0.1 / (2.5 * eta * 0.4 / period * (period / (2.0 * math.pi)) ** 2) / G


RETURN = (1.6 * 0.2 + 0.48 * 1.0) / (2.08 * 1.5)
HELD = WEIGHT * 0.2 + 20e3 * 0.1 - 1e3 * 3.0
PIER = 3.0 * UNIT
TANK = 3000.0 * G
BACK = 2000.0 * G * 3.0 * 0.5  # moment that the weight holds, per metre
ROWS: dict[str, tuple[float, Stands]] = {
    "wall of three courses": (0.5 / 3.0, courses),
    "wall with a roof": (HELD / (WEIGHT * 1.5), roofed),
    "wall with a roof that is shaken": (HELD / (WEIGHT * 1.5 + 20e3 * 3.0), shaken),
    "pier under fill": (
        0.5 * (PIER + 40e3) / (PIER * 1.5 + 40e3 * 4.0),
        carrying("fill:cover=2m,weight=20kN/m3"),
    ),
    "pier with a mass": (
        0.5 * (PIER + TANK) / (PIER * 1.5 + TANK * 3.2),
        carrying("pier:3000kg@0.5,0.5,3.2"),
    ),
    "wall with a tie": ((WEIGHT * 0.2 + 15e3 * 2.8) / (WEIGHT * 1.5), tied),
    "square pier about its corner": (math.sqrt(0.5) / 2.0, corner),
    "facade and return wall, L": (2.0 * RETURN, returned(0.0)),
    "facade and return wall, T": (2.0 * RETURN, returned(1.8)),
    "wall, displacement": (displacement_capacity(0.4, 2.0, 1.0, 1.0), displaced(OLD)),
    "wall, displacement, 2019": (
        displacement_capacity(1.0, 1.68, 1.35, math.sqrt(10.0 / 13.0)),
        displaced('edition = "2019"'),
    ),
    "wall with earth": (
        BACK / (18e3 * 27.0 / 6.0),
        behind("earth:side=-x,weight=18kN/m3,k={!r}"),
    ),
    "wall with a surcharge": (
        (BACK - 0.2 * 18e3 * 27.0 / 6.0) / (0.2 * 1e3 * 9.0 / 2.0),
        behind("earth:side=-x,weight=18kN/m3,k=0.2,surcharge={!r}kPa"),
    ),
    "cube, equilibrium": (0.9 * UNIT * 0.5 / (1.5 * 0.5), combined(2.0)),
    "cube, friction divided": (0.9 * UNIT * 0.6 / 1.25 / 1.5, combined(0.6)),
}  # fmt: skip


def told() -> dict[str, str]:
    """What each row of the table expects."""
    with TABLE.open(encoding="utf-8") as file:
        return {row["what"]: row["expected"] for row in csv.DictReader(file)}


def test_every_hand_value_has_its_row() -> None:
    assert list(told()) == list(ROWS)


@pytest.mark.parametrize("name", ROWS)
def test_it_stands_below_the_hand_value_and_falls_above(name: str, tmp_path: Path) -> None:
    expected, stands = ROWS[name]
    assert float(told()[name]) == pytest.approx(expected, rel=1e-4)
    assert stands(0.999 * expected, tmp_path)
    assert not stands(1.001 * expected, tmp_path)
