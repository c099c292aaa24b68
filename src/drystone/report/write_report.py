"""Writing of reports: PDF or HTML by the suffix."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from drystone.answer import Answer
from drystone.base.errors import FormatError, InputError
from drystone.base.files import PathLike, write_bytes, write_text
from drystone.base.settings import checked_call
from drystone.base.table import Table
from drystone.base.version import version
from drystone.report.document import Document, Part, Picture, Section
from drystone.report.report_page import html_of
from drystone.report.report_pdf import pdf_of
from drystone.report.report_sections import document_of
from drystone.report.title_block import TitleBlock
from drystone.studies import study_chart, study_map
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
    sections = Section("Charts", tuple(pictures)), Section("Rows", (table,))
    entries = {"studied": table.title, "rows": str(len(table)), "drystone": version()}
    document = Document(f"Study: {table.title}", entries, f"drystone {version()}", sections)
    write_text(path, html_of(document))
