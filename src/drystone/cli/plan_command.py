"""``drystone plan`` and ``scaffold``: the order of assembly, and what holds blocks meanwhile."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass, replace
from enum import Enum
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from drystone.base import units
from drystone.base.display import differing
from drystone.base.errors import InputError
from drystone.cli import kinds, offered
from drystone.cli.command import command
from drystone.cli.mend_command import may_mend
from drystone.cli.model_input import Subject
from drystone.cli.offered import OUTPUT, Analysis, Of, Option, writes
from drystone.cli.told import Told, WithFilm
from drystone.cli.waiting import Waiting, executor_of

if TYPE_CHECKING:
    from drystone.answer import Sentence
    from drystone.base.table import Table
    from drystone.cli.told import Files, Jobs
    from drystone.model import Model
    from drystone.sequence import (
        Margins,
        Plan,
        PlanOptions,
        Robot,
        Scaffolding,
        ScaffoldOptions,
        StageAnswer,
        Support,
        Turns,
    )


SCAFFOLDS = ("strut", "rope", "clamp", "centring")
_ORDERS = ("top", "course", "boundary", "fewest-props")
_FEW = 14
"""Free blocks up to which the order with the fewest props is searched without being asked for."""

_LISTED = 40
"""Blocks up to which the order is told to be given again. Chosen: some lines."""

_RESERVE = "--margins tells what each stage has in reserve, and takes tens of times as long"

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
    csv: offered.Csv = None,
    time_limit: offered.TimeLimit = None,
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
    said = {*table["message"].tolist()}
    alike = len(said) == 1  # told once; and orders with equal plans share a line
    told += [Sentence(one, Role.REMARK) for one in said if alike and one]
    columns = {"order": table["order"], **table.columns}
    compared = Table("compared", columns, table.units, hidden=("message",) * alike)
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


@dataclass(frozen=True)
class PlanFiles(WithFilm):
    """The files of a plan."""

    cad: offered.Cad = None
    work: Annotated[
        Path | None,
        writes(
            "Write the placements for robots: paths, grips and holds, .json or .csv.",
            ".json", ".csv", expert=True,
        ),
    ] = None  # fmt: skip
    stages: Annotated[
        Path | None,
        Option("Folder for a model of each stage, .json; what is propped then is a support there.",
               OUTPUT, kind=kinds.FOLDER, expert=True),
    ] = None  # fmt: skip
    instructions: Annotated[
        Path | None,
        writes(
            "Write numbered instructions for printing, .html.",
            ".html", ".htm", flags=("--print",), expert=True,
        ),
    ] = None  # fmt: skip

    def models(self, stage: Callable[[int], Model], count: int) -> Jobs:
        """The files of the stages, where they are asked for."""
        from drystone import io

        if self.stages is None:
            return []
        digits = len(str(count))
        return [
            (self.stages / f"stage-{i + 1:0{digits}d}.json", partial(io.write, stage(i)))
            for i in range(count)
        ]

    def of_turns(self, turns: Turns) -> Files:
        """The files of robots that take turns."""
        jobs, notes = self.of(turns)
        stages = self.models(turns.stage, len(turns.turns))
        held = "the block that is held is a support in its stage, so nothing is free in the first"
        return [*jobs, *stages], [*notes, held] if stages else notes

    def all_of(
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
        jobs, notes = replace(self, csv=None).of(made or plan)
        jobs += self.models(plan.stage, len(plan))
        if self.instructions is not None:
            from drystone.report import save_instructions

            jobs.append((self.instructions, partial(save_instructions, plan)))
        if self.csv is not None:
            jobs.append((self.csv, (plan if margins is None else margins).table().to_csv))
        if self.work is None:
            return jobs, notes
        from drystone.sequence import handling

        placed = handling(plan, robots, margins=margins, scaffolding=made)
        more = sorted({*placed.notes} - {*plan.notes}, key=placed.notes.index)
        flat = self.work.suffix == ".csv"
        jobs.append((self.work, placed.table().to_csv if flat else placed.save_json))
        return jobs, [*notes, *more]


def _numbers(text: str) -> tuple[float, ...]:
    return tuple(units.coefficient(part) for part in text.split(","))


def _pair(text: str) -> tuple[str, str]:
    first, colon, then = text.partition(":")
    if not colon or not first or not then:
        raise InputError(f"'{text}' is no pair", remedy="write FIRST:THEN")
    return first, then


def _names(text: str) -> list[str]:
    return [name.strip() for name in text.split(",")]


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
            f"'{text}' is no robot", remedy="write NAME:X,Y,Z, or NAME:X,Y,Z:REACH:PAYLOAD"
        ) from error
    return Robot(name, (x, y, z), *most)


@command(
    "drystone plan arch.json --html plan.html",
    "drystone plan arch.json --order course --hands 3 --csv stages.csv",
)
def plan(
    *,
    subject: Subject,
    order: Annotated[
        str,
        Option(
            "Order of removal: top (highest first), course (course by course), boundary (farthest "
            "from it first); or names in the order of assembly, separated by commas: other blocks "
            "follow in the default order (top).",
            metavar="top|course|boundary|NAMES",
        ),
    ] = "top",
    chosen: Annotated[
        PlanOptions,
        Of(
            "drystone.sequence.PlanOptions",
            ("rules.hands", "rules.payload", "scaffold", *SCAFFOLD_LIMITS),
            shown=("rules.hands", "scaffold"),
            flags=SCAFFOLD_LIMITS,
        ),
    ],
    robot: Annotated[
        tuple[Any, ...],  # of Robot, which is imported when needed
        Option("A robot: its base in m, its reach in m and its payload in kg; several times. Then "
               "--hands and --payload are not used.",
               kind=kinds.OptionKind("NAME:X,Y,Z:REACH:PAYLOAD", _robot), expert=True),
    ] = (),
    before: Annotated[
        tuple[tuple[str, str], ...],
        Option("One block before another; several times.", expert=True,
               kind=kinds.OptionKind("FIRST:THEN", _pair)),
    ] = (),
    turns: Annotated[
        bool, Option("Each robot or hand holds its block until the next one is in place, and "
                     "nothing is propped. Needs two or more, searches for no order: tries that of "
                     "the file, or --order NAMES with every free block.",
                     expert=True)
    ] = False,
    best: Annotated[
        bool, Option("Search until no order with less help is left.", expert=True)
    ] = False,
    thorough: Annotated[
        bool, Option("Accept stages that are sensitive to joint stiffness.", expert=True)
    ] = False,
    margins: Annotated[
        bool, Option("Least friction, to 0.01, and tilt limit, to 0.5 degrees, of every stage; "
                     "takes tens of times as long as the plan.", expert=True)
    ] = False,
    sweep: Annotated[
        tuple[float, ...] | None,
        Option("Plan at these friction coefficients as well.",
               kind=kinds.OptionKind("MU,MU,...", _numbers), expert=True),
    ] = None,
    workers: offered.Workers = 1,
    time_limit: offered.TimeLimit = None,
    checkpoint: Annotated[
        Path | None,
        Option("File with which an interrupted search continues.", kind=kinds.target(),
               expert=True),
    ] = None,
    wanted: PlanFiles,
    waiting: Waiting,
) -> Told:  # fmt: skip
    """Plan the assembly of a model: order, blocks to hold, blocks to prop.

    Exit code 0: every stage stands without a prop. 1: props are needed, blocks cannot be placed, or
    the complete model does not stand. 2: bad input. 130: stopped by Ctrl-C, with the blocks that
    are known to be placed last.
    """
    refuse_unused(chosen.scaffold_options, chosen.scaffold)
    others = chosen.scaffold, margins, sweep, best, before, wanted.work, wanted.instructions
    if turns and any(others):
        raise InputError(
            "takes no --scaffold, --margins, --sweep, --best, --before, --work, --print",
            where="--turns",
            remedy="leave these out; --json has the holds",
        )
    chosen = _with_rules(chosen, order, before, robot)
    chosen = replace(chosen, patience=float("inf") if best else None, anyway=subject.anyway)
    waiting.checkpoint = checkpoint
    model = subject.prepared(waiting)
    from drystone import sequence

    waiting.stage("plan", "planning")
    check = sequence.check_thoroughly if thorough else None
    limit = float("inf") if time_limit is None else time_limit

    if turns:
        with waiting.stoppable() as stop:
            in_turn = sequence.take_turns(
                model, None if order == "top" else _names(order), chosen.rules.team,
                check=check, executor=executor_of(workers),
                progress=waiting, stop=stop, time_limit_s=limit,
            )  # fmt: skip
        notes = list(model.notes)
        if order == "top" and not (in_turn.works or in_turn.stopped or in_turn.falls):
            notes.append("in the order of the file: another one may do, try --order NAMES")
        return Told(
            in_turn, notes=notes, files=partial(wanted.of_turns, in_turn), into=wanted.stages,
            then=_next(subject, in_turn.complete),
        )  # fmt: skip

    def plan_at(model: Model, saved: Path | None = None) -> Plan:
        return sequence.plan(
            model, options=chosen, check=check, executor=executor_of(workers), checkpoint=saved,
            progress=waiting, stop=lambda: waiting.interrupted, time_limit_s=limit,
        )  # fmt: skip

    measured = swept = made = None
    with waiting.stoppable() as stop:
        found = plan_at(model, checkpoint)
        if margins and found.steps:
            waiting.stage("margins", "margins")
            measured = sequence.margins(found, progress=waiting, stop=stop)
        if sweep:
            waiting.stage("sweep", "sweep over friction")
            swept = sequence.sweep_friction(model, list(sweep), plan_at, stop=stop)
        if chosen.scaffold is not None and found.steps:
            made = sequence.scaffolding(
                found, chosen.scaffold, options=chosen.scaffold_options, stop=stop,
                time_limit_s=limit,
            )  # fmt: skip
    also = {"scaffolding": made, "margins": measured, "friction_sweep": swept}
    kept = [waiting.left()] if found.stopped and checkpoint is not None else []
    return Told(
        found, {key: one for key, one in also.items() if one is not None},
        notes=[*model.notes, *found.notes, *_again(found, margins, made), *kept],
        files=partial(wanted.all_of, found, made, measured, robot),
        into=wanted.stages if found.steps else None,
        then=_next(subject, found.complete, found),
    )  # fmt: skip


def _again(plan: Plan, margins: bool, made: object) -> list[str]:
    """The order of a plan of few blocks, to be given again, its reserve; and what saves props."""
    if plan.impossible or not plan.steps:
        return []
    names = shlex.quote(",".join(plan.order))
    said = [] if margins or not plan.stable else [_RESERVE]
    said += [f"this order: --order {names}"] if len(plan.order) <= _LISTED else []
    if plan.counts["propped"]:
        ways = [
            f"--hands {plan.rules.hands + 1} gives one more hand" if not plan.rules.robots else "",
            "--scaffold strut asks for real ones" if made is None else "",
            "drystone recut may change joints so that none is needed",
        ]
        said.append(f"props: {', '.join(filter(None, ways))}")
    return said


def _next(subject: Subject, complete: StageAnswer | None, plan: Plan | None = None) -> str:
    """The command that mends what falls when it is complete, or changes joints to save props."""
    if complete is not None and may_mend(complete):
        return subject.command("mend")
    if plan is None or not plan.stable or not plan.counts["propped"]:
        return ""
    hands = len(plan.rules.team)
    return subject.command("recut", *([] if hands == 2 else ["--hands", str(hands)]))


def _with_rules(
    chosen: PlanOptions,
    order: str,
    before: tuple[tuple[str, str], ...],
    robots: tuple[Robot, ...],
) -> PlanOptions:
    from drystone.sequence import Order, Rules

    rules, free = chosen.rules, Rules()
    if robots and (rules.hands, rules.payload) != (free.hands, free.payload):
        raise InputError("--robot contradicts --hands and --payload", remedy="give one of them")
    tried = {one.value: one for one in Order}.get(order)
    more = replace(
        rules,
        hands=len(robots) or rules.hands,
        before=list(before),
        order=tried if tried is not None else _names(order),
        robots=robots,
    )
    return replace(chosen, rules=more)
