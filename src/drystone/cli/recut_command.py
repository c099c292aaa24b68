"""``drystone recut``: joints changed until every block is placed without help."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from drystone.cli import kinds, options
from drystone.cli.command import command
from drystone.cli.model_input import Finding, Subject
from drystone.cli.offered import OUTPUT, Option
from drystone.cli.told import Told
from drystone.cli.waiting import Waiting

if TYPE_CHECKING:
    from drystone.base.files import Job
    from drystone.design import Buildable


@command(
    "drystone recut arch.json --most 4 --out recut.json",
    "drystone recut arch.json --hands 3 --most 2 --html built.html",
)
def recut(
    *,
    subject: Subject,
    finding: Finding,
    hands: Annotated[int, Option("Hands: one places, others hold (2).", kind=kinds.whole(1))] = 2,
    most: Annotated[
        int, Option("Changes that are tried in all (200).", kind=kinds.whole(1), expert=True)
    ] = 200,
    out: Annotated[
        Path | None, Option("Write the changed model.", OUTPUT, kind=kinds.target(".json"))
    ] = None,
    html: options.Html = None,
    time_limit: options.TimeLimit = None,
    waiting: Waiting,
) -> Told:
    """Change joints until every block is placed alone and stands at once.

    The model is planned. Where a block must be held or propped, one of its joints is turned or made
    a wedge, by 10, 20 or 30 degrees, and the model is planned again. A change is kept when less
    help is needed. See `cut` for a monolith.

    Exit code 0: every block is free. 1: some need help. 2: bad input.
    130: stopped by Ctrl-C, with the changes so far.
    """
    from drystone import design, sequence  # work is imported when there is some

    model = subject.prepared(waiting, finding)
    rules = sequence.PlanOptions(rules=sequence.Rules(hands=hands))
    waiting.stage("recut", "changing joints")
    with waiting.keywords(time_limit) as common:
        found = design.recut_joints(
            model,
            options=design.RecutOptions(most=most, plan=rules),
            **common,
        )
    return Told(found, notes=model.notes, files=partial(_files, found, out, html))


def _files(found: Buildable, out: Path | None, html: Path | None) -> tuple[list[Job], list[str]]:
    from drystone import io
    from drystone.view import save_page

    jobs: list[Job] = []
    if out is not None:
        jobs.append((out, partial(io.write, found.model)))
    if html is None:
        return jobs, []
    if found.plan is None or not found.plan.steps:
        return jobs, [f"not written: {html}"]
    return [*jobs, (html, partial(save_page, found.plan))], []
