"""The answer of each tool: the main numbers, in a short object."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from inspect import Parameter
from typing import Any, Literal

from drystone.answer import Answer
from drystone.base.declared import (
    Declared,
    Offered,
    declared,
    declared_at,
    nested,
)
from drystone.base.errors import DrystoneError, InputError, refuse_unknown
from drystone.design import diagnose, find_mends
from drystone.detection import find_contacts
from drystone.io import Inspection, read
from drystone.io import inspect as inspect_file
from drystone.io.inspection import usable
from drystone.io.load_options import grown
from drystone.io.opening import tolerances
from drystone.limits import LIMITS
from drystone.loads import LoadCase
from drystone.mcp.folder import Folder, how_of, model_of, opened
from drystone.sequence import plan
from drystone.stability import check

_MOST = 20
"""Entries of a list in an answer. Chosen."""
_LONGEST = 200
"""Numbers of a list in an answer. Chosen."""
_DIGITS = 6
"""Significant digits of a number in an answer."""
_SHARE = 0.8
"""Share of the time of a call after which an analysis ends. The rest is for reading and for its
last step."""
UP = "the time was up"


@dataclass(frozen=True)
class Tool:
    """A tool that programs can use, and a call of the JSON interface.

    Attributes
    ----------
    text
        What it answers, for whoever chooses one.
    run
        From the model, the arguments, the folder and the time at which it has to end.
    arguments
        Beside the model, by their names.
    of_model
        Whether it takes a model.
    """

    text: str
    run: Callable[[Mapping[str, Any], dict[str, Any], Folder, float], dict[str, Any]]
    arguments: Mapping[str, Declared] = field(default_factory=dict)
    of_model: bool = True

    @property
    def names(self) -> tuple[str, ...]:
        """The names of all its arguments."""
        return (*(("model",) if self.of_model else ()), *self.arguments)


def answer(tool: str, given: Mapping[str, Any], folder: Folder, seconds: float) -> dict[str, Any]:
    """The answer of a tool, or an ``error`` and its parts. Runs in a process of its own.

    Parameters
    ----------
    tool
        A key of :data:`TOOLS`.
    given
        Its arguments, as JSON has them.
    folder
    seconds
        Time for all of it.
    """
    began = time.monotonic()
    end = began + _SHARE * seconds
    try:
        one = TOOLS[tool]
        model, values = arguments_of(one, given)
        said = one.run(model, values, folder, end)
    except DrystoneError as error:
        return {"error": str(error), **error.parts()}
    return {**_short(said), "time_s": round(time.monotonic() - began, 2)}


def arguments_of(tool: Tool, given: Mapping[str, Any]) -> tuple[Mapping[str, Any], dict[str, Any]]:
    """The model of a call, and its other arguments.

    Raises
    ------
    InputError
        One is not known, or has a value that it cannot have; its place is named.
    """
    known = tool.arguments
    refuse_unknown(given, tool.names)
    model = given.get("model", {} if not tool.of_model else None)
    if not isinstance(model, Mapping):
        raise InputError("is missing", where="model", remedy="give an object with file or content")
    values = {name: known[name].value(one) for name, one in given.items() if name != "model"}
    return model, values


def _files(_: Mapping[str, Any], __: dict[str, Any], folder: Folder, ___: float) -> dict[str, Any]:
    found = [{"file": name, "bytes": size} for name, size in folder.files()]
    return {"count": len(found), "files": found[:200]}


def _inspect(
    subject: Mapping[str, Any], _: dict[str, Any], folder: Folder, __: float
) -> dict[str, Any]:
    how = how_of(subject, folder)
    names = ("units", "split", "repair", "layers", "hidden", "thickness", "max_size", "supports")
    own = {name: how.pop(name) for name in names if name in how}
    search = {name: how.pop(name) for name in ("gap", "angle", "edges") if name in how}
    refuse_unknown(how, (*names, *search))
    with opened(subject, folder) as path:
        built = inspect_file(path, **own)
    blocks, notes = usable(built, own.get("supports"))
    found = None if blocks is None else find_contacts(blocks, options=tolerances(**search))
    return told(Inspection(blocks, found, built), notes)


def _paths(offered: Offered) -> dict[str, str]:
    """What an analysis takes, by the last part of names such as ``options.rules.hands``."""
    late = ("executor", "time_limit_s")
    paths = (*offered.arguments, *offered.options)
    return {path.rpartition(".")[2]: path for path in paths if path not in late}


def _arguments(offered: Offered) -> dict[str, Declared]:
    """What an analysis takes, a load as :func:`drystone.read` does."""
    known = [declared_at(offered.analysis, path) for path in _paths(offered).values()]
    load = declared(read)["load"].hint
    return {one.name: replace(one, hint=load) if LoadCase in one.kinds else one for one in known}


def _tool(text: str, analysis: Callable[..., Answer], *names: str) -> Tool:
    """A tool of an analysis of a model, with some of its options."""
    offered = Offered(analysis, names=names)
    return Tool(text, partial(_analysed, offered), _arguments(offered))


def _analysed(
    offered: Offered,
    subject: Mapping[str, Any],
    values: dict[str, Any],
    folder: Folder,
    end: float,
) -> dict[str, Any]:
    """The answer of an analysis with values by the names of its options."""
    analysis, paths = offered.analysis, _paths(offered)
    model, known = model_of(subject, folder), declared(analysis)
    for name, value in values.items():
        if LoadCase in declared_at(analysis, paths[name]).kinds:
            values[name] = grown(value, model, subject.get("gravity"))
    chosen = nested(analysis, {paths[name]: value for name, value in values.items()})
    left = {"time_limit_s": max(end - time.monotonic(), 1e-3)}
    said = told(analysis(model, **chosen, **(left if "time_limit_s" in known else {})), model.notes)
    return {**said, "stopped": UP} if said.get("stopped") or time.monotonic() > end else said


def _limit(
    subject: Mapping[str, Any], values: dict[str, Any], folder: Folder, end: float
) -> dict[str, Any]:
    how_of(subject, folder)  # what is wrong with the model is told first
    of = values.pop("of", None)
    if of is None:
        raise InputError("is missing", where="of", remedy=f"give {', '.join(LIMITS)}")
    one = LIMITS[of]
    paths = _paths(one)
    for name in (*one.arguments, *values):
        if name not in values:
            raise InputError(f"is missing for the limit of {of}", where=name, remedy="give it")
        if name not in paths:
            raise InputError(f"is not used by the limit of {of}", where=name, remedy="leave it out")
    return _analysed(one, subject, values, folder, end)


def told(answer: Answer, notes: Sequence[str]) -> dict[str, Any]:
    """What an answer says of itself, and notes on the model."""
    return {**answer.to_dict(), "notes": list(notes)}


_OF = Declared(
    "of",
    Literal[tuple(LIMITS)],
    Parameter.empty,
    " ".join(f"{name}: {one.text.splitlines()[0]}" for name, one in LIMITS.items()),
)
TOOLS: Mapping[str, Tool] = {
    "files": Tool("List the model files in the folder of this server.", _files, of_model=False),
    "inspect": Tool(
        "Blocks, volumes and defects of a model, and the contacts that are found and missed.",
        _inspect,
    ),
    "check": _tool(
        "Does a model stand? Verdict, blocks that fall, what a prop would carry, largest forces. "
        "'stable' and 'unstable' are proved. 'sensitive': it stands for some contact stiffnesses "
        "of those that were tried, and not for all.",
        check,
    ),
    "diagnose": _tool(
        "Why does a model fall, and what would hold it? One sentence for each region that falls. "
        "'needs' of a region: the force that is missing and its point, a support from below, the "
        "least friction, ballast on one block, turn of one joint, and whether glue would hold.",
        diagnose,
        "options.kinds",
        "options.regions",
    ),
    "limit": Tool(
        "By how much does a model stand? A bracket: stands at one value, falls at the other. "
        "'equilibrium' is where some forces balance the loads, 'rest' where it comes to rest for "
        "some contact stiffness, 'uniform' for a uniform one.",
        _limit,
        {"of": _OF}
        | {name: argument for one in LIMITS.values() for name, argument in _arguments(one).items()},
    ),
    "mend": _tool(
        "Which changes make a model stand? Each was checked on the whole model, cheapest first. "
        "'mends' lists them by region, 'tried' those that are not enough.",
        find_mends,
        "options.margin",
        "options.kinds",
        "options.keep",
    ),
    "plan": _tool(
        "In which order to assemble a model so that every stage stands: what to hold and to prop. "
        "Counts of free, held, propped and impossible blocks, the order, the force of each prop.",
        plan,
        *(f"options.{name}" for name in ("rules.hands", "rules.payload", "rules.order", "anyway")),
    ),
}
"""The tools by name."""


def _short(value: Any) -> Any:
    """The same with rounded numbers, and of rows and names their number and the first ones."""
    if isinstance(value, Mapping):
        return {key: _short(one) for key, one in value.items()}
    if isinstance(value, float):
        return float(f"{value:.{_DIGITS}g}")
    if not isinstance(value, list | tuple):
        return value
    rows = len(value) > _MOST and isinstance(value[0], Mapping | str)
    first = [_short(one) for one in value[: _MOST if rows else _LONGEST]]
    return {"count": len(value), "first": first} if rows else first
