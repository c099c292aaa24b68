"""Charts on paper, through matplotlib when asked."""

from __future__ import annotations

import html
import re
import textwrap
import warnings
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from drystone.answer.chart import Chart, HeatMap, MarkKind, Marks
from drystone.base.arrays import Floats
from drystone.base.errors import FormatError, InputError, quoted
from drystone.base.files import PathLike, write_bytes
from drystone.base.settings import checked_call
from drystone.view.palette import ROLE_COLOUR

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


_WIDE = 85
"""Letters of a title that fit on a line."""


_WIDTH = 7.0
"""[inches]"""


def require_axes(ax: Any) -> None:
    """Refuse what are no axes of matplotlib; None is none."""
    if not (ax is None or hasattr(ax, "get_window_extent")):
        raise InputError(f"ax is {quoted(ax)}", remedy="give axes of matplotlib")


def _axes(title: str, inside: Axes | None, projection: str = "rectilinear") -> tuple[Figure, Any]:
    """A figure with one pair of axes; or those that are given, and their figure."""
    from matplotlib.figure import Figure  # optional work: plotting is slow to import

    require_axes(inside)
    letters: int = _WIDE
    axes: Any = inside
    if axes is None:
        figure = Figure(figsize=(_WIDTH, 4.6), layout="constrained")
        axes = figure.add_subplot(projection=projection)
    else:
        letters = max(20, int(_WIDE / _WIDTH * axes.get_window_extent().width / axes.figure.dpi))
        if axes.name != projection:
            what = f"this chart needs {projection} axes, and ax is {axes.name}"
            raise InputError(what, remedy=f"make them with projection='{projection}'")
    wrapped = "\n".join(textwrap.fill(line, letters) for line in title.splitlines())
    axes.set_title(wrapped, fontsize=10)
    return axes.figure, axes


_SHAPES = {
    MarkKind.LINE: "-",
    MarkKind.DASHED: "--",
    MarkKind.DISC: "o",
    MarkKind.RING: "o",
    MarkKind.CROSS: "x",
    MarkKind.DIAMOND: "D",
}
_WRITTEN = 100
"""Cells of a map up to which their values are written in them: they are wide enough for them."""
_INK = {"accent": "pressure", "good": "resultant", "bad": "help", "unsure": "missed", "ink": "edge"}


@checked_call
def save_chart(
    chart: Chart | HeatMap,
    path: PathLike | None = None,
    *,
    title: str = "",
    ax: Axes | None = None,
) -> Figure:
    """Draw a chart, such as the ``plot`` of an answer, and write it if there is a path.

    Parameters
    ----------
    chart
    path
        Its suffix says PNG, SVG or PDF. Written to a temporary name beside it and renamed. Left
        out, nothing is written.
    title
        Above the chart; left out, none.
    ax
        Axes of matplotlib to draw in, polar ones of a chart that is; the legend is within them.

    Returns
    -------
    matplotlib.figure.Figure
        It belongs to no window; or that of ``ax``.

    Raises
    ------
    FormatError
        Another suffix, or the file cannot be written.
    InputError
        ``ax`` are no axes, or of another kind.
    """
    if isinstance(chart, HeatMap):
        head = f"{title}\n{chart.title}" if title else chart.title
        return save_plot(path, lambda: _map_figure(chart, head, ax))
    return save_plot(path, lambda: _chart_figure(chart, title, ax))


def chart_png(chart: Chart | HeatMap) -> tuple[bytes, tuple[int, int]]:
    """A chart as the bytes of a PNG, and its width and height [pixels]."""
    figure, made = save_chart(chart), BytesIO()
    figure.savefig(made, format="png", dpi=150.0, metadata=_UNDATED["png"])
    wide, high = figure.get_size_inches()
    return made.getvalue(), (round(150.0 * wide), round(150.0 * high))


def chart_svg(chart: Chart) -> str:
    """A chart as an element of a page, in the colours of its style."""
    from matplotlib import rc_context  # as above
    from matplotlib.figure import Figure

    made = BytesIO()
    with rc_context(
        {
            "svg.fonttype": "none",
            "svg.hashsalt": "drystone",
            "font.size": 9,
            "axes.labelsize": 8,
        }
    ):
        named = len({one.label for one in chart.marks} - {""})
        # as wide as a panel, in which letters are 11 pixels high
        figure = Figure(figsize=(3.0, 2.5 + 0.18 * named), layout="constrained")
        axes = figure.add_subplot(projection="polar" if chart.polar else "rectilinear")
        draw_chart(axes, chart)
        if named:
            handles = axes.get_legend_handles_labels()
            figure.legend(*handles, loc="outside lower left", frameon=False)
        figure.savefig(made, format="svg", transparent=True)
    text = made.getvalue().decode()
    box, text = re.findall(r"(?s)<svg.*?(viewBox=.*?) xmlns.*?</metadata>.*?</defs>(.*)", text)[0]
    for ink, role in {**_INK, "quiet": "black"}.items():
        text = text.replace(ROLE_COLOUR["light"].get(role, "#000000"), f"var(--{ink})")
    name = html.escape(f"{chart.title}: {chart.up} by {chart.across}")
    return f'<svg {box} width="100%" role="img" fill="var(--quiet)" aria-label="{name}">{text}'


