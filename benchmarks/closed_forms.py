"""Jams, piles, counterweights and hinges: ``python -m benchmarks.closed_forms``.

Writes docs/trust/tables/closed-forms.csv: each closed form, and the bracket that checks find.
Exit code 1 where one is farther than a thousandth from the closed form.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from benchmarks.leaning import card_house
from benchmarks.tables import TABLES, write_table
from drystone import Assembly, Block, LoadCase, Model, check
from drystone.models import box, prism

TABLE = TABLES / "closed-forms.csv"
BELOW, ABOVE, WIDTH, WITHIN = 0.03, 0.02, 1e-4, 1e-3
"""By the closed form: the ends of the search, the width of a bracket, and how far it may be."""
NARROW = 1e-4
"""[m] Width of a face that is taken for a hinge, of structures of 1 m."""


def brick(right: float, level: int, name: str) -> Block:
    """A brick of length 1 that ends at x."""
    return box((1.0, 0.5, 0.2), (right - 1.0, 0.0, 0.2 * level), name)


def on_a_table(friction: float, *bricks: Block) -> Model:
    table = box((2.0, 0.5, 1.0), (-2.0, 0.0, -1.0), "table")
    return Model.of(Assembly((table, *bricks)).with_fixed([0]), friction=friction)


SPINE = 9.0 / 8.0


def with_a_spine(of_table: float, of_spine: float) -> Model:
    """Two bricks on the ends of the spine balance about its middle.

    So three of them stand on the end of the lowest one, whose end is an eighth beyond the table.
    Each edge may be passed by some length.
    """
    lowest = 0.125 + of_table
    middle = lowest + of_spine
    return on_a_table(
        0.6,
        brick(lowest, 0, "lowest"),
        brick(middle + 0.5, 1, "spine"),
        brick(middle + 1.0, 2, "out"),
        brick(middle, 2, "counterweight"),
    )


DIAMOND = (15.0 - 4.0 * math.sqrt(2.0)) / 8.0


def diamond(out: float, back: float, of_table: float) -> Model:
    """A diamond, whose top brick presses on the tails of both middle ones.

    It presses on the outer one with f. Moments about the end of the lowest brick put the outer one
    at (1 / 2 + f) / (1 + f) beyond it, those about its other end put the inner one there, and those
    about the table put its end at (5 / 2 - f) / 4; f = sqrt(2) - 1 is best. At the largest overhang
    all three edges are about to turn: beyond any of them it falls. Friction would let the top
    brick tie the middle ones, so there is hardly any.
    """
    press = math.sqrt(2.0) - 1.0
    lowest = (2.5 - press) / 4.0 + of_table
    outer = lowest + (0.5 + press) / (1.0 + press)
    inner = lowest - 1.0 + 0.5 / (2.0 - press)
    top = press * (outer - 1.0) + (1.0 - press) * inner + 0.5
    return on_a_table(
        0.01,
        brick(lowest, 0, "lowest"),
        brick(outer + out, 1, "outer"),
        brick(inner - back, 1, "inner"),
        brick(top + 0.5 * (out - back), 2, "top"),
    )


def drawer(friction: float, off: float) -> Model:
    """It is pulled at a distance from its middle, between two rough sides on a smooth floor.

    The pull F at e presses two corners with F e / L, which resist with twice the friction.
    """
    blocks = (
        box((6.0, 3.0, 0.5), (-3.0, -1.5, -0.5), "floor"),
        box((6.0, 1.0, 0.5), (-3.0, -1.3, 0.0), "right"),
        box((6.0, 1.0, 0.5), (-3.0, 0.3, 0.0), "left"),
        box((1.0, 0.6, 0.2), (-0.5, -0.3, 0.0), "drawer"),
    )
    assembly = Assembly(blocks).with_fixed([0, 1, 2])
    pull = LoadCase.point_load(assembly, "drawer", (500.0, 0.0, 0.0), (0.0, off, 0.1))
    model = Model.of(assembly, load=LoadCase.gravity(assembly) + pull)
    sides = (model.contacts.block_a != 0) & (model.contacts.block_b != 0)
    return model.with_friction(np.where(sides, friction, 0.0))


ROUGH, WEDGE_HIGH = 0.3, 0.4
"""Friction of the wedge on both of its sides, and the height [m] of its thin end."""


def wedge_angle(heavy: float) -> float:
    """[degrees] Where tan(angle - phi) = mu (1 + w / W); w depends on the angle."""
    lean = math.radians(15.0)
    for _ in range(60):
        ratio = (0.5 * math.tan(lean) + WEDGE_HIGH) / heavy
        lean = math.atan(ROUGH) + math.atan(ROUGH * (1.0 + ratio))
    return math.degrees(lean)


def pressed_wedge(heavy: float, degrees: float) -> Model:
    """A wedge on a floor below a block that is guided by smooth walls, ``heavy`` [m2] of stone."""
    rise = math.tan(math.radians(degrees))
    wedge = [(0.0, 0.0), (1.0, 0.0), (1.0, WEDGE_HIGH), (0.0, WEDGE_HIGH + rise)]
    top = 2.0 + WEDGE_HIGH
    guided = [(0.0, WEDGE_HIGH + rise), (1.0, WEDGE_HIGH), (1.0, top), (0.0, top)]
    blocks = (
        box((6.0, 1.0, 0.5), (-3.0, 0.0, -0.5), "floor"),
        box((0.5, 1.0, 3.0), (-0.5, 0.0, WEDGE_HIGH + rise), "left"),
        box((0.5, 1.0, 3.0), (1.0, 0.0, WEDGE_HIGH + 0.3), "right"),
        prism(wedge, (0.0, 1.0), "wedge"),
        prism(guided, (0.0, 1.0), "guided", 2400.0 * heavy / (2.0 - 0.5 * rise)),
    )
    model = Model.of(Assembly(blocks).with_fixed([0, 1, 2]))
    smooth = np.isin(model.contacts.block_a, [1, 2]) | np.isin(model.contacts.block_b, [1, 2])
    return model.with_friction(np.where(smooth, 0.0, ROUGH))


HEXAGONS = (-4.0 / math.sqrt(3.0) + math.sqrt(16.0 / 3.0 + 12.0)) / 6.0


def hexagon(x: float, z: float, name: str) -> Block:
    """A hexagonal log of side 1 with a face below."""
    angles = np.deg2rad(60.0 * np.arange(6))
    return prism([(x + np.cos(a), z + np.sin(a)) for a in angles], (0.0, 3.0), name)


def hexagons(friction: float) -> Model:
    """A log on two others. Their faces lean by 60 degrees: cot(30 + phi) = 3 tan(phi)."""
    half = math.sqrt(3.0) / 2.0
    blocks = (
        box((12.0, 3.0, 1.0), (-6.0, 0.0, -1.0), "floor"),
        hexagon(-1.5, half, "left"),
        hexagon(1.5, half, "right"),
        hexagon(0.0, 2.0 * half, "top"),
    )
    return Model.of(Assembly(blocks).with_fixed([0]), friction=friction)


def hinged_arch(friction: float, share: float) -> Model:
    """Three hinges, with a load on a hinge, by what its other foot carries before it slides.

    Halves of weight W, as wide as high; W acts at d from the crown, the load Q at e from the left
    foot. Moments about the feet and the crown: the right foot carries V = W + Q e / 2 and thrusts
    with V - W d, which is friction times V where V = W d / (1 - friction). A beam brings Q on a
    hinge without friction.
    """
    at, pier = -0.5, -1.7
    left = prism(
        [(-1.0, 0.0), (NARROW - 1.0, 0.0), (0.0, 1.0 - NARROW), (0.0, 1.0), (-1.0, 1.0)],
        (0.0, 1.0),
        "left",
    )
    right = left.transformed(np.diag([-1.0, 1.0, 1.0])).renamed("right")
    weight = left.volume * left.density
    carried = weight * -left.centroid[0] / (1.0 - friction)
    load = share * 2.0 / (1.0 + at) * (carried - weight)
    outline = [
        (at, 1.0),
        (at + NARROW, 1.0),
        (at + 0.1, 1.1),
        (at + 0.1, 1.3),
        (pier, 1.3),
        (pier, 1.1),
        (at - 0.1, 1.1),
    ]
    beam = prism(outline, (0.0, 1.0), "beam")
    portion = beam.volume * (beam.centroid[0] - pier) / (at - pier)
    blocks = (
        box((6.0, 1.0, 0.5), (-3.0, 0.0, -0.5), "floor"),
        box((NARROW, 1.0, 1.1), (pier, 0.0, 0.0), "pier"),
        left,
        right,
        prism(outline, (0.0, 1.0), "beam", load / portion),
    )
    model = Model.of(Assembly(blocks).with_fixed([0, 1]))
    joints = list(zip(model.contacts.block_a, model.contacts.block_b, strict=True))
    of_joint = {(2, 3): 2.0, (2, 4): 0.0}
    return model.with_friction([of_joint.get(joint, friction) for joint in joints])


def thrust_of_cards(degrees: float) -> float:
    """Of two thin cards that lean on each other, by the weight of one."""
    house = card_house(1, degrees, thick=NARROW)
    found = check(house, friction=1.0)
    assert found.force is not None
    world = np.einsum("ki,kij->kj", found.force, found.contacts.frame[found.contacts.interface])
    of_floor = (found.contacts.block_a == 0)[found.contacts.interface]
    weight = 9.81 * float(house.blocks[1].mass)
    return 0.5 * float(np.abs(world[of_floor, 0]).sum()) / weight


@dataclass(frozen=True)
class Row:
    """A closed form: the value at which the structure begins to fall, or to stand.

    Attributes
    ----------
    build
        The model at a value.
    stands_above
        It falls below the value, and not above it.
    """

    structure: str
    what: str
    source: str
    expected: float
    build: Callable[[float], Model]
    stands_above: bool = False

    def found(self) -> tuple[float, float]:
        """The bracket of checks: they end STABLE at one of its ends, and UNSTABLE at the other."""
        values = [self.expected * (1.0 - BELOW), self.expected * (1.0 + ABOVE)]
        ends = [check(self.build(value)) for value in values]
        while values[1] - values[0] > WIDTH * self.expected:
            middle = 0.5 * sum(values)
            found = check(self.build(middle))
            end = int(found.stable is self.stands_above)
            values[end], ends[end] = middle, found
        if not (ends[self.stands_above].stable and ends[not self.stands_above].falls):
            raise SystemExit(f"{self.structure}: no bracket about {self.expected:g}")
        return values[0], values[1]


def rows() -> list[Row]:
    """Every closed form."""
    found = [
        Row(
            "four bricks, two on the ends of a spine", "overhang by a brick",
            "Paterson and Zwick 2009: 9/8", SPINE,
            lambda far: with_a_spine(0.5 * (far - SPINE), 0.5 * (far - SPINE)),
        ),
        Row(
            "four bricks, a diamond", "the same", "Ainley 1979: (15 - 4 sqrt 2)/8", DIAMOND,
            lambda far: diamond(*(0.5 * (far - DIAMOND),) * 3),
        ),
    ]  # fmt: skip
    found += [
        Row(
            f"drawer between sides with friction {mu:g}, pulled off its middle",
            "place by its length, from which it jams", "moments about its middle: 1/(2 mu)",
            0.5 / mu, partial(drawer, mu), stands_above=True,
        )
        for mu in (0.3, 0.5, 0.8)
    ]  # fmt: skip
    found += [
        Row(
            f"wedge with friction {ROUGH:g} below a guided block of {heavy:g} m2",
            "angle [degrees] at which it is pressed out",
            "Coulomb 1776: tan(a - phi) = mu (1 + w/W)",
            wedge_angle(heavy), partial(pressed_wedge, heavy),
        )
        for heavy in (1.0, 4.0)
    ]  # fmt: skip
    found += [
        Row(
            "hexagonal log on two others", "friction", "cot(30 + phi) = 3 tan(phi)", HEXAGONS,
            hexagons, stands_above=True,
        )
    ]  # fmt: skip
    return found + [
        Row(
            f"arch of three hinges, friction {mu:g} at its feet, load on a hinge",
            "load by the one at which the other foot slides",
            "moments about feet and crown: V = W d/(1 - mu)", 1.0, partial(hinged_arch, mu),
        )
        for mu in (0.5, 0.6)
    ]  # fmt: skip


LEANS = (60.0, 75.0)
"""[degrees] Of the cards whose thrust is told."""


def expected_thrust(degrees: float) -> float:
    """Moments about a foot of two thin cards: by the weight of one."""
    return 0.5 / math.tan(math.radians(degrees))


def main() -> int:
    """Write the table."""
    lines = ["| structure | what | source | expected | drystone |", "|---|---|---|---|---|"]
    far, begin = 0.0, time.process_time()
    for row in rows():
        low, high = row.found()
        far = max(far, abs(low / row.expected - 1.0), abs(high / row.expected - 1.0))
        said = ("falls", "stands") if row.stands_above else ("stands", "falls")
        ends = f"{said[0]} at {low:#.6g}, {said[1]} at {high:#.6g}"
        lines.append(
            f"| {row.structure} | {row.what} | {row.source} | {row.expected:#.6g} | {ends} |"
        )
    for degrees in LEANS:
        expected, found = expected_thrust(degrees), thrust_of_cards(degrees)
        far = max(far, abs(found / expected - 1.0))
        lines.append(
            f"| two thin cards at {degrees:g} degrees, hinges at head and feet "
            f"| thrust by the weight of one | moments about a foot: cot(a)/2 "
            f"| {expected:#.6g} | {found:#.6g} |"
        )
    write_table(TABLE, lines)
    print("\n".join(lines))
    print(f"farthest: {far:.1e}; {time.process_time() - begin:.1f} CPU s", file=sys.stderr)
    return 1 if far > WITHIN else 0


if __name__ == "__main__":
    sys.exit(main())
