"""Known optima, found by gradient from a poor start: ``python -m benchmarks.optima [CASE ...]``.

Prints a row for each case. The shape that was found is written to a file, read, and checked again.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from scipy.optimize import brentq

from drystone import Assembly, Model, check, read, write
from drystone.base.arrays import Floats
from drystone.base.errors import InputError
from drystone.design import (
    Changed,
    DesignMargin,
    FamilyMoves,
    Parameter,
    ShapeOptions,
    TuneOptions,
    block_moves,
    free_vertices,
    shape,
    thickening,
    tune,
)
from drystone.design.needs import Form
from drystone.models import arch, box, buttressed_arch, prism
from drystone.models.simple import blocks_between
from drystone.stability import CheckOptions

HEAD = "| case | start | found | known | its file | CPU s |\n|---|---|---|---|---|---|\n"

VOLUME = ShapeOptions(aim="volume")
DEPTH = (0.0, 0.3)
ROUGH = 4.0
"""Friction with which the steep vertical joints near the feet do not slide."""


def vertical_arch(thickness: float, joints: int = 40) -> Assembly:
    """A semicircular arch of radius 1 whose inner joints are vertical, on horizontal feet."""
    inner, outer = 1.0 - 0.5 * thickness, 1.0 + 0.5 * thickness
    x = -0.999 * inner * np.cos(np.pi * np.arange(joints) / (joints - 1))
    ends = np.stack(
        [np.column_stack([x, np.sqrt(radius**2 - x**2)]) for radius in (inner, outer)],
        axis=1,
    )
    rim = np.arccos(x[-1] / outer) * np.arange(6) / 6.0
    arc = outer * np.column_stack([np.cos(rim), np.sin(rim)])
    right = [(inner, 0.0), *arc, ends[-1, 1], ends[-1, 0]]
    left = [(-one[0], one[1]) for one in right]
    feet = [
        box((2.0 * thickness, 0.3, 0.2), (side * 1.0 - thickness, 0.0, -0.2), name)
        for side, name in ((-1.0, "left"), (1.0, "right"))
    ]
    blocks = (
        feet[0], prism(left, DEPTH, "haunch-left"), *blocks_between(ends, DEPTH),
        prism(right, DEPTH, "haunch-right"), feet[1],
    )  # fmt: skip
    return Assembly(blocks).with_fixed([0, len(blocks) - 1])


def arch_about(heights: Sequence[float], thickness: float) -> Assembly:
    """An arch of constant thickness, span 2 and rise 1 about a centre line.

    ``heights`` are those of its inner nodes on the left side, at equal angles of a half circle.
    """
    count = 2 * len(heights) + 2
    angle = np.pi * (1.0 - np.arange(count + 1) / count)
    z = np.array([0.0, *heights, 1.0, *heights[::-1], 0.0])
    node = np.column_stack([np.cos(angle), z])
    along = np.gradient(node, axis=0)
    # the feet have the slope of a parabola through the next two nodes
    along[0] = -1.5 * node[0] + 2.0 * node[1] - 0.5 * node[2]
    along[-1] = 1.5 * node[-1] - 2.0 * node[-2] + 0.5 * node[-3]
    across = np.column_stack([-along[:, 1], along[:, 0]])
    across *= 0.5 * thickness / np.linalg.norm(across, axis=1, keepdims=True)
    ends = np.stack([node - across, node + across], axis=1)
    blocks = blocks_between(ends, DEPTH)
    feet = []
    for name, end, along_foot in (("left", ends[0], -along[0]), ("right", ends[-1], along[-1])):
        back = 0.1 * along_foot / np.linalg.norm(along_foot)
        feet.append(prism([end[0], end[1], end[1] + back, end[0] + back], DEPTH, name))
    whole = (feet[0], *blocks, feet[1])
    return Assembly(whole).with_fixed([0, len(whole) - 1])


def catenary(x: Floats) -> Floats:
    """Heights of the catenary of span 2 and rise 1 at x."""
    a = brentq(lambda a: a * (np.cosh(1.0 / a) - 1.0) - 1.0, 0.1, 10.0)
    heights: Floats = 1.0 - a * (np.cosh(x / a) - 1.0)
    return heights


def again(found: Changed) -> str:
    """The verdict on the shape, written to a file and read."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "shape.json"
        write(found.model, path)
        return check(read(path)).verdict.value


def radial() -> tuple[str, str, str, str]:
    """Least thickness with radial joints (Milankovitch 1907)."""
    found = shape(
        arch(0.2, 100), lambda m: thickening(m, (0.0, 0.0, 0.0), 0.15), friction=0.8, options=VOLUME
    )
    thick = 0.2 + float(found.x[0])
    return "t/R 0.2", f"t/R {thick:.4f}", "0.1075", again(found)


