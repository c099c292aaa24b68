"""Plans of towers, shells and the Armadillo: ``python -m benchmarks.sequence``.

Correctness first: a plan with a stage that does not stand stops the run. Times are CPU seconds of
one thread. Each part writes its table, docs/trust/tables/plans-PART.csv.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TypeAlias

import numpy as np

from benchmarks.machine import description
from benchmarks.niche import niche
from benchmarks.tables import TABLES, write_table
from drystone import Assembly
from drystone.checks import check_forces
from drystone.detection import find_contacts
from drystone.io import read
from drystone.model import Model
from drystone.models import (
    arch,
    bridge,
    corbelled_bridge,
    corbelled_wall,
    leaning_column,
    snake,
    tower,
    winding_column,
)
from drystone.reproduce.assembly_cases import ring_dome
from drystone.sequence import (
    Order,
    Plan,
    PlanOptions,
    Rules,
    Status,
    plan,
    sweep_friction,
)
from drystone.sequence.stages import members

VAULT_WEDGES = (0.02, 0.05, 0.1, 0.2, 0.3)
VAULT_FRICTION, DOME_FRICTION = 0.6, 0.66
BY_COURSE = Rules(order=Order.COURSE)


@dataclass(frozen=True, eq=False)
class Row:
    """A plan and what it took.

    Attributes
    ----------
    name
    plan
    plan_s
    """

    name: str
    friction: float
    plan: Plan
    plan_s: float


def cpu(work: Callable[[], object], least: float = 0.3) -> float:
    """CPU seconds of the fastest of several runs."""
    best, total = math.inf, 0.0
    while total < least:
        began = time.process_time()
        work()
        spent = time.process_time() - began
        best, total = min(best, spent), total + spent
    return best


def planned(name: str, assembly: Assembly, friction: float, rules: Rules) -> Row:
    """Plan a model; stops the run when a stage of the plan does not stand."""
    contacts = find_contacts(assembly, friction=friction).contacts
    model, options = Model(assembly, contacts), PlanOptions(rules=rules)
    began = time.process_time()
    found = plan(model, options=options)
    spent = time.process_time() - began
    if spent < 1.0:
        spent = cpu(lambda: plan(model, options=options), 1.0)
    answers = [a for step in found.steps for a in (*step.during, step.answer)]
    if not found.steps or not all(answer.stands for answer in answers):
        raise SystemExit(f"{name}: {found.message or 'a stage does not stand'}")
    for step in found.steps:
        standing = sorted(set(members(step.placed)) - set(step.props))
        others = np.delete(np.arange(len(assembly)), standing).tolist()
        force = np.zeros((contacts.corner_count, 3))
        force[step.answer.corner] = step.answer.force
        rest = check_forces(Model(assembly.with_fixed(others), contacts, found.model.load), force)
        if rest.largest > 1e-8:
            raise SystemExit(f"{name}: forces of a stage are out of balance by {rest.largest:.1e}")
    return Row(name, friction, found, spent)


Told: TypeAlias = tuple[list[str], list[str]]
"""The lines of a table, and what is told beside it."""


def table(rows: Sequence[Row]) -> list[str]:
    """Counts and times."""
    lines = [
        "| model | friction | blocks | free | held | propped | stages | checks | plan [s] |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        counts = row.plan.counts
        lines.append(
            f"| {row.name} | {row.friction:g} | {len(row.plan.model.assembly.free)} "
            f"| {counts['free']} | {counts['held']} | {counts['propped']} "
            f"| {len(row.plan.steps)} | {row.plan.solved} | {row.plan_s:.2f} |"
        )
    return lines


def helped(found: Plan) -> str:
    """The blocks that are not free, by status."""
    names = found.model.assembly.names
    out = []
    for status in (Status.HELD, Status.PROPPED):
        some = [names[b] for b, one in enumerate(found.status) if one is status]
        if some:
            out.append(f"{status.value}: {', '.join(some)}")
    return "; ".join(out) or "every block is free"


def shells() -> Told:
    """The vault with its wedges, and the dome."""
    rows = [planned(f"vault, wedge {w:g}", niche(w), VAULT_FRICTION, BY_COURSE)
            for w in VAULT_WEDGES]  # fmt: skip
    rows.append(planned("dome", ring_dome(), DOME_FRICTION, BY_COURSE))
    return table(rows), [f"The dome, {helped(rows[-1].plan)}."]


def designs() -> Told:
    """Columns, bridges, the snake, and three that everyone knows."""
    rows = [
        planned(name, assembly, 0.6, Rules())
        for name, assembly in (
            ("leaning column", leaning_column()),
            ("winding column", winding_column()),
            ("corbelled bridge", corbelled_bridge()),
            ("bridge of the source", bridge()),
            ("snake of the source", snake()),
            ("stack of 10", tower(11)),
            ("corbelled wall", corbelled_wall()),
        )
    ]
    rows.append(planned("arch, 1 hand", arch(0.3, 7), 0.4, Rules(hands=1)))
    rows.append(planned("arch, 2 hands", arch(0.3, 7), 0.4, Rules(hands=2)))
    lines = []
    for name, family in (
        ("leaning column", leaning_column),
        ("winding column", winding_column),
        ("corbelled bridge", corbelled_bridge),
    ):
        low, high = least(family())
        lines.append(
            f"- {name}: built without props from friction {high:.3f}, not at {low:.3f} and below."
        )
    lines.append(f"- arch with one hand, {helped(rows[-2].plan)}.")
    lines.append(f"- arch with two hands, {helped(rows[-1].plan)}.")
    return table(rows), lines


FRICTIONS = (0.35, 0.5, 0.66, 0.84, 1.0)


def frictions() -> Told:
    """What models need at several friction coefficients."""
    head = " | ".join(f"{friction:g}" for friction in FRICTIONS)
    lines = [f"| model | {head} |", "|---|" + "---|" * len(FRICTIONS)]
    reasons = []
    for name, (assembly, rules) in sweeps().items():
        row, why = help_by_friction(name, assembly, rules)
        print(row, *why, sep="\n", flush=True)
        lines.append(row)
        reasons += why
    return lines, reasons or ["No model needs more help at more friction."]


def sweeps() -> dict[str, tuple[Assembly, Rules]]:
    """Models of the sweep over friction, and the rules of their plans."""
    return {
        "bridge of the source": (bridge(), Rules()),
        "the same, with load": (bridge(load=True), Rules()),
        "snake of the source": (snake(), Rules()),
        "corbelled bridge": (corbelled_bridge(), Rules()),
        "corbelled wall": (corbelled_wall(), Rules()),
        "arch of 7, 1 hand": (arch(0.3, 7), Rules(hands=1)),
        "arch of 13": (arch(0.25, 13), Rules()),
        "dome": (ring_dome(), BY_COURSE),
        **{f"vault, wedge {w:g}": (niche(w), BY_COURSE) for w in VAULT_WEDGES},
    }


def help_by_friction(name: str, assembly: Assembly, rules: Rules) -> tuple[str, list[str]]:
    """A row: blocks propped and held at each coefficient; and why it needs more than at less."""
    swept = sweep_friction(
        Model.of(assembly),
        FRICTIONS,
        partial(plan, options=PlanOptions(rules=rules)),
    )
    cells = []
    for one, why in zip(swept.plans, swept.why_more, strict=True):
        props, held, _ = one.help
        cells.append(f"{props} + {held}{' *' if why else ''}" if one.steps else "falls")
    reasons = [
        f"- {name} at friction {friction:g}: {why}."
        for friction, why in zip(swept.friction, swept.why_more, strict=True)
        if why
    ]
    return f"| {name} | {' | '.join(cells)} |", reasons


def least(assembly: Assembly) -> tuple[float, float]:
    """Friction coefficients around the least one that needs no props."""
    model = Model.of(assembly)
    low, high = 0.0, 0.6
    while high - low > 0.002:
        middle = 0.5 * (low + high)
        found = plan(model.with_friction(middle))
        if found.steps and found.stable and not (found.props or found.impossible):
            high = middle
        else:
            low = middle
    return low, high


def armadillo(path: Path) -> Told:
    """The vault of 399 stones, taken down course by course, counted from its supports."""
    row = planned("Armadillo vault", read(path).assembly, 0.84, BY_COURSE)
    counts = row.plan.counts
    free = len(row.plan.model.assembly.free)
    shares = ", ".join(
        f"{kind} {counts[kind]} ({counts[kind] / free:.0%})" for kind in ("free", "held", "propped")
    )
    at_once = max(len(step.props) for step in row.plan.steps)
    return table([row]), [f"Blocks {shares}; at most {at_once} props at once."]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "parts", nargs="*", help="shells, designs, frictions, armadillo; all when left out"
    )
    parser.add_argument("--armadillo", type=Path, help="model file of the Armadillo vault")
    arguments = parser.parse_args()
    machine = description()
    parts: dict[str, Callable[[], Told]] = {
        "designs": designs,
        "shells": shells,
        "frictions": frictions,
    }
    if arguments.armadillo is not None:
        parts["armadillo"] = partial(armadillo, arguments.armadillo)
    for name in arguments.parts or parts:
        if name not in parts:
            raise SystemExit(f"there is no part '{name}' (armadillo needs --armadillo FILE)")
        lines, beside = parts[name]()
        print(*lines, "", *beside, "", f"Measured with {machine}", sep="\n", flush=True)
        write_table(TABLES / f"plans-{name}.csv", lines)


if __name__ == "__main__":
    main()
