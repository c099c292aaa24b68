"""A thousand subsets of a structure, beside PIQP: ``python -m benchmarks.subsets``.

Random orders of removal: the next block is one of the 16 highest in place, as a planner tries them,
and what is no longer connected to a support goes with it. Where a model has too few subsets one
block of each is held. PIQP is asked too (`benchmarks.convex`). Times are CPU seconds of one thread.

``--check`` asks ``drystone.check`` about every subset too; another verdict ends with exit code 1.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Callable

import numpy as np

from benchmarks.convex import by_piqp
from benchmarks.machine import description
from drystone import Assembly, Model, Structure, Verdict, check, models
from drystone.sequence import Stage, StagedModel
from drystone.sequence.stages import members
from drystone.solvers.threads import one_blas_thread

WIDTH = 16
"""Blocks of which one is removed: as many as a planner tries."""
MODELS: dict[str, tuple[Callable[[], Assembly], float]] = {
    "wall": (lambda: models.wall(8, 7), 0.6),
    "vault": (models.barrel_vault, 0.6),
    "arch": (lambda: models.arch(0.25, 21), 0.6),
    "bridge": (models.bridge, 0.66),
}

Subset = tuple[int, int]


def subsets(model: Model, count: int, seed: int) -> list[Subset]:
    """Blocks in place, and the held ones among them, as bits, in the order asked."""
    whole, draw = StagedModel(model), np.random.default_rng(seed)
    from_top = sorted(members(whole.everything), key=lambda b: -whole.height[b])
    out: dict[Subset, None] = {}
    for order in range(20 * count):
        placed = whole.everything
        while placed and len(out) < count:
            held = 0
            if order > count:
                held = 1 << int(draw.choice(list(members(placed))))
            out[placed, held] = None
            there = [block for block in from_top if placed >> block & 1][:WIDTH]
            placed &= ~(1 << int(draw.choice(there)))
            placed &= ~whole.floating(placed)
    return list(out)


def cut_out(model: Model, subset: Subset) -> Model:
    """The blocks in place and the supports, held ones fixed."""
    part, _ = StagedModel(model).cut_out(Stage(*subset))
    return part.with_contacts(part.contacts.select(part.active))


@one_blas_thread()
def measured(name: str, chosen: argparse.Namespace) -> int:
    """Print the row of a model; the number of subsets with another verdict than a check."""
    build, friction = MODELS[name]
    model = Model.of(build(), friction=friction)
    asked = subsets(model, chosen.count, chosen.seed)
    cuts = [cut_out(model, one) for one in asked]
    said, peer = zip(*map(by_piqp, cuts), strict=True)
    mean = 1e3 * float(np.mean(peer))
    print(f"{name}: {len(model)} blocks, {len(asked)} subsets; PIQP: {dict(Counter(said))}")
    print(f"  PIQP             mean {mean:7.2f} ms, most {1e3 * max(peer):8.1f} ms", flush=True)
    wrong = 0
    for robust in (False, True):
        structure = Structure(model, robust=robust, each_s=chosen.each)
        times, found = [], []
        for placed, held in asked:
            blocks, fixed = list(members(placed)), list(members(held))
            began = time.thread_time()
            found.append(structure.stands(blocks, held=fixed))
            times.append(time.thread_time() - began)
        ours, most = 1e3 * float(np.mean(times)), 1e3 * max(times)
        kinds = Counter(one.verdict.value for one in found)
        kind = "robust" if robust else "plain "
        print(
            f"  {kind}           mean {ours:7.2f} ms, most {most:8.1f} ms,"
            f" {most / ours:5.1f} times; {ours / mean:5.2f} of PIQP; {dict(kinds)}",
            flush=True,
        )
        stood = [one.stands and word != "solved" for one, word in zip(found, said, strict=True)]
        if any(stood):
            print(f"  {sum(stood)} stand that PIQP did not solve")
        if chosen.check and not robust:
            wrong = compared(model, asked, [one.verdict for one in found])
    return wrong


def compared(model: Model, asked: list[Subset], verdicts: list[Verdict]) -> int:
    """The number of subsets with another verdict than a check."""
    times, wrong = [], 0
    for number, (subset, verdict) in enumerate(zip(asked, verdicts, strict=True)):
        part = cut_out(model, subset)
        began = time.thread_time()
        found = check(part)
        times.append(time.thread_time() - began)
        if found.verdict is not verdict:
            wrong += 1
            print(f"  {number}: {verdict}; check says {found.verdict}", flush=True)
    print(
        f"  check            mean {1e3 * float(np.mean(times)):7.2f} ms, most"
        f" {1e3 * max(times):8.1f} ms; {wrong} of {len(asked)} verdicts differ",
        flush=True,
    )
    return wrong


def main() -> int:
    """Run, and print a block of rows for each model."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("models", nargs="*", default=[*MODELS], help=", ".join(MODELS))
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--each", type=float, default=float("inf"), help="[s], of every check")
    parser.add_argument("--check", action="store_true", help="compare with drystone.check")
    chosen = parser.parse_args()
    print(description())
    return 1 if sum(measured(name, chosen) for name in chosen.models) else 0


if __name__ == "__main__":
    sys.exit(main())
