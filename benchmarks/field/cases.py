"""Models with known or published answers as data, by ``python -m benchmarks.field.cases``.

Each file of ``benchmarks/field/models`` is a model in our JSON: blocks, which of them are fixed,
and a load case for each state. ``_benchmark`` has a title, the citation, and for each state its
load case, its friction coefficient, whether it stands, and the limit that this follows from.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from typing import TypeAlias

import numpy as np

from benchmarks.field import MODELS, lact3, stud_bricks
from benchmarks.field.ferris import WALLS, wall_of_rows
from drystone import Assembly, Contacts, LoadCase, models
from drystone.base.arrays import Floats
from drystone.base.files import write_bytes
from drystone.io.json_files import contacts_content
from drystone.models.simple import blocks_between
from drystone.reproduce.tilt_cases import studies

Vector: TypeAlias = tuple[float, float, float]

G = 9.81
DECIMALS = 12
"""Of coordinates [m]: the last digits of a float are rounding."""
KAO = "Kao 2023, doctoral dissertation, ETH Zurich; the limit is that of 3DEC"
FERRIS = (
    "Ferris and Tin-Loi 2001, International Journal of Mechanical Sciences 43, 209-224; limits as "
    "programs that cite it quote them"
)
LACT3 = (
    "Hua, Buzzetti, Pingaro, da Silva and Milani 2025, LACT3 1.0; the limit is that of its solver "
    "test, with associated friction"
)
STABLE_LEGO = "Liu and others 2024, StableLego, arXiv 2402.10711: label of the data set"
NO_SLIDING = 2.0
"""Friction coefficient with which no joint of these arches slides."""


@dataclass(frozen=True)
class State:
    """One question: does it stand?

    Attributes
    ----------
    name
        Of the load case.
    friction
    stands
        The known answer.
    gravity : (3,) [m/s2]
    limit
        What the answer follows from.
    """

    name: str
    friction: float
    stands: bool
    gravity: Vector
    limit: str


@dataclass(frozen=True)
class Case:
    """A structure and its states; its contacts where they cannot be found from the blocks."""

    key: str
    title: str
    citation: str
    assembly: Assembly
    states: Sequence[State]
    contacts: Contacts | None = None

    def text(self) -> str:
        """The file."""
        loads = []
        for state in self.states:
            size = math.hypot(*state.gravity)
            direction = [x / size for x in state.gravity]
            part = {"kind": "gravity", "g": size, "direction": direction}
            loads.append({"name": state.name, "parts": [part]})
        told = [
            {key: value for key, value in asdict(state).items() if key != "gravity"}
            for state in self.states
        ]
        blocks = [
            {
                "name": block.name,
                "vertices": block.vertices.round(DECIMALS).tolist(),
                "faces": [list(face) for face in block.faces],
                "fixed": bool(fixed),
                **({} if self.contacts is None else {"density": round(block.density, 6)}),
            }
            for block, fixed in zip(self.assembly.blocks, self.assembly.fixed, strict=True)
        ]
        lines = [
            '{"schema": "drystone", "version": 1, "units": "m",',
            f'"_benchmark": {{"title": {json.dumps(self.title)},',
            f'"citation": {json.dumps(self.citation)},',
            f'"states": {_rows(told)}}},',
            f'"blocks": {_rows(blocks)},',
        ]
        if self.contacts is not None:
            given = contacts_content(self.contacts, DECIMALS)
            lines.append(f'"contacts": {json.dumps(given)},')
        lines.append(f'"loads": {_rows(loads)}}}')
        return "\n".join(lines) + "\n"


def _rows(values: Iterable[object]) -> str:
    return "[\n" + ",\n".join(json.dumps(value) for value in values) + "]"


DOWN = (0.0, 0.0, -G)


def pushed(share: float) -> Vector:
    """Gravity and a horizontal acceleration along x."""
    return (share * G, 0.0, -G)


def tilted(axis: Sequence[float], degrees: float) -> Vector:
    """Gravity as the structure sees it once it is turned counter-clockwise about an axis."""
    cube = models.box((1.0, 1.0, 1.0))
    load = LoadCase.tilt(Assembly((cube,)), axis, degrees, G)
    x, y, z = (load.wrench[0, :3] / cube.mass).tolist()
    return (x, y, z)


def about_y(degrees: float) -> Vector:
    """A tilt about y."""
    return tilted((0.0, 1.0, 0.0), degrees)


def around(
    limit: float,
    share: float,
    gravity: Callable[[float], Vector],
    friction: float,
    what: str,
    least: float = 0.0,
) -> list[State]:
    """A state below a limit and one above it, by a share of it and by at least so much."""
    away = max(share * limit, least)
    return [
        State(f"{what} {value:.4g}, mu {friction:.3g}", friction, stands, gravity(value), text)
        for value, stands in ((limit - away, True), (limit + away, False))
        for text in [f"{what}: {limit:g}"]
    ]


def tilts() -> list[Case]:
    """The tilt tests of the source."""
    found: dict[str, Case] = {}
    for study in studies():
        states = around(
            study.dem,
            0.02,
            lambda degrees, axis=study.axis: tilted(axis, degrees),
            study.friction,
            f"tilt about {study.axis_name} [degrees]",
            study.tolerance,
        )
        name = study.model if study.model != "arch" else "arch-tilted"
        case = found.get(name)
        before = () if case is None else case.states
        built = study.build() if case is None else case.assembly
        title = name if name != "arch-tilted" else "Semicircular arch, thickness / radius 0.15"
        found[name] = Case(name, title, KAO, built, (*before, *states))
    return list(found.values())


def walls() -> list[Case]:
    """Walls under a horizontal load in proportion to the weight."""
    cases = []
    for number, wall in WALLS.items():
        what = "horizontal load by weight"
        states = [
            State(
                f"{what} {1.02 * wall.associated:.4g}",
                0.65,
                False,
                pushed(1.02 * wall.associated),
                f"{what}, associated: {wall.associated:g}",
            )
        ]
        if wall.non_associated is not None:
            below = 0.98 * wall.non_associated
            limit = f"{what}, non-associated: {wall.non_associated:g}"
            states.insert(0, State(f"{what} {below:.4g}", 0.65, True, pushed(below), limit))
        citation = FERRIS if number != 6 else f"{FERRIS}; of wall 6 by a linear program of ours"
        built = wall_of_rows(wall.rows)
        cases.append(Case(f"ferris-{number}", f"Wall {number}", citation, built, states))
    return cases


def tilting_table() -> list[Case]:
    """The structures of LACT3. Below an associated limit only the arch, where no joint slides."""
    built = {
        "portal": ("Portal of irregular blocks", lact3.portal()),
        "wall": ("Wall with a door and a window",
                 wall_of_rows(lact3.WALL, lact3.BRICK, lact3.COURSE)),
        "arch": ("Semicircular arch of 25 voussoirs, thickness / radius 0.163",
                 part_arch(lact3.RADIUS, lact3.THICKNESS, lact3.ANGLE, lact3.VOUSSOIRS)),
    }  # fmt: skip
    cases = []
    for key, (title, assembly) in built.items():
        angle, friction_angle = lact3.ANGLES[key]
        friction = math.tan(math.radians(friction_angle))
        states = around(angle, 0.02, about_y, friction, "tilt about y [degrees]")
        kept = states if key == "arch" else states[1:]
        cases.append(Case(f"lact3-{key}", title, LACT3, assembly, kept))
    return cases


def bricks() -> list[Case]:
    """The labelled designs of StableLego: studs pull."""
    gravity = (0.0, 0.0, -stud_bricks.G)
    cases = []
    for key, design in stud_bricks.DESIGNS.items():
        model = stud_bricks.model_of_lines(design.lines)
        limit = f"share of the largest pull: {design.share:g}"
        state = State("weight", 0.0, design.stands, gravity, limit)
        title = f"Stud-and-tube bricks, {key.replace('-', ' ')}"
        name, blocks = f"bricks-{key}", model.assembly
        cases.append(Case(name, title, STABLE_LEGO, blocks, [state], model.contacts))
    return cases


def part_arch(radius: float, thickness: float, degrees: float, count: int) -> Assembly:
    """Equal straight-sided voussoirs between two fixed ones; radius of the centre line."""
    step = math.radians(degrees) / count
    angle = 0.5 * math.pi + 0.5 * math.radians(degrees) - step * np.arange(-1, count + 2)
    ray: Floats = np.column_stack([np.cos(angle), np.sin(angle)])
    half = 0.5 * thickness
    joints = np.stack([(radius - half) * ray, (radius + half) * ray], axis=1)
    blocks = blocks_between(joints, (0.0, 1.0))
    fixed = np.zeros(len(blocks), dtype=bool)
    fixed[[0, -1]] = True
    return Assembly(tuple(blocks), fixed)


def arches() -> list[Case]:
    """Arches under a horizontal load, and the least thickness under self-weight."""
    what = "horizontal load by weight"
    thin = "thickness / radius: least 0.1075"
    return [
        Case(
            "oppenheim",
            "Arch of 7 voussoirs, 157.5 degrees, radius 10 m, thickness 1.5 m",
            "Oppenheim 1992; De Lorenzis, DeJong and Ochsendorf 2007: 0.37",
            part_arch(10.0, 1.5, 157.5, 7),
            around(0.37, 0.03, pushed, NO_SLIDING, what),
        ),
        Case(
            "lemos",
            "Semicircular arch of 17 voussoirs, inner span 7.5 m, thickness 0.5 m",
            "the arch of Lemos 2007; the limit is that of a linear program of ours, 0.0691",
            part_arch(4.0, 0.5, 180.0, 17),
            around(0.0691, 0.03, pushed, 0.7, what),
        ),
        *(
            Case(
                f"arch-{ratio:g}",
                f"Semicircular arch of 36 voussoirs, thickness / radius {ratio:g}",
                "Milankovitch 1907, closed form",
                models.arch(ratio),
                [State("weight", 0.9, stands, DOWN, thin)],
            )
            for ratio, stands in ((0.11, True), (0.105, False))
        ),
    ]


def closed_forms() -> list[Case]:
    """Sliding, overturning, overhanging, wedging."""
    tilt = "tilt about y [degrees]"
    slides, topples = math.degrees(math.atan(0.4)), math.degrees(math.atan(0.25))

    stack = models.two_blocks_on_incline(23.6)
    least = math.tan(math.radians(23.6))
    cases = [
        Case("slide", "Cube on a cube", "atan(mu)", models.tower(2),
             around(slides, 0.02, about_y, 0.4, tilt)),
        Case("topple", "Four cubes on a cube", "atan(1/4)", models.tower(5),
             around(topples, 0.02, about_y, 0.8, tilt)),
        Case("slanted-joint", "Two blocks with a slanted joint", "mu = tan(23.6 degrees)", stack, [
            State(f"weight, mu {share:g} of the least", share * least, share > 1.0, DOWN,
                  f"friction: {least:.4f}")
            for share in (1.02, 0.98)
        ]),
        Case("h", "Block between two walls, H", f"{KAO}; falls at every friction",
             models.h_model(), [State("weight", 0.84, False, DOWN, "none stands")]),
        Case("a", "Block between two slanted walls, A", f"{KAO}; falls at every friction",
             models.a_model(), [State("weight", 0.84, False, DOWN, "none stands")]),
        Case("shelf", "Shelf of ten slanted pieces", "Kao 2023, section 6.3: two pieces fall",
             models.shelf(), [State("weight", 0.9, False, DOWN, "two pieces are not pressed")]),
        Case("shelf-less-two", "The shelf without the two pieces", "Kao 2023, section 6.3",
             models.shelf().without(["block-9", "block-10"]),
             [State("weight", 0.9, True, DOWN, "published")]),
    ]  # fmt: skip
    for share, stands in ((0.98, True), (1.02, False)):
        stack = models.overhang(models.harmonic_offsets(4, share=share))
        corbel = share * 0.05
        wall = models.corbelled_wall(corbel=corbel)
        overhang = State("weight", 0.6, stands, DOWN, "share of the harmonic sum: 1")
        outwards = State("weight", 0.8, stands, DOWN, "step of a course [m]: 0.05")
        cases += [
            Case(f"overhang-{share:g}", f"Four bricks, {share:g} of the largest overhang",
                 "Hall 2005: 1/2 + 1/4 + 1/6 + 1/8", stack, [overhang]),
            Case(f"corbel-{share:g}", f"Corbelled wall, steps of {corbel:g} m",
                 "centre of gravity over the edge of the base", wall, [outwards]),
        ]  # fmt: skip
    return cases


def cases() -> list[Case]:
    """All of them."""
    return [*closed_forms(), *arches(), *walls(), *tilting_table(), *bricks(), *tilts()]


def main() -> None:
    for case in cases():
        write_bytes(MODELS / f"{case.key}.json", case.text().encode())
    files = list(MODELS.glob("*.json"))
    states = sum(len(case.states) for case in cases())
    size = sum(file.stat().st_size for file in files)
    print(f"{len(files)} models, {states} states, {size / 1024:.0f} KiB")


if __name__ == "__main__":
    main()