def vertical() -> tuple[str, str, str, str]:
    """Least thickness with vertical joints (Makris and Alexakis 2013)."""
    model = Model.of(vertical_arch(0.2), friction=ROUGH)
    moves = FamilyMoves.of(vertical_arch, {"thickness": 0.2}, {"thickness": 0.15})
    found = shape(model, moves, options=VOLUME)
    low, high = 0.09, 0.13
    while high - low > 1e-4:
        middle = 0.5 * (low + high)
        stands = check(Model.of(vertical_arch(middle), friction=ROUGH)).stable
        low, high = (low, middle) if stands else (middle, high)
    thick = 0.2 + float(found.x[0])
    return "t/R 0.2", f"t/R {thick:.4f}", f"0.1095, by bisection {high:.4f}", again(found)


def hung(count: int, thickness: float) -> tuple[Changed, Floats, Floats]:
    """A half circle shaped to stand, and its heights above the catenary, before and after."""
    angle = np.pi * (1.0 - np.arange(1, count + 1) / (2 * count + 2))
    names = [f"z{i}" for i in range(count)]
    circle = np.sin(angle)

    def build(**heights: float) -> Assembly:
        return arch_about([heights[name] for name in names], thickness)

    start = dict(zip(names, circle.tolist(), strict=True))
    moves = FamilyMoves.of(build, start, dict.fromkeys(names, 0.4))
    model = Model.of(build(**start), friction=0.9)
    found = shape(model, moves, options=ShapeOptions(rounds=60))
    true = catenary(np.cos(angle))
    return found, circle - true, circle + found.x - true


def hanging() -> tuple[str, str, str, str]:
    """The centre line of a thin arch under its own weight."""
    found, before, after = hung(9, 0.005)
    first, last = (float(np.abs(one).max()) for one in (before, after))
    return (
        f"{100 * first:.1f} % of the rise", f"{100 * last:.2f} % ({found.message})",
        "below 1 %", again(found),
    )  # fmt: skip


def overhang(bricks: int) -> tuple[str, str, str, str]:
    """Largest overhang of a stack with one brick a course."""
    blocks = [box((1.0, 0.5, 0.25), (0.0, 0.0, 0.25 * i), f"brick-{i}") for i in range(bricks + 1)]
    model = Model.of(Assembly(tuple(blocks)).with_fixed([0]), friction=0.6)
    free = [f"brick-{i}" for i in range(1, bricks + 1)]
    moves = block_moves(model, free, (1.0, 0.0, 0.0), 1.5)
    options = ShapeOptions(aim="reach", block=f"brick-{bricks}", rounds=40, close=1e-4)
    found = shape(model, moves, options=options)
    known = sum(0.5 / i for i in range(1, bricks + 1))
    return "0", f"{found.value - found.first:.4f}", f"{known:.4f}", again(found)


ARRANGEMENTS = ("1111", "112", "121", "211", "13", "31", "22")
"""Bricks of each course from below, of four bricks that do not all lie on the table."""


def bricks(courses: str, **place: float) -> Assembly:
    """Four bricks on a table that ends at x = 0, in courses.

    ``place`` has the right end of the first brick of each course, and the gap before each next one,
    ``x0`` to ``x3`` [lengths of a brick].
    """
    blocks = [box((6.0, 0.5, 0.25), (-6.0, 0.0, -0.25), "table")]
    for level, count in enumerate(courses):
        right = 0.0
        for i in range(int(count)):
            number = len(blocks) - 1
            step = place[f"x{number}"]
            if i and step < 0.0:
                raise InputError("two bricks of one course overlap", remedy="give a gap above zero")
            right = right - 1.0 - step if i else step
            corner = (right - 1.0, 0.0, 0.25 * level)
            blocks.append(box((1.0, 0.5, 0.25), corner, f"brick-{number}"))
    return Assembly(tuple(blocks)).with_fixed([0])


def four() -> tuple[str, str, str, str]:
    """Largest overhang of four bricks in any arrangement, without friction (Paterson et al. 2009).

    Arrangements and places by search; the best of each arrangement is then shaped by gradient.
    Friction between bricks of three courses would help.
    """
    best: Changed | None = None
    tried = []
    how = {"friction": 0.0}
    for courses in ARRANGEMENTS:
        gaps = [i > 0 for count in courses for i in range(int(count))]
        parameters = [
            Parameter(f"x{i}", 0.0 if gap else -0.2, 1.0 if gap else 1.1)
            for i, gap in enumerate(gaps)
        ]
        begun = tune(partial(bricks, courses), parameters, goals=["-reach"], how=how,
                     options=TuneOptions(trials=48, batch=16))  # fmt: skip
        for trial in begun.front:
            model = Model.of(bricks(courses, **trial.values), friction=0.0)
            names = [f"brick-{i}" for i in range(4)]
            far = int(np.argmax(model.assembly.bounds[1:, 1, 0]))
            options = ShapeOptions(aim="reach", block=names[far], rounds=40, close=1e-4)
            found = shape(model, block_moves(model, names, (1.0, 0.0, 0.0), 1.5), options=options)
            reach = float(found.model.assembly.bounds[1 + far, 1, 0])
            tried.append(f"{courses}: {reach:.4f}")
            print(tried[-1], file=sys.stderr, flush=True)
            if found.stands and (
                best is None or reach > best.model.assembly.bounds[1:, 1, 0].max()
            ):
                best = found
    if best is None:
        return "search", "nothing stands", "", ""
    reach = float(best.model.assembly.bounds[1:, 1, 0].max())
    known = (15.0 - 4.0 * np.sqrt(2.0)) / 8.0
    return "search", f"{reach:.4f} ({', '.join(tried)})", f"{known:.4f}", again(best)


