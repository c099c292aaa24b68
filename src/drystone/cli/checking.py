"""The verdict of ``check``, and what it means for an exit code."""

from __future__ import annotations

from typing import TYPE_CHECKING

from drystone.cli.waiting import Waiting

if TYPE_CHECKING:
    from drystone.model import Model
    from drystone.results import Result


def solve(model: Model, waiting: Waiting, time_limit: float | None, robust: bool = False) -> Result:
    """The verdict of ``check``, or what is known when the time limit or Ctrl-C end it.

    With ``robust`` other contact stiffnesses are tried as well.
    """
    waiting.end_stage()  # the import is no part of the stage before
    from drystone.stability import CheckOptions, check

    waiting.stage("solve", "solving")
    with waiting.keywords(time_limit) as common:
        options = CheckOptions.robust() if robust else None
        result = check(model, options=options, **common)
    waiting.end_stage()
    return result


def exit_code(result: Result, strict: bool) -> int:
    """0 if stable; with ``strict`` only if it stands for every stiffness and all were tried."""
    robust = not result.sensitive and not result.stopped
    return result.code if robust or not strict else 1
