"""A document as a PDF of A4 pages, whose text can be searched, by reportlab."""

from __future__ import annotations

import io
from collections.abc import Mapping
from html import escape
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from drystone.base.display import NAME, shortened
from drystone.base.errors import require
from drystone.base.files import utf8
from drystone.base.table import Table
from drystone.report.document import Document, Heading, Part, Picture

_MARGIN = 51.0
"""[points], 18 mm."""
_WIDTH, _HEIGHT = 595.28, 841.89
"""[points], of A4."""
_ROOM = 90.0
"""[points], that a heading and the first rows of a table need."""


def pdf_of(document: Document) -> bytes:
    """The pages; the same document gives the same bytes.

    Raises
    ------
    MissingDependency
        reportlab is not installed.
    """
    require_pdf()
    from reportlab import rl_config
    from reportlab.platypus import CondPageBreak, SimpleDocTemplate

    made = io.BytesIO()
    template = SimpleDocTemplate(
        made, pagesize=(_WIDTH, _HEIGHT), leftMargin=_MARGIN, rightMargin=_MARGIN,
        topMargin=_MARGIN, bottomMargin=_MARGIN, title=_plain(document.title),
        author=_plain(document.entries.get("Author", "")), creator=document.foot, invariant=1,
    )  # fmt: skip
    paper = _Paper()
    story: list[Any] = [
        paper.text(shortened(document.title, 4 * NAME), "title"),
        paper.entries(document.entries),
    ]
    for section in document.sections:
        story += [CondPageBreak(_ROOM), paper.text(section.title, "section")]
        story += [one for part in section.parts for one in paper.part(part)]
    for one, after in pairwise(story):
        if isinstance(after, CondPageBreak):
            one.keepWithNext = 0  # a table is broken over pages, and not moved to the next one
    # bytes, not letters for them: a sixth smaller, in two thirds of the time
    before, rl_config.useA85 = rl_config.useA85, 0
    try:
        template.build(story, canvasmaker=_numbered(document))
    finally:
        rl_config.useA85 = before
    return made.getvalue()


def _plain(text: str) -> str:
    """A text without halves of letters."""
    return utf8(text).decode("utf-8")


def require_pdf() -> None:
    """Refuse where reportlab is not installed.

    Raises
    ------
    MissingDependency
    """
    require("reportlab", "report", "a PDF report")


def _numbered(document: Document) -> Any:
    """A canvas whose pages know how many there are."""
    from reportlab.pdfgen.canvas import Canvas  # as above

    class Numbered(Canvas):  # type: ignore[misc]  # it has no types
        def __init__(self, *given: Any, **named: Any) -> None:
            super().__init__(*given, **named)
            self._pages: list[dict[str, Any]] = []

        def showPage(self) -> None:  # noqa: N802  # the name of reportlab
            self._pages.append(dict(self.__dict__))
            self._startPage()

        def save(self) -> None:
            for number, page in enumerate(self._pages, 1):
                self.__dict__.update(page)
                self.setFont("DejaVu", 7.5)
                self.drawString(_MARGIN, 28.0, shortened(_plain(document.title), 70))
                foot = f"{document.foot}   {number} / {len(self._pages)}"
                self.drawRightString(_WIDTH - _MARGIN, 28.0, foot)
                super().showPage()
            super().save()

    return Numbered