def buttress() -> tuple[str, str, str, str]:
    """The buttressed arch with least masonry, against a scan of all thicknesses."""
    start, most = (
        {"thickness": 0.3, "buttress_width": 1.0},
        {"thickness": 0.2, "buttress_width": 0.85},
    )

    def build(**values: float) -> Assembly:
        return buttressed_arch(courses=3, **values)

    moves = FamilyMoves.of(build, start, most)
    found = shape(Model.of(build(**start), friction=0.7), moves, options=VOLUME)
    values = moves.values(found.x)
    least = np.inf, 0.0, 0.0
    for thickness in np.arange(0.1, 0.22, 0.01):
        low, high = float(thickness), 1.6
        while high - low > 2e-3:
            middle = 0.5 * (low + high)
            made = build(thickness=float(thickness), buttress_width=middle)
            stands = check(Model.of(made, friction=0.7)).stable
            low, high = (low, middle) if stands else (middle, high)
        made = build(thickness=float(thickness), buttress_width=high)
        if check(Model.of(made, friction=0.7)).stable:
            least = min(least, (float(made.volume.sum()), float(thickness), high))
    told = ", ".join(f"{name} {value:.3f}" for name, value in values.items())
    return (
        f"{found.first:.3f} m3", f"{found.value:.3f} m3 ({told})",
        f"{least[0]:.3f} m3 (scan: thickness {least[1]:.2f}, width {least[2]:.3f})", again(found),
    )  # fmt: skip


def hundred() -> tuple[str, str, str, str]:
    """An arch of 100 voussoirs, all vertices free: it falls, and is shaped to stand."""
    model = Model.of(arch(0.1, 100), friction=0.8)
    moves = free_vertices(model, 0.05, mirror="x")
    found = shape(model, moves)
    return "falls", f"{found.message}, {moves.count} variables", "60 s", again(found)


def lighter() -> tuple[str, str, str, str]:
    """An arch of 100 voussoirs, all vertices free: the least volume after some rounds."""
    model = Model.of(arch(0.15, 100), friction=0.8)
    moves = free_vertices(model, 0.03, mirror="x")
    options = ShapeOptions(aim="volume", rounds=6, iterations=15, least_edge=0.02)
    found = shape(model, moves, options=options)
    return f"{found.first:.4f} m3", f"{found.value:.4f} m3, {found.message}", "", again(found)


def gradient() -> tuple[str, str, str, str]:
    """CPU time of one gradient by that of a warm check, for 1 and for many variables."""
    model = Model.of(arch(0.15, 100), friction=0.8)
    form = Form.of(model)
    times = []
    for work in (lambda: check(model, options=CheckOptions(settle=False)),
                 lambda: form.help_at(form.bodies.vertex)):  # fmt: skip
        work()
        best = np.inf
        for _ in range(5):
            began = time.process_time()
            work()
            best = min(best, time.process_time() - began)
        times.append(best)
    some = f"{times[1]:.3f} s, {times[0]:.3f} s a check"
    return some, f"{times[1] / times[0]:.2f}", "at most 2", ""


def margin() -> tuple[str, str, str, str]:
    """Least thickness of an arch that stands tilted by 3 degrees."""
    options = ShapeOptions(aim="volume", margin=DesignMargin(tilt=3.0))
    found = shape(
        arch(0.3, 24), lambda m: thickening(m, (0.0, 0.0, 0.0), 0.25), friction=0.8, options=options
    )
    return "t/R 0.3", f"t/R {0.3 + float(found.x[0]):.4f}", "", again(found)


CASES: dict[str, Callable[[], tuple[str, str, str, str]]] = {
    "radial": radial,
    "vertical": vertical,
    "catenary": hanging,
    **{f"overhang-{n}": lambda n=n: overhang(n) for n in (1, 2, 3, 4, 6, 8)},  # type: ignore[misc]
    "four": four,
    "buttress": buttress,
    "hundred": hundred,
    "lighter": lighter,
    "gradient": gradient,
    "margin": margin,
}


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the rows that were asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("cases", nargs="*", metavar="CASE", help=", ".join(CASES))
    asked = parser.parse_args(arguments).cases or list(CASES)
    print(HEAD, end="", flush=True)
    for name in asked:
        began = time.process_time()
        start, found, known, file = CASES[name]()
        spent = time.process_time() - began
        print(f"| {name} | {start} | {found} | {known} | {file} | {spent:.0f} |", flush=True)


if __name__ == "__main__":
    main()
