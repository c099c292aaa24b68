"""What a window of the page sends, and what a call of the JSON interface may say.

The answers to calls are those of :mod:`drystone.mcp.answers`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from drystone.io.jsontext import Field, parse
from drystone.live.wish import Wish

VERSION = "v1"

MODEL = ("file", "content", "supports", "friction", "density", "units", "gravity", "loads")

TASKS = ("limit", "mends", "apply", "plan", "cut", "recut", "cases", "save")


def _text(field: Field) -> str:
    return field.text()


def _one_of(*words: str) -> Callable[[Field], str]:
    def read(field: Field) -> str:
        word = field.text()
        if word not in words:
            raise field.error(f"is '{word[:40]}'", f"choose one of {', '.join(words)}")
        return word

    return read


def _hands(field: Field) -> int:
    hands = field.integer()
    if not 1 <= hands <= 10:
        raise field.error(f"is {hands}", "give 1 to 10")
    return hands


def _not_negative(field: Field) -> float:
    value = field.number()
    if value < 0.0:
        raise field.error(f"is {value:g}", "give a number of zero or more")
    return value


def _above_zero(field: Field) -> float:
    value = field.number()
    if not value > 0.0:
        raise field.error(f"is {value:g}", "give a number above zero")
    return value


def _names(field: Field) -> list[str]:
    return [one.text() for one in field.elements()]


def _supports(field: Field) -> str | list[str]:
    return _names(field) if isinstance(field.value, list) else field.text()


def _gravity(field: Field) -> Any:
    return field.floats(3).tolist() if isinstance(field.value, list) else field.number()


def _loads(field: Field) -> Any:
    return [one.object().value for one in field.elements()]


_OF_MODEL: Mapping[str, Callable[[Field], Any]] = {
    "file": _text,
    "content": lambda field: field.object().value,
    "supports": _supports,
    "friction": _not_negative,
    "density": _above_zero,
    "units": _text,
    "gravity": _gravity,
    "loads": _loads,
}

ARGUMENTS: Mapping[str, Mapping[str, Callable[[Field], Any]]] = {
    "files": {},
    "inspect": {},
    "check": {},
    "diagnose": {"needs": lambda field: field.boolean()},
    "limit": {
        "of": _one_of("tilt", "friction", "load", "shrink"),
        "axis": _one_of("x", "y", "z", "-x", "-y"),
        "load": _loads,
    },
    "plan": {
        "hands": _hands,
        "order": _one_of("top", "course", "boundary"),
        "anyway": lambda field: field.boolean(),
    },
    "mend": {"kinds": _names, "keep": _names},
}
"""Arguments of each call beside ``model``."""


def given_of(tool: str, body: Field) -> dict[str, Any]:
    """The arguments of a call, each checked.

    Raises
    ------
    FormatError
        With the place in the body.
    """
    known = ARGUMENTS[tool]
    body.only(known if tool == "files" else ("model", *known))
    given = {key: read(body[key]) for key, read in known.items() if body.has(key)}
    if tool == "limit" and "of" not in given:
        raise body.error("'of' is missing", "give tilt, friction, load or shrink")
    if tool == "files":
        return given
    model = body["model"].object()
    model.only(MODEL)
    return {
        "model": {key: read(model[key]) for key, read in _OF_MODEL.items() if model.has(key)},
        **given,
    }


@dataclass(frozen=True)
class Sent:
    """A wish of a window, as plain values that were looked at.

    Attributes
    ----------
    window
    number
        The window counts its wishes.
    model
        Number of the model that it shows.
    wish
    task
        Empty where a verdict is asked for.
    extra
        What the task is told.
    """

    window: str
    number: int
    model: int
    wish: dict[str, Any]
    task: str
    extra: dict[str, Any]


def sent(body: bytes) -> Sent:
    """What the body of a request says.

    Raises
    ------
    InputError
        It is no JSON, or a value cannot be: friction below zero.
    """
    top = parse(body, Path("request"))
    top.only(("window", "number", "model", "wish", "task", "extra"))
    wish = top.get("wish", {})
    Wish.of(Field(wish.value, "", Path("wish")))
    task = top.get("task", "").text()
    if task and task not in TASKS:
        raise top["task"].error(f"there is no task '{task[:40]}'", f"there are {', '.join(TASKS)}")
    return Sent(
        top["window"].text(),
        top.get("number", 0).integer(),
        top.get("model", 0).integer(),
        wish.value,
        task,
        top.get("extra", {}).object().value,
    )
