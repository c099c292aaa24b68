"""Pictures in a notebook: the page of a value in a frame."""

from __future__ import annotations

import base64
import gzip
import html
import importlib
import importlib.util
import math
import tempfile
import webbrowser
from collections.abc import Callable, Mapping
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from drystone.base.display import OneLine
from drystone.base.errors import InputError, require
from drystone.base.files import shipped
from drystone.base.settings import checked_call
from drystone.view.figure import save_figure
from drystone.view.page import page_text, save_page
from drystone.view.subjects import Subject, scene_of

MOST_BLOCKS = 3000
"""Largest number of blocks of a model that is drawn by default. Chosen: it takes less than a
second."""

MOST_BYTES = 200_000
"""Largest page that is shown by default [bytes]. Chosen: a notebook with 20 of them is 4 MB at
most. A larger one is replaced by a still picture."""


_ALLOWED = "allow-scripts allow-downloads"
"""Permissions of the page in its frame: it has no access to the notebook."""


class Frame(OneLine):
    """The page of a value in the frame of a notebook; it can be turned and clicked.

    Parameters
    ----------
    value
        A model, an assembly, a result, a limit, a plan, a settlement or a scene.
    height : [pixels]

    Raises
    ------
    InputError
        There is no picture of such a value.

    Examples
    --------
    >>> from drystone.models import tower
    >>> Frame(tower(3))._repr_html_()[:16]
    '<iframe srcdoc="'
    """

    def __init__(self, value: Subject, height: int = 480) -> None:
        self.scene, self.height = scene_of(value), height

    def _summary(self) -> str:
        return repr(self.scene)

    def _repr_html_(self) -> str:
        return _framed(packed(page_text(self.scene)), f"width:100%;height:{self.height}px")


def packed(page: str) -> str:
    """A page that unpacks ``page`` and replaces itself: 52 kB instead of 135 for three blocks.

    Browsers support that since 2023.
    """
    small = base64.b64encode(gzip.compress(page.encode("utf-8"), mtime=0)).decode("ascii")
    return shipped("view/static/unpacking.html").replace("PACKED", small)


def _framed(page: str, style: str) -> str:
    """A page inside another one."""
    return (
        f'<iframe srcdoc="{html.escape(page)}" sandbox="{_ALLOWED}"'
        f' style="{style};border:0" title="drystone"></iframe>'
    )


@checked_call
def show(value: Subject, height: int = 480) -> None:
    """Show the page of a value: below the cell of a notebook, else in the browser.

    Parameters
    ----------
    value
        A model, an assembly, a result, a limit, a plan, a settlement or a scene.
    height : [pixels]
        In a notebook.

    Raises
    ------
    InputError
        There is no picture of such a value, or no browser; the error names the file then.
    """
    if in_notebook():
        import_module("IPython.display").display(Frame(value, height))
        return
    with tempfile.NamedTemporaryFile(prefix="drystone-", suffix=".html", delete=False) as file:
        path = Path(file.name)
    save_page(value, path)
    if not webbrowser.open(path.as_uri()):
        raise InputError("no browser was found", remedy=f"open {path} yourself")


def in_notebook() -> bool:
    """Whether this runs in a notebook."""
    if find_spec("IPython") is None:
        return False
    shell = import_module("IPython").get_ipython()
    return shell is not None and hasattr(shell, "kernel")


def beside(value: object) -> str:
    """The picture of a value: its page if that is small, else a still picture."""
    try:
        scene = scene_of(value)  # type: ignore[arg-type]
    except InputError:
        return ""
    if len(scene.assembly) > MOST_BLOCKS:
        return ""
    page = packed(page_text(scene))
    if len(page) <= MOST_BYTES:
        return _framed(page, "flex:1;min-width:20em;height:22em")
    return thumbnail(value)


