"""A self-contained HTML page, with charts as SVG: it opens from disk and needs no network."""

from __future__ import annotations

import html
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from os import PathLike

import numpy as np

from drystone.answer.chart import Chart, MarkKind, Marks
from drystone.answer.scene import Scene
from drystone.base import units
from drystone.base.arrays import Floats
from drystone.base.files import shipped, write_text
from drystone.base.settings import checked_call
from drystone.contacts import Contacts
from drystone.results import Result
from drystone.view.encode import encode, to_text
from drystone.view.section import cut_at
from drystone.view.subjects import Subject, scene_of

WIDTH, HEIGHT = 280.0, 174.0
RIGHT, TOP, BOTTOM = 12.0, 34.0, 32.0
"""Size [px] of a chart, and its margins; the left one is as wide as the values in it."""
_REACH = 92.0
"""Radius [px] of a polar chart."""


def panel(chart: Chart) -> str:
    """HTML of a chart with its title and caption."""
    drawn = ""
    if chart.marks:
        height = 2 * _REACH + 56.0 if chart.polar else HEIGHT
        name = html.escape(f"{chart.title}: {chart.up} by {chart.across}")
        body = "".join(_polar_axes() if chart.polar else _axes(chart))
        body += "".join(_drawn(chart, one) for one in chart.marks)
        drawn = (
            f'<svg viewBox="0 0 {WIDTH:g} {height:g}" width="100%" role="img" '
            f'fill="var(--quiet)" font-size="11" aria-label="{name}">{body}</svg>{_key(chart)}'
        )
    told = "".join(f"<p>{html.escape(one)}</p>" for one in chart.caption.split("\n") if one)
    told = re.sub(r"--[a-z]+ \d[\d,]*\b", r"<code>\g<0></code>", told)  # an option is not broken
    head = f"<legend>{html.escape(chart.title)}</legend>"
    return f'    <fieldset class="chart">{head}{drawn}{told}</fieldset>'