def _map_figure(chart: HeatMap, title: str, inside: Axes | None) -> Figure:
    """Cells that are darker where values are larger, with their values where there is room."""
    figure, axes = _axes(title, inside)
    axes.set(xlabel=chart.across, ylabel=chart.up)
    drawn = axes.imshow(chart.values, origin="lower", aspect="auto", cmap="YlGnBu")
    figure.colorbar(drawn, ax=axes, label=chart.quantity)
    axes.set_facecolor("white")
    for axis, names in ((axes.xaxis, chart.columns), (axes.yaxis, chart.rows)):
        every = range(0, len(names), -(-len(names) // 12))
        axis.set_ticks([*every], [names[i] for i in every])
    if chart.values.size > _WRITTEN:
        return figure
    for (row, column), value in np.ndenumerate(chart.values):
        dark = np.isfinite(value) and drawn.norm(value) > 0.55
        told = f"{value:.4g}" if np.isfinite(value) else "-"
        ink = "white" if dark else "black"
        axes.text(column, row, told, ha="center", va="center", fontsize=9, color=ink)
    return figure


def _chart_figure(chart: Chart, title: str, inside: Axes | None) -> Figure:
    head = "\n".join(one for one in (title, chart.caption) if one)
    figure, axes = _axes(head, inside, "polar" if chart.polar else "rectilinear")
    draw_chart(axes, chart)
    if any(one.label for one in chart.marks):
        handles = axes.get_legend_handles_labels()
        if inside is not None:
            inside.legend(*handles, frameon=False, fontsize=9)
            return figure
        figure.legend(*handles, loc="outside lower center", ncol=3, frameon=False, fontsize=9)
    return figure


def draw_chart(axes: Any, chart: Chart) -> None:
    """A chart in given axes of matplotlib, without a title and a legend."""
    named = zip((chart.across, chart.up), chart.units, strict=True)
    across, up = (f"{text} [{unit}]" if unit else text for text, unit in named)
    axes.set(xlabel=across, ylabel=up)
    axes.grid(alpha=0.25)
    for one in chart.marks:
        _draw_marks(axes, one, np.deg2rad(one.x) if chart.polar else one.x)
    for at, text in chart.lines:
        axes.axvline(at, color=ROLE_COLOUR["light"]["edge"], linestyle=":", linewidth=1.2)
        axes.annotate(text, (at, 1.0), xycoords=("data", "axes fraction"), xytext=(-3, -3),
                      textcoords="offset points", fontsize=9, ha="right", va="top",
                      rotation=90)  # fmt: skip
    if chart.polar or chart.top is not None:
        axes.set_ylim(0.0, chart.top)
    if chart.polar:
        axes.set_ylabel("")
        axes.set_rlabel_position(67.5)


def _draw_marks(axes: Any, marks: Marks, x: Floats) -> None:
    """Marks at places x (p,) across."""
    ink = ROLE_COLOUR["light"][_INK[marks.ink]]
    if marks.kind is MarkKind.AREA:
        low = 0.0 if marks.low is None else marks.low
        axes.fill_between(x, marks.y, low, color=ink, alpha=0.15)
        return
    face = "none" if marks.kind is MarkKind.RING else ink
    width = 4.0 if marks.kind is MarkKind.DASHED else 1.8  # is seen below another line
    shape = _SHAPES[marks.kind]
    axes.plot(x, marks.y, shape, color=ink, label=marks.label or None, markerfacecolor=face,
              linewidth=width, markersize=6, clip_on="-" in shape)  # fmt: skip


_UNDATED = {"png": {}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}
"""What says when a file was made is left out by kind: the same input gives the same bytes."""


def save_plot(
    path: PathLike | None, draw: Callable[[], Figure], dpi: float = 150.0, what: str = "plot"
) -> Figure:
    """The figure that ``draw`` makes, written if there is a path.

    The suffix is checked first. The file is written to a temporary name and renamed.

    Raises
    ------
    FormatError
        Another suffix, or the file cannot be written.
    """
    if path is None:
        return draw()
    kind = Path(path).suffix.lower().lstrip(".")
    if kind not in _UNDATED:
        as_what = f"as '.{kind}'" if kind else "without a suffix"
        raise FormatError(
            f"a {what} cannot be written {as_what}",
            where=str(path),
            remedy="end the name in .png, .svg or .pdf",
        )
    from matplotlib import rc_context  # slow to import

    drawing = draw()

    made = BytesIO()  # a PDF on a full disk would end with an error of zlib
    with warnings.catch_warnings(), rc_context({"svg.hashsalt": "drystone"}):
        # Characters that the font does not have are drawn as boxes; the figure is still valid.
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        drawing.savefig(made, format=kind, dpi=dpi, metadata=_UNDATED[kind])
    write_bytes(path, made.getvalue())
    return drawing
