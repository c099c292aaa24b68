"""How far a reader walks: ``python -m benchmarks.walks [--only PART] [--elimination MODULE ...]``.

Four trips through the package are followed with a profiler: files and functions that were entered,
calls, calls from one file to another, and the deepest stack, of functions of drystone only.
Functions are defined once where they stand: comprehensions and lambdas do not count, nor does what
an import runs. Then the frames from ``check`` down to the first call of the elimination, by name.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

import drystone
from drystone import Model, Result, models, shells
from drystone.design import find_mends

ELIMINATION = (
    "drystone.solvers.banded",
    "drystone.solvers.factors",
    "drystone.solvers.multifrontal",
    "drystone.mechanics.elimination",
)
"""Modules, or packages, that factorise."""
FRICTION = 0.9
PACKAGE = str(Path(drystone.__file__).parent)


@dataclass
class Walk:
    """What was entered on a trip.

    Attributes
    ----------
    files, codes
    calls, hops
        A hop is a call from one file to another.
    deepest
        Number of frames.
    way
        Names of the frames from ``check`` to the first one of the elimination.
    """

    elimination: Sequence[str]
    files: set[str] = field(default_factory=set)
    codes: set[CodeType] = field(default_factory=set)
    calls: int = 0
    hops: int = 0
    deepest: int = 0
    way: tuple[str, ...] = ()
    stack: list[FrameType] = field(default_factory=list)

    def __call__(self, frame: FrameType, event: str, _: Any) -> None:
        """One event of the profiler."""
        if event == "return":
            if self.stack and self.stack[-1] is frame:
                self.stack.pop()
            return
        code = frame.f_code
        ours = event == "call" and code.co_filename.startswith(PACKAGE)
        if not ours or code.co_name.startswith("<") or "__module__" in code.co_names:
            return
        self.calls += 1
        if self.stack and self.stack[-1].f_code.co_filename != code.co_filename:
            self.hops += 1
        self.stack.append(frame)
        self.codes.add(code)
        self.files.add(code.co_filename)
        self.deepest = max(self.deepest, len(self.stack))
        module = str(frame.f_globals.get("__name__", ""))
        if not self.way and f"{module}.".startswith(tuple(f"{one}." for one in self.elimination)):
            names = [one.f_code.co_qualname for one in self.stack]
            begin = names.index("check") if "check" in names else 0
            self.way = tuple(names[begin:])


def followed(work: Callable[[], object], elimination: Sequence[str]) -> Walk:
    """Work under the profiler."""
    walk = Walk(elimination)
    sys.setprofile(walk)
    try:
        work()
    finally:
        sys.setprofile(None)
    return walk


def arch_file(folder: Path, thickness: float, voussoirs: int) -> Path:
    """An arch as OBJ."""
    path = folder / f"arch-{thickness:g}-{voussoirs}.obj"
    drystone.write(models.arch(thickness, voussoirs), path)
    return path


def verdict(path: Path) -> Result:
    """From the file to the verdict."""
    return drystone.check(drystone.read(path, friction=FRICTION, supports="lowest"))


def shell() -> shells.Shell:
    """From a surface to blocks."""
    layout = shells.Layout(courses=5, blocks=4)
    return shells.build_shell(shells.barrel_vault(), layout)


def surface_to_plan() -> drystone.sequence.Plan:
    """From a surface to a plan."""
    return drystone.plan(Model.of(shell().assembly, friction=FRICTION))


def page(result: Result, folder: Path) -> None:
    """From the forces to the page."""
    drystone.save_page(result, folder / "arch.html")


def mends(path: Path) -> object:
    """From a fall to its mends."""
    return find_mends(drystone.read(path, friction=FRICTION, supports="lowest"))


def main() -> int:
    """Follow each trip, after one like it that imports everything."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", default="", help="part of a trip's name")
    parser.add_argument("--elimination", nargs="+", default=ELIMINATION, help="modules")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        arch, thin = arch_file(folder, 0.15, 36), arch_file(folder, 0.09, 36)
        small = arch_file(folder, 0.08, 6)
        trips: dict[str, tuple[Callable[[], object], Callable[[], object]]] = {
            "file to verdict": (partial(verdict, arch), partial(verdict, arch)),
            "file to verdict, falls": (partial(verdict, thin), partial(verdict, thin)),
            "force to page": (lambda: page(verdict(arch), folder), lambda: None),
            "surface to shell": (shell, shell),
            "surface to plan": (surface_to_plan, surface_to_plan),
            "fall to mends": (partial(mends, small), partial(mends, thin)),
        }
        print(f"{'':24}{'files':>7}{'functions':>11}{'deepest':>9}{'calls':>11}{'hops':>11}")
        for name, (before, work) in trips.items():
            if given.only not in name:
                continue
            before()
            if name == "force to page":
                work = partial(page, verdict(arch), folder)
            walk = followed(work, given.elimination)
            print(
                f"{name:24}{len(walk.files):7,}{len(walk.codes):11,}{walk.deepest:9,}"
                f"{walk.calls:11,}{walk.hops:11,}",
                flush=True,
            )
            if name.startswith("file to verdict"):
                print(f"    {len(walk.way)} frames to the elimination: {', '.join(walk.way)}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
