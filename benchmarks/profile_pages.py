"""Where the time of one check goes, and its floor: ``python -m benchmarks.profile_pages``.

Walls of 4 to 100,000 blocks under their weight, uniform contact stiffness, one thread. Each runs in
a process of its own: CPU seconds of each part and the largest resident memory. The floor is the
arithmetic of all factorisations alone, at the speed of a product of two full matrices.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.machine import ONE_THREAD, ROOT
from benchmarks.measure import UNIFORM, peak_mib
from drystone import Model, check, find_contacts, models
from drystone.mechanics import rest
from drystone.mechanics.maps import SparseMaps
from drystone.solvers.multifrontal import BlockFactor, BlockOrdering
from drystone.solvers.threads import one_blas_thread
from drystone.stability import attempts
from drystone.stability.problem import Problem

SHAPES = {
    4: (4, 1),
    100: (10, 10),
    400: (20, 20),
    2_000: (45, 44),
    10_000: (100, 100),
    100_000: (316, 316),
}
"""Courses and block lengths per course."""
HEADS = (
    *("blocks", "corners", "build", "detect", "prepare", "matrix", "factor", "substitute"),
    *("states", "check", "total", "factors", "floor", "MiB"),
)


class Clock:
    """CPU seconds by name; inner parts are taken from outer ones."""

    def __init__(self) -> None:
        self.spent: Counter[str] = Counter()
        self.calls: Counter[str] = Counter()
        self.inside = [0.0]

    def of(self, name: str, work: Callable[..., Any]) -> Callable[..., Any]:
        """The same function, timed."""

        def timed(*given: Any, **named: Any) -> Any:
            began = time.thread_time()
            self.inside.append(0.0)
            try:
                return work(*given, **named)
            finally:
                whole = time.thread_time() - began
                self.spent[name] += whole - self.inside.pop()
                self.inside[-1] += whole
                self.calls[name] += 1

        return timed


def operations(ordering: BlockOrdering) -> float:
    """Multiplications and additions of one factorisation."""
    total = 0.0
    for front in ordering.fronts:
        p, b = 6.0 * len(front.pivots), 6.0 * len(front.boundary)
        total += 2.0 / 3.0 * p**3 + 2.0 * p * p * b + 2.0 * p * b * b
    return total


def peak_speed() -> float:
    """Operations a second of a product of two matrices of 400 rows."""
    left, right = np.random.default_rng(0).random((2, 400, 400))
    best = np.inf
    with one_blas_thread():
        for _ in range(10):
            began = time.thread_time()
            left @ right
            best = min(best, time.thread_time() - began)
    return 2.0 * 400.0**3 / best


def profile(courses: int, lengths: int) -> list[str]:
    """One row of the table."""
    clock = Clock()
    assembly = clock.of("build", models.wall)(courses, lengths)
    contacts = clock.of("detect", find_contacts)(assembly, friction=0.6).contacts
    model = Model(assembly, contacts)
    check(models.wall(2, 2), options=UNIFORM)  # what is imported late
    setattr(SparseMaps, "blocks", clock.of("matrix", SparseMaps.blocks))  # noqa: B010
    setattr(SparseMaps, "__init__", clock.of("prepare", SparseMaps.__init__))  # noqa: B010
    setattr(BlockOrdering, "factorise", clock.of("factor", BlockOrdering.factorise))  # noqa: B010
    setattr(BlockFactor, "solve", clock.of("substitute", BlockFactor.solve))  # noqa: B010
    setattr(SparseMaps, "factorise", clock.of("dense", SparseMaps.factorise))  # noqa: B010
    setattr(attempts, "check_forces", clock.of("check", attempts.check_forces))  # noqa: B010
    path = rest._Path
    setattr(path, "follow", clock.of("states", path.follow))  # noqa: B010
    clock.of("other", check)(model, options=UNIFORM)
    clock.spent["prepare"] += clock.spent["other"]
    clock.spent["factor"] += clock.spent["dense"]
    total = sum(clock.spent.values())
    ordering = Problem.build(model).statics.maps.ordering
    floor = operations(ordering) * clock.calls["dense"] / peak_speed()
    parts = [clock.spent[name] for name in HEADS[2:10]]
    return [
        f"{len(assembly):,}",
        f"{contacts.corner_count:,}",
        *(f"{part:.3g}" for part in parts),
        f"{total:.3g}",
        f"{clock.calls['dense']}",
        f"{floor:.3g}",
        f"{peak_mib():.0f}",
    ]


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--most", type=int, default=100_000, help="largest number of blocks")
    parser.add_argument("--one", type=int, help="one size, in this process")
    chosen = parser.parse_args()
    if chosen.one is not None:
        print("| " + " | ".join(profile(*SHAPES[chosen.one])) + " |")
        return 0
    print("| " + " | ".join(HEADS) + " |")
    print("|---:" * len(HEADS) + "|", flush=True)
    for size in SHAPES:
        if size <= chosen.most:
            command = [sys.executable, "-m", "benchmarks.profile_pages", "--one", str(size)]
            subprocess.run(command, cwd=ROOT, env=os.environ | ONE_THREAD, check=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
