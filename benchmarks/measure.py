"""One workload in a process of its own: ``python -m benchmarks.measure KEY`` prints JSON.

Phases are timed apart in CPU seconds of the one thread, which are the seconds of an idle machine,
and the best of several runs is kept. The answer is checked before any time is written: it is the
one known beforehand, and the residuals of its forces and motion, or of its mechanism, are computed
from points and cross products.
"""

from __future__ import annotations

import argparse
import json
import resource
import sys
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from benchmarks.convex import by_clarabel, by_piqp
from benchmarks.workloads import PILES, Task, Workload, random_pile, workloads
from drystone import Assembly, CheckOptions, Contacts, LoadCase, Result, Verdict, check_many
from drystone.checks import mechanism_defects, unbalanced_wrench
from drystone.geometry.frames import rotation_about
from drystone.limits import LimitOptions, limit_tilt
from drystone.model import Model
from drystone.programs import RBEOptions, solve_rbe
from drystone.stability import check

RESIDUAL = 1e-8
"""Largest residual of forces and motion, dimensionless."""
CLOSING = 1e-5
"""Largest closing of a gap in a motion that shows a fall, by the speed of its blocks."""
BALANCE = 1e-6
"""The same for forces of an interior point method, which end at its tolerance."""
ENOUGH_S = 0.5
RUNS = 20
"""Runs are repeated until they took so long together; at least once, at most so often."""
UNIFORM = CheckOptions(samples=0, settle=False)
"""The verdict with uniform stiffness: forces and motion, or a mechanism or first motion."""
ARCH_LIMIT = 8.2
"""[degrees], Kao 2023; checked to its last digit."""

T = TypeVar("T")


def timed(work: Callable[[], T], enough_s: float) -> tuple[T, float]:
    """The answer, and the least CPU seconds of several runs."""
    total, best = 0.0, float("inf")
    for _ in range(RUNS):
        began = time.thread_time()
        answer = work()
        spent = time.thread_time() - began
        total, best = total + spent, min(best, spent)
        if total >= enough_s:
            break
    return answer, best


def idle_threads(before_s: float = 0.0) -> bool:
    """Whether all work was done by this thread (to 5 %, and a tenth of a second).

    But for ``before_s`` of others: manifold3d uses a thread in the search for contacts.
    """
    return time.process_time() - before_s <= 1.05 * time.thread_time() + 0.1


def peak_mib() -> float:
    """Largest resident size of this process so far."""
    size = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return size / (1024.0**2 if sys.platform == "darwin" else 1024.0)


def defect(result: Result) -> str:
    """What is wrong with the proof of a verdict; empty when nothing is."""
    assembly, contacts, load = result.assembly, result.contacts, result.load
    if result.verdict is Verdict.STABLE:
        if result.residuals is None or result.displacement is None:
            return "no forces"
        worst = result.residuals.largest
        return "" if worst <= RESIDUAL else f"residual {worst:.1e}"
    if result.verdict is Verdict.EQUILIBRIUM_EXISTS:
        if result.force is None:
            return "no forces"
        wrench, scale = unbalanced_wrench(Model(assembly, contacts, load), result.force)
        free = assembly.free
        worst = float((np.linalg.norm(wrench[free], axis=1) / scale[free]).max())
        slack = contacts.friction[contacts.interface] * result.force[:, 0]
        over = np.linalg.norm(result.force[:, 1:], axis=1) - slack
        worst = max(worst, float(over.max()) / float(np.linalg.norm(result.force, axis=1).max()))
        return "" if worst <= BALANCE else f"unbalanced by {worst:.1e}"
    if result.mechanism is None:
        return "no mechanism"
    apart = replace(contacts, friction=np.zeros(contacts.count))
    closing, power = mechanism_defects(Model(assembly, apart, load), result.mechanism)
    return "" if closing <= CLOSING and power > 0.0 else f"mechanism closes by {closing:.1e}"


def measure(work: Workload, whole: bool, enough_s: float = ENOUGH_S) -> dict[str, Any]:
    """All phases of one workload; ``whole`` also times all stiffnesses."""
    assembly, build = timed(work.build, enough_s)
    contacts, detect = timed(lambda: work.find(Assembly(assembly.blocks, assembly.fixed)), enough_s)
    others_s = time.process_time() - time.thread_time()
    load = work.load(assembly)
    row: dict[str, Any] = {
        "key": work.key,
        "blocks": len(assembly),
        "corners": contacts.corner_count,
        "build_s": build,
        "detect_s": detect,
    }
    if work.task is Task.PILES:
        return _piles(row, enough_s)
    if work.task is Task.TILT:
        return row | _tilt_limit(work, assembly, contacts, enough_s)
    result, seconds = timed(_question(work, assembly, contacts, load), enough_s)
    row |= {
        "total_s": seconds,
        "verdict": result.verdict.value,
        "right": result.verdict is work.expected,
        "defect": defect(result),
        "iterations": result.iterations,
        "peak_mib": peak_mib(),
        "one_thread": idle_threads(others_s),
    }
    if whole and work.task is Task.VERDICT:
        # longer, so that the least is of about as many runs
        all_s = 3.0 * enough_s
        model = Model(assembly, contacts, load)
        full, row["whole_s"] = timed(lambda: check(model, options=CheckOptions.robust()), all_s)
        row["all_by_one"] = row["whole_s"] / seconds
        row["whole_verdict"] = full.verdict.value
        row["right"] = row["right"] and full.verdict is work.expected
        row["samples"] = f"{full.samples.standing} of {full.samples.tried}"
    return row


