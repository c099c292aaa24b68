"""Writing of reports as PDF or HTML by the suffix, and the answers of an assessment."""

from __future__ import annotations

import base64
import html
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, Unpack

import numpy as np

from drystone.answer import Answer
from drystone.base.errors import FormatError, InputError
from drystone.base.files import PathLike, shipped, write_bytes, write_text
from drystone.base.settings import Clock, Progress, Stop, checked_call
from drystone.base.table import Table
from drystone.base.version import version
from drystone.design import DiagnosisOptions, diagnose
from drystone.io.opening import Given, How, supported_model
from drystone.limits.bounds import with_margins
from drystone.model import Model
from drystone.report.document import Document, Heading, Part, Picture, Section, TitleBlock
from drystone.report.report_pdf import pdf_of
from drystone.report.report_sections import document_of, worst_told
from drystone.report.sketches import numbered_picture
from drystone.results import Result
from drystone.sequence import Plan
from drystone.stability import CheckOptions, check
from drystone.studies import combinations, read_combinations, study_chart, study_map, study_told
from drystone.studies.limit_words import limit_of_words
from drystone.view.plots import chart_png


@checked_call
def write_report(
    answers: Answer | Sequence[Answer], path: PathLike, *, about: TitleBlock | None = None
) -> None:
    """Write a calculation report on answers about one model.

    The same answers give the same bytes, but for the date.

    Parameters
    ----------
    answers
        One, or several; the first one has the verdict. See :func:`drystone.report.assess`.
    path
        Its suffix says PDF (A4) or HTML. Written to a temporary name beside it and renamed.
    about
        The title block.

    Raises
    ------
    InputError
        There is no answer.
    FormatError
        Another suffix, or the file cannot be written.
    MissingDependency
        PDF needs the extra ``report``.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import drystone
    >>> from drystone.models import tower
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "tower.html"
    >>> write_report(drystone.check(tower(2)), path, about=TitleBlock(project="Tower"))
    >>> "Stability of Tower" in path.read_text(encoding="utf-8")
    True
    """
    several = [answers] if isinstance(answers, Answer) else list(answers)
    if not several:
        raise InputError("there is nothing to report", remedy="give an answer")
    kind = Path(path).suffix.lower()
    if kind not in (".pdf", ".html", ".htm"):
        raise FormatError(
            "a report is PDF or HTML", where=str(path), remedy="end the name in .pdf or .html"
        )
    document = document_of(several, TitleBlock.of(about))
    if kind == ".pdf":
        write_bytes(path, pdf_of(document))
    else:
        write_text(path, html_of(document))


def save_study(table: Table, path: PathLike) -> None:
    """Write a page on a study: its chart, its map where it has two parameters, and its table.

    Parameters
    ----------
    table
        Of :func:`drystone.studies.study`.
    path
        HTML. Written to a temporary name beside it and renamed.
    """
    pictures: list[Part] = []
    for draw in (study_chart, study_map):
        with suppress(InputError):  # it has not the parameters, or not the numbers, for it
            chart = draw(table)
            pictures.append(
                Picture(*chart_png(chart), f"{table.title}: {chart.across}, {chart.up}")
            )
    sections = Section("Charts", tuple(pictures)), Section("Rows", (study_told(table),))
    entries = {"studied": table.title, "rows": str(len(table)), "drystone": version()}
    _save(path, f"Study: {table.title}", entries, *sections)


def save_joints(result: Result, path: PathLike, *, worst: int = 12) -> None:
    """Write a page on the joints nearest to sliding or to a hinge: a table, and a plan of each.

    Parameters
    ----------
    result
        With forces.
    path
        HTML. Written to a temporary name beside it and renamed.
    worst
        How many joints are shown.

    Raises
    ------
    InputError
        The result has no forces, or the file cannot be written.
    """
    entries = {"verdict": result.verdict.value, "found": result.message, "load": result.load.name}
    joints = Section("Joints", tuple(worst_told(result, worst)))
    _save(path, "Joints that work hardest", entries, joints)


