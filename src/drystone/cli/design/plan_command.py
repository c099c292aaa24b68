"""``drystone plan``: the order of assembly, the blocks to hold and to prop."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

from drystone.base import units
from drystone.base.errors import InputError, counted
from drystone.cli.base import kinds
from drystone.cli.base.answer import Answer
from drystone.cli.base.command import OUTPUT, Option, command
from drystone.cli.base.output import Screen
from drystone.cli.base.waiting import Waiting
from drystone.cli.base.written import apart, cad_jobs, refuse_missing
from drystone.cli.inputs import options
from drystone.cli.inputs.model_input import Finding, Subject

if TYPE_CHECKING:
    from drystone.base.files import Job
    from drystone.cli.base.answer import Files
    from drystone.model import Model
    from drystone.sequence import (
        ExecutorFactory,
        Margins,
        Plan,
        Robot,
        Rules,
        Scaffolding,
        ScaffoldOptions,
    )

_LISTED = 40
"""Rows shown of a table; --json has all."""
_REASONS = 3
"""Steps whose need of help is explained."""
_HANDS = 2
SCAFFOLDS = ("strut", "rope", "clamp", "centring")
STYLE = {"held": "bold", "propped": "bold red", "impossible": "bold magenta"}


def _numbers(text: str) -> tuple[float, ...]:
    return tuple(units.coefficient(part) for part in text.split(","))


def _pair(text: str) -> tuple[str, str]:
    first, colon, then = text.partition(":")
    if not colon or not first or not then:
        raise InputError(f"'{text}' is no pair", remedy="write FIRST:THEN")
    return first, then


def _names(text: str) -> list[str]:
    return [name.strip() for name in text.split(",")]


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


def _robot(text: str) -> Robot:
    """A robot from ``NAME:X,Y,Z``, with its reach [m] and payload [kg] behind further colons."""
    from drystone.sequence import Robot

    name, *rest = text.split(":")
    try:
        base, reach, payload = (*rest, "", "")[: max(3, len(rest))]
        most = [float(one) if one else float("inf") for one in (reach, payload)]
        x, y, z = (float(one) for one in base.split(","))
    except ValueError as error:
        raise InputError(
            f"'{text}' is no robot", remedy="write NAME:X,Y,Z:REACH:PAYLOAD"
        ) from error
    return Robot(name, (x, y, z), *most)


@command(
    "drystone plan arch.json --html plan.html",
    "drystone plan arch.json --order course --hands 3 --csv stages.csv",
)
def plan(
    *,
    subject: Subject,
    finding: Finding,
    order: Annotated[
        str,
        Option(
            "Order of removal: top (highest first), course (course by course), boundary (farthest "
            "from it first); or names in the order of assembly, separated by commas: other blocks "
            "follow in the default order (top).",
            metavar="top|course|boundary|NAMES",
        ),
    ] = "top",
    hands: Annotated[
        int, Option("Hands or robots: one places, others hold (2).", flags=("--hands", "--robots"))
    ] = _HANDS,
    robot: Annotated[
        tuple[Any, ...],  # of Robot, which is imported when needed
        Option("A robot: its base in m, its reach in m and its payload in kg; several times. Then "
               "--hands and --payload are not used.",
               kind=kinds.OptionKind("NAME:X,Y,Z:REACH:PAYLOAD", _robot), expert=True),
    ] = (),
    work: Annotated[
        Path | None,
        Option("Write the placements for robots: paths, grips and holds, .json or .csv.", OUTPUT,
               kind=kinds.target(".json", ".csv"), expert=True),
    ] = None,
    payload: Annotated[
        float, Option("Mass that each hand can lift or hold, in kg.", expert=True)
    ] = float("inf"),
    before: Annotated[
        tuple[tuple[str, str], ...],
        Option("One block before another; several times.", expert=True,
               kind=kinds.OptionKind("FIRST:THEN", _pair)),
    ] = (),
    reach: Annotated[
        tuple[list[str], ...],
        Option("Blocks placed before any of the next --reach; separated by commas.",
               kind=kinds.OptionKind("NAMES", _names), expert=True),
    ] = (),
    exact: Annotated[
        bool, Option("Search all orders (up to 14 free blocks).", expert=True)
    ] = False,
    best: Annotated[
        bool, Option("Search until no order with less help is left.", expert=True)
    ] = False,
    thorough: Annotated[
        bool, Option("Accept stages that are sensitive to joint stiffness.", expert=True)
    ] = False,
    scaffold: Annotated[
        str | None,
        Option("What holds propped blocks: checked with its one-sided forces (ideal props).",
               kind=kinds.one_of(SCAFFOLDS)),
    ] = None,
    scaffold_limit: ScaffoldLimit = None,
    scaffold_foot: ScaffoldFoot = None,
    scaffold_length: ScaffoldLength = None,
    margins: Annotated[
        bool, Option("Least friction and tilt limit of every stage.", expert=True)
    ] = False,
    sweep: Annotated[
        tuple[float, ...] | None,
        Option("Plan at these friction coefficients as well.",
               kind=kinds.OptionKind("MU,MU,...", _numbers), expert=True),
    ] = None,
    workers: Annotated[
        int,
        Option("Processes that check stages side by side (1).", kind=kinds.whole(1), expert=True),
    ] = 1,
    dask: Annotated[
        str | None,
        Option("A running Dask scheduler to work on.", metavar="ADDRESS", expert=True),
    ] = None,
    checkpoint: Annotated[
        str | None,
        Option("File with which an interrupted search continues.", kind=kinds.FILE, expert=True),
    ] = None,
    html: options.Html = None,
    png: options.Png = None,
    cad: options.Cad = None,
    instructions: Annotated[
        Path | None,
        Option("Write numbered instructions for printing, .html.", OUTPUT, ("--print",),
               kinds.target(".html", ".htm"), expert=True),
    ] = None,
    csv: Annotated[
        Path | None,
        Option("Write the table of stages, .csv.", OUTPUT, kind=kinds.target(".csv"), expert=True),
    ] = None,
    waiting: Waiting,
) -> Answer:  # fmt: skip
    """Plan the assembly of a model: order, blocks to hold, blocks to prop.

    Exit code 0: every stage stands without a prop. 1: props are needed, blocks cannot be inserted,
    or the complete model does not stand. 2: bad input.
    """
    apart([html, png, cad, instructions, csv, work])
    refuse_missing(cad)
    _refuse_unused(scaffold, scaffold_limit, scaffold_foot, scaffold_length)
    rules = _rules(order, hands, payload, before, reach, robot)
    executor = _executor(workers, dask)
    waiting.checkpoint = None if checkpoint is None else Path(checkpoint)
    model = subject.prepared(waiting, finding)
    from drystone import sequence

    waiting.stage("plan", "planning")
    chosen = sequence.PlanOptions(
        rules=rules, exact=exact, patience=float("inf") if best else None, anyway=finding.anyway,
        scaffold=scaffold,
        scaffold_options=scaffold_options(scaffold_limit, scaffold_foot, scaffold_length),
    )  # fmt: skip
    check = sequence.check_thoroughly if thorough else None

    def plan_at(model: Model, saved: str | None = None) -> Plan:
        return sequence.plan(
            model, options=chosen, check=check, executor=executor, checkpoint=saved,
            progress=waiting, stop=lambda: waiting.interrupted,
        )  # fmt: skip

    found = plan_at(model, checkpoint)
    measured = swept = None
    with waiting.stoppable() as stop:
        if margins and found.steps:
            waiting.stage("margins", "margins")
            measured = sequence.margins(found, progress=waiting, stop=stop)
        if sweep:
            waiting.stage("sweep", "sweep over friction")
            swept = sequence.sweep_friction(model, list(sweep), plan_at, stop=stop)
    made = None
    if scaffold is not None and found.steps:
        made = sequence.scaffolding(found, scaffold, options=chosen.scaffold_options)
    data = found.to_dict() | {
        "model": subject.model,
        "scaffolding": None if made is None else made.to_dict(),
        "margins": None if measured is None else measured.to_dict(),
        "friction_sweep": None if swept is None else list(swept.table()),
    }
    helped = found.counts["propped"] + found.counts["impossible"]
    code = 0 if found.steps and found.stable and not helped else 1
    files = partial(
        _files, found, made, measured, html, png, cad, instructions, csv, work, robot, subject.model
    )
    return Answer(data, partial(_show, data, found), code, model.notes, files)


def _files(
    plan: Plan,
    made: Scaffolding | None,
    margins: Margins | None,
    html: Path | None,
    png: Path | None,
    cad: Path | None,
    steps: Path | None,
    csv: Path | None,
    work: Path | None,
    robots: Sequence[Robot],
    source: str,
) -> Files:
    wanted = [str(path) for path in (html, png, cad, steps, csv, work) if path is not None]
    if not plan.steps:
        return [], [f"not written: {', '.join(wanted)}"] if wanted else []
    jobs: list[Job] = cad_jobs(cad, plan, source)
    if html is not None or png is not None or steps is not None:
        from drystone.view import save_figure, save_page
        from drystone.view.paper.instructions import save_instructions

        if html is not None:
            jobs.append((html, partial(save_page, made or plan, source=source)))
        if png is not None:
            jobs.append((png, partial(save_figure, made or plan, source=source)))
        if steps is not None:
            jobs.append((steps, partial(save_instructions, plan)))
    if work is not None:
        from drystone.sequence import handling

        placed = handling(plan, robots)
        jobs.append((work, placed.save_csv if work.suffix == ".csv" else placed.save_json))
    if csv is not None:
        jobs.append((csv, (plan if margins is None else margins).table().to_csv))
    return jobs, []


def _refuse_unused(scaffold: str | None, *limits: float | str | None) -> None:
    """Refuse limits of scaffolding without scaffolding."""
    for name, value in zip(("limit", "foot", "length"), limits, strict=True):
        if scaffold is None and value is not None:
            raise InputError(
                f"--scaffold-{name} is given without --scaffold",
                remedy=f"add --scaffold, with one of {', '.join(SCAFFOLDS)}",
            )
    refuse_strutless([] if scaffold is None else [scaffold], *limits[1:], flag="--scaffold-")


def refuse_strutless(kinds: Sequence[str], *limits: float | str | None, flag: str) -> None:
    """Refuse the foot and the length of struts where nothing is held by struts."""
    for name, value in zip(("foot", "length"), limits, strict=True):
        if value is not None and kinds and "strut" not in kinds:
            raise InputError(
                f"{flag}{name} is for struts, and there are none",
                remedy="leave it out, or hold with struts",
            )


def _rules(
    order: str,
    hands: int,
    payload: float,
    before: tuple[tuple[str, str], ...],
    reach: tuple[list[str], ...],
    robots: tuple[Robot, ...],
) -> Rules:
    from drystone.sequence import Order, Rules

    if robots and (hands != _HANDS or payload != float("inf")):
        raise InputError("--robot contradicts --hands and --payload", remedy="give one of them")
    tried = {one.value: one for one in Order}.get(order)
    return Rules(
        len(robots) or hands, payload, list(before), list(reach),
        tried if tried is not None else _names(order), robots,
    )  # fmt: skip


def _executor(workers: int, dask: str | None) -> Executor | ExecutorFactory | None:
    if dask is not None:
        if workers > 1:
            raise InputError("--workers and --dask contradict each other", remedy="give one")
        from drystone.sequence import DaskWorkers

        return DaskWorkers(dask)
    if workers == 1:
        return None
    from drystone.sequence import LocalWorkers

    return LocalWorkers(workers)


def _show(data: Mapping[str, Any], found: Plan, screen: Screen) -> None:
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
