"""``drystone tune``: the parameters with which a family is best and stands."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from drystone.base.errors import InputError
from drystone.cli.base import kinds
from drystone.cli.base.answer import Answer
from drystone.cli.base.command import MODEL, OUTPUT, Argument, Option, command
from drystone.cli.base.output import Screen
from drystone.cli.base.waiting import Waiting
from drystone.cli.design.mend_command import Margin, margins
from drystone.cli.inputs import families, options

if TYPE_CHECKING:
    from drystone.design import Parameter


@command(
    "drystone tune arch --vary thickness_ratio=0.05:0.3 --friction 0.8",
    "drystone tune tower --vary edge=0.5:2 --vary count=2:6 --least volume --most height",
)
def tune(
    *,
    family: Annotated[str, Argument("FAMILY", "A parametric family; 'drystone models' lists all.")],
    vary: Annotated[
        tuple[str, ...],
        Option(
            "A parameter and its bounds, or values by commas. Can be given several times.",
            MODEL,
            metavar="NAME=LOW:HIGH",
        ),
    ] = (),
    set: families.Settings = (),
    friction: options.Friction = None,
    least: Annotated[
        tuple[str, ...],
        Option(
            "What is to be least: volume, blocks, height or a parameter (volume).", metavar="GOAL"
        ),
    ] = (),
    most: Annotated[tuple[str, ...], Option("What is to be most.", metavar="GOAL")] = (),
    margin: Margin = (),
    trials: Annotated[int, Option("Structures that are built and checked (100).")] = 100,
    workers: Annotated[int, Option("Processes (1).")] = 1,
    seed: Annotated[int, Option("Of the search (0).", expert=True)] = 0,
    store: Annotated[
        Path | None,
        Option("File that keeps the trials: the search goes on where it was ended.", OUTPUT),
    ] = None,
    out: Annotated[
        Path | None,
        Option("Write the best model by the first goal.", OUTPUT, kind=kinds.target(".json")),
    ] = None,
    time_limit: options.TimeLimit = None,
    waiting: Waiting,
) -> Answer:
    """Search for the parameters with which a family of structures stands and is best.

    With several goals the front is listed: no other structure is better in all of them.

    Exit code 0: some structure stands. 1: none does. 2: bad input. 130: Ctrl-C ended the search;
    the trials so far are the answer.
    """
    build, known = families.family(family)
    if not vary:
        raise InputError("nothing is varied", where="--vary", remedy="write --vary NAME=LOW:HIGH")
    given = dict(families.setting(text, known) for text in set)
    ranges = [_range(text, known) for text in vary]
    stands_at = margins(margin)
    from drystone import design  # work is imported when there is some
    from drystone.base.progress import Clock

    goals = (*least, *(f"-{goal}" for goal in most)) or ("volume",)
    chosen = design.TuneOptions(trials=trials, workers=workers, seed=seed, margin=stands_at)
    clock = Clock(float("inf") if time_limit is None else time_limit)
    how: dict[str, Any] = {} if friction is None else {"friction": friction}
    made = partial(build, **given)
    waiting.stage("tune", "searching")
    with waiting.stoppable() as stop:
        found = design.tune(
            made,
            ranges,
            goals=goals,
            how=how,
            store=store,
            options=chosen,
            progress=waiting,
            stop=lambda: stop() or clock.late(),
        )
    data = {"family": family, "message": found._summary(), **found.to_dict()}
    files = None
    if out is not None and found.front:
        from drystone import io
        from drystone.model import Model

        best = Model.of(made(**found.front[0].values), **how)
        files = partial(_files, [(out, partial(io.write, best))])
    return Answer(data, partial(_show, data), 0 if found.front else 1, (), files)


def _files(jobs: list[Any]) -> tuple[list[Any], list[str]]:
    return jobs, []


def _range(text: str, known: families.Parameters) -> Parameter:
    """A parameter from ``NAME=LOW:HIGH`` or ``NAME=ONE,OTHER``."""
    from drystone.design import Parameter

    name, equals, bounds = text.partition("=")
    name = name.replace("-", "_")
    if not equals:
        raise InputError(f"'{text}' is not NAME=LOW:HIGH", where="--vary")
    families.refuse_unknown(name, known, "--vary")
    low, colon, high = bounds.partition(":")
    if not colon:
        values = tuple(families.setting(f"{name}={one}", known)[1] for one in bounds.split(","))
        return Parameter(name, choices=values)
    ends = [families.setting(f"{name}={end}", known)[1] for end in (low, high)]
    if not all(isinstance(end, int | float) for end in ends):
        raise InputError(f"{name} has no bounds", where="--vary", remedy="give values by commas")
    whole = all(isinstance(end, int) for end in ends)
    return Parameter(name, float(ends[0]), float(ends[1]), whole=whole)


def _show(data: dict[str, Any], screen: Screen) -> None:
    screen.line(data["family"], data["message"], "bold")
    for one in data["front"]:
        values = ", ".join(f"{name} {_short(value)}" for name, value in one["values"].items())
        pairs = zip(data["goals"], one["goals"], strict=True)
        told = ", ".join(f"{goal.removeprefix('-')} {value:.4g}" for goal, value in pairs)
        screen.line(f"{told}: {values}")


def _short(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


__all__ = ["tune"]
