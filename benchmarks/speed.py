"""Time and memory of the analyses: ``python -m benchmarks.speed`` writes both tables of speed.

Every workload runs in a process of its own, on one thread. Its answer is checked first; a wrong
answer, or one without its proof, has no time. With ``--peer PYTHON`` the same model, with the same
interfaces, is given to compas_cra in the environment of that interpreter right afterwards.
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from benchmarks.machine import ROOT, ask, checkout_of, description
from benchmarks.tables import TABLES, write_table
from benchmarks.workloads import LARGE, WALLS, Task, Workload, workloads
from drystone import Verdict

GROUPS = {
    "armadillo": "Armadillo vault",
    "small": "Small models of the dissertation",
    "piles": "Random piles of ten blocks, tilted by up to 40 degrees: a hundred verdicts with "
    "`check_many`",
    "walls": "Running-bond walls",
    "dome": "Domes",
    "vault": "Barrel vaults",
    "limits": "Tilt limit",
}

GROWTH = 1.15
PEAK_MIB = 2048.0
SMALL_RATIO, WALL_RATIO = 10.0, 100.0
ALL_BY_ONE = 2.5
"""Aims: growth exponent, peak memory at 10,000 blocks, times faster than the peer, and
from LARGE blocks on the time with all stiffnesses by that with the uniform one alone."""

CONVEX = ("piqp", "clarabel")
"""Solvers of the question of RBE, as ``benchmarks.convex`` asks them."""


@dataclass(frozen=True)
class Row:
    """A workload, what was measured, the peer's part, and that of convex solvers."""

    work: Workload
    ours: dict[str, Any]
    peer: dict[str, Any]
    convex: dict[str, Any] = field(default_factory=dict)
    before: dict[str, Any] = field(default_factory=dict)

    def slower(self, phase: str = "total_s") -> float:
        """Our time by that of the commit before; not a number where an answer is wrong or missing.

        ``total_s`` is with uniform contact stiffness, ``whole_s`` with all stiffnesses,
        ``detect_s`` for the contacts.
        """
        timed = phase in self.before and phase in self.ours
        if self.wrong or not timed or not self.before["right"]:
            return math.nan
        return float(self.ours[phase]) / float(self.before[phase])

    @property
    def wrong(self) -> str:
        """Why the measurement does not count; empty when it does."""
        if "failed" in self.ours:
            return str(self.ours["failed"])
        if not self.ours["right"]:
            found = dict.fromkeys((self.ours["verdict"], self.ours.get("whole_verdict", "")))
            return f"{' '.join(found)} instead of {self.work.expected.value}"
        return str(self.ours["defect"]) or ("" if self.ours["one_thread"] else "several threads")

    @property
    def seconds(self) -> float:
        """CPU time of the analysis; not a number where it does not count."""
        return math.nan if self.wrong else float(self.ours["total_s"])

    def ratio(self, phase: str = "total_s") -> float:
        """How many times longer the peer took, at least; not a number where it was not asked."""
        if self.wrong or phase not in self.ours or "solve_s" not in self.peer:
            return math.nan
        return float(self.peer["solve_s"]) / float(self.ours[phase])

    def convex_ratio(self, seconds: float | None = None) -> float:
        """Time of the faster convex solver for RBE by our solve, or by some seconds.

        Not a number where they were not asked.
        """
        fastest = min(self.convex.get(f"{name}_s", math.nan) for name in CONVEX)
        return float(fastest) / (self.seconds if seconds is None else seconds)

    @property
    def differs(self) -> bool:
        """Whether both convex solvers say other than our RBE."""
        ours = self.convex.get("rbe") == Verdict.EQUILIBRIUM_EXISTS.value
        return bool(self.convex) and all((self.convex[n] == "solved") != ours for n in CONVEX)


def run(
    chosen: Sequence[Workload], arguments: argparse.Namespace, tell: Callable[[str], None]
) -> list[Row]:
    """Measure one workload after the other, the peer straight after each."""
    rows: list[Row] = []
    earlier = checkout_of(arguments.before) if arguments.before else nullcontext()
    with earlier as checkout:
        for work in chosen:
            rows.append(_row(work, arguments, checkout))
            row = rows[-1]
            against = ""
            for phase, word in (("detect_s", "contacts"), ("total_s", "solve")):
                if row.slower(phase) > 0.0:
                    against += f", {word} {row.slower(phase):.2f} times the time before"
            if "answer" in row.peer:
                against += f", peer {row.peer['solve_s']:.3f} s ({row.peer['answer']})"
            tell(f"{work.key:28s} {row.wrong or f'{row.seconds:.4f} s'}{against}")
    return rows


