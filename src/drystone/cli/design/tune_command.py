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
    from drystone.cli.base.answer import Files
    from drystone.design import Parameter, Tuned


@command(
    "drystone tune arch --vary thickness_ratio=0.05:0.3 --friction 0.8 --trials 40",
    "drystone tune tower --vary edge=0.5:2 --vary count=2:6 --least volume --most height",
)
def tune(
    *,
    family: Annotated[
        str,
        Argument(
            "FAMILY",
            "A parametric family; 'drystone models' lists all. Or a shell: barrel-shell, "
            "dome-shell, free-edge-shell and others.",
        ),
    ],
    vary: Annotated[
        tuple[str, ...],
        Option(
            "A parameter and its bounds, or values separated by commas. Can be given several "
            "times.",
            MODEL,
            metavar="NAME=LOW:HIGH",
        ),
    ] = (),
    set: families.Settings = (),
    friction: options.Friction = None,
    least: Annotated[
        tuple[str, ...],
        Option(
            "What is to be least: volume, blocks, height, reach, props, held or a parameter "
            "(volume).",
            metavar="GOAL",
        ),
    ] = (),
    most: Annotated[tuple[str, ...], Option("What is to be most.", metavar="GOAL")] = (),
    margin: Margin = (),
    props: Annotated[
        int | None,
        Option(
            "Largest number of blocks that may need a prop while it is built, course by course."
        ),
    ] = None,
    trials: Annotated[int, Option("Structures that are built and checked (100).")] = 100,
    workers: Annotated[int, Option("Processes (1).")] = 1,
    seed: Annotated[int, Option("Of the search (0).", expert=True)] = 0,
    store: Annotated[
        Path | None,
        Option("File that keeps the trials: an interrupted search continues from it.", OUTPUT),
    ] = None,
    out: Annotated[
        Path | None,
        Option("Write the best model by the first goal.", OUTPUT, kind=kinds.target(".json")),
    ] = None,
    png: Annotated[
        Path | None,
        Option(
            "Draw the trials and the front: .png, .svg or .pdf.",
            OUTPUT,
            kind=kinds.target(".png", ".svg", ".pdf"),
        ),
    ] = None,
    time_limit: options.TimeLimit = None,
    waiting: Waiting,
) -> Answer:
    """Search for the parameters with which a family of structures stands and is best.

    With several goals the front is listed: no other structure is better in all of them.

    Exit code 0: some structure stands. 1: none does. 2: bad input. 130: Ctrl-C ended the search;
    the trials so far are the answer.
    """
    build, known = families.shell_family(family) or families.family(family)
    if not vary:
        raise InputError("nothing is varied", where="--vary", remedy="write --vary NAME=LOW:HIGH")
    given = dict(families.setting(text, known) for text in set)
    ranges = [_range(text, known) for text in vary]
    stands_at = margins(margin)
    from drystone import design  # work is imported when there is some

    goals = (*least, *(f"-{goal}" for goal in most)) or ("volume",)
    chosen = design.TuneOptions(trials=trials, seed=seed, margin=stands_at, props=props)
    how: dict[str, Any] = {} if friction is None else {"friction": friction}
    made = partial(build, **given)
    waiting.stage("tune", "searching")
    with waiting.keywords(time_limit, workers) as common:
        found = design.tune(
            made,
            ranges,
            goals=goals,
            how=how,
            store=store,
            options=chosen,
            **common,
        )
    data = {"family": family, "message": found._summary(), **found.to_dict()}
    files = partial(_files, found, made, how, out, png)
    return Answer(data, partial(_show, data), 0 if found.front else 1, (), files)


def _files(
    found: Tuned, build: Any, how: dict[str, Any], out: Path | None, png: Path | None
) -> Files:
    jobs: list[Any] = []
    if out is not None and found.front:
        from drystone import io
        from drystone.design.tuning.tune_goals import model_of

        jobs.append((out, partial(io.write, model_of(build(**found.front[0].values), how))))
    if png is not None:
        from drystone.view import save_front  # as above

        jobs.append((png, partial(save_front, found)))
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
        raise InputError(
            f"{name} has no bounds", where="--vary", remedy="give values separated by commas"
        )
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
