"""``drystone study``: verdicts or limits over a table of parameters."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from drystone.base.display import shortened
from drystone.base.errors import InputError, counted
from drystone.cli import families, kinds, offered
from drystone.cli.command import command
from drystone.cli.model_input import Subject
from drystone.cli.offered import OUTPUT, Argument, Of, Option, writes
from drystone.cli.told import Files, Told
from drystone.cli.waiting import Waiting

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from drystone.report import TitleBlock


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
        writes("Keep each row in a file, with which work that was ended goes on.", ".jsonl"),
    ] = None,
    csv: offered.Csv = None,
    png: offered.Png = None,
    map: Annotated[
        Path | None,
        writes(
            "Draw the first two parameters as a map, .png, .svg or .pdf.", ".png", ".svg", ".pdf"
        ),
    ] = None,
    html: offered.Html = None,
    workers: offered.Workers = 1,
    time_limit: offered.TimeLimit = None,
    waiting: Waiting,
) -> Told:
    """Check models, or find a limit, over a table of parameters.

    Exit code 0: every row has an answer. 1: one was refused. 2: bad input.
    """
    from drystone.answer import Role, Sentence, Statement  # work is imported when there is some
    from drystone.base.table import Table
    from drystone.report import save_study
    from drystone.stability.doubts import friction_doubts
    from drystone.studies import study as studied
    from drystone.studies import study_chart, study_map, study_told
    from drystone.studies.limit_words import measures
    from drystone.studies.study import study_fixed
    from drystone.view import save_chart

    if limit:
        measures(limit)
    build, parameters = _asked(subject, set)
    _require_drawn(parameters, "--png", png, (1, 2))
    _require_drawn(parameters, "--map", map, (2,))
    for friction in parameters.get("friction", ()):
        for doubt in friction_doubts(friction):
            waiting.warn(f"{doubt.text} Write --set friction={doubt.how['friction']}")
    waiting.stage("solve", "studying")
    waiting.checkpoint = out
    with waiting.keywords(time_limit, workers) as common:
        found = studied(build, parameters, limit=limit or "", out=out, **common)
    refused = int((found["verdict"] == "refused").sum())

    def files() -> Files:
        varied, title = _varied(parameters), _titled(subject, build, parameters)
        return [
            (csv, found.to_csv),
            (png, lambda path: save_chart(study_chart(found, *varied), path, title=title)),
            (map, lambda path: save_chart(study_map(found, *varied), path, title=title)),
            (html, partial(save_study, found)),
        ], []

    text = f"{counted(len(found), 'row')}, {refused} refused, {study_fixed(found)}"
    text = text.removesuffix(", ")
    columns = {**found.columns, "mechanism": [shortened(one, 30) for one in found["mechanism"]]}
    shown = study_told(Table(found.title, columns, found.units, found.bounds, found.hidden))
    told = Statement((Sentence(text, Role.BAD if refused else Role.GOOD),), (shown,))
    return Told(told, subject=subject, files=files)


def _titled(subject: str, build: Any, parameters: Mapping[str, Sequence[Any]]) -> str:
    """What was studied; a family with the parameters that keep their default."""
    from drystone.base.declared import declared

    kept = [] if isinstance(build, str) else [
        f"{name.replace('_', ' ')} {one.default} {one.unit}".strip()
        for name, one in declared(build).items() if name not in parameters
    ]  # fmt: skip
    return f"{subject}: {', '.join(kept)}" if kept else subject


def _require_drawn(
    parameters: Mapping[str, Sequence[Any]], where: str, path: Path | None, counts: Sequence[int]
) -> None:
    """Refuse a picture of as many parameters as it cannot draw, before any work."""
    varied = len(_varied(parameters))
    if path is not None and varied not in counts:
        raise InputError(
            f"draws {' or '.join(map(str, counts))} varying parameters, not {varied}", where=where,
            remedy="give others one value, or leave it out; --csv has every row",
        )  # fmt: skip
    words = [one for one in _varied(parameters)[:1] if isinstance(parameters[one][0], str)]
    if path is not None and where == "--png" and words:
        remedy = "name a parameter with numbers first, or leave it out; --csv has every row"
        raise InputError(f"'{words[0]}' has no numbers to draw along", where=where, remedy=remedy)


def _varied(parameters: Mapping[str, Sequence[Any]]) -> list[str]:
    """The parameters with several values; all of them where none has."""
    return [one for one, values in parameters.items() if len(values) > 1] or [*parameters]


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
        one_of = known.get(name.replace("-", "_"))  # a tie has colons too
        words = one_of is not None and not {int, float} & {*one_of.kinds}
        each = _range(value) if value.count(":") == 2 and not words else [value]
        for one in each:
            key, given = families.setting(f"{name}={one}", known)
            values.setdefault(key, []).append(given)
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
    return [f"{one:.12g}" for one in values]


@command(
    "drystone report arch.json --out report.pdf --project 'Old bridge'",
    "drystone report arch.json --limit 'tilt --axis y' --author 'N. N.' --out report.html",
)
def report(
    *,
    subject: Subject,
    out: Annotated[Path, writes("Write the report, .pdf or .html.", ".pdf", ".html")],
    limit: Annotated[
        tuple[str, ...],
        Option(
            "A limit as behind 'drystone limit', such as 'tilt --axis y'; can be given several "
            "times (those of friction, size of joints and strength follow; 'none' leaves them out)."
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
    title_block: offered.TitleBlock = None,
    time_limit: offered.TimeLimit = None,
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
    asked = [one for one in limit if one != "none"]
    with waiting.keywords(time_limit) as common:
        common.pop("executor")
        answers = reports.assess(
            model, limits=asked, sensitivity="none" not in limit, cases=cases, **common
        )
    first, *others = answers
    write = partial(reports.write_report, answers, about=about)
    return Told(
        first, {f"answer_{i}": one for i, one in enumerate(others, 2)},
        exit_code=max(one.code for one in answers), notes=model.notes,
        files=lambda: ([(out, write)], []),
    )  # fmt: skip
