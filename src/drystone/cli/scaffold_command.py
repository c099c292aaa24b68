"""``drystone scaffold``: one model planned with each kind of scaffolding, and what each takes."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

from drystone.base.errors import InputError
from drystone.cli import kinds, options
from drystone.cli.command import command
from drystone.cli.model_input import Subject
from drystone.cli.offered import OUTPUT, Option
from drystone.cli.told import Printed, show_table
from drystone.cli.waiting import Waiting

if TYPE_CHECKING:
    from drystone.sequence import ScaffoldOptions

SCAFFOLDS = ("strut", "rope", "clamp", "centring")
_ORDERS = ("top", "course", "boundary", "fewest-props")
_FEW = 14
"""Free blocks up to which the order with the fewest props is searched without being asked for."""

ScaffoldLimit: TypeAlias = Annotated[
    float | None,
    Option("Largest force of one strut, rope, clamp or centring, in N (none).",
           kind=kinds.POSITIVE, expert=True),
]  # fmt: skip
ScaffoldFoot: TypeAlias = Annotated[
    str | None,
    Option("Block on which struts stand, and which bears their force (the ground).",
           metavar="BLOCK", expert=True),
]  # fmt: skip
ScaffoldLength: TypeAlias = Annotated[
    float | None,
    Option("Length of the longest strut, in m (no limit).", kind=kinds.POSITIVE, expert=True),
]


def scaffold_options(
    limit: float | None, foot: str | None, length: float | None
) -> ScaffoldOptions:
    """Limits of scaffolding, from the command line."""
    from drystone.sequence import ScaffoldOptions

    free = float("inf")
    return ScaffoldOptions(limit=limit or free, foot=foot, longest=length or free)


def refuse_strutless(kinds: Sequence[str], *limits: float | str | None, flag: str) -> None:
    """Refuse the foot and the length of struts where nothing is held by struts."""
    for name, value in zip(("foot", "length"), limits, strict=True):
        if value is not None and kinds and "strut" not in kinds:
            raise InputError(
                f"{flag}{name} is for struts, and there are none",
                remedy="leave it out, or hold with struts",
            )


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
    hands: Annotated[int, Option("Hands or robots: one places, others hold (2).")] = 2,
    limit: ScaffoldLimit = None,
    foot: ScaffoldFoot = None,
    length: ScaffoldLength = None,
    csv: Annotated[
        Path | None, Option("Write the table, .csv.", OUTPUT, kind=kinds.target(".csv"))
    ] = None,
    time_limit: options.TimeLimit = None,
    waiting: Waiting,
) -> Printed:
    """Plan a model with each kind of scaffolding in each order, and compare what it takes.

    Struts push, ropes pull, clamps or hands do both, centring carries a face; each stage is checked
    with their one-sided forces. The cheapest comes first.

    Exit code 0: with some of them every stage stands. 1: with none. 2: bad input.
    """
    from drystone import sequence

    refuse_strutless(with_, foot, length, flag="--")
    model = subject.prepared(waiting)
    few = len(model.assembly.free) <= _FEW
    orders = order or (("top", "course", "fewest-props") if few else ("top", "course"))
    waiting.stage("plan", "planning")
    with waiting.keywords(time_limit) as common:
        table = sequence.compare_scaffolding(
            model,
            with_ or SCAFFOLDS,
            orders,
            options=sequence.PlanOptions(
                rules=sequence.Rules(hands),
                anyway=subject.anyway,
                scaffold_options=scaffold_options(limit, foot, length),
            ),
            **common,
        )
    rows = list(table)
    data: dict[str, Any] = {"model": subject.name, "compared": rows}
    jobs = [(csv, table.to_csv)] if csv is not None else []
    code = 0 if any(row["failed_stages"] == 0 and row["cost"] == row["cost"] for row in rows) else 1
    return Printed(
        data, partial(show_table, table=table), code, model.notes, lambda: (list(jobs), [])
    )
