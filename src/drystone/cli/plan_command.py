"""``drystone plan``: the order of assembly, the blocks to hold and to prop."""

from __future__ import annotations

from concurrent.futures import Executor
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from drystone.base import units
from drystone.base.errors import InputError
from drystone.cli import kinds
from drystone.cli.command import command
from drystone.cli.model_input import Subject
from drystone.cli.offered import Option
from drystone.cli.plan_files import PlanFiles
from drystone.cli.scaffold_command import (
    SCAFFOLDS,
    ScaffoldFoot,
    ScaffoldLength,
    ScaffoldLimit,
    refuse_strutless,
    scaffold_options,
)
from drystone.cli.told import Told
from drystone.cli.waiting import Waiting

if TYPE_CHECKING:
    from drystone.model import Model
    from drystone.sequence import ExecutorFactory, Plan, Robot, Rules

_HANDS = 2


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
    wanted: PlanFiles,
    waiting: Waiting,
) -> Told:  # fmt: skip
    """Plan the assembly of a model: order, blocks to hold, blocks to prop.

    Exit code 0: every stage stands without a prop. 1: props are needed, blocks cannot be inserted,
    or the complete model does not stand. 2: bad input.
    """
    _refuse_unused(scaffold, scaffold_limit, scaffold_foot, scaffold_length)
    rules = _rules(order, hands, payload, before, reach, robot)
    executor = _executor(workers, dask)
    waiting.checkpoint = None if checkpoint is None else Path(checkpoint)
    model = subject.prepared(waiting)
    from drystone import sequence

    waiting.stage("plan", "planning")
    chosen = sequence.PlanOptions(
        rules=rules, patience=float("inf") if best else None, anyway=subject.anyway,
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
    also = {"scaffolding": made, "margins": measured, "friction_sweep": swept}
    return Told(
        found, {key: one for key, one in also.items() if one is not None},
        notes=model.notes, files=partial(wanted.of, found, made, measured, robot),
    )  # fmt: skip


def _refuse_unused(scaffold: str | None, *limits: float | str | None) -> None:
    """Refuse limits of scaffolding without scaffolding."""
    for name, value in zip(("limit", "foot", "length"), limits, strict=True):
        if scaffold is None and value is not None:
            raise InputError(
                f"--scaffold-{name} is given without --scaffold",
                remedy=f"add --scaffold, with one of {', '.join(SCAFFOLDS)}",
            )
    refuse_strutless([] if scaffold is None else [scaffold], *limits[1:], flag="--scaffold-")


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