def _question(
    work: Workload, assembly: Assembly, contacts: Contacts, load: LoadCase
) -> Callable[[], Result]:
    if work.task is Task.BALANCE:
        return lambda: solve_rbe(Model(assembly, contacts, load), options=RBEOptions.feasibility())
    return lambda: check(Model(assembly, contacts, load), options=UNIFORM)


def convex(work: Workload, enough_s: float = ENOUGH_S) -> dict[str, Any]:
    """RBE of a workload, by us and by convex solvers."""
    assembly = work.build()
    model = Model(assembly, work.find(assembly), work.load(assembly))
    feasible = RBEOptions.feasibility()
    result, ours_s = timed(lambda: solve_rbe(model, options=feasible), enough_s)
    row: dict[str, Any] = {"rbe": result.verdict.value, "rbe_s": ours_s}
    for name, solve in (("piqp", by_piqp), ("clarabel", by_clarabel)):
        found = [solve(model) for _ in range(RUNS if ours_s < 0.1 else 1)]
        row |= {name: found[0][0], f"{name}_s": min(seconds for _, seconds in found)}
    return row


def _tilt_limit(
    work: Workload, assembly: Assembly, contacts: Contacts, enough_s: float
) -> dict[str, Any]:
    def find() -> tuple[float, float]:
        limit = limit_tilt(
            Model(assembly, contacts),
            work.axis,
            check=lambda model: check(model, options=CheckOptions(samples=0)),
            options=LimitOptions(width=0.05),
        )
        return limit.equilibrium.value, limit.best.value

    (balance, rest), seconds = timed(find, enough_s)
    near = abs(rest - ARCH_LIMIT) <= 0.1
    return {
        "total_s": seconds,
        "verdict": f"{rest:.2f} deg",
        "right": near,
        "defect": "" if near else f"{ARCH_LIMIT} published, equilibrium {balance:.2f}",
        "iterations": 0,
        "peak_mib": peak_mib(),
        "one_thread": idle_threads(),
    }


def _piles(row: dict[str, Any], enough_s: float) -> dict[str, Any]:
    """Verdicts of random piles: each with its proof, none against equilibrium."""
    piles = [random_pile(seed) for seed in range(PILES)]
    table, seconds = timed(lambda: check_many(piles), enough_s)
    found = [check(one) for one in piles]  # with their proofs
    count = Counter(one.verdict.value for one in found)
    alike = table["verdict"].tolist() == [one.verdict.value for one in found]
    wrong = "" if alike else "many models at once have other verdicts than one by one"
    for seed, (pile, one) in enumerate(zip(piles, found, strict=True)):
        if one.verdict is Verdict.UNDECIDED:
            continue
        balance = solve_rbe(pile, options=RBEOptions.feasibility()).verdict
        if balance is Verdict.UNSTABLE and one.verdict is Verdict.STABLE:
            wrong = f"pile {seed} stands without equilibrium"
        wrong = wrong or _unproved(one, seed)
    return row | {
        "total_s": seconds,
        "verdict": ", ".join(f"{number} {name}" for name, number in sorted(count.items())),
        "right": True,
        "defect": wrong,
        "iterations": sum(one.iterations for one in found),
        "peak_mib": peak_mib(),
        "one_thread": idle_threads(),
    }


def _unproved(result: Result, seed: int) -> str:
    settled = result.settlement
    if settled is not None and result.verdict is Verdict.UNSTABLE:
        return ""  # the path is the proof
    if settled is not None and settled.rests:
        # the proof is that of the forces on the moved blocks
        worst = max(path.residuals.largest for path in settled.paths if path.residuals is not None)
        return "" if worst <= RESIDUAL else f"pile {seed} rests with residual {worst:.1e}"
    found = defect(result)
    return f"pile {seed}: {found}" if found else ""


def dump(work: Workload, path: Path) -> None:
    """The model as plain lists, turned as a whole: the peer has gravity along -z only."""
    assembly = work.build()
    contacts = work.find(assembly)
    turn = rotation_about(work.axis, work.tilt_deg)
    fixed = assembly.fixed
    model = {
        "friction": work.friction,
        "fixed": np.flatnonzero(fixed).tolist(),
        "blocks": [
            {"vertices": (block.vertices @ turn.T).tolist(), "faces": block.faces}
            for block in assembly.blocks
        ],
        "interfaces": [
            {
                "a": int(contacts.block_a[i]),
                "b": int(contacts.block_b[i]),
                "area": float(contacts.area[i]),
                "points": (contacts.polygon(i) @ turn.T).tolist(),
                "frame": (contacts.frame[i] @ turn.T).tolist(),
            }
            for i in range(contacts.count)
            if not (fixed[contacts.block_a[i]] and fixed[contacts.block_b[i]])
        ],
    }
    path.write_text(json.dumps(model), encoding="utf-8")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("key")
    parser.add_argument("--armadillo", type=Path)
    parser.add_argument("--dump", type=Path, help="write the model for the peer instead")
    parser.add_argument("--whole", action="store_true", help="also with all stiffnesses")
    parser.add_argument("--convex", action="store_true", help="RBE instead, and convex solvers")
    arguments = parser.parse_args()
    work = workloads(arguments.armadillo)[arguments.key]
    if arguments.dump is not None:
        dump(work, arguments.dump)
        print(json.dumps({"written": str(arguments.dump)}))
    elif arguments.convex:
        print(json.dumps(convex(work)))
    else:
        print(json.dumps(measure(work, arguments.whole)))


if __name__ == "__main__":
    main()