def thumbnail(value: object) -> str:
    """A small still picture as an HTML image, 20 to 60 kB; empty if the value has none."""
    try:
        scene = scene_of(value)  # type: ignore[arg-type]
    except InputError:
        return ""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "thumbnail.png"
        save_figure(scene, path, size=(6.4, 4.4), dpi=64)
        data = base64.b64encode(path.read_bytes()).decode("ascii")
    return f'<img alt="{html.escape(scene.title)}" src="data:image/png;base64,{data}">'


def interact(
    function: Callable[..., Subject], *, height: int = 480, **ranges: tuple[float, float, float]
) -> Any:
    """A widget with the page of the value of a function, and a slider for each argument.

    Parameters
    ----------
    function
        Takes the numbers by name, and returns a result, a model, a plan or another value that has a
        page. It is called when a slider is released.
    height : [pixels]
    ranges
        For each number the least value, the largest one and the first one.

    Returns
    -------
    anywidget.AnyWidget
        ``values``: the numbers. ``picked``: name of the block that was clicked, or an empty text.
        ``picked_joint``: number of the interface, or -1. ``trouble``: what went wrong when the
        function was called last. ``subject``: what it gave. ``observe`` calls back on changes, as
        of every widget; setting ``picked`` selects the block in the picture.

    Raises
    ------
    InputError
        A range is not in order, or the first call fails.
    MissingDependency
        anywidget is not installed.

    Examples
    --------
    In a notebook::

        arch = drystone.Model.of(drystone.models.arch())
        live = interact(lambda f: drystone.check(arch.with_friction(f)), f=(0.2, 0.9, 0.6))
        live
        live.picked  # after a click
    """
    for name, ends in ranges.items():
        if len(ends) != 3 or not ends[0] <= ends[2] <= ends[1] or ends[0] == ends[1]:
            raise InputError(
                f"the range of '{name}' is {ends}", remedy="give least, largest and first value"
            )
    first = {name: float(ends[2]) for name, ends in ranges.items()}
    subject = function(**first)
    sliders = [
        {"name": name, "least": low, "most": high, "step": step_of(high - low)}
        for name, (low, high, _) in ranges.items()
    ]
    widget: Any = _widget_class()(sliders=sliders, values=first, height=height)
    _put(widget, subject)

    def again(change: Mapping[str, Any]) -> None:
        try:
            _put(widget, function(**change["new"]))
        except Exception as error:  # shown in the notebook
            widget.trouble = str(error) or type(error).__name__
        else:
            widget.trouble = ""

    widget.observe(again, names="values")
    return widget


def step_of(span: float) -> float:
    """A round step (1, 2 or 5 of a decade) that is at most a share of a span.

    Examples
    --------
    >>> step_of(0.9), step_of(30.0)
    (0.005, 0.2)
    """
    decade = 10.0 ** math.floor(math.log10(span / 100))
    return float(f"{max(f for f in (1, 2, 5) if f * decade <= span / 100) * decade:.3g}")


def _put(widget: Any, subject: Subject) -> None:
    scene = scene_of(subject)
    widget.subject = subject
    widget.names = list(scene.assembly.names)
    widget.page = packed(page_text(scene))


def _widget_class() -> Any:
    """The class of the widget; it needs anywidget."""
    require("anywidget", "notebook", "a page that answers")
    anywidget: Any = importlib.import_module("anywidget")
    traitlets: Any = importlib.import_module("traitlets")
    fields: dict[str, Any] = {
        "_esm": shipped("view/static/widget.js"),
        "page": traitlets.Unicode("").tag(sync=True),
        "height": traitlets.Int(480).tag(sync=True),
        "sliders": traitlets.List([]).tag(sync=True),
        "values": traitlets.Dict({}).tag(sync=True),
        "names": traitlets.List([]).tag(sync=True),
        "picked": traitlets.Unicode("").tag(sync=True),
        "picked_joint": traitlets.Int(-1).tag(sync=True),
        "trouble": traitlets.Unicode("").tag(sync=True),
        "subject": traitlets.Any(None),
        "__module__": __name__,
        "__doc__": "The page of a value with sliders; see :func:`interact`.",
    }
    return type("PageWidget", (anywidget.AnyWidget,), fields)
