"""The answer of each tool: the main numbers, in a short object."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from inspect import Parameter
from typing import Any, Literal

from drystone.answer import Answer
from drystone.base.declared import (
    Declared,
    declared,
    declared_at,
    made_of,
    nested,
    options_of,
    refuse_unknown,
)
from drystone.base.errors import DrystoneError, InputError
from drystone.design import DiagnosisOptions, MendOptions, diagnose, find_mends
from drystone.detection import find_contacts
from drystone.io import Inspection, read
from drystone.io import inspect as inspect_file
from drystone.io.inspection import usable
from drystone.io.load_options import grown
from drystone.io.opening import tolerances
from drystone.limits import LIMITS
from drystone.loads import LoadCase
from drystone.mcp.folder import Folder, how_of, model_of, opened
from drystone.sequence import PlanOptions, plan
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
        From the model, the options and the time at which it has to end.
    options
        Class of the options that it takes.
    names
        Those that are offered, such as ``rules.hands``; all when left out.
    more
        Further arguments.
    of_model
        Whether it takes a model.
    """

    text: str
    run: Callable[..., dict[str, Any]]
    options: Callable[..., Any] | None = None
    names: tuple[str, ...] = ()
    more: Mapping[str, Declared] = field(default_factory=dict)
    of_model: bool = True

    @property
    def names_of_all(self) -> tuple[str, ...]:
        """The names of all its arguments."""
        return (*(("model",) if self.of_model else ()), *self.arguments)

    @property
    def arguments(self) -> dict[str, Declared]:
        """Its arguments beside the model, by their names."""
        if self.options is None:
            return dict(self.more)
        names = self.names or tuple(declared(self.options))
        own = {name.rpartition(".")[2]: declared_at(self.options, name) for name in names}
        return {**own, **self.more}

    def chosen(self, given: Mapping[str, Any]) -> Any:
        """The options of the arguments."""
        names = self.names or tuple(declared(self.options or dict))
        own = {name: given[name.rpartition(".")[2]] for name in names
               if name.rpartition(".")[2] in given}  # fmt: skip
        return made_of(self.options or dict, own)


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
        said = one.run(one, model, values, folder, end)
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
    refuse_unknown(given, tool.names_of_all)
    model = given.get("model", {} if not tool.of_model else None)
    if not isinstance(model, Mapping):
        raise InputError("is missing", where="model", remedy="give an object with file or content")
    values = {name: known[name].value(one) for name, one in given.items() if name != "model"}
    return model, values


def _files(
    _: Tool, __: Mapping[str, Any], ___: Mapping[str, Any], folder: Folder, ____: float
) -> dict[str, Any]:
    found = [{"file": name, "bytes": size} for name, size in folder.files()]
    return {"count": len(found), "files": found[:200]}


def _inspect(
    _: Tool, subject: Mapping[str, Any], __: Mapping[str, Any], folder: Folder, ___: float
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
    return told(Inspection(blocks, found, None, built), notes)


def _analysed(analysis: Callable[..., Answer], timed: bool = True) -> Callable[..., dict[str, Any]]:
    """A tool of an analysis that takes a model and options."""

    def run(
        tool: Tool,
        subject: Mapping[str, Any],
        values: Mapping[str, Any],
        folder: Folder,
        end: float,
    ) -> dict[str, Any]:
        model = model_of(subject, folder)
        late = _late(end)
        limit: dict[str, Any] = {"time_limit_s": _left(end)} if timed else {"stop": late}
        options = {} if tool.options is None else {"options": tool.chosen(values)}
        said = told(analysis(model, **options, **limit), model.notes)
        return said if timed or not late() else {**said, "stopped": UP}

    return run


def _limit(
    _: Tool, subject: Mapping[str, Any], values: Mapping[str, Any], folder: Folder, end: float
) -> dict[str, Any]:
    model = model_of(subject, folder)
    of = values.get("of")
    if of is None:
        raise InputError("is missing", where="of", remedy=f"give {', '.join(LIMITS)}")
    one, given = LIMITS[of], {}
    takes = (*one.arguments, *options_of(one.analysis))
    paths = {name.rpartition(".")[2]: name for name in takes}
    for name in [*one.arguments, *values]:
        if name not in values:
            raise InputError(f"is missing for the limit of {of}", where=name, remedy="give it")
        if name not in paths and name != "of":
            raise InputError(f"is not used by the limit of {of}", where=name, remedy="leave it out")
        if name != "of":
            given[paths[name]] = values[name]
            if LoadCase in declared_at(one.analysis, paths[name]).kinds:
                given[name] = grown(values[name], model, subject.get("gravity"))
    chosen, stop = nested(one.analysis, given), {"stop": _late(end)}
    known = declared(one.analysis)
    found = one.analysis(model, **chosen, **(stop if "stop" in known else {}))
    return told(found, model.notes)


def _of_limits() -> dict[str, Declared]:
    """What the limits take, a load as :func:`drystone.read` does."""
    found = {"of": _OF}
    for one in LIMITS.values():
        for path in (*one.arguments, *options_of(one.analysis)):
            known = declared_at(one.analysis, path)
            if LoadCase in known.kinds:
                known = replace(known, hint=declared(read)["load"].hint)
            if known.name not in ("executor", "time_limit_s"):
                found.setdefault(known.name, known)
    return found


def told(answer: Answer, notes: Sequence[str]) -> dict[str, Any]:
    """What an answer says of itself, with the first entries of long lists."""
    said = answer.to_dict()
    if said.get("stopped"):
        said["stopped"] = UP
    return {**said, "notes": list(notes)}


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
    "check": Tool(
        "Does a model stand? Verdict, blocks that fall, what a prop would carry, largest forces. "
        "'stable' and 'unstable' are proved. 'sensitive': it stands for some contact stiffnesses "
        "of those that were tried, and not for all.",
        _analysed(check),
    ),
    "diagnose": Tool(
        "Why does a model fall, and what would hold it? One sentence for each region that falls. "
        "'needs' of a region: the force that is missing and its point, a support from below, the "
        "least friction, ballast on one block, turn of one joint, and whether glue would hold.",
        _analysed(diagnose),
        DiagnosisOptions,
    ),
    "limit": Tool(
        "By how much does a model stand? A bracket: stands at one value, falls at the other. "
        "'equilibrium' is where some forces balance the loads, 'rest' where it comes to rest for "
        "some contact stiffness, 'uniform' for a uniform one.",
        _limit,
        more=_of_limits(),
    ),
    "mend": Tool(
        "Which changes make a model stand? Each was checked on the whole model, cheapest first. "
        "'mends' lists them by region, 'tried' those that are not enough.",
        _analysed(find_mends, timed=False),
        MendOptions,
    ),
    "plan": Tool(
        "In which order to assemble a model so that every stage stands: what to hold and to prop. "
        "Counts of free, held, propped and impossible blocks, the order, the force of each prop.",
        _analysed(plan),
        PlanOptions,
        ("rules.hands", "rules.payload", "rules.order", "anyway"),
    ),
}
"""The tools by name."""


def _left(end: float) -> float:
    """Seconds until then; at least a short time."""
    return max(end - time.monotonic(), 1e-3)


def _late(end: float) -> Callable[[], bool]:
    """Whether the time is up."""
    return lambda: time.monotonic() > end


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
