"""Reciprocal frames and card houses beside MuJoCo: ``python -m benchmarks.leaning``.

Their least friction is ours, to 1 %: it stands at the upper end of the bracket and falls at the
lower one. MuJoCo (extra ``fall``) simulates each at :data:`SHARES` of the middle. It gives way
where a block moves by more than a hundredth of its size, and rests where none moves by more than a
thousandth. Exit code 1 where MuJoCo rests below or gives way above.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import brentq, linprog

from drystone import Assembly, Block, Model, limit_friction
from drystone.geometry.frames import rotation_about
from drystone.io.mjcf import mjcf_text
from drystone.limits import LimitOptions
from drystone.models import box, prism

SHARES = (0.9, 1.1)
"""Of the least friction; MuJoCo has to give way with the first and to rest with the second."""
GIVES_WAY, RESTS = 1e-2, 1e-3
SECONDS = 3.0
CONTACT_S, STEP = 0.004, 5e-4
"""[s] Time constant of MuJoCo's contacts, and its time step: an eighth of it."""
FRICTION_BY_NORMAL = 20.0
"""How much stiffer friction is than pressure (impratio): blocks at rest creep less."""


def card(degrees: float, foot: float, low: float, thick: float, name: str) -> Block:
    """A card that leans to the right, cut level at its foot and at its top, upright at its head."""
    lean = math.radians(degrees)
    x, rise = math.cos(lean), math.tan(lean)
    wide = thick / math.sin(lean)
    top = rise * (x - 0.5 * wide)
    outline = [
        (0.0, 0.0),
        (wide, 0.0),
        (x, rise * (x - wide)),
        (x, top),
        (x - 0.5 * wide, top),
    ]
    return prism([(foot + a, low + b) for a, b in outline], (0.0, 0.5), name)


def card_house(storeys: int, degrees: float, thick: float = 0.02, apart: float = 0.02) -> Assembly:
    """Pairs of cards that lean on each other, with level cards between the storeys.

    The feet of neighbours are ``apart`` [m]: where they meet, MuJoCo lets them press each other.
    """
    half = math.cos(math.radians(degrees))
    wide = 2.0 * half + apart
    blocks = [box((12.0, 0.5, 0.5), (-6.0, 0.0, -0.5), "floor")]
    low = 0.0
    mirror = np.diag([-1.0, 1.0, 1.0])
    for storey in range(storeys):
        pairs = storeys - storey
        for i in range(pairs):
            middle = wide * (i - 0.5 * (pairs - 1))
            left = card(degrees, middle - half, low, thick, f"left-{storey}-{i}")
            right = left.transformed(mirror, (2.0 * middle, 0.0, 0.0))
            blocks += [left, right.renamed(f"right-{storey}-{i}")]
        top = float(blocks[-1].bounds[1, 2])
        for i in range(pairs - 1):
            middle = wide * (i - 0.5 * (pairs - 2))
            size = (wide - 0.4 * thick, 0.5, thick)
            blocks.append(box(size, (middle - 0.5 * size[0], 0.0, top), f"level-{storey}-{i}"))
        low = top + thick
    return Assembly(tuple(blocks)).with_fixed([0])


LENGTH, DEPTH = 1.0, 0.05
"""[m] Of a beam, and the side of its square section."""
PAST = 0.05
"""[m] Of a beam beyond where it crosses the next one."""


def beam(number: int, beams: int, opening: float, rise: float) -> Block:
    """A beam that passes the middle at a distance, its head up, its lowest edge on z = 0.

    Its axis crosses that of the next one near its head, and that of the one before as far on the
    other side of its nearest point.
    """
    reach = opening * math.tan(math.pi / beams)
    size = (LENGTH, DEPTH, DEPTH)
    start = reach / math.cos(rise) + PAST - LENGTH
    level = box(size, (start, -0.5 * DEPTH, 0.0), f"beam-{number}")
    turned = level.transformed(rotation_about((0.0, 1.0, 0.0), -math.degrees(rise)))
    lifted = turned.transformed(np.eye(3), (0.0, opening, -float(turned.bounds[0, 2])))
    return lifted.transformed(rotation_about((0.0, 0.0, 1.0), -360.0 / beams * number))


