"""Commands that are made of analyses: the model, what else must be given, options and files."""

from __future__ import annotations

from functools import partial
from inspect import Parameter, Signature
from typing import TYPE_CHECKING, Annotated, Any

from drystone.base.declared import Offered
from drystone.cli.command import Command, command
from drystone.cli.model_input import Subject
from drystone.cli.offered import Analysis, Argument, Of
from drystone.cli.told import Told
from drystone.cli.waiting import Waiting
from drystone.cli.written import Pictures
from drystone.loads import LoadCase

if TYPE_CHECKING:
    from drystone.base.declared import Declared


def command_of(offered: Offered, name: str, group: str = "") -> Command:
    """The command of an analysis of a model, which writes pictures.

    Parameters
    ----------
    offered
    name
    group
        The words before its name.
    """
    given = offered.arguments

    def run(
        *, subject: Subject, asked: Analysis, pictures: Pictures, waiting: Waiting, **more: Any
    ) -> Told:
        model = subject.prepared(waiting)
        pictures.require_through(model.assembly)
        notes = list(model.notes)
        for key, one in given.items():
            if _is_load(one):
                more[key] = subject.case_of(more[key], model)
                notes += more[key].notes
        found = asked.of(waiting, model, **more)
        return Told(found, notes=notes, files=partial(pictures.of, found))

    of = Of(offered.analysis, shown=offered.shown)
    hints: dict[str, Any] = {
        "subject": Subject,
        **{key: Annotated[str, _argument(one)] for key, one in given.items()},
        "asked": Annotated[Analysis, of],
        "pictures": Pictures,
        "waiting": Waiting,
    }
    run.__doc__, run.__annotations__ = offered.text, {**hints, "return": Told}
    kind = Parameter.KEYWORD_ONLY
    run.__signature__ = Signature([Parameter(key, kind) for key in hints])  # type: ignore[attr-defined]
    example = f"drystone {group} {name} {offered.example}"
    return command(example, f"{example} --html {name}.html", name=name)(run)


def _is_load(one: Declared) -> bool:
    return LoadCase in one.kinds


def _argument(one: Declared) -> Argument:
    return Argument("CASE" if _is_load(one) else one.name.upper(), one.told())
