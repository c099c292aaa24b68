"""``drystone report``: a calculation report on paper."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from drystone.cli import kinds, options
from drystone.cli.command import command
from drystone.cli.model_input import Subject
from drystone.cli.offered import OUTPUT, Of, Option
from drystone.cli.told import Told
from drystone.cli.waiting import Waiting

if TYPE_CHECKING:
    from drystone.base.files import Job
    from drystone.report import TitleBlock


@command(
    "drystone report arch.json --out report.pdf --project 'Old bridge'",
    "drystone report arch.json --limit 'tilt --axis y' --author 'N. N.' --out report.html",
)
def report(
    *,
    subject: Subject,
    out: Annotated[
        Path, Option("Write the report, .pdf or .html.", OUTPUT, kind=kinds.target(".pdf", ".html"))
    ],
    limit: Annotated[
        tuple[str, ...],
        Option(
            "A limit as behind 'drystone limit', such as 'tilt --axis y'; can be given several "
            "times; none for none (those of friction and of the size of joints, of what stands)."
        ),
    ] = (),
    cases: Annotated[
        Path | None,
        Option("TOML file of combinations, as for 'drystone combine'.", kind=kinds.FILE),
    ] = None,
    about: Annotated[
        TitleBlock,
        Of("drystone.report.TitleBlock", shown=("project", "author"), group=OUTPUT),
    ],
    title_block: options.TitleBlock = None,
    time_limit: options.TimeLimit = None,
    waiting: Waiting,
) -> Told:
    """Write a calculation report: input, loads, method, verdict, proof and hand checks.

    Exit code 0: all answers are good. 1: it falls, is undecided, or a train is not carried. 2: bad
    input.
    """
    from drystone import report as reports  # work is imported when there is some

    if out.suffix.lower() == ".pdf":
        reports.require_pdf()
    if title_block is not None:
        about = about.over(reports.TitleBlock.read(title_block))
    model = subject.prepared(waiting)
    waiting.stage("solve", "solving")
    asked = None if not limit else [one for one in limit if one != "none"]
    with waiting.keywords(time_limit) as common:
        common.pop("executor")
        answers = reports.assess(model, limits=asked, cases=cases, **common)
    first, *others = answers
    jobs: list[Job] = [(out, partial(reports.write_report, answers, about=about))]
    return Told(
        first, {f"answer_{i}": one for i, one in enumerate(others, 2)},
        exit_code=max(one.code for one in answers), notes=model.notes, files=lambda: (jobs, []),
    )  # fmt: skip
