"""``drystone plan``: in which order to assemble, what to hold, what to prop."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from drystone.cli import options, output, verdict
from drystone.cli.groups import Finding, Subject, expanded
from drystone.cli.waiting import Waiting
from drystone.errors import InputError, counted

if TYPE_CHECKING:
    from drystone.model import Model
    from drystone.sequence import ExecutorFactory, Margins, Plan, Rules

LISTED = 40
"""Rows shown of a table; --json has all."""
STYLE = {"held": "bold", "propped": "bold red", "impossible": "bold magenta"}


@dataclass(frozen=True)
class Files:
    """The files that were asked for; ``None`` where none is wanted."""

    html: Path | None
    print: Path | None
    csv: Path | None

    @property
    def wanted(self) -> list[str]:
        """Names of those that were asked for."""
        return [str(one) for one in (self.html, self.print, self.csv) if one is not None]

    def write(
        self, plan: Plan, margins: Margins | None, waiting: Waiting, source: str
    ) -> list[str]:
        """Write them, all or none, and name them."""
        if not plan.steps:
            return []
        from drystone.files import Job

        jobs: list[Job] = []
        if self.html is not None or self.print is not None:
            from drystone.view import save_page
            from drystone.view.instructions import save_instructions

            if self.html is not None:
                jobs.append((self.html, partial(save_page, plan, source=source)))
            if self.print is not None:
                jobs.append((self.print, partial(save_instructions, plan)))
        if self.csv is not None:
            jobs.append((self.csv, (plan if margins is None else margins).table().to_csv))
        return verdict.write(jobs, waiting)


@expanded
def plan(
    *,
    subject: Subject,
    finding: Finding,
    order: Annotated[
        str,
        typer.Option(
            help="Taken apart from the 'top', 'course' by course, farthest from the 'boundary' "
            "first; or the names of blocks in the order of assembly, separated by commas."
        ),
    ] = "top",
    hands: Annotated[
        int, typer.Option("--hands", "--robots", help="Hands or robots: one places, others hold.")
    ] = 2,
    payload: Annotated[
        float | None, typer.Option(help="What each of them can lift or hold, in kg.")
    ] = None,
    before: Annotated[
        list[str] | None,
        typer.Option(metavar="FIRST:THEN", help="One block before another; several times."),
    ] = None,
    reach: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAMES", help="Blocks placed before any of the next --reach; by commas."
        ),
    ] = None,
    exact: Annotated[
        bool, typer.Option("--exact", help="Search all orders (up to 14 free blocks).")
    ] = False,
    best: Annotated[
        bool, typer.Option("--best", help="Search until no order with fewer props is left.")
    ] = False,
    anyway: Annotated[
        bool, typer.Option("--anyway", help="Plan even if the complete model does not stand.")
    ] = False,
    thorough: Annotated[
        bool,
        typer.Option("--thorough", help="Let stages stand that are sensitive to joint stiffness."),
    ] = False,
    margins: Annotated[
        bool, typer.Option("--margins", help="Least friction and tilt limit of every stage.")
    ] = False,
    sweep: Annotated[
        str | None,
        typer.Option(metavar="MU,MU,...", help="Plan at these friction coefficients as well."),
    ] = None,
    workers: Annotated[int, typer.Option(help="Processes that check stages side by side.")] = 1,
    dask: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="A running Dask scheduler to work on.")
    ] = None,
    checkpoint: Annotated[
        str | None, typer.Option(help="File to go on from after an interruption.")
    ] = None,
    html: options.Html = None,
    instructions: Annotated[
        str | None, typer.Option("--print", help="Write numbered instructions for printing, .html.")
    ] = None,
    csv: Annotated[str | None, typer.Option(help="Write the table of stages, .csv.")] = None,
    as_json: options.Json = False,
) -> int:
    """Plan the assembly of a model: order, blocks to hold, blocks to prop.

    Exit code 0: every stage stands without a prop. 1: props are needed, blocks cannot be put in, or
    the complete model does not stand. 2: bad input.
    """
    files = Files(
        None if html is None else options.output_path(html, "--html", (".html", ".htm")),
        None if instructions is None
        else options.output_path(instructions, "--print", (".html", ".htm")),
        None if csv is None else options.output_path(csv, "--csv", (".csv",)),
    )  # fmt: skip
    rules = _rules(order, hands, payload, before, reach)
    frictions = _numbers(sweep)
    executor = _executor(workers, dask)
    with Waiting() as waiting:
        waiting.checkpoint = None if checkpoint is None else Path(checkpoint)
        prepared = subject.prepared(waiting, finding)
        from drystone import sequence

        waiting.stage("plan", "planning")
        chosen = sequence.PlanOptions(
            rules=rules, exact=exact, patience=float("inf") if best else None, anyway=anyway
        )
        check = sequence.check_thoroughly if thorough else None

        def plan_at(model: Model, saved: str | None = None) -> Plan:
            return sequence.plan(
                model, options=chosen, check=check,
                executor=executor, checkpoint=saved, progress=waiting,
            )  # fmt: skip

        found = plan_at(prepared, checkpoint)
        waiting.stage("margins", "margins")
        measured = sequence.margins(found, progress=waiting) if margins and found.steps else None
        swept = sequence.sweep_friction(prepared, frictions, plan_at) if frictions else None
        written = files.write(found, measured, waiting, subject.model)
    data = found.to_dict() | {
        "model": subject.model,
        "notes": list(prepared.notes),
        "margins": None if measured is None else measured.to_dict(),
        "friction_sweep": None if swept is None else list(swept.table()),
        "files": written,
        "time_s": dict(waiting.time_s),
    }
    if as_json:
        output.emit(data)
    else:
        _show(data, found)
        if files.wanted and not found.steps:
            output.console().print(f"not written: {', '.join(files.wanted)}")
    counts = found.counts
    helped = counts["propped"] + counts["impossible"]
    return 0 if found.steps and found.verdict == "stable" and not helped else 1


def _rules(
    order: str,
    hands: int,
    payload: float | None,
    before: list[str] | None,
    reach: list[str] | None,
) -> Rules:
    from drystone.sequence import Order, Rules

    pairs = []
    for text in before or []:
        first, colon, then = text.partition(":")
        if not colon or not first or not then:
            raise InputError(f"'{text}' is no pair", where="--before", remedy="write FIRST:THEN")
        pairs.append((first, then))
    tried = {one.value: one for one in Order}.get(order)
    return Rules(
        hands,
        float("inf") if payload is None else payload,
        pairs,
        [_names(group) for group in reach or []],
        tried if tried is not None else _names(order),
    )


def _names(text: str) -> list[str]:
    return [name.strip() for name in text.split(",")]


def _numbers(text: str | None) -> list[float]:
    if text is None:
        return []
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError as error:
        raise InputError(f"'{text}' is no list of numbers", where="--sweep") from error
    if not all(0.0 <= value < float("inf") for value in values):
        raise InputError(f"'{text}'", where="--sweep", remedy="give coefficients of zero or more")
    return values


def _executor(workers: int, dask: str | None) -> Executor | ExecutorFactory | None:
    if workers < 1:
        raise InputError(f"is {workers}", where="--workers", remedy="give one or more")
    if dask is not None:
        if workers > 1:
            raise InputError("--workers and --dask contradict each other", remedy="give one")
        from drystone.sequence import DaskWorkers

        return DaskWorkers(dask)
    if workers == 1:
        return None
    from drystone.sequence import LocalWorkers

    return LocalWorkers(workers)


def _show_impossible(data: Mapping[str, Any]) -> None:
    from rich.markup import escape

    console = output.console()
    rows = [block for block in data["blocks"] if block["status"] == "impossible"]
    for row in rows[:LISTED]:
        console.print(f"[magenta]impossible:[/] {escape(row['block'])}: {row['why']}")
    if len(rows) > LISTED:
        console.print(f"[dim]and {len(rows) - LISTED} more (--json lists all)[/]")


def _show(data: Mapping[str, Any], found: Plan) -> None:
    from rich.markup import escape
    from rich.table import Table

    console = output.console()
    counts = data["counts"]
    if not found.steps:
        console.print(f"[bold red]NO PLAN[/]  {escape(str(data['model']))}")
        console.print(escape(data["message"]))
        _show_impossible(data)
        return
    console.print(
        f"[bold]{counted(len(data['steps']), 'step')}[/]  {escape(str(data['model']))}  "
        + ", ".join(f"{counts[k]} {k}" for k in ("free", "held", "propped", "impossible"))
    )
    console.print(escape(data["message"]))
    table = Table("step", "block", "status", "with", "prop force [N]", "for stages", box=None)
    rows = list(found.table())
    for row in rows[:LISTED]:
        style = STYLE.get(row["status"], "")
        force = f"{row['prop_force']:,.0f}" if row["prop_stages"] else ""
        stages = str(row["prop_stages"] or "")
        table.add_row(
            str(row["stage"]), escape(row["block"]), row["status"], escape(row["with"]), force,
            stages, style=style,
        )  # fmt: skip
    console.print(table)
    if len(rows) > LISTED:
        console.print(f"[dim]and {len(rows) - LISTED} more (--json lists all)[/]")
    _show_impossible(data)
    if data["margins"] is not None:
        weakest = data["margins"]["weakest"]
        console.print(
            f"weakest stage: step {weakest['step'] + 1}, tilts {weakest['tilt_deg']:.1f} degrees; "
            f"this order works down to friction {data['margins']['least_friction']:.3g}"
        )
    for row in data["friction_sweep"] or []:
        if row["stands"]:
            words = ", ".join(f"{row[kind]} {kind}" for kind in ("free", "held", "propped"))
        else:
            words = "does not stand when complete"
        console.print(f"friction {row['friction']:g}: {words}")
    for note in data["notes"]:
        console.print(f"[yellow]note:[/] {escape(note)}")
    for name in data["files"]:
        console.print(f"wrote {escape(name)}")
