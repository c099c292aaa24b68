"""The answer of each tool: the main numbers, in a short object."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from drystone.answer import Answer
from drystone.base.errors import DrystoneError, InputError
from drystone.design import DiagnosisOptions, MendOptions, diagnose, find_mends
from drystone.detection import find_contacts
from drystone.io import Inspection
from drystone.io import inspect as inspect_file
from drystone.io.inspection import usable
from drystone.limits import limit_friction, limit_load, limit_shrink, limit_tilt
from drystone.mcp.folder import Folder, load_of, model_of, opened
from drystone.sequence import Order, PlanOptions, Rules, plan
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

Given = Mapping[str, Any]


def answer(tool: str, given: Given, folder: Folder, seconds: float) -> dict[str, Any]:
    """The answer of a tool, or an ``error`` and its parts. Runs in a process of its own.

    Parameters
    ----------
    tool
        A key of :data:`TOOLS`.
    given
        Its arguments.
    folder
    seconds
        Time for all of it.
    """
    began = time.monotonic()
    try:
        said = TOOLS[tool](given, folder, began + _SHARE * seconds)
    except DrystoneError as error:
        return {"error": str(error), **error.parts()}
    return {**_short(said), "time_s": round(time.monotonic() - began, 2)}


def _files(_: Given, folder: Folder, __: float) -> dict[str, Any]:
    found = [{"file": name, "bytes": size} for name, size in folder.files()]
    return {"count": len(found), "files": found[:200]}


def _inspect(given: Given, folder: Folder, _: float) -> dict[str, Any]:
    subject = given["model"]
    with opened(subject, folder) as path:
        built = inspect_file(path, units=subject.get("units"))
    blocks, notes = usable(built, subject.get("supports"))
    found = None if blocks is None else find_contacts(blocks)
    return told(Inspection(blocks, found, None, built), notes)


def _check(given: Given, folder: Folder, end: float) -> dict[str, Any]:
    model = model_of(given["model"], folder)
    return told(check(model, time_limit_s=_left(end)), model.notes)


def _diagnose(given: Given, folder: Folder, end: float) -> dict[str, Any]:
    model = model_of(given["model"], folder)
    options = DiagnosisOptions(needs=given.get("needs", True))
    return told(diagnose(model, options=options, time_limit_s=_left(end)), model.notes)


def _limit(given: Given, folder: Folder, end: float) -> dict[str, Any]:
    model = model_of(given["model"], folder)
    of, live = given["of"], given.get("load")
    if (of == "load") != bool(live):
        what = "is missing, and the limit of load grows it" if of == "load" else "is not used"
        raise InputError(what, where="load", remedy="give a load with 'of' = 'load', and only then")
    late = _late(end)
    if of == "tilt":
        found = limit_tilt(model, given.get("axis") or "x", stop=late)
    elif of == "friction":
        found = limit_friction(model, stop=late)
    elif of == "load":
        found = limit_load(model, load_of(live, model.assembly), stop=late)
    else:
        found = limit_shrink(model, stop=late)
    return told(found, model.notes)


def _plan(given: Given, folder: Folder, end: float) -> dict[str, Any]:
    model = model_of(given["model"], folder)
    rules = Rules(given.get("hands") or 2, order=Order(given.get("order") or "top"))
    chosen = PlanOptions(rules=rules, anyway=bool(given.get("anyway")))
    return told(plan(model, options=chosen, time_limit_s=_left(end)), model.notes)


def _mend(given: Given, folder: Folder, end: float) -> dict[str, Any]:
    model = model_of(given["model"], folder)
    asked: dict[str, Any] = {key: tuple(given[key]) for key in ("kinds", "keep") if given.get(key)}
    late = _late(end)
    found = find_mends(model, options=MendOptions(**asked), stop=late)
    return {**told(found, model.notes), **({"stopped": UP} if late() else {})}


def told(answer: Answer, notes: Sequence[str]) -> dict[str, Any]:
    """What an answer says of itself, with the first entries of long lists."""
    said = answer.to_dict()
    if said.get("stopped"):
        said["stopped"] = UP
    return {**said, "notes": list(notes)}


TOOLS: Mapping[str, Callable[[Given, Folder, float], dict[str, Any]]] = {
    "files": _files,
    "inspect": _inspect,
    "check": _check,
    "diagnose": _diagnose,
    "limit": _limit,
    "mend": _mend,
    "plan": _plan,
}


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