def save_instructions(plan: Plan, path: PathLike) -> None:
    """Write a page for printing: the blocks with the steps that place them, and a table.

    Parameters
    ----------
    plan
    path
        HTML. Written to a temporary name beside it and renamed.
    """
    table = plan.table()
    moved = [motion for step in plan.steps for motion in step.motion]
    columns = {**table.columns, "moved_along": np.array(moved).reshape(-1, 3)}
    told = Table(table.title, columns, table.units, hidden=table.hidden)
    entries = {"plan": plan.told, "found": plan.message}
    _save(path, "Assembly plan", entries, Section("Steps", (numbered_picture(plan), told)))


def _save(path: PathLike, title: str, entries: Mapping[str, str], *sections: Section) -> None:
    """Write a page that is no calculation report."""
    write_text(path, html_of(Document(title, entries, f"drystone {version()}", sections)))


def html_of(document: Document) -> str:
    """The page as text; it asks nothing of the network."""
    title = html.escape(document.title)
    style = shipped("report/report.css")
    parts = [f"<h1>{title}</h1>", _part(document.entries)]
    for section in document.sections:
        parts.append(f"<h2>{html.escape(section.title)}</h2>")
        parts += [_part(one) for one in section.parts]
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{title}</title><style>\n{style}</style></head><body>"
        f"{''.join(parts)}<p><small>{html.escape(document.foot)}</small></p></body></html>\n"
    )


def _part(part: Part) -> str:
    match part:
        case str():
            return f"<p>{html.escape(part)}</p>"
        case Heading():
            return f"<h3>{html.escape(part.text)}</h3>"
        case Table():
            return f'<div class="scroll">{part.to_html()}</div>'
        case Picture():
            data = base64.b64encode(part.png).decode("ascii")
            told = html.escape(part.caption)
            return (
                f'<figure><img alt="{told}" src="data:image/png;base64,{data}">'
                f"<figcaption>{told}</figcaption></figure>"
            )
    rows = (
        f"<tr><th>{html.escape(name)}</th><td>{html.escape(text)}</td></tr>"
        for name, text in part.items()
    )
    return f"<table>{''.join(rows)}</table>"


def _varied(model: Model) -> tuple[str, ...]:
    """Limits of what stands: to which share friction, joints, and strength may shrink."""
    strength = () if model.contacts.capacity is None else ("strength",)
    return "friction --scaled", "shrink", *strength


@checked_call
def assess(
    given: Given,
    *,
    limits: Sequence[str] = (),
    sensitivity: bool = True,
    cases: PathLike | None = None,
    options: CheckOptions | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
    time_limit_s: float = float("inf"),
    **how: Unpack[How],
) -> list[Answer]:
    """The verdict on a model, why it falls if it does, and limits.

    Parameters
    ----------
    given
        A model; or an assembly or a file that ``how`` turns into one.
    limits
        Each as behind ``drystone limit``, such as ``tilt --axis y`` or ``load keystone:1kN``.
    sensitivity
        Whether those of friction, size of joints and strength follow, of what stands.
    cases
        File of combinations; see :func:`drystone.studies.combinations`.
    options
        Of the check.
    progress
        Called as ``progress(stage, done, total)``, with 0 <= done <= total.
    stop
        Called often; True ends the calculation with the results so far.
    time_limit_s
        Time [s] after which the calculation ends with the results so far.

    Raises
    ------
    InputError
        There is no such limit, or it takes no such option.

    Examples
    --------
    >>> from drystone.models import tower
    >>> [one.title for one in assess(tower(2), limits=["tilt"], sensitivity=False, friction=0.6)]
    ['Stands', 'Stands up to 30.93 degrees about x']
    """
    model = supported_model(given, **how)
    varied = _varied(model) if sensitivity else ()
    asked, more = ([limit_of_words(words, model) for words in some] for some in (limits, varied))
    if cases is not None:
        read_combinations(cases, model)  # refused before the work
    clock = Clock(time_limit_s, stop)
    late: dict[str, Any] = {"progress": progress, "stop": clock.late}
    result = check(model, options=options, **late)
    answers: list[Answer] = [with_margins(result, clock.late)]
    if result.falls:
        brief = DiagnosisOptions.brief()
        answers.append(diagnose(result.model, result=result, options=brief, stop=clock.late))
    answers += [one(model, late) for one in asked]
    if result.stable:
        answers += [one(model, late) for one in more]
    if cases is not None:
        answers.append(combinations(model, cases, **late))
    return answers
