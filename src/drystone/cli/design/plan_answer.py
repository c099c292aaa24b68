"""The answer of ``drystone plan``: its files and its text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import astuple, dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from drystone.base import units
from drystone.base.errors import counted
from drystone.cli.base import kinds
from drystone.cli.base.command import OUTPUT, Option
from drystone.cli.base.output import Screen
from drystone.cli.base.written import apart, cad_jobs, refuse_missing
from drystone.cli.inputs import options

if TYPE_CHECKING:
    from drystone.base.files import Job
    from drystone.cli.base.told import Files
    from drystone.sequence import Margins, Plan, Robot, Scaffolding

_LISTED = 40
"""Rows shown of a table; --json has all."""
_REASONS = 3
"""Steps whose need of help is explained."""
STYLE = {"held": "bold", "propped": "bold red", "impossible": "bold magenta"}


@dataclass(frozen=True)
class PlanFiles:
    """The files of a plan."""

    work: Annotated[
        Path | None,
        Option("Write the placements for robots: paths, grips and holds, .json or .csv.", OUTPUT,
               kind=kinds.target(".json", ".csv"), expert=True),
    ] = None  # fmt: skip
    html: options.Html = None
    png: options.Png = None
    cad: options.Cad = None
    instructions: Annotated[
        Path | None,
        Option("Write numbered instructions for printing, .html.", OUTPUT, ("--print",),
               kinds.target(".html", ".htm"), expert=True),
    ] = None  # fmt: skip
    csv: Annotated[
        Path | None,
        Option("Write the table of stages, .csv.", OUTPUT, kind=kinds.target(".csv"), expert=True),
    ] = None

    def __post_init__(self) -> None:
        apart(astuple(self))
        refuse_missing(self.cad)

    def of(
        self,
        plan: Plan,
        made: Scaffolding | None,
        margins: Margins | None,
        robots: Sequence[Robot],
    ) -> Files:
        """The files of a plan, with its scaffolding and its margins where there are some."""
        if not plan.steps:
            wanted = [str(path) for path in astuple(self) if path is not None]
            return [], [f"not written: {', '.join(wanted)}"] if wanted else []
        jobs: list[Job] = cad_jobs(self.cad, plan)
        if self.html is not None or self.png is not None or self.instructions is not None:
            from drystone.view import save_figure, save_page
            from drystone.view.paper.instructions import save_instructions

            if self.html is not None:
                jobs.append((self.html, partial(save_page, made or plan)))
            if self.png is not None:
                jobs.append((self.png, partial(save_figure, made or plan)))
            if self.instructions is not None:
                jobs.append((self.instructions, partial(save_instructions, plan)))
        if self.work is not None:
            from drystone.sequence import handling

            placed, flat = handling(plan, robots), self.work.suffix == ".csv"
            jobs.append((self.work, placed.save_csv if flat else placed.save_json))
        if self.csv is not None:
            jobs.append((self.csv, (plan if margins is None else margins).table().to_csv))
        return jobs, []


def show(data: Mapping[str, Any], found: Plan, screen: Screen) -> None:
    """The steps, and what they need."""
    counts = data["counts"]
    if not found.steps:
        screen.line(str(data["model"]), "NO PLAN", "bold red")
        screen.line(data["message"])
        _show_impossible(data, screen)
        return
    told = ", ".join(f"{counts[k]} {k}" for k in ("free", "held", "propped", "impossible"))
    screen.line(f"{data['model']}  {told}", counted(len(data["steps"]), "step"))
    screen.line(data["message"])
    if any(found.help) and not found.proved:
        screen.dim("another order may need less help; --best searches all, which may take long")
    rows = list(found.table())
    force = "prop force" if data["scaffolding"] is None else "ideal prop force"
    screen.table(
        ("step", "block", "status", "with", force, "for stages"),
        [
            (
                str(row["stage"]), row["block"], row["status"], row["with"],
                units.quantity(row["prop_force"], "N") if row["prop_stages"] else "",
                str(row["prop_stages"] or ""),
            )
            for row in rows
        ],
        listed=_LISTED,
        styles=[STYLE.get(row["status"], "") for row in rows],
    )  # fmt: skip
    _show_impossible(data, screen)
    reasons = [(step["step"] + 1, step["why"]) for step in data["steps"] if step["why"]]
    for number, why in reasons[:_REASONS]:
        screen.line(why, f"step {number},", "bold", " ")
    if len(reasons) > _REASONS:
        screen.dim(
            f"and {counted(len(reasons) - _REASONS, 'more step')} with help (--json has why)"
        )
    if data["scaffolding"] is not None:
        made = data["scaffolding"]
        fails = f"{counted(len(made['failed']), 'stage')} without a rest state or over the limit"
        ends = fails if made["failed"] else "every stage stands"
        known = " where a rest state was found" if made["failed"] else ""
        screen.line(
            f"on {made['support']}: {ends}; {made['metre_stages']:.3g} m times stages, at most "
            f"{units.quantity(made['peak_force'], 'N')}{known}, {counted(made['moves'], 'move')}, "
            f"cost {made['cost']:.3g}"
        )
    if data["margins"] is not None and data["margins"]["stopped"]:
        screen.line(f"margins of some stages are not known: {data['margins']['stopped']}")
    elif data["margins"] is not None:
        weakest = data["margins"]["weakest"]
        screen.line(
            f"weakest stage: step {weakest['step'] + 1}, tilts {weakest['tilt_deg']:.1f} degrees; "
            f"this order works down to friction {data['margins']['least_friction']:.3g}"
        )
    for row in data["friction_sweep"] or []:
        if row["stands"]:
            words = ", ".join(f"{row[kind]} {kind}" for kind in ("free", "held", "propped"))
        else:
            words = "does not stand when complete"
        more = f" ({row['why_more']})" if row["why_more"] else ""
        screen.line(f"friction {row['friction']:g}: {words}{more}")


def _show_impossible(data: Mapping[str, Any], screen: Screen) -> None:
    rows = [block for block in data["blocks"] if block["status"] == "impossible"]
    for row in rows[:_LISTED]:
        screen.line(f"{row['block']}: {row['why']}", "impossible:", "magenta", " ")
    if len(rows) > _LISTED:
        screen.dim(f"and {len(rows) - _LISTED} more (--json lists all)")
