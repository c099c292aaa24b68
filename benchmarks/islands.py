"""One change of the verdict along a ray, at most: ``python -m benchmarks.islands FILE --csv ROW``.

A model carries its weight and a horizontal load of kx and ky times its weight. The loads that it
can carry form a set around zero; a ray from zero should leave it once. A row has one ky and all kx,
or with ``--along y`` one kx and all ky.
``--report FOLDER`` reads the rows of all CSV files and lists every ray along which the verdict
changes more than once. Exit code 1 where one does.
"""

from __future__ import annotations

import argparse
import csv
import math
import time
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

from drystone import LoadCase, Verdict, check, io

FIELDS = ("kx", "ky", "verdict", "cpu_s", "message")


def scanned(arguments: argparse.Namespace) -> None:
    """Check one row, from 0 on; values that the file has already are left out."""
    model = io.read(arguments.model, friction=arguments.friction)
    along = f"k{arguments.along}"
    known = set()
    if arguments.csv.exists():
        with arguments.csv.open(encoding="utf-8", newline="") as file:
            known = {row[along] for row in csv.DictReader(file)}
    weight = LoadCase.of(model.assembly)
    with arguments.csv.open("a", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, FIELDS)
        if not known:
            table.writeheader()
        for number in range(round(arguments.most / arguments.step) + 1):
            value, row = f"{number * arguments.step:.6g}", f"{arguments.row:.6g}"
            if value in known:
                continue
            kx, ky = (value, row) if along == "kx" else (row, value)
            case = LoadCase.seismic(model.assembly, float(kx), float(ky))
            began = time.process_time()
            found = check(model.with_load(weight + case), time_limit_s=arguments.limit)
            table.writerow(
                {
                    "kx": kx,
                    "ky": ky,
                    "verdict": found.verdict.value,
                    "cpu_s": f"{time.process_time() - began:.2f}",
                    "message": found.message,
                }
            )
            file.flush()


def reported(folder: Path) -> int:
    """The number of rays along which the verdict changes more than once."""
    found: dict[tuple[Fraction, Fraction], str] = {}
    longest = 0.0
    for path in sorted(folder.glob("*.csv")):
        with path.open(encoding="utf-8", newline="") as file:
            for row in csv.DictReader(file):
                found[Fraction(row["kx"]), Fraction(row["ky"])] = row["verdict"]
                longest = max(longest, float(row["cpu_s"]))
    rays: dict[tuple[int, int], list[tuple[Fraction, str]]] = {}
    for (x, y), verdict in found.items():
        if x or y:
            common = math.lcm(x.denominator, y.denominator)
            across, along = int(x * common), int(y * common)
            shared = math.gcd(across, along)
            rays.setdefault((across // shared, along // shared), []).append((x + y, verdict))
    wrong = 0
    for direction, points in sorted(rays.items()):
        verdicts = [verdict for _, verdict in sorted(points)]
        changes = sum(a != b for a, b in pairwise(verdicts))
        if changes > 1:
            wrong += 1
            print(direction, " ".join(verdicts))
    kinds = {kind.value: sum(v == kind.value for v in found.values()) for kind in Verdict}
    told = ", ".join(f"{kind} {count}" for kind, count in kinds.items() if count)
    print(f"{len(found)} loads: {told}; the slowest took {longest:.1f} CPU s")
    print(f"{len(rays)} rays, {wrong} with more than one change")
    return wrong


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("model", type=Path, nargs="?")
    parser.add_argument("--friction", type=float, default=0.84)
    parser.add_argument("--row", type=float, default=0.0, help="the other factor")
    parser.add_argument("--along", choices=("x", "y"), default="x", help="the factor that grows")
    parser.add_argument("--step", type=float, default=0.005, help="of the factor that grows")
    parser.add_argument("--most", type=float, default=0.3, help="its largest value")
    parser.add_argument("--limit", type=float, default=120.0, help="seconds per check")
    parser.add_argument("--csv", type=Path, help="where the row is written")
    parser.add_argument("--report", type=Path, help="folder with the rows")
    arguments = parser.parse_args()
    if arguments.report is not None:
        return 1 if reported(arguments.report) else 0
    scanned(arguments)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
