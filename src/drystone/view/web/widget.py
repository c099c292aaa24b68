"""The interactive page in a notebook: selected blocks, and sliders that call Python.

Needs anywidget (extra ``notebook``), which Jupyter, marimo, Colab and VS Code show alike.
"""

from __future__ import annotations

import importlib
import importlib.util
import math
from collections.abc import Callable, Mapping
from importlib import resources
from typing import Any

from drystone.base.errors import InputError, MissingDependency
from drystone.view.subjects import Subject, scene_of
from drystone.view.web.notebook import packed
from drystone.view.web.page import page_text

_STEPS = 100
"""Steps of a slider from one end to the other, at least."""


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
    decade = 10.0 ** math.floor(math.log10(span / _STEPS))
    return float(f"{max(f for f in (1, 2, 5) if f * decade <= span / _STEPS) * decade:.3g}")


def _put(widget: Any, subject: Subject) -> None:
    scene = scene_of(subject)
    widget.subject = subject
    widget.names = list(scene.assembly.names)
    widget.page = packed(page_text(scene))


def _widget_class() -> Any:
    """The class of the widget; it needs anywidget."""
    if importlib.util.find_spec("anywidget") is None:
        raise MissingDependency("anywidget", extra="notebook", purpose="a page that answers")
    anywidget: Any = importlib.import_module("anywidget")
    traitlets: Any = importlib.import_module("traitlets")
    static = resources.files("drystone.view.web").joinpath("static")
    fields: dict[str, Any] = {
        "_esm": static.joinpath("widget.js").read_text(encoding="utf-8"),
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