def _place(chart: Chart, x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Pixels of points."""
    if chart.polar:
        angle, radius = np.deg2rad(x), _REACH * np.nan_to_num(y) / (chart.rise[1] or 1.0)
        return 0.5 * WIDTH + radius * np.cos(angle), _REACH + 28.0 - radius * np.sin(angle)
    (left, right), (low, high) = chart.span, chart.rise
    across = (x - left) / (right - left) if right > left else np.full(np.shape(x), 0.5)
    up = (np.nan_to_num(y) - low) / ((high - low) or 1.0)
    edge = _left(chart)
    return edge + across * (WIDTH - edge - RIGHT), HEIGHT - BOTTOM - up * (HEIGHT - TOP - BOTTOM)


def _left(chart: Chart) -> float:
    """[px], of the axis up."""
    return max(
        44.0, *(9.0 + 6.5 * len(_told(one, chart.units[1], chart.rise)) for one in chart.rise)
    )


def _drawn(chart: Chart, marks: Marks) -> str:
    """Marks in a chart."""
    x, y = _place(chart, marks.x, marks.y)
    if marks.kind is MarkKind.AREA and marks.low is not None:
        back = _place(chart, marks.x, marks.low)
        x, y = (np.append(one, other[::-1]) for one, other in zip((x, y), back, strict=True))
    return _shapes(marks, x, y)


def _shapes(marks: Marks, x: Floats, y: Floats) -> str:
    """A line through points, or a mark at each [px]."""
    ink, kind = f"var(--{marks.ink})", marks.kind
    if kind in (MarkKind.LINE, MarkKind.DASHED, MarkKind.AREA):
        dashes = ' stroke-dasharray="4 3"' if kind is MarkKind.DASHED else ""
        look = f'fill="none" stroke="{ink}" stroke-width="2"{dashes}'
        if kind is MarkKind.AREA:
            look = f'fill="{ink}" fill-opacity="0.15" stroke="none"'
        told = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))
        return f'<polyline {look} points="{told}"/>'
    look = f'fill="{"none" if kind is MarkKind.RING else ink}" stroke="{ink}"'
    shape = '<circle cx="{:.1f}" cy="{:.1f}" r="3.5" ' + look + "/>"
    if kind is MarkKind.CROSS:
        shape = f'<path d="M{{:.1f}} {{:.1f}}m-3.5 -3.5l7 7m0 -7l-7 7" stroke="{ink}" '
        shape += 'stroke-width="1.5"/>'
    if kind is MarkKind.DIAMOND:
        shape = f'<path d="M{{:.1f}} {{:.1f}}m-4.5 0l4.5 -4.5l4.5 4.5l-4.5 4.5z" {look}/>'
    return "".join(shape.format(a, b) for a, b in zip(x, y, strict=True))


def _key(chart: Chart) -> str:
    """What the marks are, where they say it."""
    wide = {MarkKind.LINE: [1.0, 17.0], MarkKind.DASHED: [1.0, 17.0]}
    wide[MarkKind.AREA] = [1.0, 17.0, 17.0, 1.0]
    rows = []
    for text, marks in {one.label: one for one in chart.marks if one.label}.items():
        x = np.array(wide.get(marks.kind, [9.0]))
        y = np.array([1.0, 1.0, 11.0, 11.0]) if len(x) == 4 else np.full(len(x), 6.0)
        shape = _shapes(marks, x, y)
        swatch = f'<svg width="18" height="12" aria-hidden="true">{shape}</svg>'
        rows.append(f"<span>{swatch} {html.escape(text)}</span>")
    return f'<p class="key">{"".join(rows)}</p>' if rows else ""


def _axes(chart: Chart) -> Iterator[str]:
    """Axes, their ends, and the values that are marked: these alone where both are at one place."""
    base, left = HEIGHT - BOTTOM, _left(chart)
    yield (
        f'<path d="M{left:g} {TOP:g}V{base:g}H{WIDTH - RIGHT:g}" fill="none" stroke="var(--line)"/>'
    )
    marked = _place(chart, np.array([at for at, _ in chart.lines]), np.zeros(len(chart.lines)))[0]
    for x, (_, text) in zip(marked.tolist(), chart.lines, strict=True):
        yield f'<path d="M{x:.1f} {TOP:g}V{base:g}" stroke="var(--ink)" stroke-dasharray="3 3"/>'
        yield _text(x, TOP - 7.0, text, "end" if x > 0.8 * WIDTH else "middle")
    rise = np.unique(chart.rise)
    for value, y in zip(
        rise, _place(chart, np.full(len(rise), chart.span[0]), rise)[1], strict=True
    ):
        yield _text(left - 5.0, y + 4.0, _told(value, chart.units[1], rise), "end")
    ends = np.unique(chart.span)
    for value, x in zip(ends, _place(chart, ends, np.zeros(len(ends)))[0].tolist(), strict=True):
        if not (np.abs(marked - x) < 3.0).any():
            told = _told(value, chart.units[0], ends)
            yield _text(x, base + 13.0, told, "start" if x < left + 3.0 else "middle")
    yield _text(0.5 * WIDTH, HEIGHT - 3.0, chart.across)
    yield _text(0.0, 11.0, chart.up, "start")


def _polar_axes() -> Iterator[str]:
    middle = _REACH + 28.0
    yield (
        f'<circle cx="{0.5 * WIDTH:g}" cy="{middle:g}" r="{_REACH:g}" fill="none" '
        'stroke="var(--line)"/>'
    )
    yield _text(0.5 * WIDTH + _REACH + 8.0, middle + 4.0, "x", "start")
    yield _text(0.5 * WIDTH, middle - _REACH - 6.0, "y")


def _text(x: float, y: float, text: str, anchor: str = "middle") -> str:
    half = 3.4 * len(text) + 2.0
    x = min(max(x, half), WIDTH - half) if anchor == "middle" else x
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{html.escape(text)}</text>'


def _told(value: float, unit: str, among: Iterable[float]) -> str:
    if unit in ("m", "N", "Pa"):  # one prefix for all of an axis
        return units.components([value], unit, column=max(map(abs, among)))
    mark = "\N{DEGREE SIGN}" if unit == "deg" else f" {unit}" if unit else ""
    return f"{value:.4g}{mark}"


SCRIPTS = (
    "linear.js", "data.js", "shaders.js", "line-shaders.js", "shadow.js", "outer.js", "graphics.js",
    "block-renderer.js", "renderer.js", "picking.js", "camera.js", "pointers.js",
    "legend.js", "panel.js", "overlay.js", "captions.js", "export.js", "extent.js", "state.js",
    "drawing.js", "playing.js", "choosing.js", "pointing.js", "views.js", "framed.js",
    "taking-out.js", "main.js",
)  # fmt: skip
"""Scripts in their order in the page. They share one scope: later ones use earlier ones."""


@checked_call
def save_page(
    subject: Subject,
    path: str | PathLike[str],
    contacts: Contacts | None = None,
    *,
    section: str | None = None,
) -> None:
    """Write a page on which the model can be turned and taken apart, and its blocks clicked.

    Parameters
    ----------
    subject
        A result, a model, an assembly, a limit, a plan, a settlement, or a scene put together by
        hand.
    path
        Written to a temporary name beside it and renamed.
    contacts
        Of an assembly; a result has its own.
    section
        Show the model cut across an axis at first, as in :func:`save_figure`.

    Raises
    ------
    InputError
        The contacts belong to another model, the section is beside the model, or the file cannot
        be written.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from drystone.models import tower
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> save_page(tower(3), folder / "tower.html")
    >>> (folder / "tower.html").read_text(encoding="utf-8")[:15]
    '<!doctype html>'
    """
    if isinstance(subject, Result):
        from drystone.limits.bounds import with_margins  # only a page needs them

        subject = with_margins(subject)
    scene = scene_of(subject, contacts)
    scene = scene if section is None else cut_at(scene, section)
    write_text(path, page_text(scene))


@dataclass(frozen=True)
class Addition:
    """What the page of a server has beside the common parts; it may connect to its own server.

    Attributes
    ----------
    controls
        HTML above the other controls.
    style, script
        After those of every page, in the same scope.
    """

    controls: str = ""
    style: str = ""
    script: str = ""


def page_text(scene: Scene) -> str:
    """The page as text: HTML with its style, its script and its data inside.

    Parameters
    ----------
    scene
        What is drawn, with its charts; see :func:`scene_of`.
    """
    return page_of_data(to_text(encode(scene)), scene.title, "\n".join(map(panel, scene.charts)))


def page_of_data(data: str, title: str, aside: str = "", added: Addition | None = None) -> str:
    """The page of encoded data.

    Parameters
    ----------
    data
        Of :func:`drystone.view.encode.to_text`.
    title
    aside
        HTML for the panel beside the model.
    added
        Where it is served; no other page connects to anything.
    """
    more = Addition() if added is None else added

    def read(name: str) -> str:
        return shipped(f"view/static/{name}")

    page = read("page.html")
    for mark, text in (
        ("CONNECT", "; connect-src 'self'" if added is not None else ""),
        ("/*STYLE*/", read("page.css") + more.style),
        ("/*SCRIPT*/", "\n".join([*(read(name) for name in SCRIPTS), more.script])),
        ("TITLE", html.escape(title)),
        ("CONTROLS", more.controls),
        ("ASIDE", aside),
        ("DATA", data),  # last, because its text is not searched for placeholders
    ):
        before, after = page.split("{{" + mark + "}}")
        page = before + text + after
    return page
