"""Questions that took long or had no answer: ``python -m benchmarks.hard_models [--only PART]``.

Limits near collapse, checks of large structures near their limit, towers, and blocks of very
different size. A line has the CPU seconds of one thread, the most that they may be, and the
answer. ``--model FILE`` adds the Armadillo vault, ``--folder`` the models ``slow-*.json``. Exit
code 1 where one took longer or is undecided.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.field.ferris import WALLS, wall_of_rows
from drystone import Assembly, LoadCase, Model, Verdict, check, io, models, shells, supports
from drystone.limits import Limit, TiltSweep, limit_friction, limit_load, limit_tilt, tilt_sweep
from drystone.models import box
from drystone.results import Result

Answer = Result | Limit | TiltSweep


def pushed_wall(number: int) -> Limit:
    """Least factor of a horizontal load that makes a wall fall."""
    assembly = wall_of_rows(WALLS[number].rows)
    return limit_load(Model.of(assembly, friction=0.65), LoadCase.seismic(assembly, 1.0))


def slippery_vault() -> Limit:
    """Least friction of a cross vault of 188 blocks."""
    shell = shells.build_shell(
        shells.cross_vault(), shells.Layout(courses=15, width=0.6, wedge=0.1)
    )
    return limit_friction(shell.assembly, friction=0.84)


def small(name: str, what: str) -> Limit:
    """A limit of a model file of few blocks."""
    model = io.read(name, anyway=True)
    if what == "load":
        return limit_load(model, LoadCase.seismic(model.assembly, 1.0))
    if what == "friction":
        return limit_friction(model)
    return limit_tilt(model, what)


def pebbles() -> dict[str, Model]:
    """Blocks that differ in size by a million."""
    ground = box((2e3, 2e3, 1e3), (-1e3, -1e3, -1e3), name="ground")
    boulder = box((1e3, 1e3, 1e3), (-500, -500, 0), name="boulder")
    above = box((1e-3, 1e-3, 1e-3), (0, 0, 1e3), name="pebble")
    feet = [box((1e-3, 1e-3, 1e-3), (x, y, 0), name=f"p{x}{y}") for x in (-1, 1) for y in (-1, 1)]
    raised = box((1e3, 1e3, 1e3), (-500, -500, 1e-3), name="boulder")
    blocks = {
        "pebble on boulder": (ground, boulder, above),
        "boulder on pebbles": (ground, *feet, raised),
    }
    found = {}
    for name, those in blocks.items():
        found[name] = Model.of(Assembly(those, np.arange(len(those)) == 0), friction=0.6)
    return found


def tilted(model: Model, angle: float, friction: float) -> Result:
    """The verdict where a model is turned about x."""
    case = LoadCase.tilt(model.assembly, (1.0, 0.0, 0.0), angle)
    return check(model.with_friction(friction).with_load(case))


def questions(
    vault: Path | None, folder: Path | None
) -> dict[str, tuple[float, Callable[[], Answer]]]:
    """The most CPU seconds, and what is asked."""
    arch = Model.of(models.arch(0.15, 37), friction=0.8)
    found: dict[str, tuple[float, Callable[[], Answer]]] = {
        **{f"load of wall {i}": (10.0, partial(pushed_wall, i)) for i in WALLS},
        "friction of a cross vault": (4.0, slippery_vault),
        "polar tilt of an arch": (20.0, partial(tilt_sweep, arch, 8)),
        "polar tilt of a vault": (20.0, partial(tilt_sweep, models.vault(), 8, friction=0.84)),
    }
    for height in (200, 400):
        tower = Model.of(models.tower(height), friction=0.6)
        for angle in (0.0, 0.05, 0.1, 0.14, 0.2, 1.0):
            found[f"tower of {height} at {angle:g}"] = 30.0, partial(tilted, tower, angle, 0.6)
    for name, model in pebbles().items():
        for angle in (0.0, 10.0, 30.0, 31.5, 50.0):
            found[f"{name} at {angle:g}"] = 30.0, partial(tilted, model, angle, 0.6)
    if vault is not None:
        whole = io.read(vault, friction=0.84)
        for angle in range(18, 32):
            found[f"armadillo at {angle}"] = 30.0, partial(tilted, whole, float(angle), 0.84)
        for percent in range(15, 33):
            mu = 0.01 * percent
            found[f"armadillo friction {mu:.2f}"] = 30.0, partial(tilted, whole, 0.0, mu)
        lowest = supports.select(whole.assembly, "lowest")
        found["tilt of the armadillo"] = 60.0, partial(limit_tilt, lowest, "x", friction=0.84)
        found["friction of the armadillo"] = 60.0, partial(limit_friction, lowest, friction=0.84)
    for path in [] if folder is None else sorted(folder.glob("slow-*.json")):
        for what in ("x", "y", "load", "friction"):
            found[f"{path.stem} {what}"] = 10.0, partial(small, str(path), what)
    return found


def told(answer: Answer) -> tuple[str, bool]:
    """The answer in one line, and whether it is one."""
    if isinstance(answer, Result):
        return f"{answer.verdict.value}: {answer.message}", answer.verdict is not Verdict.UNDECIDED
    if isinstance(answer, TiltSweep):
        return f"{answer.rest.round(2).tolist()} of {answer.equilibrium.round(2).tolist()}", True
    rest = answer.best
    said = f"stands {rest.stands}, falls {rest.falls}, {len(answer.evaluations)} values"
    return "; ".join((said, *answer.remarks)), rest.stands is not None or rest.falls is not None


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", default="", help="part of a question")
    parser.add_argument("--model", type=Path, help="the Armadillo vault")
    parser.add_argument("--folder", type=Path, help="folder with slow-*.json")
    arguments = parser.parse_args()
    missed = 0
    for name, (most, ask) in questions(arguments.model, arguments.folder).items():
        if arguments.only not in name:
            continue
        began = time.process_time()
        said, answered = told(ask())
        spent = time.process_time() - began
        held = answered and spent <= most
        missed += not held
        print(
            f"{name}: {spent:.2f} s (at most {most:g}){'' if held else ', MISSED'}; {said}",
            flush=True,
        )
    return 1 if missed else 0


if __name__ == "__main__":
    raise SystemExit(main())
