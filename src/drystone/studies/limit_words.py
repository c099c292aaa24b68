"""Limits in words, as behind ``drystone limit``."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from typing import Any, get_type_hints

from drystone.answer import Answer
from drystone.base.declared import Offered, declared, declared_at, nested, refuse_unknown
from drystone.base.errors import InputError, meant
from drystone.io.load_options import grown
from drystone.limits import LIMITS, Limit
from drystone.loads import LoadCase
from drystone.model import Model


def require_two_sides(words: str) -> None:
    """Refuse words that no limit with two sides has, before there is a model.

    Raises
    ------
    InputError
        As :func:`limit_of_words`; or what is found is no :class:`drystone.limits.Limit`.
    """
    offered, _ = _asked(words)
    if get_type_hints(offered.analysis)["return"] is not Limit:
        remedy = "ask for tilt, friction, load or shrink"
        raise InputError(f"'{words}' has no two sides", where="limit", remedy=remedy)


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
        one = declared_at(offered.analysis, path)
        values[path] = grown(text, model) if LoadCase in one.kinds else one.value(text)
    known = declared(offered.analysis)

    def computed(of: Model, late: dict[str, Any]) -> Answer:
        common = {name: value for name, value in late.items() if name in known}
        found: Answer = offered.analysis(of, **nested(offered.analysis, values), **common)
        return found

    return computed


def _asked(words: str) -> tuple[Offered, dict[str, Any]]:
    """A limit, and the texts of its arguments and options."""
    name, *rest = shlex.split(words) or [""]
    if name not in LIMITS:
        remedy = meant(name, LIMITS)
        raise InputError(f"there is no limit '{name}'", where="limit", remedy=remedy)
    offered = LIMITS[name]
    paths = {path.rpartition(".")[2]: path for path in (*offered.arguments, *offered.options)}
    takes = list(offered.arguments)
    texts: dict[str, Any] = {}
    while rest:
        word = rest.pop(0)
        if word.startswith("--"):
            key = word.removeprefix("--").replace("-", "_")
            refuse_unknown([key], list(paths))
            flag = bool in declared_at(offered.analysis, paths[key]).kinds
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