def clearance(upper: Block, lower: Block) -> float:
    """The least height of one convex block above another, over the plan that they share."""
    above, below = upper.vertices, lower.vertices
    cost = np.r_[above[:, 2], -below[:, 2]]
    rows = [np.c_[above[:, :2].T, -below[:, :2].T]]
    ones, none = np.ones(len(above)), np.zeros(len(below))
    matrix = np.vstack([*rows, np.r_[ones, none], np.r_[none, ones]])
    return float(linprog(cost, A_eq=matrix, b_eq=[0.0, 0.0, 1.0, 1.0]).fun)


def reciprocal_frame(beams: int, opening: float) -> Assembly:
    """Beams in a ring: each lies on the next one and stands on the ground by its outer edge."""

    def gap(rise: float) -> float:
        return clearance(beam(0, beams, opening, rise), beam(1, beams, opening, rise))

    rise = brentq(gap, 0.02, 0.7, xtol=1e-15)
    ring = [beam(i, beams, opening, rise) for i in range(beams)]
    floor = box((4.0, 4.0, 0.5), (-2.0, -2.0, -0.5), "floor")
    return Assembly((floor, *ring)).with_fixed([0])


@dataclass(frozen=True)
class Case:
    """A structure to lean."""

    name: str
    build: Callable[[], Assembly]


def cases() -> Iterator[Case]:
    """Reciprocal frames of 3 to 6 beams, card houses of 2 to 4 storeys."""
    for beams in (3, 4, 5, 6):
        for opening in (0.1, 0.12):
            name = f"reciprocal frame of {beams} beams, {1e3 * opening:.0f} mm from the middle"
            yield Case(name, lambda n=beams, opening=opening: reciprocal_frame(n, opening))
    for storeys in (2, 3, 4):
        for degrees in (60.0, 70.0):
            name = f"card house of {storeys} storeys, {degrees:g} degrees"
            yield Case(name, lambda n=storeys, lean=degrees: card_house(n, lean))


def moved(model: Model, seconds: float = SECONDS) -> float:
    """Largest displacement of a free block in MuJoCo after some time, by its size."""
    import mujoco  # optional: the simulator is asked for by name

    simulator: Any = mujoco.MjModel.from_xml_string(mjcf_text(model, contact_s=CONTACT_S))
    simulator.opt.timestep = STEP
    simulator.opt.impratio = FRICTION_BY_NORMAL
    data: Any = mujoco.MjData(simulator)
    mujoco.mj_forward(simulator, data)
    start = np.array(data.xpos)
    free = model.assembly.free
    far = 0.0
    while far <= GIVES_WAY and data.time < seconds:
        mujoco.mj_step(simulator, data)
        gone = np.linalg.norm(data.xpos - start, axis=1)[1:]
        far = float((gone / model.assembly.size)[free].max())
    return far


def told(far: float) -> str:
    """What MuJoCo is said to find."""
    return "rests" if far < RESTS else "gives way" if far > GIVES_WAY else "between"


def main(arguments: list[str] | None = None) -> int:
    """Print a row of Markdown for each structure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", default="")
    asked = parser.parse_args(arguments)
    print("| structure | blocks | least friction | MuJoCo at 0.9 of it | MuJoCo at 1.1 of it |")
    print("|---|---|---|---|---|")
    wrong, begin = 0, time.process_time()
    for case in cases():
        if asked.only not in case.name:
            continue
        assembly = case.build()
        found = limit_friction(assembly, upper=2.0, options=LimitOptions(width=1e-3)).rest
        assert found is not None
        assert found.stands is not None
        assert found.falls is not None
        least = 0.5 * (found.stands + found.falls)
        far = [moved(Model.of(assembly, friction=share * least)) for share in SHARES]
        wrong += told(far[0]) == "rests" or told(far[1]) == "gives way"
        cells = [f"{told(one)}, {one:.1e}" for one in far]
        print(
            f"| {case.name} | {len(assembly) - 1} | {found.falls:.3f} to {found.stands:.3f} "
            f"| {cells[0]} | {cells[1]} |",
            flush=True,
        )
    print(f"{time.process_time() - begin:.0f} CPU s", file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
