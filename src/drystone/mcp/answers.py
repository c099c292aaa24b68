"""The answer of each tool: the main numbers, in a short object."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from drystone.base.errors import DrystoneError, InputError
from drystone.design import DiagnosisOptions, MendOptions, diagnose, find_mends
from drystone.detection import find_contacts
from drystone.io import inspect as inspect_file
from drystone.limits import Limit, limit_friction, limit_load, limit_shrink, limit_tilt
from drystone.mcp.folder import Folder, load_of, model_of, opened
from drystone.results import Result
from drystone.sequence import Order, PlanOptions, Rules, plan
from drystone.stability import check

_MOST = 20
"""Entries of a list in an answer. Chosen."""
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
        told = TOOLS[tool](given, folder, began + _SHARE * seconds)
    except DrystoneError as error:
        return {"error": str(error), **error.parts()}
    return {**_short(told), "time_s": round(time.monotonic() - began, 2)}


def _files(_: Given, folder: Folder, __: float) -> dict[str, Any]:
    found = [{"file": name, "bytes": size} for name, size in folder.files()]
    return {"count": len(found), "files": found[:200]}


def _inspect(given: Given, folder: Folder, _: float) -> dict[str, Any]:
    subject = given["model"]
    with opened(subject, folder) as path:
        built = inspect_file(path, units=subject.get("units"))
    blocks = [block for block in built.blocks if block is not None]
    bounds = np.array([block.bounds for block in blocks])
    usable = built.assembly or built.usable
    if usable is not None and built.assembly is not None and subject.get("supports"):
        usable = model_of(subject, folder).assembly
    fixed = [] if usable is None else np.array(usable.names)[usable.fixed].tolist()
    contacts = [] if usable is None else find_contacts(usable).report.summary()
    return {
        "blocks": len(blocks),
        "names": _few([block.name for block in blocks]),
        "fixed": _few(fixed),
        "volume_m3": sum(block.volume for block in blocks),
        "mass_kg": sum(block.mass for block in blocks),
        "lowest_corner_m": bounds[:, 0].min(axis=0).tolist() if blocks else None,
        "highest_corner_m": bounds[:, 1].max(axis=0).tolist() if blocks else None,
        "defects": _few([str(error) for error in built.defects]),
        "contacts": contacts[:_MOST],
        "notes": list(built.notes)[:_MOST],
    }


def _check(given: Given, folder: Folder, end: float) -> dict[str, Any]:
    model = model_of(given["model"], folder)
    return _told(check(model, time_limit_s=_left(end)))


def _told(result: Result) -> dict[str, Any]:
    samples = result.samples
    return {
        "verdict": result.verdict.value,
        "message": result.message,
        "sensitive": result.stable and samples.standing < samples.tried,
        "stiffnesses": asdict(samples),
        "stopped": result.stopped,
        "blocks": len(result.assembly),
        "free_blocks": len(result.assembly.free),
        "interfaces": result.contacts.count,
        "falling": _few(result.falling_names),
        "props": _props(result),
        "largest_force": _hardest(result, result.resultants.normal),
        "largest_friction_use": _hardest(result, result.utilisation),
        "notes": list(result.model.notes)[:_MOST],
    }


def _props(result: Result) -> list[dict[str, Any]]:
    if result.prop is None:
        return []
    size = np.linalg.norm(result.prop[:, :3], axis=1)
    neediest = sorted(result.falling, key=lambda block: -size[block])[:_MOST]
    return [
        {
            "block": result.assembly.names[block],
            "force_N": result.prop[block, :3].tolist(),
            "moment_Nm": result.prop[block, 3:].tolist(),
        }
        for block in neediest
    ]


def _hardest(result: Result, by: Any) -> dict[str, Any] | None:
    """The interface at which something is largest; ``None`` where it does not stand."""
    if result.force is None or result.falls or not result.contacts.count:
        return None
    at = int(np.argmax(by))
    ends = (result.contacts.block_a[at], result.contacts.block_b[at])
    return {
        "between": [result.assembly.names[end] for end in ends],
        "normal_N": float(result.resultants.normal[at]),
        "tangential_N": float(result.resultants.tangential[at]),
        "friction_use": float(result.utilisation[at]),
    }


def _diagnose(given: Given, folder: Folder, end: float) -> dict[str, Any]:
    model = model_of(given["model"], folder)
    options = DiagnosisOptions(needs=given.get("needs", True))
    told = diagnose(model, options=options, time_limit_s=_left(end)).to_dict()
    kept = ("prop", "supports", "friction", "ballast", "turn", "glue")
    return {
        "verdict": told["verdict"],
        "message": told["message"],
        "sentences": told["sentences"][:_MOST],
        "friction_of_all_joints": told["friction_of_all"],
        "regions": [
            {
                "blocks": _few(region["blocks"]),
                "sentence": region["sentence"],
                "needs": {key: region["needs"][key] for key in kept},
            }
            for region in told["regions"][:_MOST]
        ],
        "stopped": told["stopped"],
        "notes": list(model.notes)[:_MOST],
    }


def _limit(given: Given, folder: Folder, end: float) -> dict[str, Any]:
    model = model_of(given["model"], folder)
    of, live = given["of"], given.get("load")
    if (of == "load") != bool(live):
        what = "is missing, and the limit of load grows it" if of == "load" else "is not used"
        raise InputError(what, where="load", remedy="give a load with 'of' = 'load', and only then")

    def late() -> bool:
        return time.monotonic() > end

    if of == "tilt":
        found = limit_tilt(model, given.get("axis") or "x", stop=late)
    elif of == "friction":
        found = limit_friction(model, stop=late)
    elif of == "load":
        found = limit_load(model, load_of(live, model.assembly), stop=late)
    else:
        found = limit_shrink(model, stop=late)
    return _bracket(found, model.notes)


def _bracket(found: Limit, notes: Sequence[str]) -> dict[str, Any]:
    told = found.to_dict()
    kinds = ("equilibrium", "rest", "robust", "uniform")
    return {
        "parameter": found.parameter,
        "unit": found.unit,
        "stands_at": found.best.stands,
        "falls_at": found.best.falls,
        **{kind: told[kind] for kind in kinds},
        "islands": told["islands"][:_MOST],
        "falling": _few(told["falling"]),
        "message": told["message"],
        "sensitive": found.is_sensitive,
        "remarks": told["remarks"],
        "stopped": UP if found.stopped else "",
        "notes": list(notes)[:_MOST],
    }


def _plan(given: Given, folder: Folder, end: float) -> dict[str, Any]:
    model = model_of(given["model"], folder)
    rules = Rules(given.get("hands") or 2, order=Order(given.get("order") or "top"))
    anyway = bool(given.get("anyway"))
    chosen = PlanOptions(rules=rules, anyway=anyway)
    found = plan(model, options=chosen, time_limit_s=_left(end))
    told = found.to_dict()
    names = model.assembly.names
    impossible = {names[block]: why for block, why in found.impossible.items()}
    return {
        "verdict": found.verdict.value,
        "message": found.message,
        "counts": found.counts,
        "steps": len(found.steps),
        "order": _few(found.order, 200),
        "held_together": [row["blocks"] for row in told["steps"] if len(row["blocks"]) > 1][:_MOST],
        "props": [
            {
                "block": row["block"],
                "force_N": row["force"],
                "from_step": row["first_step"] + 1,
                "to_step": row["last_step"] + 1,
            }
            for row in told["props"][:_MOST]
        ],
        "impossible": dict(list(impossible.items())[:_MOST]),
        "proved": found.proved,
        "stopped": found.stopped,
        "notes": list(model.notes)[:_MOST],
    }


def _mend(given: Given, folder: Folder, end: float) -> dict[str, Any]:
    model = model_of(given["model"], folder)
    asked: dict[str, Any] = {key: tuple(given[key]) for key in ("kinds", "keep") if given.get(key)}

    def late() -> bool:
        return time.monotonic() > end

    told = find_mends(model, options=MendOptions(**asked), stop=late).to_dict()
    kept = ("kind", "description", "value", "cost", "verdict", "message")
    return {
        "mends": [
            {"blocks": _few(one["blocks"]), **{key: one[key] for key in kept}}
            for one in told["mends"][:_MOST]
        ],
        "tried": [{**one, "blocks": _few(one["blocks"])} for one in told["tried"][:_MOST]],
        "message": told["mending"],
        "stopped": UP if late() else "",
        "notes": list(model.notes)[:_MOST],
    }


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


def _few(names: Sequence[str], most: int = _MOST) -> dict[str, Any]:
    """The number of entries, and the first of them."""
    return {"count": len(names), "first": list(names[:most])}


def _short(value: Any) -> Any:
    """The same with rounded numbers; null for numbers that are not finite."""
    if isinstance(value, Mapping):
        return {key: _short(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_short(one) for one in value]
    if isinstance(value, bool | int | str) or value is None:
        return value
    number = float(value)
    return float(f"{number:.{_DIGITS}g}") if math.isfinite(number) else None