class _Paper:
    """Fonts and styles, and the parts of a document in them."""

    def __init__(self) -> None:
        import matplotlib
        from reportlab.lib.styles import ParagraphStyle
        from reportlab.pdfbase import pdfmetrics
        from reportlab.pdfbase.ttfonts import TTFont

        fonts = Path(matplotlib.get_data_path()) / "fonts" / "ttf"
        for name, file in (("DejaVu", "DejaVuSans"), ("DejaVuBold", "DejaVuSans-Bold")):
            pdfmetrics.registerFont(TTFont(name, fonts / f"{file}.ttf"))
        plain = ParagraphStyle("text", fontName="DejaVu", fontSize=8.5, leading=11.5, spaceAfter=4)
        bold = {"parent": plain, "fontName": "DejaVuBold", "keepWithNext": 1}
        self.styles = {
            "text": plain,
            "title": ParagraphStyle("title", fontSize=15, leading=20, spaceAfter=8, **bold),
            "section": ParagraphStyle(
                "section", fontSize=11, leading=15, spaceBefore=12, spaceAfter=5, **bold
            ),
            "heading": ParagraphStyle("heading", spaceBefore=7, spaceAfter=3, **bold),
            "cell": ParagraphStyle("cell", plain, fontSize=7, leading=8.6, spaceAfter=0),
            "head": ParagraphStyle("head", plain, fontName="DejaVuBold", fontSize=7, leading=8.6),
        }

    def text(self, text: str, style: str = "text") -> Any:
        """A paragraph."""
        from reportlab.platypus import Paragraph

        return Paragraph(escape(_plain(text)), self.styles[style])

    def part(self, part: Part) -> list[Any]:
        """What is printed of a part."""
        from reportlab.platypus import CondPageBreak, Spacer

        match part:
            case str():
                return [self.text(part)]
            case Heading():
                room = CondPageBreak(1.5 * _ROOM)  # with the head of a table below it
                return [room, self.text(part.text, "heading")]
            case Table():
                return self.table(part)
            case Picture():
                return [_figure(part, self.text(part.caption))]
        return [self.entries(part), Spacer(1, 6)]

    def entries(self, entries: Mapping[str, str]) -> Any:
        """Names and texts side by side."""
        rows = [
            [self.text(name, "head"), self.text(shortened(told, 4000), "cell")]
            for name, told in entries.items()  # what is longer than a page cannot be set
        ]
        return self._grid(rows, [110.0, _WIDTH - 2.0 * _MARGIN - 110.0])

    def table(self, table: Table) -> list[Any]:
        """A table under its title; of long columns the cells are broken into lines."""
        from reportlab.pdfbase.pdfmetrics import stringWidth
        from reportlab.platypus import CondPageBreak, Spacer

        heads, cells = table.printed()
        natural = np.array([
            max(
                stringWidth(heads[i], "DejaVuBold", 7),
                *(stringWidth(row[i], "DejaVu", 7) for row in cells),
            )
            for i in range(len(heads))
        ]) + 9.0  # fmt: skip
        widths = _fitted(natural, _WIDTH - 2.0 * _MARGIN)
        made = [[self.text(one, "head") for one in heads]]
        made += [[self.text(cell, "cell") for cell in row] for row in cells]
        title = self.text(table.title.capitalize(), "heading")
        title.keepWithNext = 0
        told = [CondPageBreak(_ROOM), title, self._grid(made, widths, head=1)]
        return [*told, Spacer(1, 6)]

    def _grid(self, rows: list[list[Any]], widths: Any, head: int = 0) -> Any:
        from reportlab.lib.colors import black, grey
        from reportlab.platypus import Table as Grid
        from reportlab.platypus import TableStyle

        style = [
            ("VALIGN", (0, 0), (-1, -1), "TOP"),
            ("LINEBELOW", (0, 0), (-1, -1), 0.25, grey),
            ("TOPPADDING", (0, 0), (-1, -1), 1.5),
            ("BOTTOMPADDING", (0, 0), (-1, -1), 2.0),
            ("LEFTPADDING", (0, 0), (-1, -1), 3.0),
            ("RIGHTPADDING", (0, 0), (-1, -1), 3.0),
        ]
        if head:
            style.append(("LINEBELOW", (0, 0), (-1, 0), 0.8, black))
        return Grid(rows, list(widths), repeatRows=head, hAlign="LEFT", style=TableStyle(style))


def _figure(picture: Picture, caption: Any) -> Any:
    """A picture over its caption, as small as 0.9 of its size if it fits at the foot of a page.

    Its letters of 8 points then have 7.
    """
    from reportlab.platypus import Flowable, Image

    class Figure(Flowable):  # type: ignore[misc]  # it has no types
        def wrap(self, width: float, height: float) -> tuple[float, float]:
            self.below = caption.wrap(width, height)[1] + caption.getSpaceAfter()
            full = width * picture.size[1] / picture.size[0]
            self.high = full * min(max((height - self.below) / full, 0.9), 1.0)
            self.wide = self.high * picture.size[0] / picture.size[1]
            self.margin = 0.5 * (width - self.wide)
            return width, self.high + self.below

        def draw(self) -> None:
            image = Image(io.BytesIO(picture.png), self.wide, self.high)
            image.drawOn(self.canv, self.margin, self.below)
            caption.drawOn(self.canv, 0.0, caption.getSpaceAfter())

    return Figure()


def _fitted(natural: Any, width: float) -> Any:
    """Widths of columns that fit: wide columns get equally less."""
    low, high = 0.0, float(natural.max())
    for _ in range(40):
        cap = 0.5 * (low + high)
        low, high = (cap, high) if np.minimum(natural, cap).sum() < width else (low, cap)
    return natural if natural.sum() <= width else np.minimum(natural, low)
