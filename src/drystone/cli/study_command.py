"""``drystone study``: verdicts or limits over a table of parameters."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from drystone.base.display import shortened
from drystone.base.errors import InputError, counted
from drystone.cli import families, kinds, options
from drystone.cli.command import command
from drystone.cli.offered import OUTPUT, Argument, Option
from drystone.cli.told import Told
from drystone.cli.waiting import Waiting

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from drystone.base.files import Job


@command(
    "drystone study arch --set thickness_ratio=0.12:0.2:3 --limit tilt --csv study.csv",
    "drystone study arch.json --set friction=0.4 --set friction=0.6 --png study.png",
)
def study(
    *,
    subject: Annotated[str, Argument("FAMILY|FILE", "Name of a family of models, or a file.")],
    set: Annotated[
        tuple[str, ...],
        Option(
            "A value of a parameter of the family, or of an option of reading such as friction; "
            "several, or FROM:TO:COUNT, give a row for each of their combinations.",
            metavar="NAME=VALUE",
        ),
    ] = (),
    limit: Annotated[
        str | None,
        Option("A limit as behind 'drystone limit', such as 'tilt --axis y' (a check)."),
    ] = None,
    out: Annotated[
        Path | None,
        Option(
            "Keep each row in a file, with which work that was ended goes on.",
            OUTPUT,
            kind=kinds.target(".jsonl"),
        ),
    ] = None,
    csv: options.Csv = None,
    png: options.Png = None,
    map: Annotated[
        Path | None,
        Option(
            "Draw the first two parameters as a map, .png, .svg or .pdf.",
            OUTPUT,
            kind=kinds.target(".png", ".svg", ".pdf"),
        ),
    ] = None,
    html: options.Html = None,
    workers: options.Workers = 1,
    time_limit: options.TimeLimit = None,
    waiting: Waiting,
) -> Told:
    """Check models, or find a limit, over a table of parameters.

    Exit code 0: every row has an answer. 1: one was refused. 2: bad input.
    """
    from drystone.answer import Role, Sentence, Statement  # work is imported when there is some
    from drystone.base.table import Table
    from drystone.report import save_study
    from drystone.studies import study as studied
    from drystone.studies import study_chart, study_map
    from drystone.studies.limit_words import measures
    from drystone.view import save_chart

    if limit:
        measures(limit)
    build, parameters = _asked(subject, set)
    _require_drawn(parameters, "--png", png, (1, 2))
    _require_drawn(parameters, "--map", map, (2,))
    waiting.stage("solve", "studying")
    with waiting.keywords(time_limit, workers) as common:
        found = studied(build, parameters, limit=limit or "", out=out, **common)
    refused = int((found["verdict"] == "refused").sum())
    jobs: list[Job] = [] if csv is None else [(csv, found.to_csv)]
    if png is not None:
        jobs.append((png, partial(save_chart, study_chart(found))))
    if map is not None:
        jobs.append((map, partial(save_chart, study_map(found))))
    if html is not None:
        jobs.append((html, partial(save_study, found)))
    text = f"{counted(len(found), 'row')}, {refused} refused"
    columns = {**found.columns, "mechanism": [shortened(one, 30) for one in found["mechanism"]]}
    shown = Table(found.title, columns, found.units, found.bounds)
    told = Statement((Sentence(text, Role.BAD if refused else Role.GOOD),), (shown,))
    return Told(told, subject=subject, files=lambda: (jobs, []))


def _require_drawn(
    parameters: Mapping[str, Sequence[Any]], where: str, path: Path | None, counts: Sequence[int]
) -> None:
    """Refuse a picture of as many parameters as it cannot draw, before any work."""
    varied = sum(len(values) > 1 for values in parameters.values()) or len(parameters)
    if path is not None and varied not in counts:
        raise InputError(
            f"draws {' or '.join(map(str, counts))} varying parameters, not {varied}", where=where,
            remedy="give others one value, or leave it out; --csv has every row",
        )  # fmt: skip


def _asked(subject: str, texts: tuple[str, ...]) -> tuple[Any, dict[str, list[Any]]]:
    """What is built, and the values of each parameter."""
    from drystone.base.declared import declared
    from drystone.base.files import is_there
    from drystone.io import read

    reading = declared(read)
    build: Callable[..., Any] | str = subject
    known = {**reading}
    own: families.Parameters = {}
    if not is_there(subject):
        build, own = families.family(subject)
        known = {**reading, **own}
    if not texts:
        raise InputError("is missing", where="--set", remedy="write --set friction=0.4:0.8:5")
    values: dict[str, list[Any]] = {}
    for text in texts:
        name, _, value = text.partition("=")
        each = _range(value) if value.count(":") == 2 else [value]
        for one in each:
            key, given = families.setting(f"{name}={one}", known)
            values.setdefault(key, []).append(given)
    families.refuse_missing(own, values)
    return build, values


def _range(text: str) -> list[str]:
    """The values of ``FROM:TO:COUNT``."""
    ends = text.split(":")
    try:
        first, last, count = float(ends[0]), float(ends[1]), int(ends[2])
    except ValueError as error:
        raise InputError(f"'{text}' is not FROM:TO:COUNT", where="--set") from error
    if count < 2:
        raise InputError(f"{count} values are no range", where="--set", remedy="give two or more")
    values = [first + (last - first) * i / (count - 1) for i in range(count)]
    return [repr(int(one) if one.is_integer() else one) for one in values]