def _row(work: Workload, arguments: argparse.Namespace, before: Path | None) -> Row:
    """One workload, then the same by the commit before, then the peer."""
    extra = ["--armadillo", arguments.armadillo.resolve()] if arguments.armadillo else []
    command = [sys.executable, "-m", "benchmarks.measure", work.key, *extra]
    whole = [] if work.large and not arguments.whole else ["--whole"]
    ours = ask([*command, *whole], arguments.limit)
    earlier = {} if before is None else ask([*command, *whole], arguments.limit, before)
    peer = asked(command, arguments) if work.peer and arguments.peer else {}
    forces = work.task in (Task.VERDICT, Task.BALANCE) and arguments.convex
    others = ask([*command, "--convex"], arguments.limit) if forces else {}
    return Row(work, ours, peer, others, earlier)


def asked(command: Sequence[str | Path], arguments: argparse.Namespace) -> dict[str, Any]:
    """The peer's answers on the model of a command."""
    with tempfile.TemporaryDirectory() as folder:
        model = Path(folder) / "model.json"
        written = ask([*command, "--dump", model], arguments.limit)
        if "failed" in written:
            return {"answer": f"not asked: {written['failed']}"}
        script = ROOT / "benchmarks" / "field" / "cra_peer.py"
        solved = ask([arguments.peer, script, model], arguments.peer_limit)
    if "failed" not in solved:
        return solved
    if not solved.get("stopped"):
        return {"answer": solved["failed"]}
    return {"answer": solved["failed"], "solve_s": arguments.peer_limit, "stopped": True}


def slope(points: Sequence[tuple[float, float]]) -> float:
    """Exponent of growth: least squares through logarithms of (size, time)."""
    kept = [(math.log(x), math.log(y)) for x, y in points if y == y and y > 0.0]
    if len(kept) < 2:
        return math.nan
    return statistics.linear_regression(*zip(*kept, strict=True)).slope


def seconds(value: float | None) -> str:
    """Three figures, or nothing."""
    return "" if value is None or value != value else f"{value:.3g}"


def table(rows: Sequence[Row]) -> list[str]:
    """Markdown lines."""
    lines = [
        "| group | model | blocks | corners | build | detect | solve | at most | answer "
        "| with all stiffnesses | stands for | peak MiB | peer cra_solve | peer's answer | ratio "
        "| ratio, all | our RBE | PIQP | Clarabel | best of both by RBE | best by solve |",
        "|---" * 21 + "|",
    ]
    for row in rows:
        ours, peer, wrong = row.ours, row.peer, row.wrong
        more = ">" if peer.get("stopped") else ""
        cells = [
            GROUPS[row.work.group],
            row.work.key,
            ours.get("blocks", ""),
            ours.get("corners", ""),
            seconds(ours.get("build_s")),
            seconds(ours.get("detect_s")),
            seconds(row.seconds),
            seconds(row.work.aim_s),
            f"WRONG: {wrong}" if wrong else ours["verdict"],
            seconds(ours.get("whole_s")) if not wrong else "",
            ours.get("samples", ""),
            f"{ours['peak_mib']:.0f}" if "peak_mib" in ours else "",
            more + seconds(peer.get("solve_s")),
            peer.get("answer", ""),
            more + seconds(row.ratio()) if row.ratio() == row.ratio() else "",
            more + seconds(row.ratio("whole_s")) if row.ratio("whole_s") > 0.0 else "",
            *(seconds(row.convex.get(f"{name}_s")) for name in ("rbe", *CONVEX)),
            seconds(row.convex_ratio(row.convex.get("rbe_s"))),
            seconds(row.convex_ratio()),
        ]
        lines.append("| " + " | ".join(str(cell) for cell in cells) + " |")
    return lines


