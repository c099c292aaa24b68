"""What a window of the page sends.

Calls of the JSON interface and their answers are those of :mod:`drystone.mcp.answers`.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from drystone.io.jsontext import Field, parse
from drystone.live.wish import Wish

VERSION = "v1"

TASKS = ("limit", "mends", "apply", "plan", "cut", "recut", "cases", "save")


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
