"""One model, one answer: ``python -m benchmarks.one_answer FOLDER [--cases FILE]``.

Every model of a folder is checked at six seeds, in another place, turned, numbered the other way
and with other last digits of its load. All verdicts of a model have to be the same. Exit code 1
where they are not.

A line of the cases is the name of a file and the options of ``drystone check`` that it needs:

    wedge.obj --supports l,r --friction 0.84 --gravity=0,-6.3,-7.5

Files without a line keep their own supports, or rest on their lowest faces, at friction 0.6. Blocks
that overlap are taken as they are, as with ``--anyway``.
"""

from __future__ import annotations

import argparse
import shlex
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from drystone import Assembly, CheckOptions, InputError, LoadCase, Model, Verdict, check, io
from drystone import supports as support_choice
from drystone.base.arrays import Floats
from drystone.geometry.frames import rotation_about

SEEDS = range(6)
PLACE = (12.3, -45.6, 7.89)
FAR = (1234.5, -6789.0, 321.0)
TURNS = ((0.0, 0.0, 1.0, 37.0), (1.0, 2.0, 3.0, 77.0))
"""Axis and degrees."""
DIGITS = (3e-10, -3e-10, 2e-16)
"""Relative changes of the load."""


@dataclass(frozen=True)
class Case:
    """A model file and how it is checked."""

    name: str
    supports: str | None = None
    friction: float = 0.6
    gravity: tuple[float, ...] = (0.0, 0.0, -9.81)

    @property
    def label(self) -> str:
        """For the report."""
        return f"{self.name} friction {self.friction:g}"


@dataclass(frozen=True)
class Answers:
    """The verdicts on the copies of one case."""

    case: Case
    verdicts: dict[str, Verdict]
    message: str
    seconds: float

    @property
    def one(self) -> bool:
        """Whether they are all the same."""
        return len(set(self.verdicts.values())) == 1


def parsed(line: str) -> Case:
    """One line of the cases."""
    parser = argparse.ArgumentParser(exit_on_error=False)
    parser.add_argument("name")
    parser.add_argument("--supports")
    parser.add_argument("--friction", type=float, default=0.6)
    parser.add_argument("--gravity", default="0,0,-9.81")
    given = parser.parse_args(shlex.split(line))
    gravity = tuple(float(part) for part in given.gravity.split(","))
    return Case(given.name, given.supports, given.friction, gravity)


def cases_of(folder: Path, listed: Path | None) -> list[Case]:
    """The cases of a folder, those of the list first."""
    lines = [] if listed is None else listed.read_text(encoding="utf-8").splitlines()
    cases = [parsed(line) for line in lines if line.strip() and not line.startswith("#")]
    known = {case.name for case in cases}
    names = sorted(path.name for path in folder.iterdir() if path.is_file())
    return cases + [Case(name) for name in names if name not in known]


def copies(assembly: Assembly, pull: Floats) -> Iterator[tuple[str, Assembly, Floats, int]]:
    """What must not change the answer: its name, the blocks, gravity and the seed."""
    for seed in SEEDS:
        yield f"seed {seed}", assembly, pull, seed
    for place in (PLACE, FAR):
        yield f"moved by {place[0]:g}", assembly.transformed(translation=place), pull, 0
    for x, y, z, degrees in TURNS:
        turn = rotation_about((x, y, z), degrees)
        yield f"turned by {degrees:g}", assembly.transformed(turn), turn @ pull, 0
    backwards = Assembly(assembly.blocks[::-1], assembly.fixed[::-1])
    yield "numbered the other way", backwards, pull, 0
    for change in DIGITS:
        yield f"load {change:+.0e}", assembly, pull * (1.0 + change), 0


def answers(folder: Path, case: Case) -> Answers:
    """All verdicts of one case."""
    assembly = io.read(folder / case.name, anyway=True).assembly
    if case.supports is not None or not assembly.fixed.any():
        chosen = case.supports or "lowest"
        assembly = support_choice.select(assembly, chosen)
    began = time.process_time()
    verdicts: dict[str, Verdict] = {}
    message = ""
    for name, copy, pull, seed in copies(assembly, np.array(case.gravity)):
        model = Model.of(copy, friction=case.friction, load=LoadCase.of(copy, pull), anyway=True)
        found = check(model, options=CheckOptions(seed=seed))
        verdicts[name] = found.verdict
        message = message or found.message
    return Answers(case, verdicts, message, time.process_time() - began)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--cases", type=Path, help="lines of file names and options")
    given = parser.parse_args()
    differ = 0
    for case in cases_of(given.folder, given.cases):
        try:
            found = answers(given.folder, case)
        except InputError as error:
            print(f"{case.label}: not read: {error}", flush=True)
            differ += 1
            continue
        first = next(iter(found.verdicts.values()))
        other = [f"{name}: {one}" for name, one in found.verdicts.items() if one is not first]
        differ += not found.one
        print(
            f"{case.label}: {first}, {len(found.verdicts)} copies, {found.seconds:.1f} s; "
            f"{found.message}",
            flush=True,
        )
        for line in other:
            print(f"    DIFFERS, {line}", flush=True)
    print("one answer each" if not differ else f"{differ} without one answer")
    return 1 if differ else 0


if __name__ == "__main__":
    raise SystemExit(main())
