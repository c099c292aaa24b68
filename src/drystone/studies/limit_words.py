"""Limits in words, as behind ``drystone limit``."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping
from typing import Any, get_type_hints

from drystone.answer import Answer
from drystone.base.declared import Offered, declared, declared_at, nested
from drystone.base.errors import InputError, meant, refuse_unknown
from drystone.io import read
from drystone.io.load_options import grown
from drystone.limits import LIMITS, Limit, StandingShare, ThrustBounds, TiltSweep, TrainEnvelope
from drystone.loads import LoadCase
from drystone.model import Model
from drystone.settlement import LargeDisplacement

TURNED = "turned"
"""The column of words: about which axis a tilt was found, which may be another one in each row."""
UNSURE = ("sensitive_from", "sensitive_to", "undecided_from", "undecided_to")
"""Columns of the ranges in which the joints decide: see :class:`drystone.limits.Limit`."""


def _bracket(limit: Limit) -> tuple[list[float | str | None], tuple[str, ...]]:
    sides, falling = limit.robust or limit.best, limit.best.falling
    return [sides.stands, sides.falls], () if falling is None else falling.falling_names


def _turned(limit: Limit) -> list[str | None]:
    """About which axis, of a tilt that stands at all."""
    if limit.quantity.name != "tilt":
        return []
    return [None if limit.stands is None else limit.quantity.phrase]


def _unsure(limit: Limit) -> list[float | str | None]:
    """The ranges in which the joints decide, or nothing is known."""
    ranges = (limit.sensitive_between, limit.undecided_between)
    return [end for ends in ranges for end in (sorted(ends) if ends else (None, None))]


def measures(words: str) -> Mapping[str, str]:
    """The columns of a limit in words, and their units; :func:`measured` has their values.

    Raises
    ------
    InputError
        As :func:`limit_of_words`.
    """
    offered, _ = _asked(words)
    if offered is LIMITS["tilt"]:
        return {"stands": "deg", "falls": "deg", TURNED: "", **dict.fromkeys(UNSURE, "deg")}
    return _MEASURES[get_type_hints(offered.analysis)["return"]]


_MEASURES: Mapping[type[Answer], Mapping[str, str]] = {
    Limit: {"stands": "", "falls": "", **dict.fromkeys(UNSURE, "")},
    TiltSweep: {"stands": "deg", "falls": "deg", "towards": "deg"},
    TrainEnvelope: {"factor": "", "place": "m", "stands": "", "falls": ""},
    ThrustBounds: {"least": "N", "most": "N"},
    StandingShare: {"share": "", "least": "", "most": ""},
    LargeDisplacement: {"share": "", "moved": "m"},
}


def measured(answer: Answer) -> tuple[list[float | str | None], tuple[str, ...]]:
    """The values of the columns of a limit that was found, and the blocks that move beyond it."""
    match answer:
        case TiltSweep():
            lowest = answer.lowest
            values, moves = _bracket(answer.limits[lowest])
            return [*values, float(answer.azimuth[lowest])], moves
        case TrainEnvelope():
            worst = answer.worst
            factor, place = float(answer.factors[worst]), float(answer.places[worst])
            values, moves = ([], ()) if answer.limit is None else _bracket(answer.limit)
            return [factor, place, *(values or (None, None))], moves
        case ThrustBounds():
            return [answer.least, answer.most], ()
        case StandingShare():
            return [answer.share, *answer.interval], ()
        case LargeDisplacement():
            return [float(answer.load[-1]), answer.capacity], ()
        case Limit():
            values, moves = _bracket(answer)
            return values + _turned(answer) + _unsure(answer), moves
    raise TypeError(f"no limit: {answer!r}")


_READING = ("strength", "ends")
"""Options of reading that are part of what a limit asks."""


def limit_of_words(words: str, model: Model) -> Callable[[Model, dict[str, Any]], Answer]:
    """What computes a limit, from words as behind ``drystone limit``, such as ``tilt --axis y``.

    Raises
    ------
    InputError
        There is no such limit, it takes no such option, or something is missing.
    """
    offered, texts = _asked(words)
    values: dict[str, Any] = {}
    for path, text in texts.items():
        one = declared_at(read if path in _READING else offered.analysis, path)
        values[path] = grown(text, model) if LoadCase in one.kinds else one.value(text)
    known = declared(offered.analysis)

    def computed(of: Model, late: dict[str, Any]) -> Answer:
        common = {name: value for name, value in late.items() if name in known}
        return offered.analysis(of, **nested(offered.analysis, values), **common)

    return computed


def _asked(words: str) -> tuple[Offered, dict[str, Any]]:
    """A limit, and the texts of its arguments and options."""
    name, *rest = shlex.split(words) or [""]
    if name not in LIMITS:
        remedy = "give its values by --set" if name == "thickness" else meant(name, LIMITS)
        raise InputError(f"there is no limit '{name}'", where="limit", remedy=remedy)
    offered = LIMITS[name]
    paths = {path.rpartition(".")[2]: path for path in (*offered.arguments, *offered.options)}
    paths |= {path: path for path in _READING}
    takes = list(offered.arguments)
    texts: dict[str, Any] = {}
    while rest:
        word = rest.pop(0)
        if word.startswith("--"):
            key = word.removeprefix("--").replace("-", "_")
            refuse_unknown([key], list(paths))
            flag = key not in _READING and bool in declared_at(offered.analysis, paths[key]).kinds
            if not (flag or rest):
                raise InputError(f"{word} needs a value", where="limit", remedy=f"limit {name}")
            texts[paths[key]] = True if flag else rest.pop(0)
        elif takes:
            texts[paths[takes.pop(0)]] = word
        else:
            raise InputError(f"'{word}' is one word too many", where=f"limit {name}")
    if takes:
        raise InputError(f"{takes[0]} is missing", where=f"limit {name}", remedy="give it")
    return offered, texts
