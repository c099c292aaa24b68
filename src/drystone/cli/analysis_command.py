"""Commands that are made of analyses: the model, what else must be given, options and files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING
from functools import cached_property, partial
from importlib import import_module
from typing import TYPE_CHECKING, Annotated, Any

from drystone.cli.command import SETTINGS, Command, parts_of
from drystone.cli.model_input import OneFile, Subject
from drystone.cli.offered import Analysis, Argument, Of, Part
from drystone.cli.told import Told
from drystone.cli.waiting import Waiting
from drystone.cli.written import Pictures, WithFilm, WithModel, Written

if TYPE_CHECKING:
    from drystone.base.declared import Declared, Offered


_FILES: Mapping[str, type[Pictures]] = {"joints": Written, "model": WithModel, "film": WithFilm}
"""The files of answers, by what they can write beside pictures."""


class AnalysisCommand(Command):
    """The command of an analysis of a model.

    Parameters
    ----------
    name
        With the words before it, such as ``limit tilt``.
    offered
        Or the module that has it as ``OFFERED``, and what it answers, for a list of commands.
    """

    def __init__(self, name: str, offered: Offered | tuple[str, str]) -> None:
        last, short = name.rpartition(" ")[2], offered[1] if isinstance(offered, tuple) else None
        super().__init__(
            last, short_help=short, context_settings={**SETTINGS, "allow_extra_args": True}
        )
        del self.help
        self.words, self.place = name, offered
        self.function = self._answer

    @cached_property
    def offered(self) -> Offered:
        """The analysis; it is imported when the command is asked for."""
        if not isinstance(self.place, tuple):
            return self.place
        offered: Offered = import_module(self.place[0]).OFFERED
        return offered

    @cached_property
    def help(self) -> str:  # type: ignore[override]  # a text that is set
        """What it answers."""
        codes = "Exit code 0: it stands, or what was looked for is found. 1: not. 2: bad input."
        return f"{self.offered.text}\n\n{codes}"

    @cached_property
    def examples(self) -> tuple[str, str]:  # type: ignore[override]  # as above
        """Two of its uses."""
        example = f"drystone {self.words} {self.offered.example}"
        return example, f"{example} --html {self.name}.html"

    @cached_property
    def parts(self) -> list[Part]:
        """What the parameters of its function are made of."""
        offered, arguments = self.offered, self.arguments
        free = all(name in offered.arguments for name in arguments)
        of = Of(offered.analysis, offered.options, without=tuple(arguments), shown=offered.shown)
        known: dict[str, tuple[Any, Any]] = {"subject": (Subject if free else OneFile, MISSING)}
        for name, one in arguments.items():
            default = MISSING if name in offered.arguments else None
            known[name] = Annotated[str | None, _argument(one)], default
        known["asked"] = Annotated[Analysis, of], MISSING
        known["wanted"] = _FILES.get(offered.writes, Pictures), MISSING
        return parts_of(known)

    @cached_property
    def arguments(self) -> dict[str, Declared]:
        """What is given by position: what must be given, and loads."""
        from drystone.base.declared import declared  # the program starts without numpy

        known = declared(self.offered.analysis)
        loads = {name: one for name, one in known.items() if _is_load(one)}
        return {**loads, **self.offered.arguments}

    def _answer(
        self, subject: Subject, asked: Analysis, wanted: Pictures, waiting: Waiting, **more: Any
    ) -> Told:
        model = subject.prepared(waiting)
        wanted.require_through(model.assembly)
        notes = list(model.notes)
        more = {name: text for name, text in more.items() if text is not None}
        for name in more:
            if _is_load(self.arguments[name]):
                more[name] = subject.case_of(more[name], model)
                notes += more[name].notes
        found = asked.of(waiting, model, **more)
        return Told(found, notes=notes, files=partial(wanted.of, found))


def _is_load(one: Declared) -> bool:
    from drystone.loads import LoadCase  # as above

    return LoadCase in one.kinds


def _argument(one: Declared) -> Argument:
    return Argument("CASE" if _is_load(one) else one.name.upper(), one.told())
