"""Published tilt limits beside ours: ``python -m benchmarks.thesis``.

Writes docs/trust/tables/tilt-limits.csv; with ``--extras`` structures.csv, and prints what rests.
Every limit is found by a scan from 0 to 180 degrees, and by :func:`benchmarks.scan.first_loss`.
With ``--rows FILE`` the rows are kept there as they come, and those that are there are not measured
again: so it may be stopped and goes on where it was.
"""

from __future__ import annotations

import argparse
import json
import math
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from benchmarks.explanations import EXPLANATIONS
from benchmarks.scan import Limit, tilt_limit
from benchmarks.settlement import QUICK
from benchmarks.shims.shims import could_hold
from benchmarks.tables import TABLES, write_table
from drystone import CheckOptions, LoadCase, Verdict, models
from drystone.detection import find_contacts
from drystone.model import Model
from drystone.programs import FrictionCone, RBEOptions, solve_cra, solve_rbe
from drystone.reproduce import SECTIONS, reproduce
from drystone.reproduce.tilt_cases import Study, studies
from drystone.settlement import Carrier, Outcome, settle
from drystone.stability import check

UNIFORM = CheckOptions(samples=0, settle=False)

PREDICTED = CheckOptions(
    settlement=replace(CheckOptions().settlement, carrier=Carrier.MOVING), stiff_shear=None
)
"""As by default, but the ends of joints on the block that moves: no model is undecided."""

StandsCheck = Callable[[Model], bool]


def octagon(model: Model) -> bool:
    options = RBEOptions.feasibility(FrictionCone.octagon())
    found = solve_rbe(model, options=options)
    return found.verdict is Verdict.EQUILIBRIUM_EXISTS


def exact(model: Model) -> bool:
    found = solve_rbe(model, options=RBEOptions.feasibility())
    return found.verdict is Verdict.EQUILIBRIUM_EXISTS


def uniform(model: Model) -> bool:
    found = check(model, options=UNIFORM)
    return found.verdict is Verdict.STABLE


def searched(model: Model) -> bool:
    return could_hold(model)


def settled(model: Model) -> bool:
    """Followed by steps, the ends of joints on the block that moves."""
    return settle(model, options=QUICK).outcome is Outcome.RESTS


def predicted(model: Model) -> bool:
    """The verdict: every stiffness stands, or else following by steps ends at rest."""
    return check(model, options=PREDICTED).verdict is Verdict.STABLE


def compatible(model: Model) -> bool:
    found = solve_cra(model)
    return found.verdict is Verdict.STABLE and found.method == "cra"


CHECKS: dict[str, StandsCheck] = {
    "RBE8": octagon,
    "RBE": exact,
    "uniform": uniform,
    "search": searched,
    "settled": settled,
    "check": predicted,
    "5.6": compatible,
}
"""RBE with the eight-sided pyramid and with the exact cone; rest; the verdict; eq. 5.6."""


@dataclass(frozen=True)
class Row:
    """A study, and the limit of each of our methods."""

    study: Study
    limits: dict[str, Limit]
    seconds: float

    def exceptions(self) -> list[str]:
        """The aims that are not met, by name."""
        study, angle = self.study, {name: limit.angle for name, limit in self.limits.items()}
        missed: list[str] = []
        if study.rbe is not None and not _same(angle["RBE8"], study.rbe):
            missed.append("RBE")
        if abs(angle["5.6"] - study.cra) > 1.0:
            missed.append("5.6")
        inside = (
            angle["uniform"] - study.tolerance <= study.dem <= angle["search"] + study.tolerance
        )
        if not inside:
            missed.append("3DEC")
        return missed


def _same(ours: float, published: float) -> bool:
    """Within 0.2 degree, or a whole degree that ours was cut down to."""
    return abs(ours - published) <= 0.2 or (
        published == int(published) and published <= ours + 0.2 and ours < published + 1.0
    )


def measure(study: Study, before: Row | None = None) -> Row:
    """All limits of one study; those that were measured ``before`` are kept.

    No rest state is above the limit of the exact cone, and neither the rest state of uniform
    stiffness nor a state of eq. 5.6 is above the highest that the search finds.
    """
    began = time.perf_counter()
    known = {} if before is None else before.limits
    spent = 0.0 if before is None else before.seconds
    assembly = study.build()
    contacts = find_contacts(assembly, friction=study.friction).contacts

    def limit(name: str, below: Limit | None) -> Limit:
        if name in known:
            return known[name]
        stands = CHECKS[name]
        highest = 180.0 if below is None else max(below.angle, *below.islands, 1.0)
        return tilt_limit(
            lambda tilt: stands(
                Model(assembly, contacts, LoadCase.tilt(assembly, study.axis, tilt))
            ),
            highest,
            step=min(5.0, max(1.0, highest / 12.0)),
        )

    found = {name: limit(name, None) for name in ("RBE8", "RBE")}
    found["search"] = limit("search", found["RBE"])
    others = ("uniform", "settled", "check", "5.6")
    found |= {name: limit(name, found["search"]) for name in others}
    spent += time.perf_counter() - began
    return Row(study, {name: found[name] for name in CHECKS}, spent)