def aims(rows: Sequence[Row]) -> list[str]:
    """Each aim beside what was found."""
    by_key = {row.work.key: row for row in rows}
    lines = ["| aim | at most | found | |", "|---|---:|---:|---|"]

    def line(what: str, bound: str, value: float, met: bool | None) -> None:
        if value == value:
            word = {True: "met", False: "**missed**", None: ""}[met]
            lines.append(f"| {what} | {bound} | {value:.3g} | {word} |")

    wrong = sum(bool(row.wrong) for row in rows)
    line("wrong answers", "0", wrong, wrong == 0)
    small = [row for row in rows if row.work.group == "small"]
    upright = [row.seconds for row in small if row.work.tilt_deg == 0.0 and not row.wrong]
    if upright:
        worst = max(upright)
        line("slowest small model, upright [s]", "0.02", worst, worst <= 0.02)
        middle = statistics.median(upright)
        line("median small model, upright [s]", "0.02", middle, middle <= 0.02)
    tilted = [row.seconds for row in small if row.work.tilt_deg != 0.0 and not row.wrong]
    if tilted:
        line("slowest near its limit", "", max(tilted), None)
    whole = [row.ours["whole_s"] for row in small if "whole_s" in row.ours and not row.wrong]
    if whole:
        line("slowest with all stiffnesses, and followed [s]", "0.1", max(whole), max(whole) <= 0.1)
    for row in rows:
        aim = row.work.aim_s
        if aim is not None and row.work.group != "small":
            line(f"{row.work.key} [s]", f"{aim:g}", row.seconds, row.seconds <= aim)
        aim = row.work.whole_aim_s
        if aim is not None and not row.wrong:
            all_s = row.ours["whole_s"]
            line(f"{row.work.key}, all stiffnesses [s]", f"{aim:g}", all_s, all_s <= aim)
        if row.ours.get("blocks", 0) >= LARGE and "all_by_one" in row.ours and not row.wrong:
            times = row.ours["all_by_one"]
            what = f"{row.work.key}, all stiffnesses by the uniform one"
            line(what, f"{ALL_BY_ONE:g}", times, times <= ALL_BY_ONE)
    asked = [row for row in small if row.ratio() == row.ratio()]
    solved = [row.ratio() for row in asked if row.peer["answer"] == "solved"]
    if asked:
        middle = statistics.median(row.ratio() for row in asked)
        line(
            "small models, peer / ours, median",
            f"least {SMALL_RATIO:g}",
            middle,
            middle >= SMALL_RATIO,
        )
    if solved:
        line("the same, where the peer found a state", "", statistics.median(solved), None)
    if "wall-400" in by_key:
        ratio = by_key["wall-400"].ratio()
        line("wall-400, peer / ours", f"least {WALL_RATIO:g}", ratio, ratio >= WALL_RATIO)
    sized = [by_key[f"wall-{n}"] for n in WALLS if f"wall-{n}" in by_key]
    big = [(r.ours.get("blocks", 0), r.seconds) for r in sized if r.ours.get("blocks", 0) >= 400]
    for what, rows_of in (
        ("models of less than 100 blocks", lambda n: n < 100),
        ("of 100 to 399", lambda n: 100 <= n < 400),
        ("of 400 and more", lambda n: n >= 400),
    ):
        found = [row.convex_ratio() for row in rows if rows_of(row.ours.get("blocks", 0))]
        found = [ratio for ratio in found if ratio == ratio]
        if found:
            middle = statistics.median(found)
            line(f"RBE by the best convex solver / our check, {what}, median", "", middle, None)
    differ = sum(row.differs for row in rows)
    line("RBE answers that differ from both", "0", differ, differ == 0)
    exponent = slope(big)
    line("growth exponent from 400 blocks", f"{GROWTH:g}", exponent, exponent <= GROWTH)
    theirs = slope(
        [
            (r.ours.get("blocks", 0), r.peer["solve_s"])
            for r in sized
            if "solve_s" in r.peer and not r.peer.get("stopped")
        ]
    )
    line("the peer's, on the walls that it finished", "", theirs, None)
    if "wall-10000" in by_key:
        peak = float(by_key["wall-10000"].ours.get("peak_mib", math.nan))
        line("peak memory at 10,000 blocks [MiB]", f"{PEAK_MIB:g}", peak, peak <= PEAK_MIB)
    return lines


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--armadillo", type=Path, help="model file of the Armadillo vault")
    parser.add_argument("--peer", type=Path, help="python of an environment with compas_cra 0.8.0")
    parser.add_argument("--peer-limit", type=float, default=300.0, help="CPU seconds per model")
    parser.add_argument("--convex", action="store_true", help="RBE by convex solvers as well")
    parser.add_argument(
        "--before",
        default="",
        help="commit to compare with, pair by pair, each by its own benchmark",
    )
    parser.add_argument("--limit", type=float, default=1200.0, help="CPU seconds per workload")
    parser.add_argument("--only", default="", help="part of GROUP/NAME of workloads; no page")
    parser.add_argument("--whole", action="store_true", help="all stiffnesses on large models too")
    parser.add_argument("--json", type=Path, help="also write the rows")
    arguments = parser.parse_args()
    machine = description()
    everything = workloads(arguments.armadillo).values()
    chosen = [work for work in everything if arguments.only in f"{work.group}/{work.key}"]
    began = time.perf_counter()
    rows = run(chosen, arguments, lambda line: print(line, flush=True))
    lines = [f"Measured in {time.perf_counter() - began:.0f} s. {machine}", "", *aims(rows)]
    print("\n".join([*lines, "", *table(rows)]))
    if arguments.json is not None:
        kept = [{"key": r.work.key, "ours": r.ours, "peer": r.peer} for r in rows]
        arguments.json.write_text(json.dumps(kept, indent=1), encoding="utf-8")
    if not arguments.only:
        write_table(TABLES / "speed.csv", table(rows))
        write_table(TABLES / "speed-aims.csv", aims(rows))
    return 1 if any(row.wrong for row in rows) else 0


if __name__ == "__main__":
    raise SystemExit(main())
