"""``drystone interlock``: whether a model holds by its shape alone."""

from __future__ import annotations

from functools import partial
from typing import Annotated

from drystone.base.errors import InputError
from drystone.cli import kinds
from drystone.cli.command import command
from drystone.cli.model_input import Subject
from drystone.cli.offered import Analysis, Of, Option
from drystone.cli.told import Told
from drystone.cli.waiting import Waiting
from drystone.cli.written import Pictures


@command(
    "drystone interlock arch.json --supports springer-left,springer-right",
    "drystone interlock arch.json --directions 40 --png directions.png",
)
def interlock(
    *,
    subject: Subject,
    directions: Annotated[
        int | None,
        Option(
            "Ask instead in how many of so many directions of gravity it holds, with and without "
            "friction.",
            kind=kinds.COUNT,
        ),
    ] = None,
    asked: Annotated[
        Analysis, Of("drystone.sequence.gravity_region", without=("key", "directions"))
    ],
    pictures: Pictures,
    waiting: Waiting,
) -> Told:
    """Whether a model with its supports fixed holds under every load without friction.

    Name the key of a puzzle, and one other piece, with --supports. Exit code 0: it interlocks, or
    holds in all directions. 1: blocks can move.
    """
    from drystone.sequence import interlocking  # the program starts fast

    if directions is None and asked.given:
        raise InputError(
            "--stands is about directions of gravity", remedy="write --directions 100 too"
        )
    model = subject.prepared(waiting)
    if directions is None:
        found = interlocking(model)
    else:
        found = asked.of(waiting, model, directions=directions)
    return Told(found, notes=model.notes, files=partial(pictures.of, found))
