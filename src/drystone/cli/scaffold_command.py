"""``drystone scaffold``: one model planned with each kind of scaffolding, and what each takes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from drystone.base.display import differing
from drystone.base.errors import InputError
from drystone.cli import kinds, options
from drystone.cli.command import command
from drystone.cli.model_input import Subject
from drystone.cli.offered import OUTPUT, Analysis, Of, Option
from drystone.cli.told import Told
from drystone.cli.waiting import Waiting

if TYPE_CHECKING:
    from drystone.answer import Sentence
    from drystone.base.table import Table
    from drystone.sequence import PlanOptions, ScaffoldOptions, Support


SCAFFOLDS = ("strut", "rope", "clamp", "centring")
_ORDERS = ("top", "course", "boundary", "fewest-props")
_FEW = 14
"""Free blocks up to which the order with the fewest props is searched without being asked for."""

SCAFFOLD_LIMITS = {
    "scaffold_options.limit": "--scaffold-limit",
    "scaffold_options.foot": "--scaffold-foot",
    "scaffold_options.longest": "--scaffold-length",
}
"""Limits of scaffolding, and their options in a plan."""


def refuse_unused(limits: ScaffoldOptions, kinds: str | Support | Sequence[str] | None) -> None:
    """Refuse limits without scaffolding, and those of struts where nothing is held by struts."""
    held = [kinds] if isinstance(kinds, str | Enum) else list(kinds or ())
    struts = not held or any(str(getattr(one, "value", one)) == "strut" for one in held)
    for name in differing(limits):
        if kinds is None:
            remedy = f"add --scaffold, with one of {', '.join(SCAFFOLDS)}"
            raise InputError("is given without --scaffold", where=name, remedy=remedy)
        if name != "limit" and not struts:
            remedy = "leave it out, or hold with struts"
            raise InputError("is for struts, and there are none", where=name, remedy=remedy)


@command(
    "drystone scaffold arch.json --with clamp --order course --time-limit 2",
    "drystone scaffold arch.json --with clamp --with strut --time-limit 2 --csv compared.csv",
)
def scaffold(
    *,
    subject: Subject,
    with_: Annotated[
        tuple[str, ...],
        Option(
            "What holds propped blocks; several times (all of them).",
            flags=("--with",),
            kind=kinds.one_of(SCAFFOLDS),
        ),
    ] = (),
    order: Annotated[
        tuple[str, ...],
        Option(
            "Order of removal; several times (top, course; with few blocks also fewest-props).",
            kind=kinds.one_of(_ORDERS),
        ),
    ] = (),
    chosen: Annotated[
        PlanOptions,
        Of(
            "drystone.sequence.PlanOptions",
            ("rules.hands", *SCAFFOLD_LIMITS),
            shown=("rules.hands",),
            flags={"scaffold_options.longest": "--length"},
        ),
    ],
    csv: options.Csv = None,
    time_limit: options.TimeLimit = None,
    waiting: Waiting,
) -> Told:
    """Plan a model with each kind of scaffolding in each order, and compare what it takes.

    Struts push, ropes pull, clamps or hands do both, centring carries a face; each stage is checked
    with their one-sided forces. The cheapest comes first.

    Exit code 0: with some of them every stage stands. 1: with none. 2: bad input.
    """
    from drystone import sequence

    refuse_unused(chosen.scaffold_options, with_)
    model = subject.prepared(waiting)
    few = len(model.assembly.free) <= _FEW
    orders = order or (("top", "course", "fewest-props") if few else ("top", "course"))
    waiting.stage("plan", "planning")
    with waiting.keywords(time_limit) as common:
        table = sequence.compare_scaffolding(
            model,
            with_ or SCAFFOLDS,
            orders,
            options=replace(chosen, anyway=subject.anyway),
            **common,
        )
    from drystone.answer import Role, Sentence, Statement
    from drystone.base.table import Table

    first = next(
        (row for row in table if row["failed_stages"] == 0 and row["cost"] == row["cost"]), None
    )
    verdict = "with none of them does every stage stand"
    if first is not None:
        verdict = f"{first['support']} in the order '{first['order']}' takes least"
    told = [Sentence(verdict, Role.BAD if first is None else Role.GOOD)]
    told.extend(_failing(table, first, chosen.scaffold_options.limit))
    compared = Table("compared", dict(table.columns), dict(table.units))
    return Told(
        Statement(tuple(told), (compared,)),
        subject=subject.name,
        notes=model.notes,
        files=lambda: ([(csv, table.to_csv)], []),
    )


def _failing(table: Table, first: Mapping[str, object] | None, limit: float) -> Iterator[Sentence]:
    """Of each kind with which no order stands, that it is so, and what to use instead."""
    from drystone.answer import Role, Sentence

    other = "another kind" if first is None else f"--with {first['support']}"
    within, more = (
        (f" within {limit:g} N", " or a larger --limit") if limit < float("inf") else ("", "")
    )
    for kind in dict.fromkeys(row["support"] for row in table):
        mine = [row for row in table if row["support"] == kind]
        if all(row["failed_stages"] > 0 and row["cost"] == row["cost"] for row in mine):
            said = f"{kind}: in no order tried does every stage stand{within}; use {other}{more}"
            yield Sentence(said, Role.UNSURE)


@command(
    "drystone dataset arch.json --out data --rows 100",
    "drystone dataset arch.json --rows 20 --out planned --planned",
)
def dataset(
    *,
    subject: Subject,
    out: Annotated[
        Path,
        Option("Folder of the data set. Where it has part of it, the work goes on.", OUTPUT,
               kind=kinds.FOLDER),
    ],
    asked: Annotated[
        Analysis,
        Of("drystone.sequence.dataset", shown=("options.rows", "options.seed", "options.planned",
                                               "executor")),
    ],
    waiting: Waiting,
) -> Told:  # fmt: skip
    """Write subsets of structures, verdicts, friction left and orders of assembly, with a README.

    Each MODEL is a structure. Exit code 0: the data set is complete. 1: it is not yet.
    """
    models = [replace(subject, files=one).prepared(waiting) for one in subject.each]
    waiting.checkpoint = out / "orders"
    found = asked.of(waiting, models, out, doing="orders")
    notes = [note for model in models for note in model.notes]
    return Told(found, subject=f"{out}", notes=notes)
