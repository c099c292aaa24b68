"""One answer per region: ``python -m benchmarks.regions [--csv FILE] [--sample N]``.

A hundred models are tilted farther and farther, or lose their friction. Along each scan the verdict
may change from STABLE to UNSTABLE once. UNDECIDED may lie between. A scan has 12 values from the
first to the last, and 12 more where the verdict is not one of the two ends any more.

A line for each scan: S stands, s is sensitive, ? is undecided, F falls, and its CPU seconds. Below
a scan that breaks the rule, or whose undecided values lie in more than one place, is every run of
equal verdicts with the message of its first value, and the mechanism where it is known. With
``--csv`` each verdict is kept as soon as it is known, and the same command goes on where it ended.
Exit code 1 where a scan breaks the rule and nobody has found its mechanism.
"""

from __future__ import annotations

import argparse
import csv
import fnmatch
import time
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby, pairwise
from pathlib import Path

from benchmarks.region_scans import EXPLAINED, Scan, scans
from drystone import CheckOptions, check

FIELDS = ("scan", "value", "letter", "cpu_s", "message")
COARSE, FINE = 12, 12
FALLS, UNDECIDED = "F", "?"


@dataclass(frozen=True)
class Found:
    """A verdict along a scan.

    Attributes
    ----------
    value
    letter
        S, s, ? or F.
    cpu_s
    message
    """

    value: float
    letter: str
    cpu_s: float
    message: str

    @property
    def region(self) -> str:
        """The verdict, sensitive or not."""
        return self.letter.upper()


class Answers:
    """The verdicts that a file has already, and those that are asked now."""

    def __init__(self, path: Path | None, options: CheckOptions) -> None:
        self.path, self.options = path, options
        self.known: dict[tuple[str, str], Found] = {}
        if path is not None and path.exists():
            with path.open(encoding="utf-8", newline="") as file:
                for row in csv.DictReader(file):
                    found = Found(
                        float(row["value"]), row["letter"], float(row["cpu_s"]), row["message"]
                    )
                    self.known[row["scan"], row["value"]] = found

    def at(self, scan: Scan, value: float) -> Found:
        """The verdict at a value."""
        key = (scan.name, f"{value:g}")
        if key not in self.known:
            model = scan.model(value)
            began = time.process_time()
            result = check(model, options=self.options)
            spent = time.process_time() - began
            letter = FALLS if result.falls else "S" if result.stable else UNDECIDED
            if result.stable and result.sensitive:
                letter = "s"
            self.known[key] = Found(value, letter, spent, result.message)
            self._keep(scan, self.known[key])
        return self.known[key]

    def _keep(self, scan: Scan, found: Found) -> None:
        if self.path is None:
            return
        new = not self.path.exists()
        with self.path.open("a", encoding="utf-8", newline="") as file:
            table = csv.writer(file)
            if new:
                table.writerow(FIELDS)
            table.writerow(
                (scan.name, f"{found.value:g}", found.letter, f"{found.cpu_s:.2f}", found.message)
            )


def scanned(scan: Scan, answers: Answers) -> list[Found]:
    """The verdicts along a scan, closer together where they change."""
    share = [i / (COARSE - 1) for i in range(COARSE)]
    found = {one: answers.at(scan, scan.value(one)) for one in share}
    regions = [found[one].region for one in share]
    first = next((i for i, one in enumerate(regions) if one != regions[0]), COARSE - 1)
    last = next((i for i in reversed(range(COARSE)) if regions[i] != regions[-1]), 0)
    if first < COARSE - 1 or last > 0:
        low, high = share[first - 1], share[last + 1]
        for i in range(1, FINE + 1):
            one = low + (high - low) * i / (FINE + 1)
            found[one] = answers.at(scan, scan.value(one))
    return [found[one] for one in sorted(found)]


def changes(found: list[Found]) -> int:
    """How often the verdict changes between standing and falling."""
    decided = [one.region for one in found if one.region != UNDECIDED]
    return sum(a != b for a, b in pairwise(decided))


def right(found: list[Found]) -> bool:
    """Whether it changes once at most, and from standing to falling."""
    decided = [one.region for one in found if one.region != UNDECIDED]
    return changes(found) == 0 or (changes(found) == 1 and decided[-1] == FALLS)


def runs(found: list[Found]) -> Iterator[list[Found]]:
    """Values next to each other with equal verdicts."""
    for _, group in groupby(found, key=lambda one: one.region):
        yield list(group)


def told(scan: Scan, found: list[Found]) -> str:
    """A line of the report, and the runs of a scan where they are to be looked at."""
    spent = sum(one.cpu_s for one in found)
    slowest = max(found, key=lambda one: one.cpu_s)
    word = "" if right(found) else "EXCEPTION "
    line = f"{word}{scan.name}: {''.join(one.letter for one in found)}, {spent:.1f} CPU s"
    if slowest.cpu_s > 1.0:
        line += f", {slowest.cpu_s:.1f} of them at {slowest.value:g}"
    parts = list(runs(found))
    if right(found) and sum(part[0].region == UNDECIDED for part in parts) < 2:
        return line
    rows = [
        f"    {part[0].value:g} to {part[-1].value:g}: {part[0].region} {part[0].message}"
        for part in parts
    ]
    if not right(found):
        rows.append(f"    {EXPLAINED.get(scan.name, 'nobody knows why')}")
    return "\n".join([line, *rows])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--csv", type=Path, help="file that keeps every verdict")
    parser.add_argument("--sample", type=int, help="so many scans, evenly spaced")
    parser.add_argument("--only", default="*", help="pattern of scans, or a part of a name")
    parser.add_argument(
        "--shear", type=float, help="shear stiffness with which to follow again; 0: none"
    )
    given = parser.parse_args()
    pattern = given.only if "*" in given.only else f"*{given.only}*"
    chosen = [one for one in scans() if fnmatch.fnmatchcase(one.name, pattern)]
    if given.sample:
        step = max(1.0, len(chosen) / given.sample)
        chosen = [chosen[int(i * step)] for i in range(min(given.sample, len(chosen)))]
    options = CheckOptions()
    if given.shear is not None:
        options = CheckOptions(stiff_shear=given.shear or None)
    answers = Answers(given.csv, options)
    asked = broken = unknown = scattered = 0
    spent = 0.0
    for scan in chosen:
        found = scanned(scan, answers)
        asked += len(found)
        broken += not right(found)
        unknown += not right(found) and scan.name not in EXPLAINED
        scattered += sum(part[0].region == UNDECIDED for part in runs(found)) > 1
        spent += sum(one.cpu_s for one in found)
        print(told(scan, found), flush=True)
    print(
        f"{len(chosen)} scans, {asked} verdicts, {spent:.0f} CPU s: {broken} change more than once,"
        f" {unknown} of them unexplained; {scattered} are undecided in more than one place"
    )
    return 1 if unknown else 0


if __name__ == "__main__":
    raise SystemExit(main())
