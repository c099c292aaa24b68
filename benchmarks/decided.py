"""Verdicts around every published limit: ``python -m benchmarks.decided``.

Each model of docs/trust/tables/settled.csv is checked at shares of its settled
limit, and a degree below and above it. Writes how many are decided into
docs/reference/settlement.md, and every one that is not, with both motions, into a table.
"""

from __future__ import annotations

import argparse
from collections import Counter

from benchmarks.settlement import PAGE, known_limits
from benchmarks.tables import TABLES, write_part, write_table
from drystone import LoadCase, Model, Verdict, check
from drystone.reproduce.tilt_cases import Study, studies

SHARES = (0.25, 0.5, 0.75, 0.9)


def verdicts(study: Study, limit: float) -> tuple[Counter[str], list[str]]:
    """How many of each verdict, and a line for each model that is undecided."""
    model = Model.of(study.build(), friction=study.friction)
    tilts = [share * limit for share in SHARES] + [limit - 1.0, limit + 1.0, limit + 10.0]
    count: Counter[str] = Counter()
    lines = []
    for tilt in tilts:
        found = check(model.with_load(LoadCase.tilt(model.assembly, study.axis, tilt)))
        count[found.verdict.value] += 1
        if found.verdict is Verdict.UNDECIDED:
            lines.append(f"| {study.key} | {tilt:.1f} | {found.message} |")
    return count, lines


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", default="", help="studies whose name contains this")
    given = parser.parse_args()
    limits = known_limits()
    total: Counter[str] = Counter()
    undecided: list[str] = []
    for study in studies():
        if given.only not in study.key:
            continue
        key = f"{study.model} {study.axis_label} mu {study.friction:.2f}"
        count, lines = verdicts(study, limits[key])
        print(study.key, dict(count), *lines, sep="\n    ", flush=True)
        total += count
        undecided += lines
    told = ", ".join(f"{count} {verdict}" for verdict, count in sorted(total.items()))
    lines = [f"{sum(total.values())} models: {told}."]
    print("\n".join([*lines, *undecided]))
    if not given.only:
        write_part(PAGE, "decided", "\n".join(lines))
        write_table(
            TABLES / "undecided.csv", ["| model | tilt | why |", "|---|---|---|", *undecided]
        )
    known = ("the ends of the joints decide", "it depends on the shear stiffness of the joints")
    others = [line for line in undecided if not any(why in line for why in known)]
    return 1 if others else 0


if __name__ == "__main__":
    raise SystemExit(main())
