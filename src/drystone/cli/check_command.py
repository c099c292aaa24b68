"""``drystone check``: the verdict, what falls, and the props that it needs."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Annotated

from drystone.cli import mend_command, offered
from drystone.cli.command import command
from drystone.cli.model_input import HOW, SHOWN, Subject
from drystone.cli.offered import Analysis, Option
from drystone.cli.told import Told, Written
from drystone.cli.waiting import Waiting

if TYPE_CHECKING:
    from drystone.model import Model
    from drystone.results import Result


@dataclass(frozen=True)
class Checked(Subject):
    """The model; the help shows the strength of its joints too."""

    reading: Annotated[Analysis, HOW(shown=(*SHOWN, "strength"))]


@dataclass(frozen=True)
class CheckFiles(Written):
    """The files of a check; the help shows the report too."""

    report: offered.Report = None


def solve(
    model: Model,
    waiting: Waiting,
    time_limit: float | None,
    robust: bool = False,
    key: str = "solve",
) -> Result:
    """The verdict of ``check``, or what is known when the time limit or Ctrl-C end it.

    With ``robust`` other contact stiffnesses are tried as well. Its time is told under ``key``.
    """
    waiting.end_stage()  # the import is no part of the stage before
    from drystone.stability import CheckOptions, check

    waiting.stage(key, "solving")
    with waiting.keywords(time_limit) as common:
        options = CheckOptions.robust() if robust else CheckOptions()
        result = check(model, options=options, **common)
    waiting.end_stage()
    return result


def safe(result: Result, waiting: Waiting) -> Result:
    """The result with the margins of tilt and strength of what stands."""
    if not result.stable or result.stopped:
        return result
    from drystone.limits.bounds import with_margins

    waiting.stage("margin", "looking for the margin of tilt and strength")
    with waiting.stoppable() as stop:
        return with_margins(result, stop)


def exit_code(result: Result, strict: bool) -> int:
    """0 if stable; with ``strict`` only if it stands for every stiffness and all were tried."""
    robust = not result.sensitive and not result.stopped
    return result.code if robust or not strict else 1


@command(
    "drystone check arch.json --html arch.html",
    "drystone check arch.json --friction 40deg --load 'voussoir-05:1kN'",
)
def check(
    *,
    subject: Checked,
    strict: Annotated[
        bool,
        Option(
            "Try other contact stiffnesses too: exit code 0 only if it stands for all of them.",
            expert=True,
        ),
    ] = False,
    time_limit: offered.TimeLimit = None,
    wanted: CheckFiles,
    waiting: Waiting,
) -> Told:
    """Check whether a model stands, with a proof.

    Exit code 0: it stands. 1: it falls, or it is undecided. 2: bad input. 130: stopped by Ctrl-C,
    with what is known so far.
    """
    model = subject.prepared(waiting)
    wanted.require_through(model.assembly)
    result = safe(solve(model, waiting, time_limit, strict), waiting)
    why = mend_command.short(result, waiting)
    then = "mend" if why else ""
    if result.stable and result.tilt_margin is None:
        from drystone.loads.applied import is_vertical

        still = "limit train" if model.load.fills else "limit shrink"
        then = "limit tilt" if is_vertical(model.load) else still
    return Told(
        result, why, exit_code=exit_code(result, strict), notes=result.model.notes,
        files=partial(wanted.of, result), then=subject.command(then) if then else "",
    )  # fmt: skip
