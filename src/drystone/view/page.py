"""A self-contained HTML page, with charts as SVG: it opens from disk and needs no network."""

from __future__ import annotations

import html
import re
from dataclasses import dataclass
from os import PathLike

from drystone.answer.chart import Chart
from drystone.answer.scene import Scene
from drystone.base.files import shipped, write_text
from drystone.base.settings import checked_call
from drystone.contacts import Contacts
from drystone.results import Result
from drystone.view.encode import encode, to_text
from drystone.view.plots import chart_svg
from drystone.view.section import cut_at
from drystone.view.subjects import Subject, scene_of


def panel(chart: Chart) -> str:
    """HTML of a chart with its title and caption."""
    drawn = chart_svg(chart) if chart.marks else ""
    told = "".join(f"<p>{html.escape(one)}</p>" for one in chart.caption.split("\n") if one)
    told = re.sub(r"--[a-z]+ \d[\d,]*\b", r"<code>\g<0></code>", told)  # an option is not broken
    head = f"<legend>{html.escape(chart.title)}</legend>"
    return f'    <fieldset class="chart">{head}{drawn}{told}</fieldset>'


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