def limits_table(rows: Sequence[Row]) -> list[str]:
    """Markdown lines; the last column tells why an aim is not met."""
    lines = [
        "| model | axis | mu | 3DEC | Sofistik | CRA | RBE | RBE, octagon | RBE, cone "
        "| rest, uniform | rest, search | settled | check | eq. 5.6 | 5.6 - CRA | note |",
        "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        study = row.study
        notes = [
            f"{column}: {EXPLANATIONS.get((study.key, column), 'Not explained yet.')}"
            for column in row.exceptions()
        ]
        for name, found in row.limits.items():
            if found.islands:
                span = f"{found.islands[0]:g} to {found.islands[-1]:g}"
                notes.append(
                    f"{name}: stands again at {len(found.islands)} angles of the scan, "
                    f"{span} degrees."
                )
        published = [study.dem, study.sofistik, study.cra, study.rbe]
        ours = [limit.angle for limit in row.limits.values()]
        cells = [
            study.model,
            study.axis_label,
            f"{study.friction:.2f}",
            *(f"{value:g}" if value is not None else "" for value in published),
            *(f"{value:.2f}" for value in ours),
            f"{row.limits['5.6'].angle - study.cra:+.2f}",
            " ".join(notes),
        ]
        lines.append("| " + " | ".join(cells) + " |")
    return lines


def verdict_table() -> list[str]:
    """Models that balance and yet fall."""
    shelf = models.shelf()
    lines = ["| model | mu | RBE | verdict | falls |", "|---|---|---|---|---|"]
    for name, model, friction in (
        *(("H", models.h_model(), mu) for mu in (0.2, 0.6, 2.0)),
        *(("A", models.a_model(), mu) for mu in (0.2, 0.6, 2.0)),
        ("shelf", shelf, 0.9),
        ("shelf less 9 and 10", shelf.without(["block-9", "block-10"]), 0.9),
    ):
        contacts = find_contacts(model, friction=friction).contacts
        balance, found = solve_rbe(Model(model, contacts)), check(Model(model, contacts))
        falls = ", ".join(found.falling_names)
        lines.append(
            f"| {name} | {friction:.2f} | {balance.verdict.value} | {found.verdict.value} "
            f"| {falls} |"
        )
    return lines


def structures_table() -> list[str]:
    """The source's own structures: published beside found."""
    lines = [
        "| section | what | published | found | agrees | note |",
        "|---|---|---|---|---|---|",
    ]
    for section in SECTIONS:
        for line in reproduce(section).lines:
            mark = {True: "yes", False: "no", None: ""}[line.agrees]
            lines.append(
                f"| {section} | {line.what} | {line.published} | {line.found} | {mark} "
                f"| {line.note} |"
            )
    return lines


def misses(rows: Sequence[Row]) -> list[str]:
    """How far the predicted limits are from 3DEC, and which by more than a degree."""
    found = {
        name: {row.study.key: row.limits[name].angle - row.study.dem for row in rows}
        for name in ("check", "settled")
    }
    lines = []
    for name, miss in found.items():
        mean = math.sqrt(sum(one**2 for one in miss.values()) / len(miss))
        largest = max(miss, key=lambda key: abs(miss[key]))
        lines.append(
            f"*{name}* less 3DEC: root mean square {mean:.2f} degrees over {len(rows)} rows, "
            f"largest {miss[largest]:+.2f} ({largest})."
        )
    for key, one in found["check"].items():
        other = found["settled"][key]
        if max(abs(one), abs(other)) > 1.0:
            lines.append(f"{key}, {one:+.2f} and {other:+.2f}")
    return lines


def run(pool: Executor | None, chosen: Sequence[Study], kept: Path | None) -> list[Row]:
    """Measure, in parallel where a pool is given; rows are printed and kept as they come."""
    known = kept_rows(kept)
    missing = [
        study
        for study in chosen
        if study.key not in known or set(CHECKS) - set(known[study.key].limits)
    ]
    before = [known.get(study.key) for study in missing]
    for row in (pool.map if pool is not None else map)(measure, missing, before):
        known[row.study.key] = row
        keep_rows(kept, known)
        ours = " ".join(f"{name} {limit.angle:.2f}" for name, limit in row.limits.items())
        print(
            f"{row.study.key:32s} 3DEC {row.study.dem:g} CRA {row.study.cra:g} | {ours} | "
            f"{row.seconds:.1f} s {' '.join(row.exceptions())}",
            flush=True,
        )
    return [known[study.key] for study in chosen]


def kept_rows(kept: Path | None) -> dict[str, Row]:
    """The rows that were measured before, by study."""
    if kept is None or not kept.exists():
        return {}
    stored = json.loads(kept.read_text(encoding="utf-8"))
    by_key = {study.key: study for study in studies()}
    return {
        key: Row(
            by_key[key],
            {name: Limit(**limit) for name, limit in one["limits"].items()},
            one["seconds"],
        )
        for key, one in stored.items()
    }


def keep_rows(kept: Path | None, rows: Mapping[str, Row]) -> None:
    """Write all rows; no file is left half written."""
    if kept is None:
        return
    stored = {
        key: {
            "limits": {name: asdict(limit) for name, limit in row.limits.items()},
            "seconds": row.seconds,
        }
        for key, row in rows.items()
    }
    draft = kept.with_suffix(".new")
    draft.write_text(json.dumps(stored), encoding="utf-8")
    draft.replace(kept)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", help="models whose name contains this")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--rows", type=Path, help="keep the rows in this file, and go on from it")
    parser.add_argument("--extras", action="store_true", help="only the structures of the source")
    arguments = parser.parse_args()
    if arguments.extras:
        write_table(TABLES / "structures.csv", structures_table())
        print("\n".join(verdict_table()))
        return
    chosen = [study for study in studies() if arguments.only in study.key]
    if arguments.workers > 1:
        with ProcessPoolExecutor(arguments.workers) as pool:
            rows = run(pool, chosen, arguments.rows)
    else:
        rows = run(None, chosen, arguments.rows)
    if arguments.only:
        return
    write_table(TABLES / "tilt-limits.csv", limits_table(rows))
    print("\n".join(misses(rows)))


if __name__ == "__main__":
    main()
